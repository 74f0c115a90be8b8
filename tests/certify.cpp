// The promises of the library at full count, with a line for each. Oracles as in the tests, which run a sample:
//
//     hfh_certify PART SCALAR SHARE      PART closest_point, steps, nearest, descent, flow, first_hit, tracker,
//                                        ball, ball_sweep, limited, flat or all
//                                        SCALAR float or double, SHARE of the full count, 1 for all of it
//
// Exits with 1 if a promise was broken.

#include "support/ball_strokes.hpp"
#include "support/ball_sweeps.hpp"
#include "support/brute_force_hit.hpp"
#include "support/hard_ground.hpp"
#include "support/hard_patches.hpp"
#include "support/limited_work.hpp"
#include "support/nearest_judge.hpp"
#include "support/real_terrains.hpp"
#include "support/scenes.hpp"
#include "support/step_judge.hpp"
#include "support/witness.hpp"

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/geometry/global_closest_point.hpp>
#include <hfh/terrain/min_max_pyramid.hpp>
#include <hfh/traversal/nearest_point.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

using namespace hfh;
using namespace hfh::test;

double share = 1;
bool broken = false;

[[nodiscard]] long counted(double full) { return std::max(1L, std::lround(full * share)); }

template <Real T>
constexpr const char* name = std::is_same_v<T, float> ? "float" : "double";

void report(const char* part, const char* scalar, const std::string& what, long wrong) {
    std::printf("%-13s %-6s %s: %s\n", part, scalar, what.c_str(), wrong == 0 ? "kept" : "BROKEN");
    std::fflush(stdout);
    broken = broken || wrong > 0;
}

/// `printf` into a string.
template <class... Args>
[[nodiscard]] std::string text(const char* format, Args... args) {
    char buffer[512];
    std::snprintf(buffer, sizeof buffer, format, args...);
    return buffer;
}

/// Wrong: farther than the scan by more than 1e-12 (float: 4e-6) of the largest length.
template <Real T>
void closest_point() {
    const Wide promise = std::is_same_v<T, float> ? 4e-6L : 1e-12L;
    Random random{101};
    long wrong = 0, certified = 0, cut_short = 0;
    int most = 0;
    Wide worst = 0;
    const long count = counted(1e7);
    for (long n = 0; n < count; ++n) {
        const auto c = hard_patch_case<T>(random);
        const auto found = global_closest_point(c.patch, c.query);
        const SeenPatch seen{c};
        const Wide nearest = scanned_distance(seen);
        const Wide error = (seen.distance(static_cast<Wide>(found.u), static_cast<Wide>(found.v)) - nearest) /
                           seen.size(nearest);
        wrong += !(error <= promise);
        worst = std::max(worst, error);
        certified += found.status == GlobalStatus::certified;
        cut_short += found.status == GlobalStatus::interval_limit;
        most = std::max(most, found.intervals);
    }
    report("closest_point", name<T>,
           text("%ld queries, %ld wrong, worst error %.2g, %.1f %% certified without a search, at most %d "
                "intervals, %ld searches "
                "cut short at %d",
                count, wrong, static_cast<double>(worst),
                100.0 * static_cast<double>(certified) / static_cast<double>(count), most, cut_short,
                GlobalClosestPoint<T>::max_intervals),
           wrong);
}

/// Every terrain there is, the real ones with their names.
template <Real T, class Each>
void each_terrain(Each&& each) {
    for (const auto& names : {real_terrains_without_holes, real_terrains_with_holes}) {
        for (const auto& terrain : names) {
            if (const auto ground = real_terrain<T>(terrain)) each(terrain.c_str(), *ground);
        }
    }
    for (const auto& scene : scenes<T>()) each(scene.name, scene.terrain);
}

