#include <cold_cache.hpp>
#include <haptic_thread.hpp>
#include <memory_map.hpp>
#include <offscreen.hpp>
#include <raster_maker.hpp>
#include <viewer.hpp>

#include <bad_input.hpp>
#include <terrain_options.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// Figures of the viewer: hfh_viewer_figures SECONDS [PAGE.md]. Each terrain is made, opened from a cold cache, and flown over for so
// many seconds, at 1280 x 720, without a window, while a hand presses at 1 kHz. Ends with 1 where a goal is missed that does not
// depend on the machine.

namespace {

using Clock = std::chrono::steady_clock;

struct Flight {
    std::string name;
    std::uint64_t samples = 0;
    double first_frame = 0; ///< s from the start to the first picture that shows ground
    double whole_frame = 0; ///< s to the first one that shows all of it
    std::uint64_t frames = 0;
    double seconds = 0;
    demo::Distribution frame_us;
    std::uint64_t triangles = 0, most_triangles = 0;
    std::uint64_t samples_read = 0, uploaded = 0;
    std::uint64_t in_contact = 0;
    std::size_t card_bytes = 0;
    viewer::Punctuality hand;
    std::string renderer;
};

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A person who presses, zooms in and out, and every few seconds moves on towards a place that goes round the terrain.
viewer::FrameInput fly(double t, double step, const glm::ivec2& size, const viewer::Viewer& shown,
                       const glm::dvec2& extent) {
    viewer::FrameInput input;
    input.has_pointer = true;
    input.pointer = glm::dvec2{size} * (0.5 + 0.15 * glm::dvec2{std::sin(1.1 * t), std::cos(1.7 * t)});
    // In by six doublings over ten seconds, and out again.
    input.zoom = 0.6 * step * (std::fmod(t, 20.0) < 10 ? 1 : -1);
    input.pressing = std::fmod(t, 4.0) > 1;
    if (!input.pressing) {
        const glm::dvec2 goal = extent * (0.5 + 0.25 * glm::dvec2{std::sin(0.2 * t), std::cos(0.2 * t)});
        const glm::dvec2 way = goal - glm::dvec2{shown.hand().proxy};
        input.pan = 500 * step * glm::dvec2{-way.x, way.y} / std::max(1.0, glm::length(way));
    }
    return input;
}

Flight flight_over(const std::filesystem::path& file, const std::string& name, double seconds) {
    Flight flight;
    flight.name = name;
    {
        const demo::MemoryMap map{file};
        large_terrain::make_cold(file, map.bytes());
    }
    const auto start = Clock::now();
    demo::TerrainOptions options;
    options.terrain = file;
    options.read.for_editing = true;
    demo::Terrain terrain = demo::open_terrain(options);
    const hfh::GridFrame frame = demo::frame_of(terrain, options);
    viewer::TouchedTerrain touched{std::move(terrain), frame, {}};
    flight.samples = static_cast<std::uint64_t>(touched.displayed.columns * touched.displayed.rows);
    const viewer::OffscreenContext context;
    const glm::ivec2 size{1280, 720};
    const viewer::OffscreenFrame target{size};
    viewer::Viewer shown{touched, 127, 1.0f};
    flight.renderer = viewer::renderer_name();
    std::optional<viewer::HapticThread> haptic;

    const glm::dvec2 extent =
        touched.displayed.spacing * glm::dvec2{static_cast<double>(touched.displayed.columns - 1),
                                               static_cast<double>(touched.displayed.rows - 1)};
    std::uint64_t read_before = 0;
    auto last = Clock::now();
    Clock::time_point takes_off{};
    while (flight.frames == 0 || since(takes_off) < seconds) {
        const auto now = Clock::now();
        const double step = std::chrono::duration<double>(now - last).count();
        last = now;
        const bool flies = flight.whole_frame > 0;
        const viewer::FrameInput input =
            flies ? fly(since(takes_off), step, size, shown, extent) : viewer::FrameInput{};
        target.bind();
        shown.layer().begin_without_window(size, static_cast<float>(step));
        const viewer::FrameReport report = shown.frame(input, size, step, false);
        glFinish();
        if (report.has_terrain && flight.first_frame == 0) flight.first_frame = since(start);
        if (report.has_terrain && !haptic) haptic.emplace([&] { touched.haptics.tick(); });
        if (!flies) {
            if (!report.has_terrain ||
                shown.levels()->levels.front()->level > std::floor(shown.hand().wanted_level))
                continue;
            flight.whole_frame = since(start);
            read_before = report.samples_read;
            takes_off = last = Clock::now();
            flight.frames = 1;
            continue;
        }
        ++flight.frames;
        flight.frame_us.add(static_cast<std::uint64_t>(1e6 * since(now)));
        flight.triangles += report.terrain.triangles;
        flight.most_triangles = std::max(flight.most_triangles, report.terrain.triangles);
        flight.uploaded += report.terrain.uploaded_vertices;
        flight.samples_read = report.samples_read - read_before;
        flight.in_contact += shown.hand().touching();
    }
    flight.seconds = since(takes_off);
    flight.card_bytes = shown.terrain_drawer().card_bytes();
    haptic->stop();
    flight.hand = haptic->punctuality();
    return flight;
}

std::string number(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/// One line of the table: a name and a value a terrain.
template <class Value>
std::string row(const std::string& name, const std::vector<Flight>& flights, Value&& value) {
    std::string line = "| " + name + " |";
    for (const Flight& flight : flights) line.append(" ").append(value(flight)).append(" |");
    return line + "\n";
}

std::string page_of(const std::vector<Flight>& flights) {
    std::string page = "| " + flights.front().renderer + ", 1280 × 720, windows of 127 × 127 |";
    for (const Flight& flight : flights) page.append(" ").append(flight.name).append(" |");
    page += "\n|---|";
    for (std::size_t k = 0; k < flights.size(); ++k) page += "--:|";
    page += "\n";
    const auto per_frame = [](std::uint64_t total, const Flight& f) {
        return number("%.0f", static_cast<double>(total) / static_cast<double>(f.frames));
    };
    page += row("frames a second, mean", flights,
                [](const Flight& f) { return number("%.1f", static_cast<double>(f.frames) / f.seconds); });
    page += row("time of a frame, median / 99 %, ms", flights, [](const Flight& f) {
        return number("%.1f", 1e-3 * static_cast<double>(f.frame_us.quantile(0.5))) + " / " +
               number("%.1f", 1e-3 * static_cast<double>(f.frame_us.quantile(0.99)));
    });
    page += row("triangles of a frame, mean / most", flights, [&](const Flight& f) {
        return per_frame(f.triangles, f) + " / " + number("%.0f", static_cast<double>(f.most_triangles));
    });
    page += row("samples read for a frame, mean", flights,
                [&](const Flight& f) { return per_frame(f.samples_read, f); });
    page += row("vertices uploaded for a frame, mean", flights,
                [&](const Flight& f) { return per_frame(f.uploaded, f); });
    page += row("memory on the card, MiB", flights,
                [](const Flight& f) { return number("%.1f", static_cast<double>(f.card_bytes) / 1048576); });
    page += row("first frame with ground, from a cold cache, s", flights,
                [](const Flight& f) { return number("%.2f", f.first_frame); });
    page += row("first frame with all levels, s", flights,
                [](const Flight& f) { return number("%.2f", f.whole_frame); });
    page += row("haptic ticks", flights, [](const Flight& f) {
        return std::to_string(f.hand.ticks) + (f.hand.real_time ? "" : ", not in real time");
    });
    page += row("of them over 1 ms late, ‰", flights, [](const Flight& f) {
        return number("%.3f", 1e3 * static_cast<double>(f.hand.late) /
                                  static_cast<double>(std::max<std::uint64_t>(1, f.hand.ticks)));
    });
    page += row("worst lateness, ms", flights, [](const Flight& f) {
        return number("%.2f", 1e-6 * static_cast<double>(f.hand.worst_lateness));
    });
    page += row("a tick, median / 99.9 % / worst, µs", flights, [](const Flight& f) {
        const demo::Distribution& d = f.hand.nanoseconds;
        return number("%.1f", 1e-3 * static_cast<double>(d.quantile(0.5))) + " / " +
               number("%.1f", 1e-3 * static_cast<double>(d.quantile(0.999))) + " / " +
               number("%.0f", 1e-3 * static_cast<double>(d.worst()));
    });
    page += row("page faults of the hand that read the disk", flights,
                [](const Flight& f) { return std::to_string(f.hand.disk_reads); });
    return page;
}

std::string today() {
    const std::time_t now = std::time(nullptr);
    char text[32];
    std::strftime(text, sizeof text, "%F", std::gmtime(&now));
    return text;
}

int run(double seconds, const char* page_file) {
    const auto folder =
        std::filesystem::temp_directory_path() / ("hfh_viewer_figures_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    const std::shared_ptr<void> gone{nullptr, [&](void*) {
                                         std::error_code none;
                                         std::filesystem::remove_all(folder, none);
                                     }};
    std::vector<Flight> flights;
    for (const auto& [name, side] :
         {std::pair{"0.28 M samples", 530u}, {"16.8 M", 4097u}, {"1.07 G", 32768u}}) {
        const auto file = folder / (std::to_string(side) + ".bil");
        std::fprintf(stderr, "%s: making the terrain\n", name);
        large_terrain::make_raster(file, side, side, 1);
        std::fprintf(stderr, "%s: flying\n", name);
        flights.push_back(flight_over(file, name, seconds));
        std::filesystem::remove(file);
    }
    double load[3]{};
    ::getloadavg(load, 3);
    const std::string page = "Over ground of `make_terrain`, " + number("%.0f", seconds) + " s each; " +
                             today() + ", load average " + number("%.1f", load[0]) + " on " +
                             std::to_string(std::thread::hardware_concurrency()) + " cores.\n\n" +
                             page_of(flights);
    std::fputs(page.c_str(), stdout);
    if (page_file != nullptr) std::ofstream{page_file} << page;
    const bool fits = std::ranges::all_of(flights, [](const Flight& f) { return f.card_bytes <= 64u << 20; });
    const bool touches = std::ranges::all_of(flights, [](const Flight& f) { return f.in_contact > 0; });
    if (!fits) std::fputs("More than 64 MiB on the card.\n", stderr);
    if (!touches) std::fputs("A hand that presses never touched.\n", stderr);
    return fits && touches ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run(argc > 1 ? std::atof(argv[1]) : 60, argc > 2 ? argv[2] : nullptr);
    } catch (const demo::BadInput& error) {
        std::fprintf(stderr, "hfh_viewer_figures: %s\n", error.what());
    }
    return 2;
}
