#ifndef HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP
#define HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP

#include "random.hpp"

#include <hfh/force_guard.hpp>

#include <bit>
#include <vector>

// What a guard may do, judged from outside from all that went in and came out, and inputs that try it. Shares nothing
// with the guard but its types: causes are worked out from the whole history each time, and whether a number is one from
// its bits, so that the judge holds under -ffast-math as well.

namespace hfh::test {

/// Made from bits, and through volatile, so that no compiler knows what it is.
[[nodiscard]] inline double from_bits(std::uint64_t bits) {
    const volatile std::uint64_t hidden = bits;
    return std::bit_cast<double>(static_cast<std::uint64_t>(hidden));
}
[[nodiscard]] inline double make_nan() { return from_bits(0x7ff8'0000'0000'0000u); }
[[nodiscard]] inline double make_signalling_nan() { return from_bits(0xfff0'0000'0000'0001u); }
[[nodiscard]] inline double make_infinity() { return from_bits(0x7ff0'0000'0000'0000u); }
[[nodiscard]] inline double make_denormal() { return from_bits(1); }
[[nodiscard]] inline double make_largest() { return from_bits(0x7fef'ffff'ffff'ffffu); }

/// A number that a guard takes: its exponent, read from the bits, is below that of 2⁶⁴.
[[nodiscard]] inline bool is_number(const double& x) {
    const volatile std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
    return (bits & 0x7fff'ffff'ffff'ffffu) < std::bit_cast<std::uint64_t>(0x1p64);
}
[[nodiscard]] inline bool is_number(const glm::dvec3& p) {
    return is_number(p.x) && is_number(p.y) && is_number(p.z);
}
[[nodiscard]] inline bool is_zero(const glm::dvec3& p) {
    const volatile std::uint64_t bits = std::bit_cast<std::uint64_t>(p.x) |
                                        std::bit_cast<std::uint64_t>(p.y) | std::bit_cast<std::uint64_t>(p.z);
    return bits == 0;
}
[[nodiscard]] constexpr long double wide(double x) { return static_cast<long double>(x); }
[[nodiscard]] inline long double distance(const glm::dvec3& a, const glm::dvec3& b) {
    const long double x = wide(a.x) - wide(b.x), y = wide(a.y) - wide(b.y), z = wide(a.z) - wide(b.z);
    return std::sqrt(x * x + y * y + z * z);
}

/// One update as seen from outside.
struct GuardUpdate {
    DeviceSample sample;
    glm::dvec3 asked{0.0};
    bool buried = false;
    bool rearmed = false; ///< rearm() was called just before it
    GuardedForce result;
};

/// The first rule that an update breaks, or nullptr. `past` is all before it, oldest first.
class GuardJudge {
public:
    explicit GuardJudge(const GuardLimits& limits) : limits_{limits} {}

    [[nodiscard]] const char* operator()(const GuardUpdate& update) {
        const unsigned causes = find_causes(update);
        if (update.rearmed) latched_ = false;
        if (causes != 0 && limits_.latch) latched_ = true;
        for (int k = 1; k < guard_trip_count; ++k)
            if ((causes >> k & 1u) != 0 && (last_causes_ >> k & 1u) == 0) ++trips_[k];
        last_causes_ = causes;

        GuardTrip gravest = GuardTrip::none;
        for (int k = 1; k < guard_trip_count && gravest == GuardTrip::none; ++k)
            if ((causes >> k & 1u) != 0) gravest = static_cast<GuardTrip>(k);

        const char* broken = judge(update, gravest);
        const bool good = is_number(update.sample.time) && is_number(update.sample.position);
        if (good) good_.push_back(update.sample);
        sent_ = update.result.newtons;
        return broken;
    }

    [[nodiscard]] unsigned trips(GuardTrip trip) const { return trips_[static_cast<int>(trip)]; }

private:
    const char* judge(const GuardUpdate& update, GuardTrip gravest) {
        const glm::dvec3& sent = update.result.newtons;
        if (!is_number(sent)) return "the force is a number";
        if (update.result.trip != gravest) return "the trip is the gravest cause that stands";
        if (update.result.latched != (latched_ && gravest == GuardTrip::none)) return "says if it is latched";
        if (gravest != GuardTrip::none || latched_) {
            if (!is_zero(sent)) return "a trip gives zero in the same update";
            ramp_time_ = 0;
            return nullptr;
        }
        const long double length = distance(sent, glm::dvec3{0.0}), most = wide(limits_.max_force);
        if (length > most * (1 + 1e-12L)) return "never longer than max_force";

        long double step = 0;
        if (!good_.empty() && update.sample.time > good_.back().time)
            step = wide(update.sample.time) - wide(good_.back().time);
        const long double allowed = 1000 * wide(limits_.max_slew) * step;
        const long double changed = distance(sent, sent_);
        if (changed > allowed * (1 + 1e-9L) + 1e-12L * most) return "no faster than max_slew";

        ramp_time_ += step;
        const long double ramp = wide(limits_.ramp);
        const long double gain = ramp_time_ < ramp ? ramp_time_ / ramp : 1.0L;
        if (length > gain * most * (1 + 1e-9L) + 1e-12L) return "below the ramp";

        // What is sent is on the way from the last force to the one asked for, and there if the slew allows it.
        const long double asked = distance(update.asked, glm::dvec3{0.0});
        const long double cut = asked > most ? most / asked : 1.0L;
        const long double scale = gain * cut;
        const glm::dvec3 target = update.asked * static_cast<double>(scale);
        const long double whole = distance(target, sent_);
        const long double left = whole > allowed ? whole - allowed : 0.0L;
        const long double error = distance(target, sent) - left;
        if (error > 1e-9L * most || error < -1e-9L * most) return "goes straight to the force asked for";
        return nullptr;
    }

    [[nodiscard]] unsigned find_causes(const GuardUpdate& update) const {
        const auto bit = [](GuardTrip trip) { return 1u << static_cast<unsigned>(trip); };
        unsigned causes = 0;
        if (!is_number(update.asked)) causes |= bit(GuardTrip::bad_force);
        if (update.buried) causes |= bit(GuardTrip::buried);
        if (update.sample.force_refused) causes |= bit(GuardTrip::device_fault);
        const DeviceSample& now = update.sample;
        if (!is_number(now.time) || !is_number(now.position)) return causes | bit(GuardTrip::bad_sample);
        if (good_.empty()) return causes;
        const DeviceSample& last = good_.back();
        if (now.time < last.time || now.time - last.time > limits_.max_gap) causes |= bit(GuardTrip::stale);

        // Backwards through the history: how often time stood still, since when the place is the same.
        int repeats = now.time > last.time ? 0 : 1;
        for (std::size_t k = good_.size(); repeats > 0 && k-- > 1 && !(good_[k].time > good_[k - 1].time);)
            ++repeats;
        double since = now.time;
        double later = now.time;
        for (std::size_t k = good_.size(); k-- > 0;) {
            if (good_[k].position != now.position || good_[k].time > later) break;
            since = later = good_[k].time;
        }
        const bool still = limits_.max_still > 0 && now.time - since > limits_.max_still;
        if (repeats > limits_.max_repeats || still) causes |= bit(GuardTrip::repeated);

        const long double step = now.time > last.time ? wide(now.time) - wide(last.time) : 0.0L;
        const long double moved = distance(now.position, last.position);
        if (moved > 1e-150L &&
            moved > wide(limits_.max_step) + wide(limits_.max_speed) * step) // its square may underflow
            causes |= bit(GuardTrip::jump);
        return causes;
    }

    GuardLimits limits_;
    std::vector<DeviceSample> good_{};
    glm::dvec3 sent_{0.0};
    long double ramp_time_ = 0;
    unsigned trips_[guard_trip_count]{};
    unsigned last_causes_ = 0;
    bool latched_ = false;
};

/// A number that is none, or nearly none.
[[nodiscard]] inline double nasty(Random& random) {
    switch (random.whole(0, 7)) {
    case 0: return make_nan();
    case 1: return make_signalling_nan();
    case 2: return make_infinity();
    case 3: return -make_infinity();
    case 4: return make_largest();
    case 5: return make_denormal();
    case 6: return 0x1p64;
    default: return -0.0;
    }
}

/// Samples and forces of a hand and a scene that go wrong in every way, now and then or all the time.
class NastyStream {
public:
    NastyStream(std::uint64_t seed, int calm) : random_{seed}, calm_{calm} {}

    [[nodiscard]] GuardUpdate next() {
        GuardUpdate update;
        time_ += 0.001 * random_.between(0.5, 1.5);
        if (random_.one_in(calm_)) time_ += random_.between(-0.02, 0.02);
        if (!random_.one_in(4)) // now and then the hand is still
            hand_ +=
                1e-3 * glm::dvec3{random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1)};
        if (random_.one_in(calm_)) hand_ += glm::dvec3{random_.between(-0.1, 0.1), 0, 0};
        if (random_.one_in(calm_)) repeat_ = static_cast<int>(random_.whole(1, 8));
        if (repeat_ > 0 && --repeat_ >= 0)
            update.sample = last_;
        else
            update.sample = {.time = time_, .position = hand_};
        last_ = update.sample;
        update.asked = {random_.between(-6, 6), random_.between(-6, 6), random_.between(-6, 6)};
        if (random_.one_in(calm_)) update.asked[static_cast<int>(random_.whole(0, 2))] = nasty(random_);
        if (random_.one_in(calm_))
            update.sample.position[static_cast<int>(random_.whole(0, 2))] = nasty(random_);
        if (random_.one_in(4 * calm_)) update.sample.time = nasty(random_);
        if (is_number(update.sample.time) && update.sample.time > 1e6) update.sample.time = time_;
        update.buried = random_.one_in(2 * calm_);
        update.sample.force_refused = random_.one_in(2 * calm_);
        update.rearmed = random_.one_in(calm_);
        return update;
    }

private:
    Random random_;
    int calm_, repeat_ = 0;
    double time_ = 10;
    glm::dvec3 hand_{0.0};
    DeviceSample last_{};
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP
