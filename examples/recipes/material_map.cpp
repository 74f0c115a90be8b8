// Stiffness and friction as functions of the place: a map of materials beside the map of heights, as rock, ice and snow in one
// landscape. Both are properties of the contact, so they are asked for at the proxy, between the tracker and the force.
//
// At a border between two materials neither may jump: the force would, by as much. Pressing with 2 N into ground that becomes
// twice as stiff gives 4 N, and where ice follows on rock what held the hand is gone at once. So the map is interpolated
// like the heights, and the step from update to update is bounded by the map's slope.
//
// Here a hand is dragged at 20 mm/s over stripes of ice and rock. Ends with 0 if each is felt as it should be and no step
// of the force is larger than 0.02 N.

#include <hfh/contact/friction.hpp>
#include <hfh/hfh.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

constexpr hfh::Index columns = 201, rows = 41;
constexpr double spacing = 0.001; // m

struct Material {
    double stiffness; ///< N/m
    hfh::Friction<double>::Coefficients friction;
};

/// Two materials, and how much of the second there is at each sample.
class MaterialMap {
public:
    explicit MaterialMap(const hfh::BilinearGrid<double, hfh::HeightView<float>>& share) noexcept
        : share_{&share} {}

    /// At the proxy of a contact.
    [[nodiscard]] Material at(const hfh::SurfacePoint<double>& proxy) const noexcept {
        const auto patch = share_->patch(proxy.cell);
        const double share = patch ? patch->height(proxy.u, proxy.v) : 0.0;
        const auto between = [share](double a, double b) { return a + share * (b - a); };
        return {between(ice.stiffness, rock.stiffness),
                {between(ice.friction.at_rest, rock.friction.at_rest),
                 between(ice.friction.sliding, rock.friction.sliding)}};
    }

    static constexpr Material ice{300, {.at_rest = 0.05, .sliding = 0.03}};
    static constexpr Material rock{800, {.at_rest = 0.6, .sliding = 0.5}};

private:
    const hfh::BilinearGrid<double, hfh::HeightView<float>>* share_; ///< 0: ice, 1: rock
};

} // namespace

int main() {
    std::vector<float> heights(columns * rows, 0.0f), shares;
    for (hfh::Index j = 0; j < rows; ++j)
        for (hfh::Index i = 0; i < columns; ++i) {
            // Stripes of 50 mm, with 10 mm from one to the other.
            const double place = std::fmod(static_cast<double>(i), 100.0);
            shares.push_back(
                static_cast<float>(std::clamp((25 - std::abs(place - 50)) / 10 + 0.5, 0.0, 1.0)));
        }
    const hfh::GridFrame frame{.spacing = {spacing, spacing}};
    const hfh::BilinearGrid ground{hfh::HeightView{heights.data(), columns, rows}, frame};
    const hfh::BilinearGrid share{hfh::HeightView{shares.data(), columns, rows}, frame};
    const MaterialMap materials{share};

    hfh::ProxyTracker tracker{ground};
    hfh::Friction<double> friction;
    hfh::vec3<double> last{0.0};
    double largest_step = 0, on_ice = 0, on_rock = 0;
    for (int ms = 0; ms < 9000; ++ms) {
        const hfh::vec3<double> hand{0.01 + 0.00002 * ms, 0.02,
                                     ms == 0 ? 0.001 : -std::min(0.002, 0.00001 * ms)};
        const auto touched = tracker.update(hand);
        const Material material = materials.at(touched.point);
        const auto anchor = friction.state(); // other coefficients, the same hold
        friction = hfh::Friction<double>{material.friction};
        friction.restore(anchor);
        const auto contact = friction.hold(ground, touched, hand);
        const auto felt = hfh::ForceEvaluator<double>{.stiffness = material.stiffness}(contact).newtons;
        if (ms > 300) largest_step = std::max(largest_step, glm::length(felt - last));
        last = felt;
        const double ratio = -felt.x / std::max(1e-9, felt.z); // friction over normal force
        if (ms == 400) on_ice = ratio;
        if (ms == 2000) on_rock = ratio;
    }
    std::printf("friction over normal force: %.3f on ice, %.3f on rock; largest step of the force %.4f N\n",
                on_ice, on_rock, largest_step);
    return std::abs(on_ice - 0.03) < 1e-3 && std::abs(on_rock - 0.5) < 1e-3 && largest_step < 0.02 ? 0 : 1;
}
