#ifndef HFH_FORCE_ENERGY_TANK_HPP
#define HFH_FORCE_ENERGY_TANK_HPP

#include <hfh/geometry/scalar.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

// Based on: Franken, Stramigioli, Misra, Secchi, Macchelli, Bilateral telemanipulation with time delays: a two-layer
// approach combining passivity and transparency, 2011: an energy tank, and a force saturated by what the tank can bear.

namespace hfh {

/// What the hand and the device can do between two updates, and what a tank may give.
struct EnergyTankOptions {
    /// Metres, > 0 and finite: the farthest that the position moves in one update.
    double largest_step = 1e-3;
    /// Metres, ≥ 0: the most by which the step of one update differs from the step before, which is T²·(largest
    /// acceleration) plus twice the resolution. Infinite: no bound is known.
    double largest_turn = std::numeric_limits<double>::infinity();
    /// Joules, ≥ 0 and finite, that may be given before any was taken. The default keeps the energy above −10⁻⁹ J: the other
    /// half of that is left to the rounding of 10⁷ updates.
    double allowance = 0.5e-9;
    double capacity = 0.1; ///< joules, ≥ 0: energy taken beyond that is not stored; ∞ for no limit
};

/// A force that the tank can bear, and by how much it is shorter than the wanted one.
struct TankForce {
    glm::dvec3 newtons{0.0};
    bool shortened = false;
    double held_back = 0; ///< N by which it is shorter than the wanted one; 0 where that is no number
    double owed = 0;      ///< J that the hand got beyond the allowance, by motions beyond the options
};

/// Shortens forces so that they never give the hand more energy than they took from it: force saturation on an energy
/// tank. Of all passivity controllers it promises the most and takes away the most force.
///
/// A force that is held from update k−1 to update k gives the hand exactly F_{k−1}·(x_k − x_{k−1}). The tank's level is the
/// energy that was taken less the energy that was given,
///
///     level = −Σ F_{k−1}·(x_k − x_{k−1}) ≥ −allowance,
///
/// and the bound holds for every motion within the options, because no force passes that could break it. With s the step
/// just made, the next one is at most r = min(largest_step, s·F/|F| + largest_turn) along F, so that
///
///     |F| ≤ (level + allowance)/r    if r > 0, else any F
///
/// keeps the bound. Without a `largest_turn` no greater force would keep it, because the hand may make the step r: the tank
/// takes off no more than it has to.
///
/// Its cost: a spring that is touched while the tank is empty is felt only as fast as the tank fills. Without a
/// `largest_turn` the force grows by a factor e every `largest_step` of depth, however small the allowance; with one it is
/// whole at once if the hand comes in faster than largest_turn an update. A sampled spring without friction gives back
/// all that it took and K·T·v·D more; that part is cut off at the end of the way out. So the tank is for scenes that must
/// never be active. Ground is hardly felt through it: a hand has gone millimetres deep before there is a force, or feels
/// the force come in jumps. For ground use `VirtualCoupling`.
///
/// The account is of the positions as the device tells them. Between two steps of the encoders the hand may get more or
/// less.
///
/// The tank is the last link before the device, behind the guard, because it only shortens. What changes the force behind
/// it has to be told by `sent`, and may shorten the force but not turn it: a turned force, as from a clamp of each axis,
/// can give more energy than the tank has counted. The device must hold the force until the next update (delay 0). A
/// motion beyond the options is counted in `exceeded`; the energy that it drew beyond the allowance is `owed`. Until that
/// is paid back only a force that is sure to take energy passes. Without a `largest_turn` no force is sure to, so none
/// passes until `reset`. Does not throw, does not allocate.
class EnergyTank {
public:
    GLM_CONSTEXPR explicit EnergyTank(const EnergyTankOptions& options = {}) noexcept : options_{options} {}

