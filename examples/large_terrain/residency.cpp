#include "residency.hpp"

#include <cmath>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifndef MADV_POPULATE_READ // Linux 5.14
#define MADV_POPULATE_READ 22
#endif

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
    : layout_{layout}, settings_{settings}, page_{static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE))} {
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
    // Below everything else of this program. Linux takes a thread for a process here.
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 10);

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
    rusage usage{};
    if (::getrusage(RUSAGE_THREAD, &usage) == 0) report_.page_reads = usage.ru_majflt;
}

void Residency::bring_in(hfh::Cell here, hfh::Cell there) {
    const hfh::VertexRange box = neighbourhood(layout_, here, there, settings_.margin);
    const auto each = [&](auto&& visit) {
        for_each_page_range(layout_, box, here.j, there.j >= here.j, page_, visit);
    };
    const auto advise = [](const PageRange& range, int advice) {
        return ::madvise(reinterpret_cast<void*>(range.begin), range.end - range.begin, advice) == 0;
    };
    // First all reads are asked for, so that the disk has them at the same time; then each is waited for and its pages
    // are mapped, what is nearest and ahead first.
    each([&](const PageRange& range) {
        (void)advise(range, MADV_WILLNEED);
        ++report_.ranges;
    });
    each([&](const PageRange& range) {
        can_populate_ = can_populate_ && advise(range, MADV_POPULATE_READ);
        if (can_populate_) return;
        for (std::uintptr_t at = range.begin; at < range.end; at += page_) {
            (void)*reinterpret_cast<const volatile char*>(at);
        }
    });
}

} // namespace large_terrain
