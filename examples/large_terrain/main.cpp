#include "cold_cache.hpp"
#include "command_line.hpp"
#include "real_time_loop.hpp"
#include "zoom_session.hpp"

#include <bad_input.hpp>
#include <memory_map.hpp>
#include <numbers.hpp>
#include <terrain.hpp>

#include <cctype>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <thread>

// Touches a raster that may be larger than memory, at 1 kHz, from a cold cache: once with nobody's help and once with
// the residency helper. Says how many updates took longer than they may. With --zoom the hand goes over all levels of
// detail as well.

namespace large_terrain {
namespace {

struct Options {
    std::filesystem::path terrain;
    double seconds = 20;
    double speed = 1; ///< m/s
    int zoom = 0;     ///< trips in and out
    bool single_pages = false;
    ResidencySettings helper;
};

/// Nothing if the user asked for help, which has then been printed. Throws BadInput.
std::optional<Options> read_options(int argc, const char* const* argv) {
    CLI::App app{
        "Touches a large terrain at 1 kHz from a cold cache, without and with a helper that keeps the "
        "neighbourhood of the stylus in memory. One cell of the terrain is one millimetre of the hand.",
        "large_terrain"};
    std::string terrain, seconds, speed, look_ahead, zoom;
    Options options;
    app.add_option("TERRAIN", terrain, "A .bil or .flt beside its .hdr; make_terrain makes one")->required();
    app.add_option("--seconds", seconds, "How long each of the two runs takes. Default: 20")->type_name("S");
    app.add_option("--speed", speed, "Of the hand, metres a second. Default: 1, a thousand cells a second")
        ->type_name("V");
    app.add_option("--look-ahead", look_ahead,
                   "Of the helper, along the motion, in milliseconds. Default: 250")
        ->type_name("MS");
    app.add_option(
           "--zoom", zoom,
           "Zoom instead, so many times: 1024 times in and out again while touching, or as far as the "
           "terrain has 8 cells across. In 4 s each, unless --seconds says how long all take")
        ->type_name("TRIPS");
    app.add_flag("--single-pages", options.single_pages,
                 "Keep the kernel from reading more than the page that is missing (madvise RANDOM)");
    if (!read_command_line(app, argc, argv)) return std::nullopt;

    options.terrain = terrain;
    if (!seconds.empty()) options.seconds = number_from("--seconds", seconds, 0.01, 3600.0);
    if (!speed.empty()) options.speed = number_from("--speed", speed, 0.0, 10.0);
    if (!look_ahead.empty())
        options.helper.look_ahead = number_from("--look-ahead", look_ahead, 0.0, 10000.0) / 1000;

    if (!zoom.empty()) {
        options.zoom = number_from("--zoom", zoom, 1, 1000);
        if (seconds.empty()) options.seconds = 4.0 * options.zoom;
        if (!speed.empty() || !look_ahead.empty())
            throw demo::BadInput{"--zoom goes with neither --speed nor --look-ahead."};
    }

    std::string kind = options.terrain.extension().string();
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (kind != ".bil" && kind != ".flt") {
        throw demo::BadInput{
            options.terrain.string() + " ends in " + demo::shown(kind) +
            ", but only .bil and .flt can be read where they lie, without being decoded first."};
    }
    return options;
}

/// One run, from a cache as cold as it gets.
struct Run {
    Pages before;
    SessionReport session;
    std::optional<ResidencyReport> helper;
};

template <class Heights>
Run run(const Heights& heights, const Session& session, const Options& options, const demo::MemoryMap& map,
        bool with_helper) {
    const double z = start_height(heights, session);
    make_cold(options.terrain, map.bytes());
    Run result;
    result.before = pages_resident(map.bytes());

    std::optional<Residency> helper;
    if (with_helper) {
        const glm::dvec2 at = Journey{heights.columns(), heights.rows(), session.cells_per_second}.at();
        const hfh::Cell here{static_cast<hfh::Index>(at.x), static_cast<hfh::Index>(at.y)};
        helper.emplace(layout_of(heights), here, options.helper);
    }
    // A thread of its own, because it may become a real-time one.
    std::thread haptic{
        [&] { result.session = run_session(heights, session, z, helper ? &*helper : nullptr); }};
    haptic.join();
    if (helper) {
        helper->stop();
        result.helper = helper->report();
    }
    return result;
}

/// The same for a session that zooms.
struct ZoomRun : Run {
    LevelWaits waits;
    std::uint64_t lost = 0;
};

template <class Heights>
ZoomRun run_zoom(const Heights& heights, const ZoomSession& session, const Options& options,
                 const demo::MemoryMap& map, bool with_helper) {
    ZoomingHand hand{heights, session};
    make_cold(options.terrain, map.bytes());
    ZoomRun result;
    result.before = pages_resident(map.bytes());

    std::optional<LevelResidency> helper;
    if (with_helper) {
        const glm::dvec2 cell =
            zoom_start(heights.columns(), heights.rows(), session.spacing) / session.spacing;
        helper.emplace(layout_of(heights),
                       hfh::Cell{static_cast<hfh::Index>(cell.x), static_cast<hfh::Index>(cell.y)},
                       session.coarsest);
    }
    std::thread haptic{[&] {
        const ZoomReport report = run_zoom_session(hand, session, helper ? &*helper : nullptr);
        result.session = report;
        result.waits = report.waits;
        result.lost = report.lost;
    }};
    haptic.join();
    if (helper) {
        helper->stop();
        result.helper = helper->report();
    }
    return result;
}

std::string in_microseconds(std::uint64_t nanoseconds) {
    return demo::rounded(static_cast<double>(nanoseconds) / 1000, 3);
}

void print(const Run& without, const Run& with) {
    const auto row = [&](const char* what, auto&& value) {
        std::printf("%-38s %20s %20s\n", what, std::string{value(without)}.c_str(),
                    std::string{value(with)}.c_str());
    };
    const auto times = [&](const char* what, auto&& of) {
        for (const auto& [name, share] : {std::pair{"median", 0.5}, {"99.9 %", 0.999}, {"worst", 2.0}}) {
            row((std::string{what} + name).c_str(), [&, share = share](const Run& r) {
                const demo::Distribution& d = of(r.session);
                return in_microseconds(share > 1 ? d.worst() : d.quantile(share));
            });
        }
    };
    const auto count = [&](const char* what, auto&& of) {
        row(what,
            [&](const Run& r) { return demo::grouped(static_cast<unsigned long long>(of(r.session))); });
    };
    std::printf("%-38s %20s %20s\n", "", "without helper", "with helper");
    row("pages in memory before",
        [](const Run& r) { return demo::grouped(r.before.resident) + " of " + demo::grouped(r.before.all); });
    count("updates", [](const SessionReport& s) { return s.updates; });
    row("in contact", [](const Run& r) {
        return demo::rounded(100 * static_cast<double>(r.session.in_contact) /
                             static_cast<double>(r.session.updates)) +
               " %";
    });
    count("updates of 1 ms and more", [](const SessionReport& s) { return s.too_long; });
    count("  because of the disk", [](const SessionReport& s) { return s.too_long_for_disk; });
    count("  because of the scheduler", [](const SessionReport& s) { return s.too_long_preempted; });
    count("updates that waited for the disk", [](const SessionReport& s) { return s.waited; });
    times("update, us: ", [](const SessionReport& s) -> const demo::Distribution& { return s.nanoseconds; });
    count("page faults that read the disk", [](const SessionReport& s) { return s.page_reads; });
    count("  between updates", [](const SessionReport& s) { return s.thread_page_reads - s.page_reads; });
    count("page faults that did not", [](const SessionReport& s) { return s.page_maps; });
    times("woken late, us: ", [](const SessionReport& s) -> const demo::Distribution& { return s.lateness; });
    count("woken 1 ms late and more", [](const SessionReport& s) { return s.woken_late; });
    row("scheduled as", [](const Run& r) { return r.session.real_time ? "real time" : "any thread"; });
    row("answers", [](const Run& r) {
        char digits[17];
        std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(r.session.answers));
        return std::string{digits};
    });

