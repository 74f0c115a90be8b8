#include "catch.hpp"
#include "support/skip.hpp"
#include "touch_terrain_files.hpp"

#include <bad_input.hpp>
#include <cold_cache.hpp>
#include <journey.hpp>
#include <level_residency.hpp>
#include <memory_map.hpp>
#include <page_ranges.hpp>
#include <raster_maker.hpp>
#include <real_time_loop.hpp>
#include <residency.hpp>
#include <terrain.hpp>
#include <zoom_session.hpp>

#include <chrono>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

// The parts of the demo of rasters larger than memory.

using namespace large_terrain;
using touch_terrain_tests::contents;
using touch_terrain_tests::Folder;
namespace fs = std::filesystem;

namespace {

using PageSet = std::set<std::uintptr_t>;

/// The pages that hold a byte of a sample within `margin` of the box of the two cells: every sample is asked.
PageSet pages_by_asking_every_sample(const SampleLayout& layout, hfh::Cell here, hfh::Cell there,
                                     hfh::Index margin, std::uintptr_t page) {
    const auto near = [&](hfh::Index k, hfh::Index a, hfh::Index b) { // cell c has samples c and c + 1
        return (k >= a - margin || k >= b - margin) && (k <= a + 1 + margin || k <= b + 1 + margin);
    };
    PageSet pages;
    for (hfh::Index j = 0; j < layout.rows; ++j) {
        for (hfh::Index i = 0; i < layout.columns; ++i) {
            if (!near(i, here.i, there.i) || !near(j, here.j, there.j)) continue;
            const auto at =
                static_cast<std::intptr_t>(layout.first) + i * layout.column_bytes + j * layout.row_bytes;
            for (std::size_t byte = 0; byte < layout.sample_bytes; ++byte)
                pages.insert((static_cast<std::uintptr_t>(at) + byte) / page);
        }
    }
    return pages;
}

long faults_that_read_the_disk() {
    rusage usage{};
    ::getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_majflt;
}

/// 8 MiB, 16 KiB a row, that has just been written to the disk.
struct FileOfGround {
    using Heights = demo::Heights<std::int16_t>;
    Folder folder;
    fs::path file = folder / "ground.bil";
    demo::Terrain terrain = made();
    Heights heights = std::get<Heights>(terrain.heights);
    std::span<const std::byte> bytes = static_cast<const demo::MemoryMap*>(terrain.storage.get())->bytes();

    demo::Terrain made() const {
        make_raster(file, 8192, 512, 3);
        return demo::read_raster(file, {});
    }
    /// Whether nothing of the file is in memory; a file system that is memory itself says no.
    [[nodiscard]] bool turn_cold() const {
        read_single_pages(bytes);
        make_cold(file, bytes);
        return pages_resident(bytes).resident == 0;
    }
    /// Whether every page around cell `c` is in memory.
    [[nodiscard]] bool resident_around(hfh::Cell c, hfh::Index margin) const {
        const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
        for (const std::uintptr_t at : pages_by_asking_every_sample(layout_of(heights), c, c, margin, page)) {
            unsigned char in_memory = 0;
            ::mincore(reinterpret_cast<void*>(at * page), 1, &in_memory);
            if ((in_memory & 1) == 0) return false;
        }
        return true;
    }
    /// Reads all samples around cell `c` and tells how often the disk was waited for.
    [[nodiscard]] long waits_around(hfh::Cell c, hfh::Index margin) const {
        const long before = faults_that_read_the_disk();
        long sum = 0;
        for (hfh::Index j = c.j - margin; j <= c.j + 1 + margin; ++j) {
            for (hfh::Index i = c.i - margin; i <= c.i + 1 + margin; ++i) sum += heights(i, j);
        }
        CHECK(sum != 0); // reads them all
        return faults_that_read_the_disk() - before;
    }
};

/// Heights of which one read sleeps for 3 ms.
struct SlowOnce {
    using SampleType = std::int16_t;
    FileOfGround::Heights heights;
    int* reads;
    hfh::Index columns() const noexcept { return heights.columns(); }
    hfh::Index rows() const noexcept { return heights.rows(); }
    std::int16_t operator()(hfh::Index i, hfh::Index j) const noexcept {
        if (++*reads == 3000) std::this_thread::sleep_for(std::chrono::milliseconds{3});
        return heights(i, j);
    }
    bool missing(std::int16_t s) const noexcept { return heights.missing(s); }
};

} // namespace

