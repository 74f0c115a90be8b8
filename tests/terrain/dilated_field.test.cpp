#include "catch.hpp"
#include "support/reference.hpp"
#include "support/scenes.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/dilated_field.hpp>

#include <cstdio>
#include <type_traits>
#include <utility>

using namespace hfh;
using namespace hfh::test;

namespace {

/// The height of the centre of a ball that touches the terrain over (x, y), by sampling every patch and its edges
/// `samples` to a cell. Never too high; too low by what the samples miss.
template <Real T>
std::optional<Wide> search_centre(const Surface<T>& surface, Wide x, Wide y, Wide r, int samples) {
    std::optional<Wide> top;
    const Wide a = surface.column_of(x), b = surface.row_of(y);
    const auto i0 = static_cast<Index>(std::floor(a - r / surface.dx())) - 1,
               i1 = static_cast<Index>(std::ceil(a + r / surface.dx())) + 1;
    const auto j0 = static_cast<Index>(std::floor(b - r / surface.dy())) - 1,
               j1 = static_cast<Index>(std::ceil(b + r / surface.dy())) + 1;
    for (Index j = j0; j <= j1; ++j) {
        for (Index i = i0; i <= i1; ++i) {
            const auto p = surface.patch(i, j);
            if (!p) continue;
            for (int n = 0; n <= samples; ++n) {
                for (int m = 0; m <= samples; ++m) {
                    const Wide u = Wide(m) / samples, v = Wide(n) / samples;
                    const Wide ox = (static_cast<Wide>(i) + u - a) * p->dx,
                               oy = (static_cast<Wide>(j) + v - b) * p->dy;
                    const Wide left = r * r - ox * ox - oy * oy;
                    if (left < 0) continue;
                    const Wide z = p->height(u, v) + std::sqrt(left);
                    if (!top || z > *top) top = z;
                }
            }
        }
    }
    return top;
}

/// How much a height read from the raised field is off the true one, over points of cells away from the rim.
struct Off {
    double above = 0, below = 0; ///< the most by which the bilinear surface is too high, too low
};
template <Real T>
Off off(const Terrain<T>& ground, T r, int finer, int points, int samples) {
    const Surface<T> surface{ground};
    const auto grid = ground.grid();
    const DilatedField field{grid, r, finer};
    Random random{101};
    Off most;
    for (int n = 0; n < points; ++n) {
        const Cell c{random.whole(4 * finer, (ground.columns - 5) * finer - 1),
                     random.whole(4 * finer, (ground.rows - 5) * finer - 1)};
        const auto patch = field.patch(c);
        const T u = static_cast<T>(random.unit()), v = static_cast<T>(random.unit());
        const Wide x = static_cast<Wide>(ground.frame.origin.x) +
                       (static_cast<Wide>(c.i) + static_cast<Wide>(u)) * surface.dx() / finer;
        const Wide y = static_cast<Wide>(ground.frame.origin.y) +
                       (static_cast<Wide>(c.j) + static_cast<Wide>(v)) * surface.dy() / finer;
        const double wanted =
            static_cast<double>(*search_centre(surface, x, y, static_cast<Wide>(r), samples));
        const double found = static_cast<double>(patch->height(u, v));
        most.above = std::max(most.above, found - wanted);
        most.below = std::max(most.below, wanted - found);
    }
    return most;
}

} // namespace

TEMPLATE_TEST_CASE("DilatedField: over a plane it is the plane, r along its normal higher", "[dilated_field]",
                   float, double) {
    using T = TestType;
    for (const auto& [along_x, along_y] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {-1.0, 0.25}, {3.0, -2.0}}) {
        const auto ground =
            tilted_plane<T>(24, 24, along_x, along_y, 5, {.origin = {-3, 4}, .spacing = {1, 0.5}});
        const auto grid = ground.grid();
        for (const double r : {0.125, 0.75, 2.0}) {
            for (const int finer : {1, 3}) {
                const DilatedField field{grid, static_cast<T>(r), finer};
                const double lift = r * std::sqrt(1 + along_x * along_x + 4 * along_y * along_y);
                for (Index j = 8 * finer; j < 16 * finer; ++j) {
                    for (Index i = 8 * finer; i < 16 * finer; ++i) {
                        const double z = 5 + along_x * double(i) / finer + along_y * double(j) / finer + lift;
                        REQUIRE(field.height({i, j}));
                        CHECK(double(*field.height({i, j})) == Approx(z).margin(200 * double(epsilon<T>)));
                    }
                }
            }
        }
    }
}