    const ResidencyReport& helper = *with.helper;
    std::printf("helper: %s rounds, %s ranges of pages, %s waits for the disk, longest round %s ms\n",
                demo::grouped(helper.rounds).c_str(), demo::grouped(helper.ranges).c_str(),
                demo::grouped(static_cast<unsigned long long>(helper.page_reads)).c_str(),
                demo::rounded(static_cast<double>(helper.longest_round.count()) / 1e6).c_str());
}

/// 1 if the thread that feels waited for the disk in spite of the helper, else 0.
template <class Heights>
int zoom(const Heights& heights, const glm::dvec2& spacing, const Options& options,
         const demo::MemoryMap& map) {
    ZoomSession session{.spacing = spacing, .trips = options.zoom, .seconds = options.seconds / options.zoom};
    while (session.coarsest > 0 && (std::min(heights.columns(), heights.rows()) - 1) >> session.coarsest < 8)
        --session.coarsest;
    std::printf("zooming from level %d to level 0 and back, %d times\n", session.coarsest, session.trips);
    std::fflush(stdout);
    const ZoomRun without = run_zoom(heights, session, options, map, false);
    const ZoomRun with = run_zoom(heights, session, options, map, true);
    print(without, with);
    std::printf("contacts lost: %s without helper, %s with helper\n", demo::grouped(without.lost).c_str(),
                demo::grouped(with.lost).c_str());
    std::printf(
        "level: waited %s times, in %s updates, at most %s one after another, at most %s levels off\n",
        demo::grouped(with.waits.waits).c_str(), demo::grouped(with.waits.updates).c_str(),
        demo::grouped(with.waits.longest).c_str(), demo::rounded(with.waits.farthest).c_str());
    return with.session.thread_page_reads == 0 ? 0 : 1;
}

/// 1 if the helper changed an answer, else 0: how many updates were too long is for the reader to judge.
int touch(const Options& options) {
    const demo::Terrain terrain = demo::read_terrain(options.terrain);
    const auto& map = *static_cast<const demo::MemoryMap*>(terrain.storage.get()); // as read_raster makes it
    if (options.single_pages) read_single_pages(map.bytes());
    const glm::dvec2 spacing = terrain.spacing.value_or(glm::dvec2{1.0});
    const double scale = 0.001 / spacing.x; // one cell is one millimetre
    const Session session{.frame = {.spacing = scale * spacing, .height_scale = scale},
                          .updates = static_cast<std::uint64_t>(options.seconds * Journey::rate),
                          .cells_per_second = 1000 * options.speed};
    return std::visit(
        [&](const auto& heights) {
            std::printf("%s, %td x %td samples, %s bytes; ", terrain.name.c_str(), heights.columns(),
                        heights.rows(), demo::grouped(map.bytes().size()).c_str());
            if (options.zoom > 0) return zoom(heights, spacing, options, map);
            std::printf("1 m/s is 1000 cells a second, here %s\n",
                        demo::rounded(session.cells_per_second).c_str());
            std::fflush(stdout);
            const Run without = run(heights, session, options, map, false);
            const Run with = run(heights, session, options, map, true);
            print(without, with);
            if (without.session.answers == with.session.answers) return 0;
            std::fputs("large_terrain: the answers of the two runs differ.\n", stderr);
            return 1;
        },
        terrain.heights);
}

} // namespace
} // namespace large_terrain

int main(int argc, char** argv) {
    constexpr int bad_input = 2;
    try {
        const auto options = large_terrain::read_options(argc, argv);
        return options ? large_terrain::touch(*options) : 0;
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "large_terrain: %s\n", error.what());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "large_terrain: cannot go on: %s.\n", error.what());
    }
    return bad_input;
}
