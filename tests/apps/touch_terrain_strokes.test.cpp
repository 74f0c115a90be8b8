#include "catch.hpp"
#include "support/random.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/bilinear_grid.hpp>
#include <terrain.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <variant>
#include <vector>

// Strokes over the bundled terrain with limited work.

using namespace hfh;
using hfh::test::Random;

namespace {

constexpr double dx = 73.596, dy = 92.491; // m

std::vector<float> bundled_heights() {
    const auto terrain = demo::read_terrain(HFH_SOURCE_DIR "/examples/data/spanish_peaks.png");
    std::vector<float> heights;
    std::visit(
        [&](const auto& samples) {
            for (Index j = 0; j < samples.rows(); ++j)
                for (Index i = 0; i < samples.columns(); ++i)
                    heights.push_back(static_cast<float>(samples(i, j)));
        },
        terrain.heights);
    return heights;
}

struct Dropouts {
    int updates = 0, contacts = 0;
    int unfelt = 0; ///< below ground after a contact or a search, and no force
    int stuck = 0;  ///< at rest, and out of work for 300 updates
};

/// A stroke of 400 updates, half a cell each, that winds over the ground and waves up to `deep` cells above and below it.
template <class Grid>
void stroke(const Grid& grid, Random& random, double deep, Dropouts& found) {
    using T = typename Grid::Scalar;
    ProxyTracker tracker{grid, {.max_contact_patches = 8}};
    double x = dx * 299 * random.between(0.1, 0.9), y = dy * 299 * random.between(0.1, 0.9);
    const auto ground = [&] {
        const Lattice lattice = grid.lattice();
        const Cell c{static_cast<Index>(std::floor(lattice.u_of(x, 0))),
                     static_cast<Index>(std::floor(lattice.v_of(y, 0)))};
        const auto patch = grid.patch(c);
        return patch ? static_cast<double>(patch->height(static_cast<T>(lattice.u_of(x, c.i)),
                                                         static_cast<T>(lattice.v_of(y, c.j))))
                     : std::numeric_limits<double>::quiet_NaN();
    };
    const auto update = [&](double z) {
        return tracker.update({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
    };
    (void)update(ground() + 10 * dx);
    double heading = random.between(0, 2 * std::numbers::pi);
    const double depth = deep * dx * random.unit(), phase = random.between(0, 6),
                 rhythm = 0.25 * random.unit();
    for (int k = 0; k < 400; ++k) {
        heading += random.between(-0.2, 0.2);
        x += 0.5 * dx * std::cos(heading), y += 0.5 * dx * std::sin(heading);
        const double surface = ground();
        if (std::isnan(surface)) return;
        const double z = surface - depth * std::sin(phase + k * rhythm);
        auto contact = update(z);
        ++found.updates;
        found.contacts += contact.touching();
        found.unfelt += contact.status == ContactStatus::sweep_limit && surface - z > 1e-6 * dx;
        if (contact.status != ContactStatus::sweep_limit && contact.status != ContactStatus::descent_limit)
            continue;
        if (!random.one_in(20)) continue;
        const auto state = tracker.state();
        int rests = 0;
        do contact = update(z);
        while (++rests < 300 && (contact.status == ContactStatus::sweep_limit ||
                                 contact.status == ContactStatus::descent_limit));
        found.stuck += rests == 300;
        tracker.restore(state);
    }
}

} // namespace

TEMPLATE_TEST_CASE(
    "proxy_tracker: strokes over the bundled terrain drop no contact with max_contact_patches 8",
    "[proxy_tracker][limited][regression]", float, double) {
    // Below the ground an update ended without a force, and the next one gave it back with a jump.
    const auto heights = bundled_heights();
    REQUIRE(heights.size() == 300 * 300);
    const HeightView view{heights.data(), 300, 300};
    const BilinearGrid<TestType, HeightView<float>> grid{view, {.spacing = {dx, dy}}};
    Random random{7};
    Dropouts found;
    for (const double deep : {0.5, 5.0, 40.0})
        for (int n = 0; n < 100; ++n) stroke(grid, random, deep, found);
    CHECK(found.updates > 50'000);
    CHECK(found.contacts > 20'000);
    CHECK(found.unfelt == 0);
    CHECK(found.stuck == 0);
}
