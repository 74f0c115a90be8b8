#include "catch.hpp"

#include "support/brute_force_hit.hpp"
#include "support/exact_walk.hpp"
#include "support/random.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

// A lattice in float: with places that are short numbers it is as exact as one in double, and the side of a segment that goes
// from cell to cell lets nothing through whatever the rounding. certify and the tracker's own tests, compiled with
// HFH_TEST_FLOAT_LATTICE, judge the rest.

namespace {

using hfh::BasicCellSpan;
using hfh::Cell;
using hfh::FloatLattice;
using hfh::HitStatus;
using hfh::Index;
using hfh::Side;
using hfh::SurfaceKind;
using hfh::widen;
using hfh::test::Random;
using FloatField = hfh::BilinearGrid<float, hfh::HeightView<float>, float>;

static_assert(std::is_same_v<hfh::FrameScalar<FloatField>, float>);
static_assert(std::is_same_v<hfh::FrameScalar<hfh::BilinearGrid<float, hfh::HeightView<float>>>, double>);
static_assert(sizeof(hfh::TrackerState<float, float>) < sizeof(hfh::TrackerState<float>));

FloatField field_of(const hfh::test::Terrain<float>& terrain) {
    return {hfh::HeightView<float>{terrain.heights.data(), terrain.columns, terrain.rows}, terrain.frame};
}

} // namespace

TEST_CASE("FloatLattice: a place in a cell is exact to roundings of itself, not of the position",
          "[float_lattice][law]") {
    Random random{301};
    for (int n = 0; n < 100'000; ++n) {
        const float origin = static_cast<float>(random.between(-100, 100)),
                    spacing = static_cast<float>(std::exp2(random.between(-6, 6)));
        const FloatLattice lattice{{origin, origin}, {spacing, spacing}};
        const Index i = random.whole(0, 4000);
        const float x = static_cast<float>(static_cast<double>(origin) +
                                           (static_cast<double>(i) + random.between(-1, 2)) *
                                               static_cast<double>(spacing));
        const long double offset = static_cast<long double>(x - origin); // as it is rounded
        for (const Index line : {i - 1, i, i + 1}) {
            const long double u =
                (offset - static_cast<long double>(line) * static_cast<long double>(spacing)) /
                static_cast<long double>(spacing);
            REQUIRE(std::abs(static_cast<long double>(lattice.u_of(x, line)) - u) <=
                    2 * 0x1p-23L * std::abs(u));
        }
    }
}

TEST_CASE("FloatLattice: positions in which a cell cannot be told are refused", "[float_lattice]") {
    const FloatLattice lattice{{0, 0}, {1, 1}};
    CHECK(lattice.reaches(hfh::vec3<float>{4194302, -4194302, 0}));
    CHECK_FALSE(lattice.reaches(hfh::vec3<float>{4194304, 0, 0}));
    CHECK_FALSE(lattice.reaches(hfh::vec3<float>{0, -4194304, 0}));
    const auto flat = hfh::test::plane<float>(9, 9);
    const auto field = field_of(flat);
    hfh::ProxyTracker tracker{field};
    CHECK(tracker.update({5e6F, 0, 0}).status == hfh::ContactStatus::bad_input);
}

TEST_CASE("FloatLattice: with short numbers walk_cells visits the cells of the exact supercover in order",
          "[float_lattice][law]") {
    Random random{302};
    for (int n = 0; n < 20'000; ++n) {
        const hfh::test::WholeLattice whole{{8, -4}, 0.125, {random.whole(1, 12), random.whole(1, 12)}};
        const FloatLattice lattice{hfh::vec2<float>{whole.origin},
                                   hfh::vec2<float>{whole.lattice().spacing()}};
        const hfh::CellRange range{{0, 0}, {10, 10}};
        const auto point = [&]() -> hfh::test::WholePoint {
            return {random.whole(-2 * whole.step[0], 12 * whole.step[0]),
                    random.whole(-2 * whole.step[1], 12 * whole.step[1])};
        };
        const auto a = point(), b = n % 10 == 0 ? a : point();
        std::vector<Cell> visited;
        float reached = -1;
        bool ordered = true;
        hfh::walk_cells(lattice, range, hfh::vec2<float>{place(whole, a)}, hfh::vec2<float>{place(whole, b)},
                        [&](const BasicCellSpan<float>& span) {
                            ordered = ordered && 0 <= span.t_in && span.t_in <= span.t_out &&
                                      span.t_out <= 1 && (reached < 0 || span.t_in <= reached);
                            reached = std::max(reached, span.t_out);
                            visited.push_back(span.cell);
                            return visited.size() < 1000;
                        });
        CAPTURE(n);
        REQUIRE(ordered);
        std::vector<Cell> exact;
        for (const auto& span : exact_cells(whole, range, a, b)) exact.push_back(span.cell);
        const auto before = [](Cell l, Cell r) { return l.j != r.j ? l.j < r.j : l.i < r.i; };
        std::sort(visited.begin(), visited.end(), before);
        std::sort(exact.begin(), exact.end(), before);
        REQUIRE(visited == exact);
    }
}

