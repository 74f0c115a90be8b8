#ifndef HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP
#define HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP

#include "guards.hpp"
#include "random.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

// What a guard may do, judged from outside from all that went in and came out, and inputs that try it. Shares nothing
// with the guard but its types: everything is worked out in long double from histories, and whether a number is one from its
// bits, so that the judge holds under -ffast-math as well.

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

/// The first rule that an update breaks, or nullptr. Keeps in long double what the rules are about: the history of good
/// samples since the start or the last release, and of forces.
class GuardJudge {
public:
    explicit GuardJudge(const GuardLimits& limits) : limits_{limits} {}

    [[nodiscard]] const char* operator()(const GuardUpdate& update) {
        const DeviceSample& now = update.sample;
        const bool good = is_number(now.time) && is_number(now.position);
        const long double before = latest_;
        if (good && now.has_sent) told(now);
        const unsigned causes = find_causes(update);
        if (update.rearmed) latched_ = false;
        if (causes != 0 && limits_.latch) latched_ = true;
        for (int k = 1; k < guard_trip_count; ++k)
            if ((causes >> k & 1u) != 0 && (last_causes_ >> k & 1u) == 0) ++trips_[k];
        last_causes_ = causes;

        GuardTrip gravest = GuardTrip::none;
        for (int k = 1; k < guard_trip_count && gravest == GuardTrip::none; ++k)
            if ((causes >> k & 1u) != 0) gravest = static_cast<GuardTrip>(k);

        const char* broken = judge(update, gravest, good_.size() > 1 ? before : latest_);
        sent_ = update.result.newtons;
        // A told time that is later than this one is out of order; if it is too late for that, it was for this update only.
        if (good && (sent_at_ < latest_ || sent_at_ > latest_ + wide(limits_.max_gap))) sent_at_ = latest_;
        if (!good) sent_at_ = 0x1p64L; // zero, until a time that nothing tells
        const bool released = now.release && distance(sent_, glm::dvec3{0.0}) == 0; // -0 is zero as well
        if (update.result.released != released) broken = "says if it is released";
        if (released) {
            good_.clear();
            repeats_ = 0;
            start_ramp();
        }
        return broken;
    }

    [[nodiscard]] unsigned trips(GuardTrip trip) const { return trips_[static_cast<int>(trip)]; }

private:
    /// `before`: the latest time before this update.
    const char* judge(const GuardUpdate& update, GuardTrip gravest, long double before) {
        const glm::dvec3& sent = update.result.newtons;
        if (!is_number(sent)) return "the force is a number";
        if (update.result.trip != gravest) return "the trip is the gravest cause that stands";
        if (update.result.latched != (latched_ && gravest == GuardTrip::none)) return "says if it is latched";
        if (gravest != GuardTrip::none || latched_) {
            if (!is_zero(sent)) return "a trip gives zero in the same update";
            start_ramp();
            return nullptr;
        }
        const long double length = distance(sent, glm::dvec3{0.0}), most = wide(limits_.max_force);
        if (length > most * (1 + fine)) return "never longer than max_force";

        // The motors have had the last force since it was sent, or since the update before if that is later.
        const long double passed = latest_ > before ? latest_ - before : 0.0L;
        const long double since = sent_at_ > before ? sent_at_ : before;
        const long double held = latest_ > since ? latest_ - since : 0.0L;
        const long double allowed = 1000 * wide(limits_.max_slew) * held;
        const long double changed = distance(sent, sent_);
        if (changed > allowed * (1 + coarse) + fine * most) return "no faster than max_slew";

        const long double ramp = wide(limits_.ramp), part = passed < ramp ? passed / ramp : 1.0L;
        gain_ += update.sample.release ? -part : part;
        gain_ = gain_ < 0 ? 0.0L : gain_ > 1 ? 1.0L : gain_;
        const long double ramped = gain_ * most, had = distance(sent_, glm::dvec3{0.0});
        if (length > std::max(ramped, had) * (1 + coarse) + fine) return "below the ramp, or falling to it";

        const long double asked = distance(update.asked, glm::dvec3{0.0});
        const long double wanted = asked > most ? most : asked;
        const long double kept = held_back(update.asked, asked, wanted, part);

        // What is sent is on the way from the last force to the one asked for, and there if the slew allows it.
        const long double scale = asked > 0 ? gain_ * (wanted - kept) / asked : 0.0L;
        const glm::dvec3 target = update.asked * static_cast<double>(scale);
        const long double whole = distance(target, sent_);
        const long double left = whole > allowed ? whole - allowed : 0.0L;
        const long double error = distance(target, sent) - left;
        if (error > coarse * most || error < -coarse * most) return "goes straight to the force asked for";
        return nullptr;
    }