/// The nearest point of a whole field, from 10⁻⁶ to 100 cells away, with bounds and without: wrong if the distance is too
/// large by more than 1e-12 (float: 4e-6) of the largest length, or if anything else of the result is not true. A fifth of
/// the queries each on real terrains with and without holes and on the scenes, as they are and with holes; the rest on hard
/// ground.
template <Real T>
void nearest() {
    Random random{113};
    const long count = counted(1e6);
    long queries = 0, wrong = 0, none = 0, sides = 0;
    Wide worst = 0;
    const auto judge = [&](const char* terrain, const Terrain<T>& ground, long share_of_count) {
        // A lattice in double: the search for the nearest point knows no other.
        const BilinearGrid<T, HeightView<T>> grid{
            HeightView<T>{ground.heights.data(), ground.columns, ground.rows}, ground.frame};
        std::vector<SampleRange<T>> storage(
            static_cast<std::size_t>(MinMaxPyramid<T>::size(ground.columns, ground.rows)));
        BoundedGrid bounded{grid, storage.data(), static_cast<Index>(storage.size())};
        (void)bounded.build();
        const NearestJudge<T> right{ground};
        for (long n = 0; n < share_of_count; ++n, ++queries) {
            const auto query = nearest_query(random, ground, 100);
            NearestOptions<T> options{.max_work = std::numeric_limits<Index>::max()};
            if (random.one_in(4))
                options.max_distance =
                    static_cast<T>(ground.frame.spacing.x * std::pow(10, random.between(-6, 2)));
            const bool with_bounds = random.one_in(2);
            const auto found =
                with_bounds ? nearest_point(bounded, query, options) : nearest_point(grid, query, options);
            const auto verdict = right(query, static_cast<Wide>(options.max_distance), found);
            none += found.status == NearestStatus::none_within;
            sides += found.side != Side::none;
            worst = std::max(worst, verdict.error);
            if (!verdict.fault.empty() && wrong++ < 3) {
                std::printf("  %s on %s%s, query %s within %s\n", verdict.fault.c_str(), terrain,
                            with_bounds ? " with bounds" : "", digits(query).c_str(),
                            digits(options.max_distance).c_str());
            }
        }
    };
    const auto everywhere = scenes<T>();
    const long named =
        static_cast<long>(real_terrains_without_holes.size() + real_terrains_with_holes.size());
    for (const auto& names : {real_terrains_without_holes, real_terrains_with_holes}) {
        for (const auto& terrain : names) {
            if (const auto ground = real_terrain<T>(terrain))
                judge(terrain.c_str(), *ground, 1 + count * 2 / 5 / named);
        }
    }
    for (const auto& scene : everywhere) {
        auto ground = scene.terrain;
        const long each = 1 + count / 5 / 2 / static_cast<long>(everywhere.size());
        judge(scene.name, ground, each);
        punch_holes(ground, 8, 114);
        judge(scene.name, ground, each);
    }
    // All kinds but heights of every size, which are too far from one another to be told by distances.
    const auto are_left = [&] { return queries < count; };
    for (int n = 0; are_left(); ++n)
        judge("hard ground", hard_ground<T>(static_cast<HardGround>(n % (hard_grounds - 1)), random), 20);
    report(
        "nearest", name<T>,
        text(
            "%ld queries, %ld wrong, worst error %.2g (an eighth of the promise and less is not looked for), "
            "%ld with none within their distance, %ld with a side",
            queries, wrong, static_cast<double>(worst), none, sides),
        wrong);
}

/// Strokes of 0.05 to 100 cells per update, 0.01 to 20 cells deep: the distance never rises, no patch around the end
/// leads down by more than 64 ulp-scales, no descent runs out of work.
template <Real T>
void descent() {
    Random random{102};
    const long count = counted(1e7);
    long updates = 0, wrong = 0;
    int most = 0, terrains = 0;
    double steepest = 0;
    each_terrain<T>([&](const char*, const Terrain<T>&) { ++terrains; });
    each_terrain<T>([&](const char*, const Terrain<T>& ground) {
        const auto grid = ground.grid();
        const Surface<T> surface{ground};
        const double columns = static_cast<double>(ground.columns - 1),
                     rows = static_cast<double>(ground.rows - 1);
        for (long n = 0; n < count / terrains;) {
            const double step = 0.05 * std::pow(2000, random.unit()),
                         deep = 0.01 * std::pow(2000, random.unit());
            double x = random.between(0, columns), y = random.between(0, rows),
                   heading = random.between(0, 6.283185307);
            const auto under = [&] {
                return surface.under(static_cast<Wide>(ground.frame.origin.x + x * ground.frame.spacing.x),
                                     static_cast<Wide>(ground.frame.origin.y + y * ground.frame.spacing.y));
            };
            const auto first = under();
            if (!first) continue;
            SurfacePoint<T> at{{first->i, first->j}, static_cast<T>(first->u), static_cast<T>(first->v)};
            double height = static_cast<double>(surface.position(*first).z);
            for (int k = 0; k < 50; ++k, ++n) {
                heading += random.between(-0.3, 0.3);
                x = std::clamp(x + step * std::cos(heading), 0.0, columns);
                y = std::clamp(y + step * std::sin(heading), 0.0, rows);
                if (const auto here = under()) height = static_cast<double>(surface.position(*here).z);
                const vec3<T> query{static_cast<T>(ground.frame.origin.x + x * ground.frame.spacing.x),
                                    static_cast<T>(ground.frame.origin.y + y * ground.frame.spacing.y),
                                    static_cast<T>(height - deep * ground.frame.spacing.x)};
                const auto end = descend(grid, query, at, TrackerOptions{}.max_patches);
                ++updates;
                most = std::max(most, end.patches);
                const WideSurfacePoint from{at.cell.i, at.cell.j, static_cast<Wide>(at.u),
                                            static_cast<Wide>(at.v)};
                const WideSurfacePoint to{end.point.cell.i, end.point.cell.j, static_cast<Wide>(end.point.u),
                                          static_cast<Wide>(end.point.v)};
                const Point q = wide(query);
                const Wide before = surface.half_square(from, q), after = surface.half_square(to, q);
                const Wide eps = static_cast<Wide>(epsilon<T>);
                const Wide blur = surface.blur(to, q, eps) + surface.blur(from, q, eps) +
                                  eps * (surface.dx() + surface.dy());
                bool bad = after > before + 16 * blur * std::sqrt(2 * before + blur * blur);
                if (end.status == DescentStatus::minimum) {
                    const Wide fall = surface.template fall<T>(to, q);
                    steepest = std::max(steepest, static_cast<double>(fall));
                    bad = bad || fall > 64;
                }
                bad = bad || end.status == DescentStatus::work_limit;
                if (bad && wrong++ < 3) {
                    std::printf("  from cell %td %td at %s %s, query %s\n", at.cell.i, at.cell.j,
                                digits(at.u).c_str(), digits(at.v).c_str(), digits(query).c_str());
                }
                if (end.status == DescentStatus::off_border || end.status == DescentStatus::off_hole) break;
                at = end.point;
            }
        }
    });
    report("descent", name<T>,
           text("%ld updates on %d terrains, %ld exceptions, steepest descent left %.1f ulp-scales, at most "
                "%d patches",
                updates, terrains, wrong, steepest, most),
           wrong);
}