TEST_CASE("FloatLattice: from above to below by more than roundings nothing slips through",
          "[float_lattice][law][hard]") {
    Random random{303};
    int slipped = 0, off = 0, checked = 0;
    for (int round = 0; round < 60; ++round) {
        const double relief = std::exp2(random.whole(-6, 6));
        const double spacing = random.one_in(2) ? 2 : random.between(0.1, 10);
        const auto terrain = hfh::test::rough<float>(7, 6, relief, 304 + static_cast<std::uint64_t>(round),
                                                     {{widen(static_cast<float>(random.between(-50, 50))), 0},
                                                      {widen(static_cast<float>(spacing)), 0.5}});
        const auto field = field_of(terrain);
        const auto place = [&] {
            const glm::dvec2 low = terrain.low(), high = terrain.high();
            glm::dvec2 p{random.between(low.x, high.x), random.between(low.y, high.y)};
            // On a grid line, or an ulp beside it.
            for (int axis = 0; axis < 2; ++axis) {
                if (!random.one_in(2)) continue;
                const double step = terrain.frame.spacing[axis];
                p[axis] = low[axis] + std::round((p[axis] - low[axis]) / step) * step;
            }
            hfh::vec2<float> rounded{p};
            for (auto k = random.whole(-2, 2); k != 0; k += k > 0 ? -1 : 1)
                rounded.x = std::nextafter(rounded.x, k > 0 ? 1e9F : -1e9F);
            // Not on the rim, which a rounding of x − x₀ can put to either side.
            return glm::clamp(rounded, hfh::vec2<float>{low} + 0.01F, hfh::vec2<float>{high} - 0.01F);
        };
        const auto surface = [&](const hfh::vec2<float>& p) {
            const glm::dvec2 at{widen(p.x), widen(p.y)};
            const auto pieces = hfh::test::hit_pieces(terrain, {at, 0}, {at, 0});
            return pieces.empty() ? 0.0 : static_cast<double>(-pieces.front().c0);
        };
        for (int n = 0; n < 2000; ++n) {
            const auto p = place(), q = n % 7 == 0 ? p : place();
            // Roundings of a place times the slope, and of the height.
            const double least = 0x1p-20 * relief * (1 + 60 / std::min(spacing, 0.5));
            const double over = least + relief * std::exp2(-random.between(0, 20)),
                         under = least + relief * std::exp2(-random.between(0, 20));
            const hfh::vec3<float> a{p, static_cast<float>(surface(p) + over)},
                b{q, static_cast<float>(surface(q) - under)};
            ++checked;
            for (const auto kind : {SurfaceKind::solid, SurfaceKind::sheet}) {
                const auto found = hfh::first_hit(field, a, b, {.surface = kind});
                slipped += found.status != HitStatus::hit || found.side != Side::above;
                const auto patch = field.patch(found.point.cell);
                const double t = widen(found.t), z = widen(a.z) + t * (widen(b.z) - widen(a.z));
                off += !patch || std::abs(widen(patch->height(found.point.u, found.point.v)) - z) >
                                     least + 0x1p-18 * (widen(a.z) - widen(b.z));
            }
            const auto up = hfh::first_hit(field, b, a, {.surface = SurfaceKind::sheet});
            slipped += up.status != HitStatus::hit || up.side != Side::below;
        }
    }
    CHECK(checked == 120'000);
    CHECK(slipped == 0);
    CHECK(off == 0);
}
