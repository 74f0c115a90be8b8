#ifndef HFH_FORCE_DAMPING_HPP
#define HFH_FORCE_DAMPING_HPP

#include <hfh/force/force_evaluator.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: Colgate and Schenkel, Passivity of a Class of Sampled-Data Systems (1997): a virtual wall K + B·d/dt; and
// Hunt and Crossley, Coefficient of Restitution Interpreted as Damping in Vibroimpact (1975): damping that begins and
// ends at zero with the penetration, so that a contact neither starts with a blow nor ends with a pull.

namespace hfh {

/// Velocity from positions, for a device that does not measure it: differences through a first-order low pass,
///
///     v ← v + α·(Δx/Δt − v),   α = 1 − exp(−2π·cutoff·Δt)
///
/// The velocity of a steady motion is approached with an error that falls as exp(−2π·cutoff·t); any other is followed with
/// a lag of 1/(2π·cutoff), 3.2 ms at 50 Hz. Steps of the encoder of size q give a noise of at most α·q/Δt: 15 mm/s for
/// q = 0.055 mm at 1 kHz and 50 Hz. Does not throw, does not allocate.
template <Real T>
class VelocityFilter {
public:
    /// Cut-off in Hz, > 0. Anything else: no filter, plain differences.
    constexpr explicit VelocityFilter(T cutoff = T(50)) noexcept : cutoff_{cutoff} {}

    /// The velocity, in m/s, when the stylus is at `position`, in metres, `seconds` after the last call. The first call
    /// gives zero. Where no time has passed (seconds ≤ 0) nothing changes. After a position, a time or a quotient that is
    /// not finite the velocity is zero and the next call counts as the first.
    vec3<T> update(const vec3<T>& position, T seconds) noexcept {
        if (!is_finite(position) || !is_finite(seconds)) {
            reset();
        } else if (!started_) {
            started_ = true;
            last_ = position;
        } else if (seconds > 0) {
            const bool filters = is_finite(cutoff_) && cutoff_ > 0;
            const T share = filters ? -std::expm1(T(-6.283185307179586) * cutoff_ * seconds) : T(1);
            const vec3<T> next = velocity_ + share * ((position - last_) / seconds - velocity_);
            if (is_finite(next)) {
                velocity_ = next;
                last_ = position;
            } else {
                reset();
            }
        }
        return velocity_;
    }

    [[nodiscard]] constexpr const vec3<T>& velocity() const noexcept { return velocity_; }

    /// Forgets the positions: the velocity is zero.
    constexpr void reset() noexcept {
        started_ = false;
        velocity_ = vec3<T>{T(0)};
    }

private:
    T cutoff_;
    vec3<T> last_{T(0)};
    vec3<T> velocity_{T(0)};
    bool started_ = false;
};

/// Spring, damping and the device's limit in one: with n the contact's normal, v the stylus's velocity and F the force
/// of the spring, k·(proxy − stylus),
///
///     newtons = F − along_normal·(v·n) n − tangential·(v − (v·n) n)
///
/// shortened to max_force as a whole, and `clamped` says so. Only in contact. Neither part of the damping is greater than the
/// spring's force: the normal part is at most F·n, the tangential part at most |F|. So damping begins and ends at zero with
/// the depth, and never pulls the stylus towards the surface, however fast it lifts off: newtons·n ≥ 0 wherever F·n ≥ 0, and
/// elsewhere newtons·n is F·n, but for roundings. n is the normal of the very contact that is given. For one that friction has
/// held back or shaded F·n ≥ 0 (friction.hpp), for one of the tracker's it is where the surface is smooth. In return the damping is
/// less than its coefficient says where the depth is below coefficient·|v|/k.
///
///     const auto contact = tracker.update(position);
///     device.send(damping(force, contact, velocity.update(position, seconds)).newtons);
///
/// At zero velocity the result is the evaluator's, to the bit. There is no damping where the velocity or its square is not
/// finite, or a coefficient is below 0 or not finite. Has no state, does not throw.
template <Real T>
struct Damping {
    T along_normal = T(0); ///< N·s/m, ≥ 0
    T tangential = T(0);   ///< N·s/m, ≥ 0

    [[nodiscard]] Force<T> operator()(const ForceEvaluator<T>& spring, const Contact<T>& contact,
                                      const vec3<T>& velocity) const noexcept {
        const Force<T> undamped = spring(contact);
        const bool usable =
            is_at_least_zero(along_normal) && is_at_least_zero(tangential) && is_finite(velocity);
        if (!contact.touching() || !usable || undamped.newtons == vec3<T>{T(0)}) return undamped;

        const vec3<T> elastic = spring.stiffness * contact.penetration;
        const T outward = glm::dot(velocity, contact.normal);
        const vec3<T> across = velocity - outward * contact.normal;
        const T push = std::max(glm::dot(elastic, contact.normal), T(0));
        const T slide = glm::length(across), most = spring.stiffness * contact.depth;
        if (!is_finite(outward) || !is_finite(slide)) return undamped;
        const T slows = tangential * slide > most ? most / slide : tangential;
        const vec3<T> damping =
            std::clamp(-along_normal * outward, -push, push) * contact.normal - slows * across;
        if (damping == vec3<T>{T(0)}) return undamped;

        const vec3<T> sum = elastic + damping;
        const T size = glm::length(sum);
        if (!is_finite(sum) || !is_finite(size)) return undamped;
        const bool clamped = size > spring.max_force;
        return {clamped ? sum * (spring.max_force / size) : sum, clamped};
    }
};

} // namespace hfh

#endif // HFH_FORCE_DAMPING_HPP