/// Ends in the same minimum as a gradient flow in small steps, at up to half a cell per update.
template <Real T>
void flow() {
    Random random{103};
    const long count = counted(2e6);
    long updates = 0, other = 0;
    int terrains = 0;
    each_terrain<T>([&](const char*, const Terrain<T>&) { ++terrains; });
    // The bound is for all of them together; on the scenes alone, which are rougher, more ways part.
    const bool judged = terrains > static_cast<int>(scenes<T>().size());
    each_terrain<T>([&](const char* terrain, const Terrain<T>& ground) {
        if (std::string_view{terrain} == "roughest")
            return; // half a cell there is a peak or two: no way is the same
        const auto grid = ground.grid();
        const Surface<T> surface{ground};
        for (long n = 0; n < count / terrains;) {
            const Index i = static_cast<Index>(random.whole(0, ground.columns - 2)),
                        j = static_cast<Index>(random.whole(0, ground.rows - 2));
            if (!surface.patch(i, j)) continue;
            SurfacePoint<T> at{{i, j}, static_cast<T>(random.unit()), static_cast<T>(random.unit())};
            const double deep = 0.01 * std::pow(200, random.unit());
            double heading = random.between(0, 6.283185307);
            Point hand = surface.position({i, j, static_cast<Wide>(at.u), static_cast<Wide>(at.v)});
            for (int k = 0; k < 40; ++k, ++n) {
                heading += random.between(-0.5, 0.5);
                const double step = 0.5 * random.unit();
                hand.x += static_cast<Wide>(step * std::cos(heading)) * surface.dx();
                hand.y += static_cast<Wide>(step * std::sin(heading)) * surface.dy();
                const auto height = surface.height(hand.x, hand.y);
                if (!height) break;
                const vec3<T> query{static_cast<T>(hand.x), static_cast<T>(hand.y),
                                    static_cast<T>(*height - static_cast<Wide>(deep) * surface.dx())};
                const auto end = descend(grid, query, at, TrackerOptions{}.max_patches);
                if (end.status != DescentStatus::minimum) break;
                const auto flowed = surface.flow(
                    {at.cell.i, at.cell.j, static_cast<Wide>(at.u), static_cast<Wide>(at.v)}, wide(query));
                ++updates;
                other += !surface.same_basin({end.point.cell.i, end.point.cell.j,
                                              static_cast<Wide>(end.point.u), static_cast<Wide>(end.point.v)},
                                             flowed, wide(query));
                at = end.point;
            }
        }
    });
    // A sample may have three deviations more than its share.
    const double allowed = 0.0006 * static_cast<double>(updates);
    const bool beyond_chance =
        static_cast<double>(other) > allowed + (share < 1 ? 3 * std::sqrt(allowed) : 0);
    report("flow", name<T>,
           text("%ld updates of up to half a cell, %ld in another minimum than the gradient flow (%.3f %%, "
                "%s)",
                updates, other, 100.0 * static_cast<double>(other) / static_cast<double>(updates),
                judged ? "below 0.06 %" : "not judged: the real terrains are not here"),
           judged && beyond_chance);
}

