#ifndef HFH_BENCH_ACCURACY_QUERY_SETS_HPP
#define HFH_BENCH_ACCURACY_QUERY_SETS_HPP

#include <hfh/geometry/bilinear_patch.hpp>
#include <hfh/geometry/lattice.hpp>

#include <random.hpp>
#include <real_terrains.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

// What is asked: one patch and one stylus below it, as a tracker asks when the proxy is on that patch.

namespace accuracy {

using hfh::Real;

template <Real T>
struct Query {
    hfh::BilinearPatch<T> patch;
    hfh::CellPoint<T> at;
};

template <Real T>
[[nodiscard]] std::vector<Query<T>> rounded(const std::vector<Query<double>>& queries) {
    std::vector<Query<T>> out;
    out.reserve(queries.size());
    const auto r = [](double x) { return static_cast<T>(x); };
    for (const auto& [p, q] : queries) {
        out.push_back({{r(p.p00), r(p.p10), r(p.p01), r(p.p11), {r(p.spacing.x), r(p.spacing.y)}},
                       {r(q.u), r(q.v), r(q.z)}});
    }
    return out;
}

/// Where every Newton method starts: over the query, kept in the cell.
template <Real T>
[[nodiscard]] hfh::vec2<T> start(const Query<T>& query) {
    return {std::clamp(query.at.u, T(0), T(1)), std::clamp(query.at.v, T(0), T(1))};
}

/// An answer on the patch.
template <Real T>
struct SurfaceFoot {
    T u{}, v{};
    bool gave_up = false; ///< the method says itself that it did not finish
};

/// An answer on a surface that stands for the patch.
template <Real T>
struct FacetFoot {
    T u{}, v{}, z{};        ///< z in metres over the query
    T slope_u{}, slope_v{}; ///< metres per cell
};

/// In cells, the side of a square as large as the cell.
struct Depth {
    const char* name;
    double least, most;
};

struct QuerySet {
    std::string terrain, depth, about;
    std::vector<Query<double>> queries;

    [[nodiscard]] std::string name() const { return terrain + ", " + depth; }
};

/// The stylus is `depth` cells below a point of the patch or of its continuation by a quarter of a cell: as far as the
/// hand gets between two updates. Straight down the normal there.
inline Query<double> query_below(hfh::test::Random& random, const hfh::BilinearPatch<double>& patch,
                                 const Depth& depth) {
    const double u = random.between(-0.25, 1.25), v = random.between(-0.25, 1.25);
    const auto inward = patch.normal(u, v);
    const double cell = std::sqrt(patch.spacing.x * patch.spacing.y);
    const double by = random.between(depth.least, depth.most) * cell;
    return {patch,
            {u - by * inward.x / patch.spacing.x, v - by * inward.y / patch.spacing.y,
             patch.height(u, v) - by * inward.z}};
}

/// On cells of a real terrain drawn at random; empty if its file is absent.
inline std::vector<Query<double>> real_queries(const std::string& file, const Depth& depth, std::size_t count,
                                               std::uint64_t seed) {
    std::vector<Query<double>> queries;
    const auto ground = hfh::test::real_terrain<double>(file);
    if (!ground) return queries;
    hfh::test::Random random{seed};
    while (queries.size() < count) {
        const auto i = static_cast<hfh::Index>(random.whole(0, ground->columns - 2));
        const auto j = static_cast<hfh::Index>(random.whole(0, ground->rows - 2));
        const hfh::BilinearPatch<double> patch{ground->at(i, j), ground->at(i + 1, j), ground->at(i, j + 1),
                                               ground->at(i + 1, j + 1), ground->frame.spacing};
        if (std::isnan(patch.p00 + patch.p10 + patch.p01 + patch.p11)) continue;
        queries.push_back(query_below(random, patch, depth));
    }
    return queries;
}

/// On cells of 1 × ½…2 m with four unrelated heights, 1 to 1000 cells of relief, evenly over its powers of ten.
inline std::vector<Query<double>> hard_queries(const Depth& depth, std::size_t count, std::uint64_t seed) {
    std::vector<Query<double>> queries;
    hfh::test::Random random{seed};
    while (queries.size() < count) {
        const double dy = std::pow(2.0, random.between(-1, 1));
        hfh::BilinearPatch<double> patch{
            random.unit(), random.unit(), random.unit(), random.unit(), {1.0, dy}};
        const double relief = std::pow(10.0, random.between(0, 3)) * std::sqrt(dy);
        const double scale = relief / (patch.highest() - patch.lowest());
        for (double* p : {&patch.p00, &patch.p10, &patch.p01, &patch.p11}) *p *= scale;
        queries.push_back(query_below(random, patch, depth));
    }
    return queries;
}

/// Six sets, or two where the real terrains are absent.
inline std::vector<QuerySet> query_sets(std::size_t count) {
    constexpr Depth shallow{"shallow", 0.0, 0.1}, deep{"deep", 1.0, 5.0}, deeper{"deep", 1.0, 20.0};
    const std::string at_most_a_tenth = "at most 0.1 cells below", one_to_five = "1 to 5 cells below",
                      one_to_twenty = "1 to 20 cells below";
    std::vector<QuerySet> sets{
        {"gentle", "shallow", "enoriver, 8.3 x 10.3 m, " + at_most_a_tenth,
         real_queries("enoriver", shallow, count, 11)},
        {"gentle", "deep", "enoriver, 8.3 x 10.3 m, " + one_to_five,
         real_queries("enoriver", deep, count, 12)},
        {"steep", "shallow", "swissalps_voids, 64 x 93 m, " + at_most_a_tenth,
         real_queries("swissalps_voids", shallow, count, 21)},
        {"steep", "deep", "swissalps_voids, 64 x 93 m, " + one_to_five,
         real_queries("swissalps_voids", deep, count, 22)},
        {"hard", "shallow", "four unrelated heights, relief 1 to 1000 cells, " + at_most_a_tenth,
         hard_queries(shallow, count, 31)},
        {"hard", "deep", "four unrelated heights, relief 1 to 1000 cells, " + one_to_twenty,
         hard_queries(deeper, count, 32)}};
    std::erase_if(sets, [](const QuerySet& set) { return set.queries.empty(); });
    return sets;
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_QUERY_SETS_HPP
