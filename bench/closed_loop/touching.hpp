#ifndef HFH_BENCH_CLOSED_LOOP_TOUCHING_HPP
#define HFH_BENCH_CLOSED_LOOP_TOUCHING_HPP

#include "grounds.hpp"
#include "reference.hpp"

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_glide.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <limits>

namespace closed_loop {

/// What is done to a contact before it becomes a force.
struct Feel {
    bool friction = false; ///< with the coefficients 0.5 and 0.4
    bool shading = false;
    double release_speed = std::numeric_limits<double>::infinity(); ///< m an update
};

/// Positions in, forces out, and a watcher beside it that knows the heights, the position and the answer and shares no
/// code with the library: is the proxy at a local minimum?
template <Real T>
class Touching {
public:
    Touching(const hfh::test::Terrain<T>& terrain, double stiffness, double max_force = 1e30,
             const hfh::TrackerOptions& options = {}, const Feel& feel = {})
        : surface_{terrain}, grid_{terrain.grid()}, tracker_{grid_, options}, feel_{feel},
          glide_{feel.release_speed}, force_{.stiffness = static_cast<T>(stiffness),
                                             .max_force = static_cast<T>(max_force)} {}
    Touching(const Touching&) = delete;
    Touching& operator=(const Touching&) = delete;

    /// The force at `position`, N.
    [[nodiscard]] glm::dvec3 update(const glm::dvec3& position) {
        const hfh::vec3<T> stylus{position};
        auto contact = glide_.follow(grid_, tracker_.update(stylus), stylus);
        touching_ = contact.touching();
        if (touching_) {
            ++contacts_;
            // 64 ulp-scales of the derivative is the bound of the tests: what rounding leaves.
            jammed_ +=
                surface_.template fall<T>(hfh::test::wide(contact.point), hfh::test::wide(stylus)) > 64;
            unfinished_ += contact.status != hfh::ContactStatus::contact;
            without_force_ += !(contact.depth > 0);
        }
        if (feel_.shading) contact = hfh::shade_force(grid_, contact);
        if (feel_.friction) contact = friction_.hold(grid_, contact, stylus);
        return glm::dvec3{force_(contact).newtons};
    }
    /// Forgets the stylus.
    void reset() {
        tracker_.reset();
        glide_.reset();
        friction_.reset();
    }

    [[nodiscard]] bool touching() const { return touching_; }
    /// The proxy that is felt has not come to the tracker's.
    [[nodiscard]] bool is_under_way() const { return glide_.state().is_under_way; }
    /// How many updates a hand that rests at `position` has to wait for it.
    [[nodiscard]] int updates_to_arrive(const glm::dvec3& position) const {
        const hfh::vec3<T> stylus{position};
        auto tracker = tracker_;
        auto glide = glide_;
        int updates = 0;
        for (; glide.state().is_under_way && updates < 1000; ++updates)
            (void)glide.follow(grid_, tracker.update(stylus), stylus);
        return updates;
    }
    [[nodiscard]] long without_force() const { return without_force_; } ///< of the updates in contact
    [[nodiscard]] long contacts() const { return contacts_; }           ///< updates in contact
    [[nodiscard]] long jammed() const { return jammed_; } ///< of these, with the proxy not at a local minimum
    [[nodiscard]] long unfinished() const { return unfinished_; } ///< of these, by the tracker's own word

private:
    hfh::test::Surface<T> surface_;
    typename hfh::test::Terrain<T>::Grid grid_;
    hfh::ProxyTracker<typename hfh::test::Terrain<T>::Grid> tracker_;
    Feel feel_;
    hfh::ProxyGlide<T> glide_;
    hfh::Friction<T> friction_{};
    hfh::ForceEvaluator<T> force_;
    bool touching_ = false;
    long contacts_ = 0, jammed_ = 0, unfinished_ = 0, without_force_ = 0;
};

/// Updates in contact, how many of them were jammed, and how many the tracker says it did not finish.
struct Lag {
    long contacts = 0, jammed = 0, unfinished = 0;

    template <Real T>
    void add(const Touching<T>& touching) {
        contacts += touching.contacts();
        jammed += touching.jammed();
        unfinished += touching.unfinished();
    }
};

/// Energy given to the hand by forces that are each held until the next position, J: Σ F_{k−1}·(x_k − x_{k−1}).
class Energy {
public:
    /// The stylus is at `position`, where `newtons` begins to act.
    void add(const glm::dvec3& position, const glm::dvec3& newtons) {
        if (started_) {
            const glm::dvec3 step = position - position_;
            const bool acts = newtons_ != glm::dvec3{0.0};
            given_ += glm::dot(newtons_, step);
            if (acts || newtons != glm::dvec3{0.0}) steps_ += glm::dot(step, step);
            most_ = std::max(most_, given_);
        }
        started_ = true;
        position_ = position;
        newtons_ = newtons;
    }
    [[nodiscard]] double given() const { return given_; }
    [[nodiscard]] double most() const { return most_; } ///< at any time
    /// Σ |x_k − x_{k−1}|², m², over the steps that begin or end with a force.
    [[nodiscard]] double squared_steps() const { return steps_; }

private:
    bool started_ = false;
    glm::dvec3 position_{0.0}, newtons_{0.0};
    double given_ = 0, most_ = 0, steps_ = 0;
};

} // namespace closed_loop

#endif // HFH_BENCH_CLOSED_LOOP_TOUCHING_HPP