/// A point in plan on the terrain or up to a cell beside it, on a grid line where that is asked for.
template <Real T>
glm::dvec2 random_place(Random& random, const Terrain<T>& ground, bool on_column, bool on_row) {
    const double columns = static_cast<double>(ground.columns - 1),
                 rows = static_cast<double>(ground.rows - 1);
    const glm::dvec2 cells{on_column ? std::round(random.between(0, columns))
                                     : random.between(-1, columns + 1),
                           on_row ? std::round(random.between(0, rows)) : random.between(-1, rows + 1)};
    return ground.frame.origin + cells * ground.frame.spacing;
}

/// How far roundings may lift or lower the surface under a segment, in metres, on ground with slopes of 4 m a cell and
/// heights of 6 m. Of a lattice in float: some roundings of the places, in cells, on both axes, and of the heights.
template <Real T>
[[nodiscard]] Wide crossing_error(const Terrain<T>& ground, const glm::dvec3& a, const glm::dvec3& b) {
    if constexpr (std::is_same_v<PlaceScalar<T>, double>) return 1e-11L;
    double cells = 0;
    for (int axis = 0; axis < 2; ++axis) {
        const double origin = ground.frame.origin[axis], spacing = ground.frame.spacing[axis];
        for (const double metres : {a[axis] - origin, b[axis] - origin, b[axis] - a[axis]})
            cells = std::max(cells, std::abs(metres) / spacing);
    }
    return static_cast<Wide>(epsilon<float>) * (2 * 4 * static_cast<Wide>(cells) + 8 * 6);
}

