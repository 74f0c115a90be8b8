#ifndef HFH_BENCH_ACCURACY_MEASURE_HPP
#define HFH_BENCH_ACCURACY_MEASURE_HPP

#include "methods.hpp"
#include "still_to_gain.hpp"

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <stdexcept>

// Time and error of all methods on the same queries.

namespace accuracy {

/// Of one kind of error over a query set.
struct Spread {
    double mean = 0, most = 0, largest = 0; ///< most: 99.9 % of the queries have no more

    [[nodiscard]] static Spread of(std::vector<double>& errors) {
        std::sort(errors.begin(), errors.end());
        double sum = 0;
        for (const double error : errors) sum += error;
        const auto count = errors.size();
        return {sum / static_cast<double>(count), errors[(count * 999 + 999) / 1000 - 1], errors.back()};
    }
};

struct Figures {
    Title title;
    double nanoseconds = 0;       ///< per query
    Spread distance, foot, angle; ///< cells, cells, degrees
    double wrong = 0;             ///< share with a distance off by more than the tolerance
    double unfinished = 0;        ///< share from which going downhill gains more than the tolerance
    double gave_up = 0;           ///< share of which the method itself says that it did not finish
};

struct Measured {
    std::string terrain, depth, about, scalar;
    std::vector<Figures> methods;

    [[nodiscard]] std::string name() const { return terrain + ", " + depth; }
};

/// "Wrong" begins at this times `size_of_problem`.
template <Real T>
inline constexpr Wide tolerance = std::same_as<T, double> ? 1e-12L : 4e-6L;

/// Judges the answers of one method. `feet` are the oracle's, per query.
template <Real T>
[[nodiscard]] Figures judged(const Method<T>& method, const std::vector<Query<T>>& queries,
                             const std::vector<Feet>& feet) {
    Figures figures;
    figures.title = method.title;
    std::vector<double> distance, foot, angle;
    std::size_t wrong = 0, unfinished = 0, gave_up = 0;
    const bool on_patch = method.title.family != Family::triangles;
    for (std::size_t k = 0; k < queries.size(); ++k) {
        const SeenPatch patch = seen(queries[k]);
        const Claim claimed = method.answer(patch, k);
        const Wide nearest = feet[k].front().distance, found = length(claimed.foot);
        const Wide size = size_of_problem(patch, nearest), slack = tolerance<T> * size;
        if (!(on_patch ? found >= nearest - 1e-17L * size : std::isfinite(found)))
            throw std::runtime_error{method.title.name + " found a nearer point than the oracle, or none."};

        // Of feet that are equally near (the medial axis) the one that was found counts.
        Wide off = std::numeric_limits<Wide>::max(), turned = 0;
        for (const LocalFoot& known : feet[k]) {
            if (known.distance > nearest + slack) break;
            const Wide apart = length(claimed.foot - patch.at(known.u, known.v));
            if (apart >= off) continue;
            off = apart;
            const Point n = patch.normal(known.u, known.v);
            turned = std::atan2(length(cross(claimed.normal, n)), dot(claimed.normal, n));
        }
        distance.push_back(static_cast<double>(std::abs(found - nearest) / patch.cell()));
        foot.push_back(static_cast<double>(off / patch.cell()));
        angle.push_back(static_cast<double>(turned * (180 / std::acos(Wide(-1)))));
        wrong += std::abs(found - nearest) > slack;
        gave_up += claimed.gave_up;
        if (on_patch) unfinished += still_to_gain(patch, claimed.u, claimed.v) > slack;
    }
    const auto share = [&](std::size_t of) {
        return static_cast<double>(of) / static_cast<double>(queries.size());
    };
    figures.distance = Spread::of(distance);
    figures.foot = Spread::of(foot);
    figures.angle = Spread::of(angle);
    figures.wrong = share(wrong);
    figures.unfinished = share(unfinished);
    figures.gave_up = share(gave_up);
    return figures;
}

/// Nanoseconds a query of each method. Batch after batch of independent queries, back to back, a batch being too long
/// for a branch predictor to learn; the methods take turns at a batch, in another order each round, so that none
/// profits from what comes before it. The clock is read every slice of a batch, and of each method and slice the
/// quickest of the rounds counts: a slice is short enough to pass undisturbed on a busy machine.
template <Real T>
[[nodiscard]] std::vector<double> timed(const std::vector<std::unique_ptr<Method<T>>>& all,
                                        const std::vector<Query<T>>& queries, int rounds) {
    using Clock = std::chrono::steady_clock;
    using Nanoseconds = std::chrono::duration<double, std::nano>;
    constexpr std::size_t slice = 500, batch = 20 * slice;
    const std::size_t slices = (queries.size() + slice - 1) / slice;
    std::vector<std::vector<double>> quickest(
        all.size(), std::vector<double>(slices, std::numeric_limits<double>::max()));
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    hfh::test::Random random{41};
    for (const auto& method : all) method->run(queries, 0, queries.size());
    for (std::size_t first = 0; first < queries.size(); first += batch) {
        const std::size_t last = std::min(first + batch, queries.size());
        for (int round = 0; round < rounds; ++round) {
            for (std::size_t k = order.size() - 1; k > 0; --k) {
                const auto other = random.whole(0, static_cast<std::int64_t>(k));
                std::swap(order[k], order[static_cast<std::size_t>(other)]);
            }
            for (const std::size_t m : order) {
                auto before = Clock::now();
                for (std::size_t from = first; from < last; from += slice) {
                    all[m]->run(queries, from, std::min(from + slice, last));
                    const auto now = Clock::now();
                    double& least = quickest[m][from / slice];
                    least = std::min(least, Nanoseconds(now - before).count());
                    before = now;
                }
            }
        }
    }
    std::vector<double> times;
    for (const auto& of_slices : quickest) {
        times.push_back(std::accumulate(of_slices.begin(), of_slices.end(), 0.0) /
                        static_cast<double>(queries.size()));
    }
    return times;
}

/// Measures all methods in T on one set. The answers that are judged are those of the last timed round.
template <Real T>
[[nodiscard]] Measured measured(const QuerySet& set, int rounds) {
    const auto queries = rounded<T>(set.queries);
    const auto all = methods<T>();
    const auto times = timed(all, queries, rounds);
    std::vector<Feet> feet;
    feet.reserve(queries.size());
    for (const auto& query : queries) feet.push_back(closest_points(seen(query)));

    Measured out{set.terrain, set.depth, set.about, std::same_as<T, double> ? "double" : "float", {}};
    for (std::size_t m = 0; m < all.size(); ++m) {
        out.methods.push_back(judged(*all[m], queries, feet));
        out.methods.back().nanoseconds = times[m];
    }
    return out;
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_MEASURE_HPP
