#include "level_residency.hpp"

#include <hfh/terrain/height_levels.hpp>

#include <cmath>

namespace large_terrain {

namespace {

/// Where the samples of level k lie.
SampleLayout layout_of_level(const SampleLayout& finest, int k) noexcept {
    SampleLayout level = finest;
    level.columns = hfh::samples_on_level(finest.columns, k);
    level.rows = hfh::samples_on_level(finest.rows, k);
    level.column_bytes *= std::ptrdiff_t{1} << k;
    level.row_bytes *= std::ptrdiff_t{1} << k;
    return level;
}

/// Bytes of the pages that hold a level, no fewer than there are.
std::size_t bytes_of_pages(const SampleLayout& level) noexcept {
    constexpr std::size_t page = 4096;
    const auto row = static_cast<std::size_t>(level.columns * std::abs(level.column_bytes));
    return static_cast<std::size_t>(level.rows) * (row / page + 2) * page;
}

hfh::Cell on_level(hfh::Cell c, int k) noexcept { return {c.i >> k, c.j >> k}; }

/// Whether `box` has all of `part`, whose numbers are of a level that is `coarser` levels coarser.
bool contains(const hfh::VertexRange& box, const hfh::VertexRange& part, int coarser) noexcept {
    return box.begin.i <= part.begin.i << coarser && box.begin.j <= part.begin.j << coarser &&
           (part.end.i - 1) << coarser < box.end.i && (part.end.j - 1) << coarser < box.end.j;
}

} // namespace

LevelResidency::LevelResidency(const SampleLayout& finest, hfh::Cell here, double level,
                               const LevelResidencySettings& settings)
    : settings_{settings}, last_{std::min(hfh::count_levels(finest.columns, finest.rows), most_levels) - 1},
      level_{std::clamp(level, 0.0, static_cast<double>(last_))}, position_{pack(here)}, wanted_{level_},
      set_{level_} {
    for (int k = 0; k <= last_; ++k) levels_[static_cast<std::size_t>(k)] = layout_of_level(finest, k);
    const auto layout = [&](int k) -> const SampleLayout& { return levels_[static_cast<std::size_t>(k)]; };
    while (whole_ < last_ && bytes_of_pages(layout(whole_)) > settings.whole) ++whole_;
    bring_in_whole();
    round(here, here, level_, level_, 1);
    (void)brought_in_.take(known_);
    thread_ = std::thread{[this] { run(); }};
}

void LevelResidency::stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
}

double LevelResidency::level_for(hfh::Cell stylus, hfh::Cell proxy, double wanted) noexcept {
    (void)brought_in_.take(known_);
    wanted = std::clamp(wanted, 0.0, static_cast<double>(last_));
    const double next = std::clamp(wanted, level_ - settings_.most_change, level_ + settings_.most_change);
    level_ = nearest_in_memory(next, stylus, proxy);
    count_wait(level_ != next, std::abs(wanted - level_));
    position_.store(pack(stylus), std::memory_order_relaxed);
    wanted_.store(wanted, std::memory_order_relaxed);
    set_.store(level_, std::memory_order_relaxed);
    return level_;
}

/// Level k+1 has no other samples than level k, so a box of any finer level will do.
bool LevelResidency::in_memory(int level, hfh::Cell stylus, hfh::Cell proxy) const noexcept {
    if (level >= whole_) return true;
    const hfh::VertexRange read =
        neighbourhood(levels_[static_cast<std::size_t>(level)], on_level(stylus, level),
                      on_level(proxy, level), settings_.reach);
    if (read.empty()) return true;
    for (int finer = level; finer >= 0; --finer) {
        if (contains(known_[static_cast<std::size_t>(finer)], read, level - finer)) return true;
    }
    return false;
}