/// Against brute force over every cell; a segment within `crossing_error` of a graze may go either way.
template <Real T>
void first_crossing() {
    Random random{104};
    using F = PlaceScalar<T>;
    constexpr bool in_double = std::is_same_v<F, double>;
    // Of t: some roundings of 1.
    constexpr Wide time_error = in_double ? 1e-14L : 8 * static_cast<Wide>(epsilon<float>);
    long segments = 0, wrong = 0, unclear = 0, hits = 0;
    const auto compare = [&](const Terrain<T>& ground, const glm::dvec3& start, const glm::dvec3& end) {
        const vec3<F> from{start}, to{end};
        const glm::dvec3 a = widen(from), b = widen(to);
        const auto kind = random.one_in(2) ? SurfaceKind::solid : SurfaceKind::sheet;
        const auto found = first_hit(ground.grid(), from, to, {.surface = kind});
        const Wide error = crossing_error(ground, a, b);
        const auto pieces = hit_pieces(ground, a, b);
        const auto exact = brute_force_hit(pieces, kind),
                   lifted = brute_force_hit(pieces, kind, Side::none, error),
                   lowered = brute_force_hit(pieces, kind, Side::none, -error);
        // One that begins on the surface and dips into it by less than the error: lifted it never does, and lowered it
        // begins below.
        const Wide t = static_cast<Wide>(found.t);
        const bool grazes_at_start = !in_double && found.status == HitStatus::hit &&
                                     std::any_of(pieces.begin(), pieces.end(), [&](const HitPiece& piece) {
                                         return piece.t_in <= 0 && t <= piece.t_out &&
                                                std::abs(piece.at(0)) <= error &&
                                                std::abs(piece.at(t)) <= error;
                                     });
        ++segments;
        if (grazes_at_start || exact.hit != lifted.hit || exact.hit != lowered.hit ||
            exact.side != lifted.side || exact.side != lowered.side ||
            std::abs(lifted.t - lowered.t) > 1e-3L) {
            ++unclear;
            return;
        }
        const Wide first = std::min({exact.t, lifted.t, lowered.t}),
                   last = std::max({exact.t, lifted.t, lowered.t});
        const bool right = (found.status == HitStatus::hit) == exact.hit && found.side == exact.side &&
                           t >= first - time_error && t <= last + time_error;
        hits += exact.hit;
        if (!right && wrong++ < 3) {
            std::printf("  %.17g %.17g %.17g -> %.17g %.17g %.17g on a terrain of %td x %td\n", a.x, a.y, a.z,
                        b.x, b.y, b.z, ground.columns, ground.rows);
        }
    };
    const GridFrame frames[]{{{0, 0}, {1, 1}}, {{-30, 12.5}, {10, 2.5}}, {{1e7 + 0.125, -1e7}, {4, 16}}};
    std::vector<Terrain<T>> grounds;
    std::uint64_t seed = 400;
    for (const auto& frame : frames) {
        for (const bool holes : {false, true}) {
            grounds.push_back(rough_in_steps<T>(8, 7, 4, ++seed, frame));
            if (holes) punch_holes(grounds.back(), 8, seed);
        }
        grounds.push_back(saddle<T>(8, 7, 0.25, frame));
    }
    const long count = counted(1e7);
    while (segments < count) {
        const auto& ground =
            grounds[static_cast<std::size_t>(random.whole(0, static_cast<std::int64_t>(grounds.size()) - 1))];
        const auto place = [&](bool on_column, bool on_row) {
            return random_place(random, ground, on_column, on_row);
        };
        const auto z = [&] {
            return random.one_in(2) ? random.between(-2, 6) : random.fraction(-1, 5, 64) + 1e-3;
        };
        const glm::dvec2 p = place(false, false), q = place(false, false), v = place(true, true),
                         w = place(true, true);
        switch (random.whole(0, 8)) {
        case 0: compare(ground, {p, z()}, {q, z()}); break;
        case 1: compare(ground, {p, z()}, {p + 0.1 * (q - p), z()}); break;
        case 2: compare(ground, {v.x, p.y, z()}, {v.x, q.y, z()}); break;
        case 3: compare(ground, {p.x, v.y, z()}, {q.x, v.y, z()}); break;
        case 4: compare(ground, {v, z()}, {w, z()}); break;
        case 5: compare(ground, {p, z()}, {2.0 * v - p, z()}); break;
        case 6: compare(ground, {p, z()}, {p, z()}); break;
        case 7: { // level, on the surface at its start or its end
            const auto height = Surface<T>{ground}.height(static_cast<Wide>(p.x), static_cast<Wide>(p.y));
            const double level = height ? static_cast<double>(*height) : z();
            compare(ground, {p, level}, {q, random.one_in(2) ? level : z()});
            break;
        }
        default: { // from an ulp beside a vertex
            const glm::dvec2 near{
                widen(std::nextafter(static_cast<F>(v.x), random.one_in(2) ? F(1e9) : F(-1e9))), v.y};
            compare(ground, {near, z()}, {2.0 * near - p, z()});
        }
        }
    }
    // Long ones, over a strip.
    const auto strip = rough_in_steps<T>(3002, 4, 4, 77, {});
    const long more = counted(1e4);
    for (long n = 0; n < more; ++n) {
        const double length = 0.5 * std::pow(6000, random.unit()), x = random.between(0, 3001 - length);
        const double top = random.between(3.9, 4.2);
        compare(strip, {x, random.between(0, 3), top},
                {x + length, random.between(0, 3), random.between(3.5, top)});
    }
    report(
        "first_hit", name<T>,
        text("%ld segments, %ld hits, %ld missed, invented or not the first; %ld within roundings of a graze",
             segments, hits, wrong, unclear),
        wrong);
}

/// A hand that does all a hand can do, under a witness, on every terrain: solid and, every fourth update, sheet.
template <Real T>
void tracker() {
    each_terrain<T>([&](const char* terrain, const Terrain<T>& ground) {
        for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
            Witness<T> witness{ground, {.surface = kind}};
            Hand<T> hand{ground, kind == SurfaceKind::solid ? 105u : 107u};
            const long count = counted(kind == SurfaceKind::solid ? 1e6 : 2.5e5);
            for (long n = 0; n < count; ++n) (void)witness.update(hand.next());
            if (witness.faults > 0) std::printf("  %s\n", witness.first_fault.c_str());
            report("tracker", name<T>,
                   text("%s, %s, %d updates, %.0f %% in contact, %d faults, at most %d patches", terrain,
                        kind == SurfaceKind::solid ? "solid" : "sheet", witness.updates,
                        100.0 * witness.contacts / witness.updates, witness.faults, witness.most_patches),
                   witness.faults);
        }
    });
}

