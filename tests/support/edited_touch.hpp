#ifndef HFH_TESTS_SUPPORT_EDITED_TOUCH_HPP
#define HFH_TESTS_SUPPORT_EDITED_TOUCH_HPP

#include "guard_oracle.hpp"
#include "terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <algorithm>

// Ground that is edited under a stylus whose force goes through a guard, which a judge looks on at.

namespace hfh::test {

/// In metres, at 500 N/m.
template <Real T>
class EditedTouch {
public:
    Terrain<T> ground;
    vec3<T> stylus;

    EditedTouch(Terrain<T> on, const vec3<T>& at, const GuardLimits& limits = {})
        : ground{std::move(on)}, stylus{at}, guard_{limits}, judge_{limits} {}
    EditedTouch(const EditedTouch&) = delete;
    EditedTouch& operator=(const EditedTouch&) = delete;

    GuardUpdate step(double seconds = 0.001) {
        time_ += seconds;
        contact_ = tracker_.update(stylus);
        GuardUpdate now;
        now.sample = {.time = time_, .position = glm::dvec3{stylus}};
        now.asked = glm::dvec3{force_(contact_).newtons};
        now.buried = contact_.status == ContactStatus::buried;
        now.result = guard_.update(now.sample, now.asked, now.buried);
        if (const char* rule = judge_(now)) broken_ = rule;
        return now;
    }

    [[nodiscard]] const Contact<T>& contact() const { return contact_; }
    [[nodiscard]] const GuardCounts& counts() const { return guard_.counts(); }
    [[nodiscard]] bool tripped() const {
        return std::ranges::any_of(counts().trips, [](unsigned times) { return times > 0; });
    }
    /// The rule of the judge that was broken last, or nullptr.
    [[nodiscard]] const char* broken() const { return broken_; }

private:
    typename Terrain<T>::Grid grid_{ground.grid()};
    ProxyTracker<typename Terrain<T>::Grid> tracker_{grid_};
    ForceEvaluator<T> force_{.stiffness = T(500)};
    ForceGuard guard_;
    GuardJudge judge_;
    Contact<T> contact_{};
    double time_ = 7;
    const char* broken_ = nullptr;
};

/// Samples every 5 mm.
inline constexpr GridFrame five_millimetres{.spacing = {0.005, 0.005}};

/// One sample after the other around a resting stylus changes at random by up to `size` metres.
template <Real T>
class RandomEdits {
public:
    EditedTouch<T> touch{rough_in_steps<T>(16, 16, 0.002, 112, five_millimetres),
                         {T(0.0415), T(0.038), T(0.003)},
                         {.max_slew = 0.1}};
    int touching = 0, slewed = 0; ///< of 3000 updates

    explicit RandomEdits(double size) {
        Random random{113};
        // Above, until the ramp is over.
        for (int n = 0; n < 600; ++n) (void)touch.step();
        touch.stylus.z = T(-0.001);
        for (int n = 0; n < 50; ++n) (void)touch.step();
        for (int n = 0; n < 3000; ++n) {
            T& height = touch.ground.at(8 + random.whole(-1, 2), 7 + random.whole(-1, 2));
            height = static_cast<T>(std::clamp(double(height) + random.between(-size, size), -0.008, 0.008));
            slewed += touch.step(0.001 * random.between(0.5, 1.5)).result.slewed;
            touching += touch.contact().touching();
        }
    }
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_EDITED_TOUCH_HPP