/// Whether a patch near fine vertex (i, j) is bent more sharply than a ball of radius r, `cells` columns of the ground.
template <Real T>
bool is_bent_near(const Surface<T>& surface, Index i, Index j, int finer, double cells, T r) {
    const auto i0 = static_cast<Index>(std::floor(Wide(i) / finer - Wide(cells))) - 1;
    const auto reach_j = static_cast<Index>(std::ceil(static_cast<Wide>(r) / surface.dy())) + 1;
    const auto j0 = static_cast<Index>(std::floor(Wide(j) / finer)) - reach_j;
    for (Index b = j0; b <= j0 + 2 * reach_j + 1; ++b) {
        for (Index a = i0; a <= i0 + 2 * static_cast<Index>(std::ceil(cells)) + 3; ++a) {
            const auto p = surface.patch(a, b);
            if (p && std::abs(p->p11 - p->p10 - p->p01 + p->p00) * static_cast<Wide>(r) >= p->dx * p->dy / 2)
                return true;
        }
    }
    return false;
}

/// Height at fine vertex (i, j) against a search with 32 samples a cell. True if it is too low, as it may be where patches
/// are bent more sharply than the ball.
template <Real T, class Field>
bool check_vertex(const Terrain<T>& ground, const Field& field, Index i, Index j, int finer, double cells,
                  T r) {
    const int samples = 32;
    const Surface<T> surface{ground};
    const Wide x = static_cast<Wide>(ground.frame.origin.x) + static_cast<Wide>(i) * surface.dx() / finer;
    const Wide y = static_cast<Wide>(ground.frame.origin.y) + static_cast<Wide>(j) * surface.dy() / finer;
    const auto wanted = search_centre(surface, x, y, static_cast<Wide>(r), samples);
    const auto found = field.height({i, j});
    if (!wanted || !found) {
        CHECK_FALSE(wanted);
        return false;
    }
    const Wide z = static_cast<Wide>(*found), scale = std::abs(z) + static_cast<Wide>(r) + 20;
    // Never above the truth by more than the samples miss: near the top, of curvature below 1/r + |twist| and with the
    // slopes there, a sample is within half a step; at the end of the ball's reach √ falls steeply, so allow
    // √(2 r · step).
    const Wide step = std::hypot(surface.dx(), surface.dy()) / samples;
    const Wide relief = ground.frame.spacing.x > 0 ? Wide(16) : Wide(0);
    const Wide missed =
        step * relief / std::min(surface.dx(), surface.dy()) + std::sqrt(2 * static_cast<Wide>(r) * step);
    CHECK(z <= *wanted + missed);
    const bool low = z < *wanted - 64 * static_cast<Wide>(epsilon<T>) * scale;
    if (!is_bent_near(surface, i, j, finer, cells, r)) CHECK_FALSE(low);
    return low;
}