TEST_CASE("large_terrain pages: those asked for are those that hold a sample of the neighbourhood",
          "[large_terrain]") {
    std::mt19937_64 random{1};
    const auto any = [&](hfh::Index low, hfh::Index high) {
        return std::uniform_int_distribution<hfh::Index>{low, high}(random);
    };
    for (int k = 0; k < 2000; ++k) {
        const auto page = std::uintptr_t{1} << any(4, 9);
        SampleLayout layout;
        layout.sample_bytes = std::size_t{1} << any(0, 3);
        const auto bytes = static_cast<std::ptrdiff_t>(layout.sample_bytes);
        layout.columns = any(2, k % 3 == 0 ? 3 : 70);
        layout.rows = any(2, k % 5 == 0 ? 3 : 50);
        layout.column_bytes = bytes * (k % 4 == 0 ? any(1, 16 / bytes) : 1);
        layout.row_bytes = layout.columns * layout.column_bytes + bytes * any(0, 20);
        layout.first = static_cast<std::uintptr_t>(1 << 20) + layout.sample_bytes * (random() % 100);
        if (k % 2 == 0) { // north row first
            layout.first += static_cast<std::uintptr_t>((layout.rows - 1) * layout.row_bytes);
            layout.row_bytes = -layout.row_bytes;
        }
        if (k % 7 == 0) { // east column first
            layout.first += static_cast<std::uintptr_t>((layout.columns - 1) * layout.column_bytes);
            layout.column_bytes = -layout.column_bytes;
        }
        const hfh::Cell here{any(-5, layout.columns + 5), any(-5, layout.rows + 5)};
        const hfh::Cell there{here.i + any(-30, 30), here.j + any(-30, 30)};
        const hfh::Index margin = any(0, 12);
        CAPTURE(k, page, layout.columns, layout.rows, here.i, here.j, there.i, there.j, margin);

        PageSet asked;
        bool one_after_another_differ = true;
        PageRange last{};
        const hfh::VertexRange box = neighbourhood(layout, here, there, margin);
        const bool upwards = there.j >= here.j;
        for_each_page_range(layout, box, here.j, upwards, page, [&](const PageRange& range) {
            one_after_another_differ &= range.begin != last.begin || range.end != last.end;
            if (last.end == 0) { // what is nearest comes first
                const hfh::Index row = std::clamp(here.j, box.begin.j, box.end.j - 1);
                const PageRange nearest = pages_of_row(layout, box, row, page);
                CHECK(range.begin == nearest.begin);
                CHECK(range.end == nearest.end);
            }
            last = range;
            for (std::uintptr_t at = range.begin; at < range.end; at += page) asked.insert(at / page);
        });
        CHECK(one_after_another_differ);
        CHECK(asked == pages_by_asking_every_sample(layout, here, there, margin, page));
    }
}

TEST_CASE("large_terrain pages: rows ahead come before rows behind, near ones before far ones",
          "[large_terrain]") {
    const SampleLayout layout{
        .first = 0, .columns = 64, .rows = 64, .column_bytes = 2, .row_bytes = 128, .sample_bytes = 2};
    const hfh::VertexRange box = neighbourhood(layout, {20, 20}, {20, 24}, 2);
    const auto rows = [&](bool upwards) {
        std::vector<std::uintptr_t> order;
        for_each_page_range(layout, box, 20, upwards, 64,
                            [&](const PageRange& range) { order.push_back(range.begin / 128); });
        return order;
    };
    CHECK(rows(true) == std::vector<std::uintptr_t>{20, 21, 22, 23, 24, 25, 26, 27, 19, 18});
    CHECK(rows(false) == std::vector<std::uintptr_t>{20, 19, 18, 21, 22, 23, 24, 25, 26, 27});
}