/// Balls of 0.1 to 5 cells, 0.1 to 100 cells an update and 0.1 to 10 cells deep, judged by every patch in reach: penetration,
/// side, never farther, a minimum, touches that are real and whose shares make up the force, never free in the ground; and
/// the same minimum as a gradient flow of the centre. Solid, and a sheet in a fifth of the strokes. A stroke ends at its
/// first fault. Prints the first faults with a line that replays each (`BallStroke`).
template <Real T>
void ball() {
    const long count = counted(1e5);
    constexpr std::int64_t flow_every = 20;
    const auto make = [](const auto&, const auto& grid, T radius, SurfaceKind kind) {
        return BallTracker<std::remove_cvref_t<decltype(grid)>>{grid, radius, {.surface = kind}};
    };
    long flows = 0, other = 0;
    std::uint64_t seed = 1000;
    const auto judge = [&](const std::string& terrain, auto&& follow) {
        BallTally tally;
        follow(tally);
        for (const auto& example : tally.examples) std::printf("  %s\n", example.c_str());
        for (const auto& [kind, times] : tally.kinds) std::printf("  %d x %s\n", times, kind.c_str());
        flows += tally.flows, other += tally.other_minima;
        report(
            "ball", name<T>,
            text("%s, %ld updates, %.0f %% in contact, %ld faults, penetration at most %.2g r, residual at "
                 "most %.2g, %ld minima narrower than 1e-3 r, %ld of %ld in another minimum than the flow",
                 terrain.c_str(), tally.updates,
                 100.0 * static_cast<double>(tally.contacts) / static_cast<double>(tally.updates),
                 tally.faults, static_cast<double>(tally.penetration), static_cast<double>(tally.residual),
                 tally.narrow, tally.other_minima, tally.flows),
            tally.faults);
    };
    each_terrain<T>([&](const char* terrain, const Terrain<T>& ground) {
        judge(terrain, [&](BallTally& tally) {
            follow_strokes<T>(terrain, ground, count, flow_every, ++seed, make, tally);
        });
    });
    // All kinds whose heights are near enough to one another to be told by distances.
    for (int kind = 0; kind < static_cast<int>(HardGround::no_data); ++kind) {
        judge("hard ground " + std::to_string(kind), [&](BallTally& tally) {
            for (long n = 0; tally.updates < count; ++n) {
                const std::string ground = "hard " + std::to_string(kind) + ' ' + std::to_string(n);
                follow_strokes<T>(ground, *named_terrain<T>(ground), std::min(500L, count), flow_every,
                                  ++seed, make, tally);
            }
        });
    }
    // A sample may have three deviations more than its share.
    const double allowed = 1e-4 * static_cast<double>(flows);
    report(
        "ball", name<T>,
        text(
            "%ld updates of up to half a cell, %ld in another minimum than the gradient flow (below 0.01 %%)",
            flows, other),
        static_cast<double>(other) > allowed + 3 * std::sqrt(allowed));
}

/// Balls of 0.1 to 5 cells that move 0.1 to 100 cells in all directions, from anywhere and from where they touch: the first touch
/// is neither late nor early, and a tracker's ball that is free stops there or slides on from there. Each terrain of the scenes
/// with holes as well.
template <Real T>
void ball_sweep() {
    const long count = counted(1e4);
    std::uint64_t seed = 2000;
    MovingBallTally tally;
    const auto move = [&](const std::string& terrain, const Terrain<T>& ground, long share_of_count) {
        move_balls<T>(terrain, ground, share_of_count, ++seed, tally);
    };
    each_terrain<T>([&](const char* terrain, const Terrain<T>& ground) { move(terrain, ground, count); });
    for (const auto& scene : scenes<T>()) {
        auto ground = scene.terrain;
        punch_holes(ground, 8, 114);
        move(std::string{scene.name} + " with holes", ground, count);
    }
    for (int kind = 0; kind < static_cast<int>(HardGround::no_data); ++kind) {
        for (long n = 0; n * 100 < count; ++n) {
            const std::string ground = "hard " + std::to_string(kind) + ' ' + std::to_string(n);
            move(ground, *named_terrain<T>(ground), std::min(100L, count));
        }
    }
    for (const auto& example : tally.examples) std::printf("  %s\n", example.c_str());
    report("ball_sweep", name<T>,
           text("%ld balls, %ld touches, %ld glide for too long to tell, %ld faults", tally.balls,
                tally.touches, tally.unclear, tally.faults),
           tally.faults);
}

/// Positions `deep` cells below the surface, `step` cells apart, of a hand that turns by up to `turn` at each; back from the
/// rim. Where there is no surface, as low as before.
template <Real T>
class Plough {
public:
    Plough(const Terrain<T>& terrain, double step, double deep, std::uint64_t seed)
        : terrain_{&terrain}, surface_{terrain}, random_{seed}, step_{step}, deep_{deep} {
        at_ = {random_.between(0, columns()), random_.between(0, rows())};
    }