    /// N that are kept back of the `wanted` ones: what the hand did not make is owed, and paid at the ramp's pace, `part` of
    /// which has passed.
    [[nodiscard]] long double held_back(const glm::dvec3& force, long double length, long double wanted,
                                        long double part) {
        const long double most = wide(limits_.max_force);
        if (asked_ < 0 || wide(limits_.ramp) == 0) {
            owed_ = spare_ = 0;
        } else {
            owed_ = owed_ > part * most ? owed_ - part * most : 0.0L;
            const bool rested = latest_ - changed_at_ >= wide(limits_.max_gap);
            const long double along = rested ? along_last(force, length) : asked_;
            const long double from = asked_ - along > wide(limits_.max_sudden) ? along : asked_;
            const long double rise = wanted - from, made = wide(limits_.stiffness) * moved_;
            if (rise > made + spare_) owed_ += rise - made - spare_;
            if (rise < 0) owed_ += rise;
            if (owed_ > wanted) owed_ = wanted;
            if (owed_ < 0) owed_ = 0;
            spare_ = rise <= 0 ? made : rise < made ? made - rise : 0.0L;
        }
        asked_ = wanted;
        last_ = force;
        const long double sudden = wide(limits_.max_sudden);
        return owed_ > sudden ? owed_ - sudden : 0.0L;
    }

    /// N that the force before had in the direction of this one.
    [[nodiscard]] long double along_last(const glm::dvec3& force, long double length) const {
        const long double last = distance(last_, glm::dvec3{0.0});
        if (!(length > 0) || !(last > 0)) return asked_;
        long double cosine = 0;
        for (int k = 0; k < 3; ++k) cosine += wide(force[k]) / length * (wide(last_[k]) / last);
        return cosine > 0 ? cosine * asked_ : 0.0L;
    }

    /// s by which two stamps may seem farther apart than they are.
    [[nodiscard]] static long double rounding_of([[maybe_unused]] long double one,
                                                 [[maybe_unused]] long double other,
                                                 [[maybe_unused]] long double gap) {
        if constexpr (sizeof(GuardScalar) == sizeof(double))
            return 0x1p-52L * (std::abs(one) + std::abs(other));
        else
            return 1e-9L + 3 * 0x1p-23L * gap;
    }

    void start_ramp() {
        gain_ = 0;
        asked_ = -1;
    }

    void told(const DeviceSample& now) {
        sent_ = is_number(now.sent) ? now.sent : glm::dvec3{0.0};
        const long double length = distance(sent_, glm::dvec3{0.0}), most = wide(limits_.max_force);
        if (length > most) sent_ *= static_cast<double>(most / length);
        sent_at_ = is_number(now.sent_at) ? std::max(sent_at_, wide(now.sent_at)) : 0x1p64L;
    }

    [[nodiscard]] unsigned find_causes(const GuardUpdate& update) {
        const auto bit = [](GuardTrip trip) { return 1u << static_cast<unsigned>(trip); };
        unsigned causes = 0;
        if (!is_number(update.asked)) causes |= bit(GuardTrip::bad_force);
        if (update.buried) causes |= bit(GuardTrip::buried);
        if (update.sample.force_refused) causes |= bit(GuardTrip::device_fault);
        const DeviceSample& now = update.sample;
        if (!is_number(now.time) || !is_number(now.position)) return causes | bit(GuardTrip::bad_sample);
        moved_ = 0;
        if (good_.empty()) {
            good_.push_back(now);
            scatter_ = reserve_ = wide(limits_.max_gap);
            mean_ = limits_.period > 0 ? std::min(wide(limits_.period), scatter_) : scatter_;
            waited_ = false;
            latest_ = changed_at_ = wide(now.time);
            return causes;
        }
        const DeviceSample last = good_.back();
        good_.push_back(now);
        const long double time = wide(now.time), most = wide(limits_.max_gap), passed = time - latest_;
        const long double rounding = rounding_of(time, latest_, most);
        const bool back = passed < -most - rounding, stale = back || passed > most + rounding;
        if (stale) causes |= bit(GuardTrip::stale);
        repeats_ = passed > 0 || stale ? 0 : repeats_ + 1;
        if (passed > 0 || stale) latest_ = time;
        if (back) changed_at_ = time;

        reserve_ += passed > 0 ? passed : 0.0L;
        if (reserve_ > most) reserve_ = most;
        const long double fades = 6 * most, gone = passed > 0 ? passed : 0.0L;
        scatter_ = gone < fades ? scatter_ * (fades - gone) / fades : 0.0L;
        moved_ = distance(now.position, last.position);
        if (now.position != last.position && jumped(stale, gone)) causes |= bit(GuardTrip::jump);
        waited_ = now.position == last.position;
        const bool still = limits_.max_still > 0 && latest_ - changed_at_ > wide(limits_.max_still);
        if (repeats_ > limits_.max_repeats || still) causes |= bit(GuardTrip::repeated);
        return causes;
    }

