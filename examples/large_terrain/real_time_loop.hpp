#ifndef LARGE_TERRAIN_REAL_TIME_LOOP_HPP
#define LARGE_TERRAIN_REAL_TIME_LOOP_HPP

#include "journey.hpp"
#include "residency.hpp"

#include <distribution.hpp>

#include <hfh/hfh.hpp>

#include <bit>
#include <chrono>
#include <cstdint>

#include <pthread.h>
#include <sys/resource.h>

// The real-time loop: a journey over the terrain, one update a millisecond, and what the clock and the kernel say.

namespace large_terrain {

struct SessionReport {
    std::uint64_t updates = 0;
    std::uint64_t in_contact = 0;
    std::uint64_t waited = 0;             ///< updates that waited for a page from the disk, however long
    std::uint64_t too_long = 0;           ///< updates of 1 ms and more
    std::uint64_t too_long_for_disk = 0;  ///< of these: the thread waited for the disk
    std::uint64_t too_long_preempted = 0; ///< of these: it did not, but the scheduler ran something else
    std::uint64_t woken_late = 0;         ///< updates that began 1 ms or more after their time
    demo::Distribution nanoseconds;       ///< an update itself, tracker and force
    demo::Distribution lateness; ///< ns from when the update was due to when the scheduler let it begin
    long page_reads = 0;         ///< faults that waited for the disk (ru_majflt), within updates
    long thread_page_reads = 0;  ///< the same, within updates and between them
    long page_maps = 0;          ///< faults that did not (ru_minflt), within updates
    bool real_time = false;      ///< ran as SCHED_FIFO
    std::uint64_t answers = 0;   ///< a digest of every contact and force
};

/// What a session needs to know beside the heights.
struct Session {
    hfh::GridFrame frame;
    std::uint64_t updates = 0;
    double cells_per_second = 1000;
    bool paced = true; ///< by the clock; else as fast as it goes
};

/// The height from which the stylus comes down at the beginning of the journey: 20 cells above the ground there.
template <class Heights>
[[nodiscard]] double start_height(const Heights& heights, const Session& session) noexcept {
    const hfh::BilinearGrid<double, Heights> grid{heights, session.frame};
    const glm::dvec2 at = Journey{heights.columns(), heights.rows(), session.cells_per_second}.at();
    const auto patch = grid.patch({static_cast<hfh::Index>(at.x), static_cast<hfh::Index>(at.y)});
    return (patch ? patch->highest() : 0.0) + 20 * session.frame.spacing.x;
}

namespace detail {

inline void digest(std::uint64_t& into, double value) noexcept {
    into = (into ^ std::bit_cast<std::uint64_t>(value)) * 0x9e37'79b9'7f4a'7c15u;
    into ^= into >> 32;
}

inline rusage usage_of_this_thread() noexcept {
    rusage usage{};
    ::getrusage(RUSAGE_THREAD, &usage);
    return usage;
}

/// A haptic loop comes before everything else, where the system allows it.
inline bool ask_for_real_time() noexcept {
    sched_param parameters{};
    parameters.sched_priority = 50;
    return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters) == 0;
}

} // namespace detail

/// Runs `updates` updates in the calling thread, one a millisecond if it is paced, else as fast as it goes, and writes down
/// what the clock and the kernel say: `update` is what is timed, `afterwards` what follows it.
template <class Update, class Afterwards>
void run_updates(SessionReport& report, std::uint64_t updates, bool paced, Update&& update,
                 Afterwards&& afterwards) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds period{1};
    const auto in_ns = [](auto span) {
        return static_cast<std::uint64_t>(std::max<std::int64_t>(0, span / std::chrono::nanoseconds{1}));
    };

    report.real_time = paced && detail::ask_for_real_time();
    const long reads_of_others = detail::usage_of_this_thread().ru_majflt;
    auto due = Clock::now() + period;
    for (; report.updates < updates; ++report.updates) {
        if (paced) std::this_thread::sleep_until(due);
        const rusage before = detail::usage_of_this_thread();
        const auto start = Clock::now();
        update();
        const auto stop = Clock::now();

        const rusage after = detail::usage_of_this_thread();
        const long reads = after.ru_majflt - before.ru_majflt;
        // A page that is on its way already counts as no read, but the thread gives way while it waits.
        const bool waited = reads > 0 || after.ru_nvcsw != before.ru_nvcsw;
        const bool preempted = after.ru_nivcsw != before.ru_nivcsw;
        report.waited += waited;
        report.page_reads += reads;
        report.page_maps += after.ru_minflt - before.ru_minflt;
        report.nanoseconds.add(in_ns(stop - start));
        if (stop - start >= period) {
            ++report.too_long;
            report.too_long_for_disk += waited;
            report.too_long_preempted += !waited && preempted;
        }
        report.lateness.add(in_ns(start - due));
        report.woken_late += start - due >= period;
        // A late update is not made up for by a burst of others: the clock starts anew from it.
        due = std::max(due + period, stop);
        afterwards();
    }
    report.thread_page_reads = detail::usage_of_this_thread().ru_majflt - reads_of_others;
}

/// Runs a session in the calling thread, from `z` down to the ground and along it. The hand presses half a cell deep: it
/// knows no more of the ground than what it felt in the last update. `helper` may be null.
template <class Heights>
[[nodiscard]] SessionReport run_session(const Heights& heights, const Session& session, double z,
                                        Residency* helper) {
    const hfh::BilinearGrid<double, Heights> grid{heights, session.frame};
    const glm::dvec2 cell = session.frame.spacing;
    hfh::ProxyTracker tracker{grid};
    const hfh::ForceEvaluator<double> force{.stiffness = 500, .max_force = 3.3};
    Journey journey{heights.columns(), heights.rows(), session.cells_per_second};

    SessionReport report;
    hfh::Contact<double> contact;
    hfh::Force<double> felt;
    const auto update = [&] {
        const glm::dvec2 at = journey.at();
        if (helper != nullptr) helper->note({static_cast<hfh::Index>(at.x), static_cast<hfh::Index>(at.y)});
        contact = tracker.update({at.x * cell.x, at.y * cell.y, z});
        felt = force(contact);
    };
    run_updates(report, session.updates, session.paced, update, [&] {
        report.in_contact += contact.touching();
        for (int k = 0; k < 3; ++k) {
            detail::digest(report.answers, contact.proxy[k]);
            detail::digest(report.answers, felt.newtons[k]);
        }
        detail::digest(report.answers, static_cast<double>(contact.status));

        if (contact.touching() || contact.status == hfh::ContactStatus::free) {
            z = contact.proxy.z - 0.5 * cell.x;
        } else if (contact.status ==
                   hfh::ContactStatus::buried) { // came in from a hole: up, to come down from outside
            z += 2 * cell.x;
        }
        journey.advance();
    });
    return report;
}

} // namespace large_terrain

#endif // LARGE_TERRAIN_REAL_TIME_LOOP_HPP