TEMPLATE_TEST_CASE("DilatedField: its vertices are where a ball touches, by search", "[dilated_field][law]",
                   float, double) {
    using T = TestType;
    for (const bool holes : {false, true}) {
        for (auto& scene : scenes<T>()) {
            if (holes) punch_holes(scene.terrain, 16, 102);
            const auto& ground = scene.terrain;
            const auto grid = ground.grid();
            Random random{103};
            for (const double cells : {0.25, 1.0, 2.5}) {
                const T r = static_cast<T>(cells * ground.frame.spacing.x);
                for (const int finer : {1, 2}) {
                    const DilatedField field{grid, r, finer};
                    int low = 0;
                    for (int n = 0; n < 40; ++n) {
                        const Index i = random.whole(-4, (ground.columns + 3) * finer),
                                    j = random.whole(-4, (ground.rows + 3) * finer);
                        CAPTURE(scene.name, holes, cells, finer, i, j);
                        low += check_vertex(ground, field, i, j, finer, cells, r);
                    }
                    CAPTURE(scene.name, holes, cells, finer, low);
                    CHECK(low <= 8);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE(
    "DilatedField: neighbouring patches agree to the bit, holes and rim reach as far as the ball",
    "[dilated_field]", float, double) {
    using T = TestType;
    auto ground = rough_in_steps<T>(12, 10, 1, 104);
    ground.remove(5, 5);
    const auto grid = ground.grid();
    for (const double r : {0.4, 1.5}) {
        const DilatedField field{grid, static_cast<T>(r), 2};
        static_assert(HeightField<DilatedField<decltype(ground.grid())>>);
        const auto all = field.cells();
        int there = 0, beyond = 0;
        for (Index j = all.begin.j - 1; j <= all.end.j; ++j) {
            for (Index i = all.begin.i - 1; i <= all.end.i; ++i) {
                const auto here = field.patch({i, j});
                if (!here) continue;
                REQUIRE(all.contains({i, j}));
                ++there;
                beyond += i < 0 || j < 0 || i >= 22 || j >= 18;
                CHECK(here->spacing == vec2<T>{T(0.5)});
                if (const auto east = field.patch({i + 1, j}))
                    CHECK((here->p10 == east->p00 && here->p11 == east->p01));
                if (const auto north = field.patch({i, j + 1}))
                    CHECK((here->p01 == north->p00 && here->p11 == north->p10));
            }
        }
        // Over the rim as far as r, to a vertex; the hole, of two cells, is narrower than the larger ball.
        CHECK(there > 300);
        CHECK((beyond > 0) == (r > 0.5));
        CHECK(field.patch({9, 9}).has_value() == (r > 1));
        CHECK(field.height({-static_cast<Index>(2 * r), 8}).has_value());
        CHECK_FALSE(field.height({-static_cast<Index>(2 * r) - 1, 8}).has_value());
    }
}

TEMPLATE_TEST_CASE("DilatedField: without a radius it is the field", "[dilated_field]", float, double) {
    using T = TestType;
    auto ground = rough_in_steps<T>(12, 10, 4, 105);
    const auto grid = ground.grid();
    const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
    for (const T r : {T(0), T(-1), nan, inf}) {
        const DilatedField field{grid, r};
        for (Index j = 0; j < 9; ++j) {
            for (Index i = 0; i < 11; ++i) {
                const auto a = field.patch({i, j}), b = grid.patch({i, j});
                REQUIRE(a);
                CHECK((a->p00 == b->p00 && a->p10 == b->p10 && a->p01 == b->p01 && a->p11 == b->p11));
            }
        }
        CHECK_FALSE(field.patch({-1, 3}));
        CHECK_FALSE(field.patch({11, 3}));
    }
    // Between 1 and 1000 pieces to a cell, however many are asked for, and none where they are too small.
    for (const auto& [asked, got] :
         {std::pair{0, 1}, {-7, 1}, {1000, 1000}, {1001, 1000}, {2147483647, 1000}}) {
        const DilatedField field{grid, T(0), asked};
        CHECK(field.lattice().spacing().x == grid.lattice().spacing().x / got);
    }
    auto small = plane<T>(3, 3);
    small.frame.spacing = glm::dvec2{4 / widen(longest<T>)};
    const auto small_grid = small.grid();
    CHECK_FALSE(DilatedField{small_grid, T(0), 4}.cells().empty());
    CHECK(DilatedField{small_grid, T(0), 5}.cells().empty());
    CHECK_FALSE(DilatedField{small_grid, T(0), 5}.patch({0, 0}));
    const auto nothing = plane<T>(1, 4);
    const auto nothing_grid = nothing.grid();
    const DilatedField empty{nothing_grid, T(2)};
    CHECK(empty.cells().empty());
    CHECK_FALSE(empty.patch({0, 0}));
    const auto dot = plane<T>(2, 2, 1);
    const auto dot_grid = dot.grid();
    CHECK(DilatedField{dot_grid, T(1e30)}.radius() == T(1000)); // a cell of 1 m
}

TEMPLATE_TEST_CASE("DilatedField: a finer lattice brings it near the true offset surface", "[dilated_field]",
                   float, double) {
    using T = TestType;
    // A ball of one cell's radius. The chord over an arc of radius r is (dx² + dy²)/(8 r n²) too low, on gentle ground;
    // in a crease that turns by s the bilinear surface is at most s·dx/(4n) too high. By search with 48 samples a cell,
    // which is itself 1/(8·48²) or so too low.
    struct Case {
        const char* name;
        Terrain<T> ground;
        double turn;  ///< change of slope in the sharpest valley
        double steep; ///< 1/cos³ of the steepest slope, by which an arc is bent more
    };
    const Case cases[] = {{"ridge", ridge<T>(20, 20, 0.5), 0, 1.4},
                          {"valley", valley<T>(20, 20, 0.5), 1, 1.4},
                          {"peak", peak<T>(20, 20, 0.5), 0.5, 1.6},
                          {"pit", pit<T>(20, 20, 0.5), 1, 1.6},
                          {"hills", hills<T>(20, 20, 1, 8), 0.4, 1.6}};
    for (const auto& [name, ground, turn, steep] : cases) {
        for (const int n : {1, 2, 4}) {
            const Off most = off(ground, T(1), n, 300, 48);
            CAPTURE(name, n, most.above, most.below);
            CHECK(most.below <= 0.25 / (n * n) * steep + 1e-4);
            CHECK(most.above <= 0.5 * turn / n + 2e-3);
        }
    }
}

// Hidden; prints the table that the header quotes: hfh_tests "[tip_error]"
TEST_CASE("DilatedField: how far it is from the true offset surface", "[.][tip_error]") {
    const Terrain<double> grounds[] = {tilted_plane<double>(24, 24, 0.5, 0.25), valley<double>(24, 24, 0.5),
                                       ridge<double>(24, 24, 0.5), rough_in_steps<double>(24, 24, 0.5, 107),
                                       rough_in_steps<double>(24, 24, 2, 107)};
    const char* const names[] = {"plane", "valley", "ridge", "random, half a cell", "random, two cells"};
    std::printf("tip of one cell, 200 points, in cells: too high / too low\n%-22s", "");
    for (const int n : {1, 2, 4, 8}) std::printf("  n = %d          ", n);
    for (std::size_t k = 0; k < std::size(grounds); ++k) {
        std::printf("\n%-22s", names[k]);
        for (const int n : {1, 2, 4, 8}) {
            const Off most = off(grounds[k], 1.0, n, 200, 64);
            std::printf("  %.4f / %.4f", most.above, most.below);
        }
    }
    std::printf("\n");
    CHECK(true);
}

TEMPLATE_TEST_CASE("DilatedField: the tracker keeps its promise: a tip that was outside is never free below",
                   "[dilated_field][law]", float, double) {
    using T = TestType;
    for (const auto& scene : scenes<T>()) {
        const auto& ground = scene.terrain;
        const auto grid = ground.grid();
        const T r = static_cast<T>(0.75 * ground.frame.spacing.x);
        const DilatedField field{grid, r};
        // The raised surface once more, as samples: what the reference reads.
        auto raised = terrain<T>(
            ground.columns, ground.rows,
            [&](Index i, Index j) {
                return double(*field.height({i, j}));
            },
            ground.frame);
        const Surface<T> surface{raised};
        ProxyTracker tracker{field};
        Random random{106};
        const glm::dvec2 low = ground.low(), high = ground.high(), cell = ground.frame.spacing;
        double x = (low.x + high.x) / 2, y = (low.y + high.y) / 2, heading = 0;
        int touching = 0, faults = 0;
        static_cast<void>(tracker.update({static_cast<T>(x), static_cast<T>(y), T(1000)}));
        for (int n = 0; n < 1500; ++n) {
            heading += random.between(-0.5, 0.5);
            const double step = random.one_in(40) ? 4 : 0.3;
            x = std::clamp(x + step * cell.x * std::cos(heading), low.x + cell.x, high.x - cell.x);
            y = std::clamp(y + step * cell.y * std::sin(heading), low.y + cell.y, high.y - cell.y);
            const T tx = static_cast<T>(x), ty = static_cast<T>(y);
            const Wide height = *surface.height(static_cast<Wide>(tx), static_cast<Wide>(ty));
            const vec3<T> at{tx, ty, static_cast<T>(height + Wide(random.between(-0.5, 0.25) * cell.x))};
            const auto contact = tracker.update(at);
            touching += contact.touching();
            const bool free = contact.status == ContactStatus::free &&
                              height - static_cast<Wide>(at.z) <= Wide(1e-11L) * (100 + std::abs(height));
            if (!contact.touching() && !free && faults++ == 0)
                FAIL_CHECK(scene.name << " " << n << ": " << to_string(contact.status));
        }
        CAPTURE(scene.name);
        CHECK(faults == 0);
        CHECK(touching > 500);
    }
}

TEMPLATE_TEST_CASE("DilatedField: an edit of the ground is felt at once", "[dilated_field]", float, double) {
    using T = TestType;
    auto ground = plane<T>(9, 9);
    const auto grid = ground.grid();
    const DilatedField field{grid, T(1)};
    CHECK(*field.height({3, 4}) == T(1));
    ground.at(4, 4) = T(2);
    CHECK(*field.height({4, 4}) == T(3));
    CHECK(*field.height({3, 4}) > T(2)); // the ball leans on the peak's edge
    ground.remove(4, 4);
    CHECK(*field.height({4, 4}) == T(0)); // it sinks to its equator in a hole as wide as itself
}

TEST_CASE("DilatedField: keeps a pointer, a radius and a number", "[dilated_field]") {
    using Grid = Terrain<double>::Grid;
    static_assert(sizeof(DilatedField<Grid>) <= 24);
    static_assert(
        !std::is_constructible_v<DilatedField<Grid>, Grid, double>); // a temporary would not outlive it
    static_assert(noexcept(std::declval<const DilatedField<Grid>&>().patch({})));
    CHECK(true);
}