    /// Whether the options are in range. If they are not, no force passes, ever.
    [[nodiscard]] constexpr bool usable() const noexcept {
        return is_at_least_zero(options_.largest_step) && options_.largest_step > 0 &&
               is_upper_limit(options_.largest_turn) && is_at_least_zero(options_.allowance) &&
               is_upper_limit(options_.capacity);
    }

    /// One update: the device is at `position`, in metres, and `newtons` is wanted until the next one. No force where either
    /// is no number; where the position is none, the force before is charged with the most that it can have given.
    [[nodiscard]] TankForce operator()(const glm::dvec3& position, const glm::dvec3& newtons) noexcept {
        if (!is_finite(position)) {
            level_ -= at_stake_;
            forget();
            return {{}, true, 0, owed()};
        }
        settle(position);
        const double length = glm::length(newtons);
        if (!is_finite(newtons) || !is_finite(length)) return {{}, true, 0, owed()};
        if (!(length > 0)) return {{}, false, 0, owed()};
        if (!usable()) return {{}, true, length, owed()};
        const double reach = reach_along(newtons / length);
        // Joules, less the rounding of what follows.
        const double most = std::max(0.0, level_ + options_.allowance) * (1 - 0x1p-40);
        const bool shortened = reach > 0 && !(length * reach <= most);
        force_ = shortened ? newtons * (most / (reach * length)) : newtons;
        at_stake_ = reach > 0 ? std::min(most, length * reach) : 0.0;
        return {force_, shortened, shortened ? length - glm::length(force_) : 0, owed()};
    }

    /// What the motors got in place of the force last given out, where something behind the tank shortened it or left an
    /// update out. The tank then counts with this force. A force that is no number is ignored.
    void sent(const glm::dvec3& newtons) noexcept {
        if (!is_finite(newtons)) return;
        const double length = glm::length(newtons);
        force_ = newtons;
        at_stake_ = length > 0 ? std::max(0.0, length * reach_along(newtons / length)) : 0.0;
    }

    /// Joules taken from the hand and not given back.
    [[nodiscard]] constexpr double level() const noexcept { return level_; }
    /// Joules that the hand got beyond the allowance. While it is above 0, only a force that is sure to take energy passes.
    [[nodiscard]] constexpr double owed() const noexcept {
        return std::max(0.0, -(level_ + options_.allowance));
    }
    /// Updates in which the hand moved farther, or turned more, than the options say.
    [[nodiscard]] constexpr unsigned long long exceeded() const noexcept { return exceeded_; }

    /// Empty, as at the start.
    GLM_CONSTEXPR void reset() noexcept { *this = EnergyTank{options_}; }

private:
    /// Counts what the last force has done on the way to `position`.
    void settle(const glm::dvec3& position) noexcept {
        if (known_ > 0) {
            const glm::dvec3 step = position - position_;
            const bool turned = known_ > 1 && glm::length(step - step_) > options_.largest_turn;
            if (turned || glm::length(step) > options_.largest_step) ++exceeded_;
            level_ = std::min(options_.capacity, level_ - glm::dot(force_, step));
            step_ = step;
        }
        known_ = std::min(2, known_ + 1);
        position_ = position;
        force_ = {};
        at_stake_ = 0;
    }

    /// Metres: the most by which the next step can go in a direction of length 1.
    [[nodiscard]] double reach_along(const glm::dvec3& direction) const noexcept {
        const double step = options_.largest_step;
        return known_ > 1 ? std::min(step, glm::dot(step_, direction) + options_.largest_turn) : step;
    }

    constexpr void forget() noexcept {
        known_ = 0;
        force_ = {};
        at_stake_ = 0;
    }

    EnergyTankOptions options_;
    double level_ = 0;
    double at_stake_ = 0; ///< J: the most that the present force can give
    glm::dvec3 position_{0.0};
    glm::dvec3 step_{0.0};
    glm::dvec3 force_{0.0};
    int known_ = 0; ///< positions seen in a row, up to 2
    unsigned long long exceeded_ = 0;
};

} // namespace hfh

#endif // HFH_FORCE_ENERGY_TANK_HPP
