// The guard under -ffast-math, where a compiler may take it that no number is a NaN or an infinity, and the processor
// takes denormals for zero. A program of its own, because the flag changes how the whole program starts.

#include "support/edited_touch.hpp"
#include "support/guard_oracle.hpp"
#include "support/guards.hpp"

#include <cstdio>
#include <cstring>

using namespace hfh;
using namespace hfh::test;

namespace {

int failures = 0;

void check(bool holds, const char* what, const char* with) {
    if (holds) return;
    ++failures;
    std::printf("FAILED: %s (%s)\n", what, with);
}

struct Named {
    const char* name;
    double value;
};

/// A guard in full force, with 2 N asked for.
struct Scene {
    Guard guard{{.max_slew = 0.01}};
    DeviceSample sample{.time = 5};
    glm::dvec3 asked{0, 0, 2};

    Scene() {
        for (int n = 0; n < 1000; ++n) (void)step();
    }
    GuardedForce step() {
        sample.time += 0.001;
        sample.position.x += 0.0001;
        return guard.update(sample, asked);
    }
};

void check_numbers_that_are_none(const Named& bad) {
    for (int axis = 0; axis < 3; ++axis) {
        Scene force;
        check(force.step().newtons.z > 1.9, "feels its force before", bad.name);
        force.asked[axis] = bad.value;
        auto result = force.step();
        check(result.trip == GuardTrip::bad_force, "a bad force trips", bad.name);
        check(is_zero(result.newtons), "a bad force is zero at once", bad.name);
        force.asked = {0, 0, 2};
        for (int n = 0; n < 1000; ++n) result = force.step();
        check(result.newtons.z > 1.9 && result.newtons.z < 2.1, "comes back", bad.name);

        Scene place;
        place.sample.position[axis] = bad.value;
        result = place.step();
        check(result.trip == GuardTrip::bad_sample, "a bad position trips", bad.name);
        check(is_zero(result.newtons), "a bad position is zero at once", bad.name);
    }
    Scene time;
    time.sample.time = bad.value;
    const auto result = time.step();
    check(result.trip == GuardTrip::bad_sample, "a bad time trips", bad.name);
    check(is_zero(result.newtons), "a bad time is zero at once", bad.name);

    // As arithmetic makes it, not as memory holds it: 0/0 and 1/0 by a divisor that nobody knows.
    volatile double zero = 0;
    for (const double numerator : {0.0, 1.0, -1.0}) {
        Scene made;
        made.asked.z = numerator / zero;
        if (is_number(made.asked.z)) continue; // folded away by the compiler: there is nothing bad to find
        check(is_zero(made.step().newtons), "a force from a division by zero is zero", bad.name);
    }

    for (double GuardLimits::*limit :
         {&GuardLimits::max_force, &GuardLimits::max_slew, &GuardLimits::ramp, &GuardLimits::max_gap,
          &GuardLimits::max_still, &GuardLimits::max_speed, &GuardLimits::max_step, &GuardLimits::stiffness,
          &GuardLimits::max_sudden, &GuardLimits::period}) {
        GuardLimits limits;
        limits.*limit = bad.value;
        Guard guard{limits};
        check(guard.update({.time = 1}, {0, 0, 1}).trip == GuardTrip::bad_limits, "a bad limit trips",
              bad.name);
    }
}

void check_denormals() {
    const double tiny = make_denormal();
    Scene scene;
    scene.asked = {tiny, -tiny, 2};
    auto result = scene.step();
    check(result.trip == GuardTrip::none && result.newtons.z > 1.9, "a denormal force is a force",
          "denormal");
    scene.asked = {tiny, tiny, tiny};
    for (int n = 0; n < 1000; ++n) result = scene.step();
    check(is_number(result.newtons) && std::abs(result.newtons.z) < 1e-300, "goes to nearly zero",
          "denormal");
    scene.sample.position = {tiny, tiny, tiny};
    check(is_number(scene.step().newtons), "a denormal position gives a number", "denormal");
}

void check_everything_at_once() {
    for (const int calm : {3, 20, 400}) {
        const GuardLimits limits{.ramp = 0.05, .max_repeats = 3, .max_still = 0.003};
        Guard guard{limits};
        GuardJudge judge{as_seen(limits)};
        NastyStream stream{99, calm};
        for (int n = 0; n < 20000; ++n) {
            auto update = stream.next();
            update.sample = as_seen(update.sample);
            update.asked = as_seen(update.asked);
            update.result = guard.update(update.sample, update.asked, update.buried);
            const char* broken = judge(update);
            check(broken == nullptr, broken == nullptr ? "" : broken, "everything at once");
            if (broken != nullptr) return;
        }
        for (int k = 0; k < guard_trip_count; ++k)
            check(guard.counts().trips[k] == judge.trips(static_cast<GuardTrip>(k)), "counts",
                  to_string(static_cast<GuardTrip>(k)));
    }
}

/// A force from ground that is edited under the stylus, all of it under this flag.
template <Real T>
void check_edited_ground(const char* scalar) {
    for (const double size : {5e-5, 0.001, 0.008}) {
        const RandomEdits<T> edits{size};
        const char* broken = edits.touch.broken();
        check(broken == nullptr, broken == nullptr ? "" : broken, scalar);
        check(!edits.touch.tripped(), "an edit does not trip", scalar);
        check(edits.touching > 1000, "is touched", scalar);
    }
}

} // namespace

int main() {
#ifndef __FAST_MATH__
    std::printf("FAILED: this program is for -ffast-math\n");
    return 1;
#endif
    for (const Named& bad : {Named{"quiet NaN", make_nan()}, Named{"signalling NaN", make_signalling_nan()},
                             Named{"infinity", make_infinity()}, Named{"-infinity", -make_infinity()},
                             Named{"largest", make_largest()}})
        check_numbers_that_are_none(bad);
    check_denormals();
    check_everything_at_once();
    check_edited_ground<float>("edits in float");
    check_edited_ground<double>("edits in double");
    std::printf("%s\n", failures == 0 ? "the guard holds under -ffast-math" : "it does not hold");
    return failures == 0 ? 0 : 1;
}