    /// The place has changed by moved_: whether that is a jump. Learns the interval in which places change.
    [[nodiscard]] bool jumped(bool stale, long double passed) {
        const long double most = wide(limits_.max_gap), unchanged = latest_ - changed_at_;
        const bool rested = waited_ && unchanged > most;
        const long double since = std::min(rested ? passed : unchanged, most);
        const long double seconds = std::min(std::max(since, mean_) + scatter_, reserve_);
        const bool jump = moved_ > 1e-150L && // its square may underflow
                          moved_ > wide(limits_.max_step) + wide(limits_.max_speed) * seconds;
        const bool slow = waited_ && (rested || moved_ <= wide(limits_.max_step));
        if (!jump && !stale && !slow) {
            const long double off = since > mean_ ? since - mean_ : mean_ - since;
            if (2 * off > scatter_) scatter_ = 2 * off;
            mean_ = (15 * mean_ + since) / 16;
        }
        const long double took = moved_ / wide(limits_.max_speed);
        reserve_ = took < reserve_ ? reserve_ - took : 0.0L;
        changed_at_ = latest_;
        return jump;
    }

    // Of the roundings in one update, and of those that add up while a force comes up by the ramp: in float half a rounding in
    // each of up to 500 updates.
    static constexpr long double fine = wide(guard_rounding(1e-12, 8)),
                                 coarse = wide(guard_rounding(1e-9, 250));

    GuardLimits limits_;
    std::vector<DeviceSample> good_{};
    long double mean_ = 0, scatter_ = 0; ///< s, of the intervals in which the place changes
    long double reserve_ = 0;            ///< s that moves may still take at max_speed
    bool waited_ = false;                ///< the place was the same in the last sample
    long double latest_ = 0, changed_at_ = 0, moved_ = 0;
    glm::dvec3 sent_{0.0}; ///< N, at the motors
    glm::dvec3 last_{0.0}; ///< N, asked for last
    long double sent_at_ = 0;
    long double gain_ = 0, asked_ = -1, owed_ = 0, spare_ = 0; ///< asked_ < 0: nothing was asked for before
    int repeats_ = 0;
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
        if (random_.one_in(calm_)) time_ += random_.between(-0.06, 0.06);
        if (random_.one_in(300)) still_ = static_cast<int>(random_.whole(10, 80));
        const bool still = still_ > 0;
        if (still) --still_;
        if (!still && !random_.one_in(4)) // now and then the hand is still
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
        // Where denormals are flushed to zero a guard sees no time between them and zero; the judge's long double does.
        if (std::bit_cast<std::uint64_t>(update.sample.time) == std::bit_cast<std::uint64_t>(make_denormal()))
            update.sample.time = 0;
        update.buried = random_.one_in(2 * calm_);
        update.sample.force_refused = random_.one_in(2 * calm_);
        update.rearmed = random_.one_in(calm_);
        // The driver tells what it sent: as it was told, or shorter, or none at all in an update of its own.
        if (random_.one_in(3 * calm_)) release_ = !release_;
        update.sample.release = release_;
        update.sample.has_sent = random_.one_in(2);
        if (update.sample.has_sent) {
            update.sample.sent = {random_.between(-3, 3), random_.between(-3, 3), random_.between(-3, 3)};
            update.sample.sent_at = time_ - 0.001 * random_.between(-0.5, 3);
            if (random_.one_in(calm_)) update.sample.sent[1] = nasty(random_);
            if (random_.one_in(calm_)) update.sample.sent_at = nasty(random_);
        }
        return update;
    }

private:
    Random random_;
    int calm_, repeat_ = 0, still_ = 0;
    bool release_ = false;
    double time_ = 10;
    glm::dvec3 hand_{0.0};
    DeviceSample last_{};
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_GUARD_ORACLE_HPP
