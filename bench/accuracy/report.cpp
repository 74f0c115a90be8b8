#include "report.hpp"

#include "text.hpp"

#include <ctime>
#include <fstream>

namespace accuracy {
namespace {

[[nodiscard]] std::string processor() {
    std::ifstream file{"/proc/cpuinfo"};
    for (std::string line; std::getline(file, line);) {
        const auto colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "unknown processor";
}

[[nodiscard]] std::string compiler() {
#if defined(__clang__)
    return text("Clang %d.%d", __clang_major__, __clang_minor__);
#else
    return text("GCC %d.%d", __GNUC__, __GNUC_MINOR__);
#endif
}

[[nodiscard]] std::string today() {
    const std::time_t now = std::time(nullptr);
    char date[16];
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    return date;
}

[[nodiscard]] std::string json_spread(const char* name, const Spread& spread) {
    return text("\"%s\": {\"mean\": %.3g, \"p99_9\": %.3g, \"largest\": %.3g}, ", name, spread.mean,
                spread.most, spread.largest);
}

[[nodiscard]] std::string json_method(const Figures& f) {
    std::string out = text("      {\"name\": \"%s\", \"ns\": %.4g, ", f.title.name.c_str(), f.nanoseconds);
    out += json_spread("distance", f.distance);
    out += json_spread("foot", f.foot);
    out += json_spread("normal", f.angle);
    const auto share = [](bool known, double of) { return known ? text("%.4g", of) : std::string{"null"}; };
    return out + filled("\"wrong\": {}, \"unfinished\": {}, \"gave_up\": {}}",
                        {share(true, f.wrong), share(iterates(f.title.family), f.unfinished),
                         share(tells(f.title.family), f.gave_up)});
}

} // namespace

std::string machine() { return filled("{}, {}, {}", {processor(), compiler(), today()}); }

double rounding_error(const std::string& scalar) {
    return 4 * (scalar == "double" ? hfh::epsilon<double> : static_cast<double>(hfh::epsilon<float>));
}

std::string table(const Run& run) {
    std::string out;
    for (const Measured& set : run.sets) {
        out += filled("\n{}, {} ({})\n", {set.name(), set.scalar, set.about});
        out += text("%-24s%8s | %-26s | %-26s | %-26s | %7s %10s %8s\n", "", "", "distance error, cells",
                    "foot error, cells", "normal error, degrees", "wrong", "unfinished", "gave up");
        const char* const spread = "    mean   99.9 %  largest";
        out += text("%-24s%8s | %s | %s | %s | %7s %10s %8s\n", "method", "ns", spread, spread, spread, "%",
                    "%", "%");
        for (const Figures& f : set.methods) {
            out += text("%-24s%8.1f", f.title.name.c_str(), f.nanoseconds);
            for (const Spread& s : {f.distance, f.foot, f.angle})
                out += text(" | %8.1e %8.1e %8.1e", s.mean, s.most, s.largest);
            out += text(" | %7.3f ", 100 * f.wrong);
            out += iterates(f.title.family) ? text("%10.3f ", 100 * f.unfinished) : text("%10s ", "-");
            out += tells(f.title.family) ? text("%8.3f\n", 100 * f.gave_up) : text("%8s\n", "-");
        }
    }
    return out;
}

std::string json(const Run& run) {
    std::string out =
        filled("{\n  \"about\": \"closest point of one patch: time and error on the same queries\",\n"
               "  \"date\": \"{}\", \"processor\": \"{}\", \"compiler\": \"{}\",\n",
               {today(), processor(), compiler()});
    out += text("  \"queries_per_set\": %zu, \"rounds\": %d,\n", run.queries, run.rounds);
    out += "  \"units\": {\"ns\": \"nanoseconds per query, the quickest round\", \"distance\": \"cells\", "
           "\"foot\": \"cells\", \"normal\": \"degrees\", \"wrong\": \"share\", \"unfinished\": \"share\", "
           "\"gave_up\": \"share\"},\n  \"sets\": [\n";
    for (const Measured& set : run.sets) {
        out += filled("    {\"terrain\": \"{}\", \"depth\": \"{}\", \"about\": \"{}\", \"scalar\": \"{}\", "
                      "\"methods\": [\n",
                      {set.terrain, set.depth, set.about, set.scalar});
        for (const Figures& f : set.methods) {
            out += json_method(f);
            out += &f == &set.methods.back() ? "]}" : ",\n";
        }
        out += &set == &run.sets.back() ? "\n" : ",\n";
    }
    return out + "  ]\n}\n";
}

} // namespace accuracy