    [[nodiscard]] vec3<T> next() {
        constexpr double turn = 0.2;
        heading_ += random_.between(-turn, turn);
        const glm::dvec2 to = at_ + step_ * glm::dvec2{std::cos(heading_), std::sin(heading_)};
        if (to.x < 0 || to.x > columns()) heading_ = 3.14159265358979 - heading_;
        if (to.y < 0 || to.y > rows()) heading_ = -heading_;
        at_ = glm::clamp(to, glm::dvec2{0.01}, glm::dvec2{columns(), rows()} - 0.01);
        const auto& f = terrain_->frame;
        const glm::dvec2 world = f.origin + at_ * f.spacing;
        if (const auto z = surface_.height(static_cast<Wide>(world.x), static_cast<Wide>(world.y)))
            ground_ = static_cast<double>(*z);
        // Above at first, and out now and then.
        const double over = updates_++ % 500 == 0 ? 20 : -deep_;
        return vec3<T>{glm::dvec3{world, ground_ + over * f.spacing.x}};
    }

private:
    [[nodiscard]] double columns() const { return static_cast<double>(terrain_->columns - 1); }
    [[nodiscard]] double rows() const { return static_cast<double>(terrain_->rows - 1); }

    const Terrain<T>* terrain_;
    Surface<T> surface_;
    Random random_;
    double step_, deep_;
    glm::dvec2 at_{0.0};
    double heading_ = 0, ground_ = 0;
    long updates_ = 0;
};

/// With limited work no contact is dropped: a stylus that was in contact and has the surface over it has a force, also while
/// its proxy is on the way. The hand of `tracker`, and one that ploughs half a cell and five cells deep, under the same
/// witness; real ground as if its cells were at most 10 m wide, which makes it up to nine times steeper.
template <Real T>
void limited() {
    each_terrain<T>([&](const char* terrain, Terrain<T> ground) {
        ground.frame.spacing = glm::min(ground.frame.spacing, glm::dvec2{10.0});
        const double cell = std::sqrt(ground.frame.spacing.x * ground.frame.spacing.y);
        const int ample = TrackerOptions{}.max_contact_patches;
        for (const auto& [slide, glide] :
             {std::pair{1, 0.0}, {8, 0.0}, {64, 0.0}, {ample, 0.5 * cell}, {8, 2.5 * cell}}) {
            Witness<T> witness{ground, {.max_contact_patches = slide}, glide};
            long on_the_way = 0;
            const auto follow = [&](auto&& hand, long count) {
                witness.reset();
                for (long n = 0; n < count; ++n)
                    on_the_way += witness.update(hand.next()).status == ContactStatus::descent_limit;
            };
            follow(Hand<T>{ground, 108}, counted(1e5));
            for (const double step : {0.5, 2.0, 5.0}) {
                for (const double deep : {0.5, 5.0}) follow(Plough<T>{ground, step, deep, 110}, counted(2e4));
            }
            if (witness.faults > 0) std::printf("  %s\n", witness.first_fault.c_str());
            report(
                "limited", name<T>,
                text("%s, max_contact_patches %d%s, %d updates, %.0f %% in contact, %.2f %% with a proxy on "
                     "its way, %d "
                     "dropped, %d other faults, at most %d patches",
                     terrain, slide, glide > 0 ? text(", glides %g cells", glide / cell).c_str() : "",
                     witness.updates, 100.0 * witness.contacts / witness.updates,
                     100.0 * static_cast<double>(on_the_way) / witness.updates, witness.dropped,
                     witness.faults - witness.dropped, witness.most_patches),
                witness.faults);
        }
    });
}

/// Strokes of every kind on hard ground, with limits at random: bounded, never dropped, comes to rest, and no force where
/// unlimited work gives none. Twelve kinds of ground; of the two wild ones, with heights of every size that a file can
/// hold, what is true of each update alone is judged.
template <Real T>
void strokes() {
    Random random{112};
    constexpr int kinds = hard_grounds;
    const long count = counted(5e8);
    long updates = 0, contacts = 0, rests = 0, faults = 0;
    for (int n = 0; updates < count; ++n) {
        const auto kind = static_cast<HardGround>(n % kinds);
        const auto ground = hard_ground<T>(kind, random);
        const TrackerOptions options{.surface = random.one_in(5) ? SurfaceKind::sheet : SurfaceKind::solid,
                                     .max_patches = any_limit(random),
                                     .max_contact_patches = any_limit(random)};
        LimitedWork<T> work{ground, options, any_glide_speed(random, ground)};
        work.judges_rest = kind <= HardGround::crease;
        stroke_about(work, ground, random);
        updates += work.updates, contacts += work.contacts, rests += work.rests;
        if (!work.fault().empty() && faults++ < 3) std::printf("  %s\n", work.fault().c_str());
    }
    report("strokes", name<T>,
           text("%ld updates, %.0f %% in contact, %ld rests, %ld faults", updates,
                100.0 * static_cast<double>(contacts) / static_cast<double>(updates), rests, faults),
           faults);
}

