#include "strokes.hpp"

#include <hfh/geometry/global_closest_point.hpp>

// The trajectory of a sliding stylus, through trees that find the closest of two triangles a cell.

namespace hfh::bench {
namespace {

constexpr std::size_t updates_a_stroke = 20'000, updates_a_slice = 1'000;
constexpr double steps[] = {0.1, 0.5, 2};

/// The closest distance to the bilinear surface: of every patch that may come nearer than `within`.
double exact_distance(const Terrain& ground, const glm::dvec3& query, double within) {
    const auto grid = ground.grid<double>();
    const auto& lattice = grid.lattice();
    const auto index = [](double cells) { return static_cast<Index>(std::floor(cells)); };
    const Index i0 = index((query.x - within) / ground.kind.spacing.x),
                i1 = index((query.x + within) / ground.kind.spacing.x),
                j0 = index((query.y - within) / ground.kind.spacing.y),
                j1 = index((query.y + within) / ground.kind.spacing.y);
    double nearest = std::numeric_limits<double>::max();
    for (Index j = j0; j <= j1; ++j) {
        for (Index i = i0; i <= i1; ++i) {
            const auto patch = grid.patch({i, j});
            if (!patch || patch->lowest() - query.z > within || query.z - patch->highest() > within) continue;
            const CellPoint<double> local{lattice.u_of(query.x, i), lattice.v_of(query.y, j), query.z};
            const auto foot = global_closest_point(*patch, local);
            const glm::dvec3 off{(foot.u - local.u) * ground.kind.spacing.x,
                                 (foot.v - local.v) * ground.kind.spacing.y, foot.gap};
            nearest = std::min(nearest, glm::length(off));
        }
    }
    return nearest;
}

struct Run {
    std::vector<glm::dvec3> stylus, proxies;
    Trace<double> trace;
};

Run make_run(double step) {
    const Terrain& ground = terrain(large_hills);
    Run run;
    run.stylus = positions(ground, wander(ground, updates_a_stroke, step), Way::sliding, 0.5);
    const auto grid = ground.grid<double>();
    run.trace = trace_of<double>(grid, run.stylus, updates_a_slice);
    check_trace(ground, run.trace, "sliding beside the peers");
    replay(grid, run.trace, [&](const Contact<double>& c) { run.proxies.push_back(c.proxy); });
    return run;
}

/// One peer on all three trajectories.
void measure(ClosestPeer& peer, const char* goal, const std::vector<Run>& runs, Findings& into) {
    const Terrain& ground = terrain(large_hills);
    for (std::size_t s = 0; s < std::size(steps); ++s) {
        const Run& run = runs[s];
        std::vector<glm::dvec3> found(run.stylus.size());
        const auto follow = [&](std::size_t slice) {
            const std::size_t first = slice * updates_a_slice;
            // Begins at a point of the surface: the sample nearest to the stylus.
            const auto near = [&](double x, double spacing) { return std::round(x / spacing) * spacing; };
            glm::dvec3 last{near(run.stylus[first].x, ground.kind.spacing.x),
                            near(run.stylus[first].y, ground.kind.spacing.y), 0};
            last.z = ground.surface(last.x, last.y);
            peer.follow(&run.stylus[first], updates_a_slice, last, &found[first]);
        };
        const auto paces = race({updates(ground, run.trace),
                                 {run.trace.before.size(), static_cast<double>(updates_a_slice), follow}},
                                12);
        double sum = 0, largest = 0, count = 0, missed = 0;
        for (std::size_t k = 0; k < found.size(); k += 20) {
            const double distance = glm::length(found[k] - run.stylus[k]);
            const double exact = exact_distance(ground, run.stylus[k], 1.5 * distance + 1e-9);
            const double off = std::abs(distance - exact);
            if (!(off < ground.cell())) missed += 1;
            sum += off, count += 1, largest = std::max(largest, off);
        }
        // Triangles are off by less than a cell; an answer that is not was not asked for rightly.
        if (missed > 0.01 * count) throw Fault{peer.name() + " misses closest points"};
        std::string errors = "distance off by " + text(sum / count) + " m, at most " + text(largest) + " m";
        if (missed > 0) errors += " (" + text(missed) + " of " + text(count) + " missed)";
        const double theirs = paces[1].fastest, ours = paces[0].fastest;
        into.numbers.push_back({goal, text(steps[s]) + " cells", theirs / ours, {theirs, ours}, errors});
    }
}

} // namespace

Findings closest_peers(const Settings&) {
    std::vector<Run> runs;
    for (const double step : steps) runs.push_back(make_run(step));
    Findings found;
#ifdef HFH_HAS_EMBREE
    measure(*embree_point_query(for_peers(terrain(large_hills))), "closest_embree", runs, found);
#else
    found.skipped.push_back({"closest_embree", "Embree 3 is not installed"});
#endif
#ifdef HFH_HAS_CGAL
    measure(*cgal_aabb_tree(for_peers(terrain(large_hills))), "closest_cgal", runs, found);
#else
    found.skipped.push_back({"closest_cgal", "CGAL is not installed"});
#endif
    return found;
}

} // namespace hfh::bench