TEST_CASE("large_terrain foresight: goes on as before, not too far", "[large_terrain]") {
    const ResidencySettings settings{.look_ahead = 0.25, .most_ahead = 384};
    const auto from = [&](hfh::Cell before, hfh::Cell here, double elapsed) {
        return foresee(before, here, elapsed, settings);
    };
    CHECK(from({100, 200}, {100, 200}, 0.004) == hfh::Cell{100, 200});
    CHECK(from({100, 200}, {104, 198}, 0.004) == hfh::Cell{104 + 250, 198 - 125});
    CHECK(from({100, 200}, {104, 198}, 0.008) == hfh::Cell{104 + 125, 198 - 63}); // 62.5, away from zero
    CHECK(from({100, 200}, {110, 195}, 0.001) == hfh::Cell{110 + 384, 195 - 384});
    CHECK(from({0, 0}, {2'000'000'000, 0}, 1e-9) == hfh::Cell{2'000'000'384, 0});
}

TEST_CASE("large_terrain journey: stays over the raster at the speed asked for, and is always the same",
          "[large_terrain]") {
    for (const hfh::Index size : {hfh::Index{300}, hfh::Index{1000}, hfh::Index{32768}}) {
        for (const double speed : {0.0, 10.0, 1000.0, 3000.0}) {
            CAPTURE(size, speed);
            Journey journey{size, size / 2, speed}, again{size, size / 2, speed};
            bool inside = true, same = true;
            double fastest = 0;
            glm::dvec2 last = journey.at();
            for (int k = 0; k < 60'000; ++k) {
                const glm::dvec2 at = journey.at();
                inside = inside && at.x >= 0 && at.y >= 0 && at.x <= static_cast<double>(size - 1) &&
                         at.y <= static_cast<double>(size / 2 - 1);
                fastest = std::max(fastest, std::hypot(at.x - last.x, at.y - last.y));
                same = same && at == again.at();
                last = at;
                journey.advance();
                again.advance();
            }
            CHECK(inside);
            CHECK(same);
            CHECK(fastest <= speed / 1000 * (1 + 1e-9) + 1e-9); // at 32768 one ulp is 7e-12
            CHECK(fastest >= speed / 1000 * 0.999);
        }
    }
}

TEST_CASE("large_terrain residency: brings in what lies around the stylus, follows it, and leaves the rest",
          "[large_terrain]") {
    const FileOfGround ground;
    const bool cold = ground.turn_cold();
    Residency residency{layout_of(ground.heights), {1000, 100}};
    CHECK(ground.resident_around({1000, 100}, 64));
    if (cold) {
        CHECK_FALSE(ground.resident_around({1000, 400}, 0));
        CHECK_FALSE(ground.resident_around({6000, 100}, 0));
    }
    for (hfh::Index j = 100; j <= 400; ++j) { // over pages that only this motion needs: a row is four pages
        residency.note({1000, j});
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    // However late the helper is on a busy machine.
    using Clock = std::chrono::steady_clock;
    const auto latest = Clock::now() + std::chrono::seconds{20};
    while (!ground.resident_around({1000, 400}, 64) && Clock::now() < latest)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    CHECK(ground.resident_around({1000, 400}, 64));
    residency.stop();
    CHECK(residency.report().rounds > 0);
    if (cold) {
        CHECK_FALSE(ground.resident_around({6000, 100}, 0));
        CHECK_FALSE(ground.resident_around({6000, 400}, 0));
        const Pages pages = pages_resident(ground.bytes);
        CHECK(pages.resident < pages.all / 2);
    }
}

TEST_CASE("large_terrain residency: the thread that feels does not wait for the disk where the helper was",
          "[large_terrain]") {
    const FileOfGround ground;
    if (!ground.turn_cold()) return hfh::test::skip("this file system keeps its files in memory");
    CHECK(ground.waits_around({3000, 250}, 64) > 0); // without it
    (void)ground.turn_cold();
    const Residency residency{layout_of(ground.heights), {3000, 250}};
    CHECK(ground.waits_around({3000, 250}, 64) == 0);
}

TEST_CASE(
    "large_terrain levels: a level whose samples are not in memory waits for them, and the wait is counted",
    "[large_terrain]") {
    const FileOfGround ground;
    const bool cold = ground.turn_cold();
    // Of level 4 there are 32 rows of 16 KiB.
    const LevelResidencySettings settings{.most_change = 100, .whole = 1 << 20};
    LevelResidency residency{layout_of(ground.heights), {1000, 200}, 1.5, settings};
    REQUIRE(residency.whole_level() == 4);
    residency.stop(); // nothing more comes into memory
    const hfh::Cell here{1000, 200}, far{6000, 300};

    CHECK(residency.level_for(here, here, 1.5) == 1.5);
    CHECK(residency.level_for(here, here, 1) == 1);
    CHECK(residency.level_for(here, here, 2.25) == 2.25); // has no other samples than level 1
    CHECK(residency.level_for(here, here, 6.5) == 6.5);
    CHECK(residency.level_for(here, here, 99) == 8);
    CHECK_FALSE(residency.waiting());
    CHECK(residency.waits().waits == 0);

    CHECK(residency.level_for(here, here, 0.5) == 1); // the nearest
    CHECK(residency.waiting());
    CHECK(residency.level_for(far, far, 1.5) == 4);  // the level falls back, at once
    CHECK(residency.level_for(here, far, 1.5) == 4); // nor is the proxy left out
    CHECK(residency.level_for(far, here, 5.5) == 5.5);
    CHECK_FALSE(residency.waiting());
    CHECK(residency.level_for(far, far, 0) == 4);
    CHECK(residency.waits().waits == 2);
    CHECK(residency.waits().updates == 4);
    CHECK(residency.waits().longest == 3);
    CHECK(residency.waits().farthest == 4);

    // Within the margin of 64 cells of the level, up to the 24 that an update may read.
    CHECK(residency.level_for({1000 + 2 * 38, 200}, here, 1.5) == 1.5);
    CHECK(residency.level_for({1000 + 2 * 42, 200}, here, 1.5) == 4);
    if (!cold) return;
    CHECK(ground.waits_around(far, 48) > 0);
}

TEST_CASE("large_terrain levels: towards the level wanted it is a small step an update", "[large_terrain]") {
    const FileOfGround ground;
    const LevelResidencySettings settings{.whole = 1 << 20};
    LevelResidency residency{layout_of(ground.heights), {1000, 200}, 1, settings};
    residency.stop();
    double last = 1;
    for (int n = 0; n < 300; ++n) {
        const double level = residency.level_for({1000, 200}, {1000, 200}, n < 150 ? 2.5 : 1);
        CHECK(std::abs(level - last) <= 0.02 + 1e-12);
        last = level;
        if (n == 149) CHECK(level == 2.5);
    }
    CHECK(last == 1);
    CHECK(residency.waits().waits == 0);
}

TEST_CASE("large_terrain levels: what is answered is in memory, and what is wanted comes",
          "[large_terrain]") {
    const FileOfGround ground;
    if (!ground.turn_cold()) return hfh::test::skip("this file system keeps its files in memory");
    const LevelResidencySettings settings{.whole = 1 << 20};
    LevelResidency residency{layout_of(ground.heights), {1000, 200}, 6, settings};
    using Clock = std::chrono::steady_clock;
    const auto latest =
        Clock::now() + std::chrono::seconds{20}; // however late the helper is on a busy machine
    for (const hfh::Cell here : {hfh::Cell{1000, 200}, hfh::Cell{6000, 300}, hfh::Cell{3500, 100}}) {
        double level = 8;
        while (level > 0 && Clock::now() < latest) {
            level = residency.level_for(here, here, 0);
            const auto k = static_cast<int>(level);
            const auto heights = hfh::subsampled(ground.heights, k);
            const long before = faults_that_read_the_disk();
            long sum = 0;
            for (hfh::Index j = -20; j <= 20; ++j) {
                for (hfh::Index i = -20; i <= 20; ++i) {
                    sum += heights(std::clamp<hfh::Index>((here.i >> k) + i, 0, heights.columns() - 1),
                                   std::clamp<hfh::Index>((here.j >> k) + j, 0, heights.rows() - 1));
                }
            }
            CHECK(sum != 0);
            CHECK(faults_that_read_the_disk() == before);
            std::this_thread::sleep_for(std::chrono::milliseconds{1});
        }
        CHECK(level == 0);
    }
    residency.stop();
    CHECK(residency.report().rounds > 0);
}

TEST_CASE("large_terrain zoom: the same with the helper where nothing waits, and no contact is lost",
          "[large_terrain]") {
    const FileOfGround ground;
    const ZoomSession session{.spacing = {10, 10}, .coarsest = 5, .trips = 2, .paced = false};
    ZoomingHand alone{ground.heights, session}, helped{ground.heights, session};
    const ZoomReport without = run_zoom_session(alone, session, nullptr);
    LevelResidency residency{layout_of(ground.heights), {4095, 255}, 5, {.whole = 1 << 24}};
    REQUIRE(residency.whole_level() == 0); // a small terrain is kept as it is
    const ZoomReport with = run_zoom_session(helped, session, &residency);
    CHECK(without.updates == 8000);
    CHECK(without.in_contact > 7990);
    CHECK(without.lost == 0);
    CHECK(with.answers == without.answers);
    CHECK(with.waits.waits == 0);
    CHECK(glm::length(helped.newtons()) > 0.1);
}

TEST_CASE("large_terrain session: the helper changes no answer, and a long update is counted",
          "[large_terrain]") {
    const FileOfGround ground;
    const Session session{.frame = {.spacing = {0.001, 0.001}, .height_scale = 0.0001},
                          .updates = 5000,
                          .cells_per_second = 1000,
                          .paced = false};
    const double z = start_height(ground.heights, session);
    Residency residency{layout_of(ground.heights), {2000, 100}};
    const SessionReport without = run_session(ground.heights, session, z, nullptr);
    const SessionReport with = run_session(ground.heights, session, z, &residency);
    CHECK(without.updates == 5000);
    CHECK(without.in_contact > 4500);
    CHECK(with.in_contact == without.in_contact);
    CHECK(with.answers == without.answers);
    CHECK(without.nanoseconds.total() == 5000);

    // Another terrain, another digest.
    Session steeper = session;
    steeper.frame.height_scale *= 1.01;
    const SessionReport other =
        run_session(ground.heights, steeper, start_height(ground.heights, steeper), nullptr);
    CHECK(other.answers != without.answers);

    int reads = 0;
    const SessionReport slow = run_session(SlowOnce{ground.heights, &reads}, session, z, nullptr);
    CHECK(slow.answers == without.answers);
    CHECK(slow.too_long >= 1);
    CHECK(slow.too_long_for_disk >= 1); // that is how a thread looks that waits
    CHECK(slow.nanoseconds.worst() >= 3'000'000);
}

TEST_CASE("large_terrain maker: a row depends on neither the width nor the rows before it",
          "[large_terrain]") {
    GroundRows wide{10'000, 7}, narrow{123, 7}, other{123, 8};
    std::vector<std::int16_t> from_wide, from_narrow, from_other;
    for (const std::uint64_t j : {9000u, 0u, 1u, 4095u, 4096u, 77u}) {
        wide.row(j, from_wide);
        narrow.row(j, from_narrow);
        other.row(j, from_other);
        REQUIRE(from_narrow.size() == 123);
        CHECK(std::equal(from_narrow.begin(), from_narrow.end(), from_wide.begin()));
        CHECK(from_narrow != from_other);
    }
}

TEST_CASE("large_terrain maker: the ground is rolling, without a jump where bumps meet", "[large_terrain]") {
    GroundRows ground{9000, 1};
    std::vector<std::int16_t> row, before;
    int lowest = 32767, highest = -32768, steepest = 0;
    for (std::uint64_t j = 4000; j < 4200; ++j) { // across a knot of every wavelength
        ground.row(j, row);
        for (std::size_t i = 0; i < row.size(); ++i) {
            lowest = std::min<int>(lowest, row[i]);
            highest = std::max<int>(highest, row[i]);
            if (i > 0) steepest = std::max(steepest, std::abs(row[i] - row[i - 1]));
            if (!before.empty()) steepest = std::max(steepest, std::abs(row[i] - before[i]));
        }
        before = row;
    }
    // A bump of wavelength w and height ±h rises by at most 2h · 3/2 over w: 1400 m and 4096 cells give 1 m a cell, each
    // of the twelve octaves 15/16 of the one before; and a metre of rounding. The ground lies between 365 and 5635 m.
    CHECK(steepest <= 9 + 1);
    CHECK(steepest >= 3);
    CHECK(lowest >= 365);
    CHECK(highest <= 5635);
    CHECK(highest - lowest >= 500);
}

TEST_CASE("large_terrain maker: writes what other programs read, the same on every machine",
          "[large_terrain]") {
    const Folder folder;
    make_raster(folder / "a.bil", 301, 97, 5);
    CHECK(contents(folder / "a.hdr").starts_with("NROWS 97\nNCOLS 301\nNBANDS 1\nNBITS 16\n"));
    CHECK(folder.listing().size() == 2);

    const demo::Terrain terrain = demo::read_raster(folder / "a.bil", {});
    const auto& heights = std::get<demo::Heights<std::int16_t>>(terrain.heights);
    REQUIRE(heights.columns() == 301);
    REQUIRE(heights.rows() == 97);
    CHECK(terrain.spacing == glm::dvec2{10, 10});
    GroundRows ground{301, 5};
    std::vector<std::int16_t> row;
    std::uint64_t digest = 0xcbf2'9ce4'8422'2325u; // FNV-1a
    bool same = true;
    for (hfh::Index j = 0; j < 97; ++j) { // north first in the file, south first in the view
        ground.row(static_cast<std::uint64_t>(j), row);
        for (hfh::Index i = 0; i < 301; ++i) {
            same = same && heights(i, 96 - j) == row[static_cast<std::size_t>(i)];
            for (const int shift : {0, 8}) {
                const auto sample = static_cast<std::uint16_t>(row[static_cast<std::size_t>(i)]);
                digest = (digest ^ (sample >> shift & 0xffu)) * 0x100'0000'01b3u;
            }
        }
    }
    CHECK(same);
    CHECK(digest == 0xd0d1'4454'b3fe'028bu);

    make_raster(folder / "a.bil", 12, 13, 5); // takes the old one's place
    CHECK(fs::file_size(folder / "a.bil") == 12 * 13 * 2);
    CHECK_THROWS_AS(make_raster(folder / "a.tif", 12, 13, 5), demo::BadInput);
}
