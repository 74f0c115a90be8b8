#ifndef HFH_BENCH_CLOSED_LOOP_CONTROLLERS_HPP
#define HFH_BENCH_CLOSED_LOOP_CONTROLLERS_HPP

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>

// The passivity controllers of the literature that the library does not offer, as their papers have them, to be compared
// with those it does. Each: (position, what the scene asks) → force, one update a period.

namespace closed_loop {

/// Time-domain passivity control (Hannaford and Ryu 2002): a passivity observer counts the energy at the told positions,
///
///     E ← E − F_{k−1}·(x_k − x_{k−1})
///
/// and while it is below 0 a passivity controller adds a damper that would make it good in one update at the speed of
/// the last one, α = −E/(T·v²), no more than `most`.
class TimeDomainPassivity {
public:
    TimeDomainPassivity(double most, double period) : most_{most}, period_{period} {}

    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position, const glm::dvec3& newtons) {
        const glm::dvec3 step = known_ ? position - position_ : glm::dvec3{0.0};
        energy_ -= glm::dot(force_, step);
        force_ = newtons;
        const double squared = glm::dot(step, step);
        if (energy_ < 0 && squared > 0)
            force_ -= std::min(most_, -energy_ * period_ / squared) * step / period_;
        position_ = position;
        known_ = true;
        return force_;
    }

private:
    double most_, period_, energy_ = 0;
    glm::dvec3 position_{0.0}, force_{0.0};
    bool known_ = false;
};

/// Energy bounding algorithm (Kim and Ryu 2010): a force changes by no more than the device's own damping makes good,
/// |F_k − F_{k−1}| ≤ (2b/T)·|x_k − x_{k−1}|.
class EnergyBounding {
public:
    EnergyBounding(double viscous, double period) : per_metre_{2 * viscous / period} {}

    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& position, const glm::dvec3& newtons) {
        const double most = known_ ? per_metre_ * glm::length(position - position_) : 0.0;
        const glm::dvec3 change = newtons - force_;
        const double length = glm::length(change);
        force_ += length > most ? change * (most / length) : change;
        position_ = position;
        known_ = true;
        return force_;
    }

private:
    double per_metre_;
    glm::dvec3 position_{0.0}, force_{0.0};
    bool known_ = false;
};

/// A virtual coupling's spring in series with the wall's, as soft as the device's own damping makes passive without any
/// other help (Colgate; Adams and Hannaford 1999): 2b/T.
struct SoftCoupling {
    double share; ///< of the wall's force: K_c/(K + K_c)

    SoftCoupling(double viscous, double period, double stiffness)
        : share{2 * viscous / period / (stiffness + 2 * viscous / period)} {}
    [[nodiscard]] glm::dvec3 operator()(const glm::dvec3&, const glm::dvec3& newtons) const {
        return share * newtons;
    }
};

} // namespace closed_loop

#endif // HFH_BENCH_CLOSED_LOOP_CONTROLLERS_HPP
