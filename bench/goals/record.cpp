#include "record.hpp"

#include "strokes.hpp"

#include <cstdio>
#include <fstream>
#include <ostream>

// goals.json is written one number a line, so that it can be read back by lines and compared by people.

namespace hfh::bench {
namespace {

std::string quoted(const std::string& plain) {
    std::string out = "\"";
    for (const char c : plain) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

/// The value of "key": "…" in a line; quotes inside are not expected.
std::string value_of(const std::string& line, const std::string& key) {
    const std::string begin = "\"" + key + "\": \"";
    const auto at = line.find(begin);
    if (at == line.npos) return {};
    const auto from = at + begin.size();
    return line.substr(from, line.find('"', from) - from);
}

const char* in_words(Figure::Goal goal) {
    switch (goal) {
    case Figure::Goal::at_most: return "at most";
    case Figure::Goal::below: return "below";
    case Figure::Goal::at_least: return "at least";
    case Figure::Goal::more_than: return "more than";
    }
    return "";
}

std::string measured(const Row& row) {
    std::string out;
    for (const auto& f : row.figures) {
        out += (out.empty() ? "" : " / ") + (f.measured ? text(*f.measured) : std::string{"–"});
    }
    return out + (row.unit.empty() ? "" : " ") + row.unit;
}
std::string goal(const Row& row) {
    std::string out = in_words(row.figures.front().goal);
    bool same = true;
    for (const auto& f : row.figures) same = same && f.bound == row.figures.front().bound;
    for (std::size_t k = 0; k < (same ? 1 : row.figures.size()); ++k) {
        out += (k == 0 ? " " : " / ") + text(row.figures[k].bound);
    }
    return out;
}

} // namespace

std::set<FigureName> met_at_last_recording(const std::string& path) {
    std::set<FigureName> met;
    std::ifstream file{path};
    for (std::string line; std::getline(file, line);) {
        if (line.find("\"met\": true") == line.npos) continue;
        met.insert({value_of(line, "row"), value_of(line, "figure")});
    }
    return met;
}

void write_json(std::ostream& out, const Machine& machine, const Findings& found) {
    out << "{\"machine\": {\"cpu\": " << quoted(machine.cpu) << ", \"compiler\": " << quoted(machine.compiler)
        << ", \"flags\": " << quoted(machine.flags) << ", \"date\": " << quoted(machine.date) << "},\n"
        << " \"goals\": [";
    const char* comma = "\n";
    for (const auto& row : found.rows) {
        for (const auto& f : row.figures) {
            out << comma << "  {\"row\": " << quoted(row.name) << ", \"figure\": " << quoted(f.what)
                << ", \"measured\": " << (f.measured ? text(*f.measured, 4) : "null") << ", \"goal\": \""
                << in_words(f.goal) << "\", \"bound\": " << text(f.bound)
                << ", \"unit\": " << quoted(row.unit) << ", \"met\": "
                << (!f.measured ? "null"
                    : f.met()   ? "true"
                                : "false");
            if (&f == &row.figures.front()) out << ", \"beside\": " << quoted(row.beside);
            out << "}";
            comma = ",\n";
        }
    }
    out << "\n ],\n \"workloads\": [";
    comma = "\n";
    for (const auto& w : found.workloads) {
        out << comma << "  {\"workload\": " << quoted(w.name) << ", \"ground\": " << quoted(w.ground)
            << ", \"cells\": " << text(w.cells, 10) << ", \"mean_ns\": " << text(w.mean_ns, 4);
        if (w.worst_ns) out << ", \"worst_ns\": " << text(*w.worst_ns, 4);
        out << "}";
        comma = ",\n";
    }
    out << "\n ]}\n";
}

void write_markdown(std::ostream& out, const Machine& machine, const Findings& found) {
    out << machine.cpu << ", one core; " << machine.compiler << ", `" << machine.flags << "`; "
        << machine.date << ". `double`; subject and reference in turn, in slices, in one process.\n\n"
        << "| what | measured | goal | met |\n|---|--:|--:|---|\n";
    for (const auto& row : found.rows) {
        out << "| " << row.name << " | " << measured(row) << " | " << goal(row) << " | " << row.verdict()
            << " |\n";
    }
    out << "\nWhat the figures are made of:\n\n| what | |\n|---|---|\n";
    for (const auto& row : found.rows) {
        if (!row.beside.empty()) out << "| " << row.name << " | " << row.beside << " |\n";
    }
    if (found.workloads.empty()) return;
    out << "\nOne update, nanoseconds, mean / worst of all by replay:\n\n";
    std::vector<std::string> names;
    for (const auto& w : found.workloads) {
        if (std::find(names.begin(), names.end(), w.name) == names.end()) names.push_back(w.name);
    }
    out << "| ground |";
    for (const auto& name : names) out << ' ' << name << " |";
    out << "\n|---|";
    for (std::size_t k = 0; k < names.size(); ++k) out << "--:|";
    out << '\n';
    std::string ground;
    for (const auto& w : found.workloads) {
        const std::string here = w.ground + ", " + text(w.cells / 1e6) + " M cells";
        if (here != ground) out << (ground.empty() ? "| " : "\n| ") << here << " |";
        ground = here;
        out << ' ' << text(w.mean_ns) << " / " << text(w.worst_ns.value_or(0)) << " |";
    }
    out << '\n';
}

void print(const Row& row) {
    std::printf("%s\n    %s, goal %s: %s\n", row.name.c_str(), measured(row).c_str(), goal(row).c_str(),
                row.verdict());
    if (!row.beside.empty()) std::printf("    %s\n", row.beside.c_str());
    std::fflush(stdout);
}

} // namespace hfh::bench
