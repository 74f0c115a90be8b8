#include "haptic_thread.hpp"

#include <numbers.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>

#include <pthread.h>
#include <sys/prctl.h>
#include <sys/resource.h>

namespace viewer {
namespace {

constexpr std::int64_t period = 1'000'000; ///< ns

std::int64_t now() noexcept {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

void sleep_until(std::int64_t ns) noexcept {
    const timespec time{static_cast<std::time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) != 0) {
    }
}

/// A haptic loop comes before everything else, where the system allows it.
bool ask_for_real_time() noexcept {
    ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL); // for where it does not
    sched_param parameters{};
    parameters.sched_priority = 50;
    return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters) == 0;
}

long disk_reads() noexcept {
    rusage usage{};
    ::getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_majflt;
}

} // namespace

HapticThread::HapticThread(std::function<void()> tick) : tick_{std::move(tick)}, thread_{[this] { run(); }} {}

void HapticThread::stop() {
    stopping_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
}

void HapticThread::run() {
    punctuality_.real_time = ask_for_real_time();
    real_time_.store(punctuality_.real_time, std::memory_order_relaxed);
    const long reads_before = disk_reads();
    std::int64_t due = now() + period;
    while (!stopping_.load(std::memory_order_relaxed)) {
        sleep_until(due);
        const std::int64_t begin = now();
        tick_();
        const std::int64_t end = now(), lateness = begin - due;
        ++punctuality_.ticks;
        punctuality_.late += lateness > period;
        const auto at =
            std::ranges::find_if(lateness_class, [&](int most) { return lateness <= 1000 * most; });
        ++punctuality_.lateness[static_cast<std::size_t>(at - lateness_class.begin())];
        punctuality_.worst_lateness =
            std::max(punctuality_.worst_lateness, static_cast<std::uint64_t>(lateness));
        punctuality_.nanoseconds.add(static_cast<std::uint64_t>(end - begin));
        // The next instant of the clock's grid that has not passed.
        const std::int64_t steps = std::max<std::int64_t>(1, (end - due + period - 1) / period);
        punctuality_.skipped += static_cast<std::uint64_t>(steps - 1);
        due += steps * period;
    }
    punctuality_.disk_reads = disk_reads() - reads_before;
}

std::string report(const Punctuality& p) {
    const auto line = [](std::string name, const std::string& text) {
        name.resize(16, ' ');
        return name + text + "\n";
    };
    const auto us = [](std::uint64_t ns) { return demo::rounded(static_cast<double>(ns) / 1000); };
    std::string histogram;
    for (std::size_t k = 0; k < p.lateness.size(); ++k) {
        const std::string bound =
            k < lateness_class.size() ? "to " + std::to_string(lateness_class[k]) : "beyond";
        histogram += (k == 0 ? "" : ", ") + bound + ": " + demo::grouped(p.lateness[k]);
    }
    return line("haptic ticks",
                demo::grouped(p.ticks) + " at 1 kHz, " +
                    (p.real_time ? "SCHED_FIFO"
                                 : "without real-time priority, which the system does not allow")) +
           line("late", demo::grouped(p.late) + " by more than 1 ms, worst " + us(p.worst_lateness) +
                            " us; " + demo::grouped(p.skipped) + " skipped") +
           line("lateness (us)", histogram) +
           line("tick (us)", us(p.nanoseconds.quantile(0.5)) + " median, " +
                                 us(p.nanoseconds.quantile(0.999)) + " at 99.9 %, " +
                                 us(p.nanoseconds.worst()) +
                                 " worst; page faults that read the disk: " + std::to_string(p.disk_reads));
}

} // namespace viewer
