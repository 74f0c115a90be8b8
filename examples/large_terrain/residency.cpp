#include "residency.hpp"

#include <cmath>

namespace large_terrain {

hfh::Cell foresee(hfh::Cell before, hfh::Cell here, double elapsed,
                  const ResidencySettings& settings) noexcept {
    const auto most = static_cast<double>(settings.most_ahead);
    const auto along = [&](hfh::Index from, hfh::Index at) {
        const double ahead = static_cast<double>(at - from) * (settings.look_ahead / elapsed);
        return at + std::lround(std::clamp(ahead, -most, most));
    };
    return {along(before.i, here.i), along(before.j, here.j)};
}

Residency::Residency(const SampleLayout& layout, hfh::Cell here, const ResidencySettings& settings)
    : layout_{layout}, settings_{settings} {
    note(here);
    bring_in(here, here);
    thread_ = std::thread{[this] { run(); }};
}

void Residency::stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
}

void Residency::run() {
    using Clock = std::chrono::steady_clock;
    run_at_low_priority();
    hfh::Cell last = unpack(position_.load(std::memory_order_relaxed));
    auto last_time = Clock::now();
    while (!stopping_) {
        std::this_thread::sleep_for(settings_.pause);
        const hfh::Cell here = unpack(position_.load(std::memory_order_relaxed));
        const auto now = Clock::now();
        const double elapsed = std::chrono::duration<double>(now - last_time).count();
        bring_in(here, foresee(last, here, elapsed, settings_));

        report_.longest_round = std::max<std::chrono::nanoseconds>(report_.longest_round, Clock::now() - now);
        ++report_.rounds;
        last = here;
        last_time = now;
    }
    report_.page_reads = page_reads_of_this_thread();
    report_.ranges = pages_.ranges();
}

void Residency::bring_in(hfh::Cell here, hfh::Cell there) {
    const hfh::VertexRange box = neighbourhood(layout_, here, there, settings_.margin);
    pages_.bring_in(layout_, box, here.j, there.j >= here.j);
}

} // namespace large_terrain