double LevelResidency::nearest_in_memory(double level, hfh::Cell stylus, hfh::Cell proxy) const noexcept {
    const int k = static_cast<int>(level);
    if (in_memory(k, stylus, proxy)) return level;
    double nearest = whole_;
    for (int other = 0; other < whole_; ++other) {
        if (!in_memory(other, stylus, proxy)) continue;
        // A finer level is used up to the next one, which it does not reach.
        const double up_to = other > k ? other : std::nextafter(other + 1.0, 0.0);
        if (std::abs(up_to - level) < std::abs(nearest - level)) nearest = up_to;
    }
    return nearest;
}

void LevelResidency::count_wait(bool waits, double behind) noexcept {
    if (!waits) {
        waiting_ = 0;
        return;
    }
    waits_.waits += waiting_ == 0;
    ++waits_.updates;
    waits_.longest = std::max(waits_.longest, ++waiting_);
    waits_.farthest = std::max(waits_.farthest, behind);
}

void LevelResidency::run() {
    using Clock = std::chrono::steady_clock;
    run_at_low_priority();
    const auto position = [&] { return unpack(position_.load(std::memory_order_relaxed)); };
    hfh::Cell last = position();
    double last_wanted = wanted_.load(std::memory_order_relaxed);
    auto last_time = Clock::now(), last_whole = last_time;
    while (!stopping_) {
        std::this_thread::sleep_for(settings_.pause);
        if (Clock::now() - last_whole >= std::chrono::seconds{1}) { // in case the kernel took some back
            bring_in_whole();
            last_whole = Clock::now();
        }
        const hfh::Cell here = position();
        const double wanted = wanted_.load(std::memory_order_relaxed);
        const auto now = Clock::now();
        round(here, last, wanted, last_wanted, std::chrono::duration<double>(now - last_time).count());

        report_.longest_round = std::max<std::chrono::nanoseconds>(report_.longest_round, Clock::now() - now);
        ++report_.rounds;
        last = here;
        last_wanted = wanted;
        last_time = now;
    }
    report_.page_reads = page_reads_of_this_thread();
    report_.ranges = pages_.ranges();
}

/// The levels between the one that is set, the one wanted and the one that will be, nearest to the one set first.
void LevelResidency::round(hfh::Cell here, hfh::Cell before, double wanted, double wanted_before,
                           double elapsed) {
    constexpr double most_levels_ahead = 2;
    const double set = set_.load(std::memory_order_relaxed);
    const double ahead = std::clamp((wanted - wanted_before) * settings_.look_ahead / elapsed,
                                    -most_levels_ahead, most_levels_ahead);
    const auto level = [&](double x) { return static_cast<int>(std::clamp(x, 0.0, whole_ + 0.0)); };
    const int from = level(set), to = level(wanted), then = level(wanted + ahead);
    const int low = std::min({from, to, then}), high = std::max({from, to, then});

    for (int k = 0; k < whole_; ++k) {
        if (k < low || k > high) boxes_[static_cast<std::size_t>(k)] = {};
    }
    const auto bring_in_level = [&](int k) {
        if (k < low || k > std::min(high, whole_ - 1)) return;
        const ResidencySettings foresight{.look_ahead = settings_.look_ahead,
                                          .most_ahead = settings_.most_ahead << k};
        bring_in(k, on_level(here, k), on_level(foresee(before, here, elapsed, foresight), k));
    };
    bring_in_level(from);
    for (int far = 1; far <= high - low; ++far) {
        bring_in_level(from - far);
        bring_in_level(from + far);
    }
    brought_in_.put(boxes_);
}

void LevelResidency::bring_in_whole() {
    const SampleLayout& level = levels_[static_cast<std::size_t>(whole_)];
    pages_.bring_in(level, {{0, 0}, {level.columns, level.rows}}, 0, true);
}

void LevelResidency::bring_in(int level, hfh::Cell here, hfh::Cell there) {
    const auto k = static_cast<std::size_t>(level);
    const hfh::VertexRange box = neighbourhood(levels_[k], here, there, settings_.margin);
    pages_.bring_in(levels_[k], box, here.j, there.j >= here.j);
    boxes_[k] = box;
    brought_in_.put(boxes_);
}

} // namespace large_terrain
