#include "bounded.hpp"
#include "mapped.hpp"
#include "strokes.hpp"

#include <hfh/traversal/nearest_point.hpp>

#include <functional>

// The nearest point of the whole surface to queries anywhere, above and below, with bounds and without, beside trees of two
// triangles a cell. Each peer is built, timed against the library and freed before the next one. A peer is given the point of
// its triangles over or under the query, which bounds its query as tightly as the library's own begins.

namespace hfh::bench {
namespace {

struct Reach {
    double cells; ///< over or under the surface
    std::size_t queries, a_slice;
    bool bounded; ///< whether the goal is for a field with bounds
};
constexpr Reach reaches[] = {
    {0.01, 32'768, 1'024, false}, {1, 16'384, 512, false}, {5, 8'192, 256, true}, {50, 2'048, 64, true}};
constexpr int rounds = 5;

struct Queries {
    std::vector<glm::dvec3> at, begin, theirs;
    std::vector<double> distance; ///< ours
};

/// Height of the peers' triangles at a place in cells.
template <class G>
double triangle_height(const G& ground, const glm::dvec2& cells) {
    const Index i = static_cast<Index>(cells.x), j = static_cast<Index>(cells.y);
    const double u = cells.x - static_cast<double>(i), v = cells.y - static_cast<double>(j);
    const double p00 = ground.sample(i, j), p11 = ground.sample(i + 1, j + 1);
    const double beside = u > v ? ground.sample(i + 1, j) : ground.sample(i, j + 1);
    return u > v ? p00 + u * (beside - p00) + v * (p11 - beside)
                 : p00 + v * (beside - p00) + u * (p11 - beside);
}

/// Of the query's nearest point with bounds and without: equal, and not farther than it was put.
template <class G, HeightField Field, HeightField BoundedField>
Queries make_queries(const G& ground, const Reach& reach, const Field& grid, const BoundedField& bounded) {
    Random random{31};
    Queries made;
    const glm::dvec2 spacing = ground.kind.spacing;
    while (made.at.size() < reach.queries) {
        const glm::dvec2 cells{static_cast<double>(ground.kind.columns - 1) * random.unit(),
                               static_cast<double>(ground.kind.rows - 1) * random.unit()};
        const glm::dvec2 plan = cells * spacing;
        const double off = (made.at.size() % 2 == 0 ? 1 : -1) * reach.cells * ground.cell();
        made.at.push_back({plan, ground.surface(plan.x, plan.y) + off});
        made.begin.push_back({plan, triangle_height(ground, cells)});
        const auto plain = nearest_point(grid, made.at.back()),
                   pruned = nearest_point(bounded, made.at.back());
        const double size = std::abs(off) + 2 * ground.cell();
        if (plain.status != NearestStatus::found || pruned.status != NearestStatus::found ||
            plain.distance > std::abs(off) + 1e-12 * size ||
            std::abs(plain.distance - pruned.distance) > 1e-12 * size) {
            throw Fault{"a nearest point is wrong"};
        }
        made.distance.push_back(plain.distance);
    }
    made.theirs.resize(made.at.size());
    return made;
}

double sum = 0; ///< of what is found, so that finding it is not left out

/// Runs visit(k) for the queries of a slice. Runners of one race begin at different ones, a third of all apart: none finds in
/// the caches what the one before it has just read.
template <class Visit>
Runner over(const Queries& queries, const Reach& reach, std::size_t thirds, Visit visit) {
    const std::size_t slices = queries.at.size() / reach.a_slice;
    return {slices, static_cast<double>(reach.a_slice), [=](std::size_t slice) {
                const std::size_t begin = (slice + thirds * slices / 3) % slices * reach.a_slice;
                for (std::size_t k = begin; k < begin + reach.a_slice; ++k) visit(k);
            }};
}
template <HeightField Field>
Runner find(const Field& field, const Queries& queries, const Reach& reach, std::size_t thirds) {
    return over(queries, reach, thirds, [&](std::size_t k) {
        const auto found = nearest_point(field, queries.at[k]);
        sum += found.distance + found.normal.z + found.position.x;
    });
}
/// Height and normal over the same places.
template <HeightField Field>
Runner evaluate(const Field& field, const Queries& queries, const Reach& reach) {
    return over(queries, reach, 0, [&](std::size_t k) {
        const auto there = surface_at(field, glm::dvec2{queries.at[k]});
        if (there) sum += there->height + there->normal.z;
    });
}

/// How far a peer's distances are from the true ones.
std::string errors_of(const Queries& queries, const std::string& peer, double cell) {
    double total = 0, largest = 0, missed = 0;
    for (std::size_t k = 0; k < queries.at.size(); ++k) {
        const double off = std::abs(glm::length(queries.theirs[k] - queries.at[k]) - queries.distance[k]);
        total += off;
        largest = std::max(largest, off);
        missed += off < cell ? 0 : 1;
    }
    const double count = static_cast<double>(queries.at.size());
    // Triangles are off by less than a cell; an answer that is not was not asked for rightly.
    if (missed > 0.01 * count) throw Fault{peer + " misses nearest points"};
    return peer + "'s distance is off by " + text(total / count) + " m, at most " + text(largest) + " m";
}

template <class G>
void on(const G& ground, bool with_cgal, Findings& into) {
    const auto grid = ground.template grid<double>();
    Bounded bounds{grid};
    if (!bounds.build()) throw Fault{"no bounds"};
    const auto& bounded = bounds.field();
    const double cells = static_cast<double>((ground.kind.columns - 1) * (ground.kind.rows - 1));
    const std::string size = text(cells / 1e6) + " M";

    std::vector<Queries> all;
    for (const Reach& reach : reaches) all.push_back(make_queries(ground, reach, grid, bounded));
    const auto evaluated =
        race({evaluate(grid, all[0], reaches[0]), find(grid, all[0], reaches[0], 1)}, rounds);
    into.numbers.push_back({"nearest_evaluation",
                            size,
                            evaluated[1].fastest / evaluated[0].fastest,
                            {evaluated[0].fastest, evaluated[1].fastest}});

    const auto beside = [&](const std::unique_ptr<ClosestPeer>& peer) {
        for (std::size_t r = 0; r < std::size(reaches); ++r) {
            const Reach& reach = reaches[r];
            Queries& queries = all[r];
            const auto theirs = over(queries, reach, 0, [&](std::size_t k) {
                peer->follow(&queries.at[k], 1, queries.begin[k], &queries.theirs[k]);
            });
            const auto paces =
                race({theirs, find(grid, queries, reach, 1), find(bounded, queries, reach, 2)}, rounds);
            const std::string errors = errors_of(queries, peer->name(), ground.cell());
            const std::string figure = text(reach.cells) + " cells, " + size + ", " + peer->name();
            for (const bool with_bounds : {false, true}) {
                const double ours = paces[with_bounds ? 2 : 1].fastest;
                const char* const goal = with_bounds != reach.bounded ? "nearest_other"
                                         : reach.bounded              ? "nearest_far"
                                                                      : "nearest_near";
                into.numbers.push_back({goal,
                                        figure + (with_bounds ? ", with bounds" : ""),
                                        paces[0].fastest / ours,
                                        {paces[0].fastest, ours},
                                        errors});
            }
        }
    };
#ifdef HFH_HAS_EMBREE
    beside(embree_point_query(for_peers(ground)));
#else
    into.skipped.push_back({"nearest_near", "Embree 3 is not installed"});
#endif
#ifdef HFH_HAS_CGAL
    if (with_cgal) {
        beside(cgal_aabb_tree(for_peers(ground)));
    } else {
        into.skipped.push_back(
            {"nearest_near", "CGAL's tree of 16.8 M cells takes 6 GB of memory: target bench_full"});
    }
#else
    into.skipped.push_back({"nearest_near", "CGAL is not installed"});
#endif
}

} // namespace

Findings nearest(const Settings& settings) {
    Findings found;
    on(terrain(small_hills), true, found);
    on(hills_in_memory("hills", 4097, 4097), settings.vast && available_memory() > 8e9, found);
    if (std::isnan(sum)) throw Fault{"a nearest point is no number"};
    return found;
}

} // namespace hfh::bench
