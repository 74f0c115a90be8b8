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

/// What the hand and the device can do between two updates, and what a tank may give. All are the user's.
struct EnergyTankOptions {
    /// Metres, > 0 and finite: the farthest that the position moves in one update.
    double largest_step = 1e-3;
    /// Metres, ≥ 0: the most by which the step of one update differs from the step before, T²·(largest acceleration),
    /// plus twice the resolution. Infinite: nothing is known of that.
    double largest_turn = std::numeric_limits<double>::infinity();
    /// Joules, ≥ 0 and finite, that may be given before any was taken. As it stands the energy stays above −10⁻⁹ J: the
    /// other half of that is for the rounding of 10⁷ updates.
    double allowance = 0.5e-9;
    double capacity = 0.1; ///< joules, ≥ 0: what is taken beyond that is not remembered; ∞ for no limit
};

/// A force that the tank can bear, and by how much that is less than was wanted.
struct TankForce {
    glm::dvec3 newtons{0.0};
    bool shortened = false;
    double held_back = 0; ///< N by which it is shorter than what was wanted; 0 where that is no number
    double owed = 0;      ///< J that the hand got beyond the allowance, by motions beyond the options
};

/// Shortens forces so that they never give the hand more energy than they took from it: force saturation on an energy
/// tank, the strictest of the passivity controllers and the dearest.
///
/// A force that is held from update k−1 to update k gives the hand exactly F_{k−1}·(x_k − x_{k−1}). The tank holds what
/// was taken less what was given,
///
///     level = −Σ F_{k−1}·(x_k − x_{k−1}) ≥ −allowance,
///
/// and keeps that bound for every motion within the options, because it gives out no force that could break it. With s
/// the step just made, the next one is at most r = min(largest_step, s·F/|F| + largest_turn) along F, so that
///
///     |F| ≤ (level + allowance)/r    if r > 0, else any F
///
/// keeps it. Without a `largest_turn` no greater force would: a hand may make the step r. So this takes off the least.
///
/// What it costs: a spring that is touched for the first time, with the tank empty, is felt only as fast as it fills.
/// With no `largest_turn` the force grows by a factor e every `largest_step` of depth, however small the allowance; with
/// one it is whole at once when the hand comes in faster than largest_turn an update. A sampled spring without friction
/// gives back all that it took and K·T·v·D more: that is cut off at the end of the way out. So it is for scenes that must
/// not be active whatever the price, not for ground that is to be felt: on the simulated Touch a hand that aims 10 mm
/// deep feels nothing with the defaults (9.2 mm deep, where the spring alone stops it at 3.5 mm), and with a
/// `largest_turn` steps of 0.5 to 2.6 N an update. For ground use `VirtualCoupling`.
///
/// What it counts: the positions as they are told. Between two steps of the encoders the hand may get more or less.
///
/// The last link before the device, behind the guard: it only ever shortens. What a driver changes behind it has to be
/// told by `sent`, and may only be shorter and the same way: a force that is turned behind the tank, as by a clamp of each
/// axis, can give more than it accounts for. The device must hold the force until the next update (delay 0). A motion beyond the options is counted in `exceeded`; what it drew is owed, and
/// `owed` says how much. Until it is paid back only a force that is sure to take energy passes; without a `largest_turn`
/// none is, there is no force at all any more, and `reset` has to forgive the debt. Does not throw, does not allocate.
class EnergyTank {
public:
    constexpr explicit EnergyTank(const EnergyTankOptions& options = {}) noexcept : options_{options} {}

    /// Whether the options are in range. If they are not, no force passes, ever.
    [[nodiscard]] constexpr bool usable() const noexcept {
        return is_at_least_zero(options_.largest_step) && options_.largest_step > 0 &&
               is_upper_limit(options_.largest_turn) && is_at_least_zero(options_.allowance) &&
               is_upper_limit(options_.capacity);
    }

    /// One update: the device is at `position` and `newtons` is wanted until the next one. No force where either is no
    /// number; the force before is then charged with the most that it can have given.
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
        const double most =
            std::max(0.0, level_ + options_.allowance) * (1 - 0x1p-40); // less the rounding of what follows
        const bool shortened = reach > 0 && !(length * reach <= most);
        force_ = shortened ? newtons * (most / (reach * length)) : newtons;
        at_stake_ = reach > 0 ? std::min(most, length * reach) : 0.0;
        return {force_, shortened, shortened ? length - glm::length(force_) : 0, owed()};
    }

    /// What the motors got in place of the force last given out, where something behind the tank shortened it or let an
    /// update out: that is what it counts. No number: as if nothing had been told.
    void sent(const glm::dvec3& newtons) noexcept {
        if (!is_finite(newtons)) return;
        const double length = glm::length(newtons);
        force_ = newtons;
        at_stake_ = length > 0 ? std::max(0.0, length * reach_along(newtons / length)) : 0.0;
    }

    /// Joules taken from the hand and not given back.
    [[nodiscard]] constexpr double level() const noexcept { return level_; }
    /// Joules that the hand got beyond the allowance. While it is not 0, no force passes that is not sure to take energy.
    [[nodiscard]] constexpr double owed() const noexcept {
        return std::max(0.0, -(level_ + options_.allowance));
    }
    /// Updates in which the hand moved farther, or turned more, than the options say.
    [[nodiscard]] constexpr unsigned long long exceeded() const noexcept { return exceeded_; }

    /// Empty, as at the start.
    constexpr void reset() noexcept { *this = EnergyTank{options_}; }

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