/// No step within a patch passes a first minimum of F: on its way, straight or along the floor of a valley, F never rises by
/// more than roundings. Every step down to the end, each from the end of the last.
template <Real T>
void steps() {
    Random random{109};
    long taken = 0, past = 0, over_ridges = 0;
    Wide highest = 0; // rise, as a share of F
    const long count = counted(1e7);
    while (taken < count) {
        const auto c = step_case<T>(random);
        const StepJudge judge{c.patch, c.query};
        vec2<T> at = c.start;
        for (int n = 0; n < 64; ++n) {
            const auto end = newton_closest_point(c.patch, c.query, at, {.max_iterations = 1});
            if (end.iterations == 0) break;
            ++taken;
            const vec2<T> to{end.u, end.v};
            if (const Rise rise = judge.rise(at, to); rise.height > 0) {
                highest = std::max(highest, rise.height);
                over_ridges += rise.ridge;
                if (past++ < 3) std::printf("  %s\n", describe(c.patch, c.query, at, to).c_str());
            }
            if (end.status != NewtonStatus::iteration_limit) break;
            at = to;
        }
    }
    report("steps", name<T>,
           text("%ld steps, %ld past a first minimum, %ld of them over a ridge; the highest rise %.2g of the "
                "squared distance",
                taken, past, over_ridges, static_cast<double>(highest)),
           past);
}

/// On flat ground the force has no tangential part: not small, none.
template <Real T>
void flat() {
    const auto ground = plane<T>(257, 257, 3, GridFrame{.origin = {500000, 4649776}, .spacing = {10, 10}});
    const auto grid = ground.grid();
    const ForceEvaluator<T> force{};
    ProxyTracker<typename Terrain<T>::Grid> tracker{grid};
    Random random{106};
    glm::dvec2 at = (ground.low() + ground.high()) / 2.0, way{0.3, 0.2};
    (void)tracker.update({static_cast<T>(at.x), static_cast<T>(at.y), T(4)});
    long unsteady = 0;
    const long count = counted(2.2e6);
    for (long n = 0; n < count; ++n) {
        for (int axis = 0; axis < 2; ++axis) {
            way[axis] = std::clamp(way[axis] + 0.05 * random.between(-1, 1), -0.5, 0.5);
            at[axis] = std::clamp(at[axis] + 10 * way[axis], ground.low()[axis] + 1, ground.high()[axis] - 1);
        }
        const auto f = force(tracker.update(
            {static_cast<T>(at.x), static_cast<T>(at.y), static_cast<T>(2 + 0.5 * random.unit())}));
        unsteady += f.newtons.x != 0 || f.newtons.y != 0 || !(f.newtons.z > 0);
    }
    report("flat", name<T>, text("%ld updates, %ld with a tangential force", count, unsteady), unsteady);
}

template <Real T>
[[nodiscard]] bool run(std::string_view part) {
    const bool all = part == "all";
    bool known = all;
    const auto one = [&](std::string_view called, void (*promise)()) {
        if (all || part == called) promise(), known = true;
    };
    one("closest_point", closest_point<T>);
    one("steps", steps<T>);
    one("nearest", nearest<T>);
    one("descent", descent<T>);
    one("flow", flow<T>);
    one("first_hit", first_crossing<T>);
    one("tracker", tracker<T>);
    // A ball computes places in double.
    if constexpr (std::same_as<PlaceScalar<T>, double>)
        one("ball", ball<T>), one("ball_sweep", ball_sweep<T>);
    one("limited", limited<T>);
    one("strokes", strokes<T>);
    one("flat", flat<T>);
    return known;
}

} // namespace

int main(int argc, char** argv) {
    const std::string_view scalar = argc == 4 ? argv[2] : "";
    share = argc == 4 ? std::atof(argv[3]) : 0;
    const bool understood =
        share > 0 && (scalar == "float" ? run<float>(argv[1]) : scalar == "double" && run<double>(argv[1]));
    if (!understood) {
        std::fputs("usage: hfh_certify "
                   "closest_point|steps|nearest|descent|flow|first_hit|tracker|ball|ball_sweep|limited|"
                   "strokes|flat|all "
                   "float|double "
                   "SHARE\n",
                   stderr);
        return 2;
    }
    return broken ? 1 : 0;
}
