#ifndef HFH_TESTS_SUPPORT_BALL_STROKES_HPP
#define HFH_TESTS_SUPPORT_BALL_STROKES_HPP

#include "hard_ground.hpp"
#include "real_terrains.hpp"
#include "scenes.hpp"
#include "slow_ball.hpp"

#include <sstream>

// Strokes of a ball over a terrain, each update judged, with what is needed to replay the first faults.

namespace hfh::test {

/// "hard KIND SEED": a piece of hard ground. KIND below `HardGround::no_data`, whose heights are too far apart to be judged.
template <Real T>
[[nodiscard]] Terrain<T> numbered_ground(int kind, std::uint64_t seed) {
    Random random{seed};
    return hard_ground<T>(static_cast<HardGround>(kind), random);
}

/// The terrain of that name: real, a scene, or hard ground. Empty if there is none.
template <Real T>
[[nodiscard]] std::optional<Terrain<T>> named_terrain(const std::string& name) {
    std::istringstream words{name};
    std::string first;
    words >> first;
    if (first == "hard") {
        int kind = 0;
        std::uint64_t seed = 0;
        words >> kind >> seed;
        return numbered_ground<T>(kind, seed);
    }
    for (const auto& scene : scenes<T>()) {
        if (scene.name == name) return scene.terrain;
    }
    return real_terrain<T>(name);
}

/// A ball on its way: where and how it is led.
template <Real T>
struct BallStroke {
    std::string terrain;
    T radius{};
    SurfaceKind kind = SurfaceKind::solid;
    std::vector<vec3<T>> way; ///< the styluses so far

    /// As one line, to be read again by `read`.
    [[nodiscard]] std::string line() const {
        std::string text = std::string{sizeof(T) == 4 ? "float" : "double"} + '\t' + terrain + '\t' +
                           (kind == SurfaceKind::solid ? "solid" : "sheet") + '\t' + digits(radius);
        for (const auto& p : way) text += '\t' + digits(p);
        return text;
    }
    [[nodiscard]] static BallStroke read(const std::string& line) {
        BallStroke stroke;
        std::istringstream parts{line};
        std::string part;
        std::getline(parts, part, '\t'); // the scalar
        std::getline(parts, stroke.terrain, '\t');
        std::getline(parts, part, '\t');
        stroke.kind = part == "sheet" ? SurfaceKind::sheet : SurfaceKind::solid;
        std::getline(parts, part, '\t');
        stroke.radius = static_cast<T>(std::stod(part));
        while (std::getline(parts, part, '\t')) {
            std::istringstream numbers{part};
            glm::dvec3 p{0.0};
            numbers >> p.x >> p.y >> p.z;
            stroke.way.emplace_back(p);
        }
        return stroke;
    }
};

/// Follows a ball and judges it. `Tracker` has update(stylus).
template <Real T, class Tracker>
class FollowedBall {
public:
    FollowedBall(const Terrain<T>& terrain, BallStroke<T> stroke, Tracker& tracker)
        : judge_{terrain}, stroke_{std::move(stroke)}, tracker_{&tracker} {}

    /// Which of the costly questions are asked of the next update.
    struct Questions {
        bool flow = false;  ///< the same minimum as the gradient flow
        bool sweep = false; ///< free before: whether there is something on the way
    };
    struct Answer {
        BallContact<T> found{};
        BallVerdict verdict{};
        bool flowed = false, other_minimum = false;
        std::string
            replay{}; ///< where something is wrong: all updates since the ball was free, and what was found
    };

    Answer update(const vec3<T>& stylus, Questions questions) {
        stroke_.way.push_back(stylus);
        Answer answer;
        answer.found = tracker_->update(stylus);
        const BallUpdate<T> now{
            last_centre_, last_status_, stylus, answer.found, static_cast<Wide>(stroke_.radius),
            stroke_.kind};
        answer.verdict = judge_(now);
        if (answer.verdict.fault.empty() && questions.sweep) judge_sweep(now, answer);
        if (answer.verdict.fault.empty() && questions.flow) judge_flow(now, answer);
        if (!answer.verdict.fault.empty() || answer.other_minimum) answer.replay = replay(now, answer);
        if (answer.found.status != ContactStatus::bad_input) {
            last_centre_ = centre_of(stylus, answer.found);
            if (answer.found.status == ContactStatus::sweep_limit) last_centre_.reset(); // it is on the way
            last_status_ = answer.found.status;
        }
        // A replay may begin where the ball was free.
        if (answer.found.status == ContactStatus::free) stroke_.way.assign(1, stylus);
        return answer;
    }

    /// The ground or the radius has changed: what was before says nothing about what comes.
    void forget(T radius) {
        stroke_.radius = radius;
        last_centre_.reset();
    }

    [[nodiscard]] const BallJudge<T>& judge() const { return judge_; }

private:
    void judge_sweep(const BallUpdate<T>& now, Answer& answer) const {
        if (!now.last_centre || now.last_status != ContactStatus::free) return;
        const Point to = wide(now.stylus);
        // Where T rounds away the clearance, either is right.
        const Wide slack =
            BallPromise<T>::penetration * now.radius +
            BallPromise<T>::roundings(std::max(largest_coordinate(to), largest_coordinate(*now.last_centre)));
        const auto verdict = [&](Wide radius) {
            return judge_first_touch(judge_.ground(), *now.last_centre, to, radius, {}, 1500);
        };
        if (answer.found.status == ContactStatus::free) {
            if (verdict(now.radius - slack) == SweepVerdict::nearer_before && is_held_on_way(now, to))
                answer.verdict.fault = "went through the surface: 1";
        } else if (answer.found.touching() && verdict(now.radius + slack) == SweepVerdict::right) {
            answer.verdict.fault = "a contact with nothing on the way: 1";
        }
    }
    /// Whether what is on the way of a ball holds it, so that it cannot slide around. A sheet's ball may have got round a rim, where
    /// one is in reach; a solid that is met from over a hole or from beside it may hold nothing; and a flow that ends on a crest says nothing.
    [[nodiscard]] bool is_held_on_way(const BallUpdate<T>& now, const Point& to) const {
        if (now.kind == SurfaceKind::sheet && judge_.may_have_left(now)) return false;
        constexpr int parts = 256;
        for (int k = 0; k <= parts; ++k) {
            const Point at = *now.last_centre + static_cast<Wide>(k) / parts * (to - *now.last_centre);
            if (!judge_.ground().surface().height(at.x, at.y)) return false;
        }
        const Flow flow = flow_of_ball(judge_.ground(), *now.last_centre, to, now.radius, now.kind, 5000);
        return flow.end == FlowEnd::minimum &&
               !(judge_.gain_nearby(flow.centre, to, now.radius, 1e-6L, 1e-3L * now.radius) > 0);
    }
    void judge_flow(const BallUpdate<T>& now, Answer& answer) const {
        const bool was_led = now.last_centre && (now.last_status == ContactStatus::free ||
                                                 now.last_status == ContactStatus::contact);
        const bool ended =
            now.found.status == ContactStatus::free || now.found.status == ContactStatus::contact;
        if (!was_led || !ended) return;
        const auto start = judge_.ground().pushed_clear(*now.last_centre, now.radius);
        if (!start) return;
        const Point stylus = wide(now.stylus), centre = centre_of(now.stylus, now.found);
        const auto differs = [&](int max_steps, int steps_per_radius) {
            const Flow flow = flow_of_ball(judge_.ground(), *start, stylus, now.radius, now.kind, max_steps,
                                           steps_per_radius);
            if (flow.end != FlowEnd::arrived && flow.end != FlowEnd::minimum) return false;
            answer.flowed = true;
            flow_end_ = flow.centre;
            return !in_one_basin(judge_.ground(), flow.centre, centre, stylus, now.radius);
        };
        // Where ways part, shorter steps tell which the flow takes.
        answer.other_minimum = differs(3000, 50) && differs(20000, 400);
    }
    [[nodiscard]] static std::string point(const Point& p) {
        return digits(
            vec3<double>{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
    }
    [[nodiscard]] std::string replay(const BallUpdate<T>& now, const Answer& answer) const {
        std::string text = answer.other_minimum ? "other minimum" : answer.verdict.fault;
        text += "\n    last centre " + (now.last_centre ? point(*now.last_centre) : std::string{"none"}) +
                " (" + to_string(now.last_status) + ")";
        text += "\n    stylus " + digits(now.stylus) + "\n    found " + to_string(now.found.status) +
                ", centre " + point(centre_of(now.stylus, now.found));
        if (answer.other_minimum) text += "\n    flow ends at " + point(flow_end_);
        for (int n = 0; n < now.found.count; ++n) {
            const auto& touch = now.found.touches[n];
            text += "\n    touch " + std::to_string(touch.point.cell.i) + ' ' +
                    std::to_string(touch.point.cell.j) + ' ' + digits(touch.point.u) + ' ' +
                    digits(touch.point.v) + " normal " + digits(touch.normal) + " share " +
                    digits(touch.share);
        }
        if (now.found.touching()) {
            const Point centre = centre_of(now.stylus, now.found);
            for (const BallFoot& foot : judge_.ground().feet(centre, 1.001L * now.radius)) {
                const Point n = foot.normal();
                text += "\n    near  " + std::to_string(foot.at.i) + ' ' + std::to_string(foot.at.j) + ' ' +
                        digits(static_cast<double>(foot.at.u)) + ' ' +
                        digits(static_cast<double>(foot.at.v)) + " normal " + point(n) + " gap/r " +
                        digits(static_cast<double>(foot.distance / now.radius - 1));
            }
        }
        return text + "\n    replay " + stroke_.line();
    }

    BallJudge<T> judge_;
    BallStroke<T> stroke_;
    Tracker* tracker_;
    std::optional<Point> last_centre_;
    ContactStatus last_status_ = ContactStatus::free;
    mutable Point flow_end_;
};

/// A hand that ploughs: up to `step` cells an update, `deep` cells below the ground, and out now and then. A steady one goes up
/// and down slowly, another one as it likes. Stays a hundredth of a cell from the rim.
template <Real T>
class BallHand {
public:
    BallHand(const Terrain<T>& terrain, double radius, double step, double deep, bool steady,
             std::uint64_t seed)
        : terrain_{&terrain}, surface_{terrain}, random_{seed}, radius_{radius}, step_{step}, deep_{deep},
          steady_{steady} {
        at_ = {random_.between(0.01, columns() - 0.01), random_.between(0.01, rows() - 0.01)};
        for (const T height : terrain.heights) {
            if (holds_number(height) && std::abs(height) < no_height_from<T>)
                top_ = std::max(top_, static_cast<double>(height));
        }
        heading_ = random_.between(0, 6.283185307);
    }

    [[nodiscard]] vec3<T> next() {
        heading_ += random_.between(-0.3, 0.3);
        const glm::dvec2 to =
            at_ + step_ * random_.unit() * glm::dvec2{std::cos(heading_), std::sin(heading_)};
        if (to.x < 0 || to.x > columns()) heading_ = 3.14159265358979 - heading_;
        if (to.y < 0 || to.y > rows()) heading_ = -heading_;
        at_ = glm::clamp(to, glm::dvec2{0.01}, glm::dvec2{columns(), rows()} - 0.01);
        const auto& f = terrain_->frame;
        const glm::dvec2 world = f.origin + at_ * f.spacing;
        if (const auto z = surface_.height(static_cast<Wide>(world.x), static_cast<Wide>(world.y)))
            ground_ = static_cast<double>(*z);
        // Above all at first and sometimes; else below, and now and then out or near the surface.
        const double cell = std::min(f.spacing.x, f.spacing.y);
        const double share =
            steady_ ? 0.75 + 0.25 * std::sin(0.1 * static_cast<double>(updates_)) : random_.between(0.5, 1);
        double z = ground_ - deep_ * cell * share;
        if (updates_ % 100 == 0)
            z = top_ + radius_ * 1.01 + cell;
        else if (!steady_ && random_.one_in(10))
            z = ground_ + radius_ * random_.between(0, 2);
        ++updates_;
        return vec3<T>{glm::dvec3{world, z}};
    }

private:
    [[nodiscard]] double columns() const { return static_cast<double>(terrain_->columns - 1); }
    [[nodiscard]] double rows() const { return static_cast<double>(terrain_->rows - 1); }

    const Terrain<T>* terrain_;
    Surface<T> surface_;
    Random random_;
    double radius_, step_, deep_;
    bool steady_;
    glm::dvec2 at_{0.0};
    double heading_ = 0, ground_ = 0, top_ = std::numeric_limits<double>::lowest();
    long updates_ = 0;
};

/// What came out of many strokes.
struct BallTally {
    long updates = 0, contacts = 0, faults = 0, flows = 0, narrow = 0, other_minima = 0;
    Wide penetration = 0, residual = 0;
    int examples_of_a_kind = 2;
    std::map<std::string, int> kinds{};  ///< of faults, and how many of each
    std::vector<std::string> examples{}; ///< the first few of each kind
};

/// Strokes on one terrain with balls of 0.1 to 5 cells: at most 100 updates each, 0.1 to 100 cells an update, 0.1 to 10 cells deep.
/// One update in `flow_every` of those up to half a cell is compared with the gradient flow.
///
/// `make(terrain, grid, radius, kind)` is a tracker.
template <Real T, class Make>
void follow_strokes(const std::string& name, const Terrain<T>& terrain, long updates, std::int64_t flow_every,
                    std::uint64_t seed, const Make& make, BallTally& tally) {
    constexpr std::array<double, 5> radii{0.1, 0.5, 1, 2, 5};
    Random random{seed};
    const auto grid = terrain.grid();
    const double cell = std::min(terrain.frame.spacing.x, terrain.frame.spacing.y);
    for (long done = 0; done < updates;) {
        BallStroke<T> stroke;
        stroke.terrain = name;
        stroke.radius = static_cast<T>(cell * radii[static_cast<std::size_t>(random.whole(0, 4))]);
        stroke.kind = random.one_in(5) ? SurfaceKind::sheet : SurfaceKind::solid;
        const bool small = random.one_in(2);
        const double step = log_between(random, 0.1, small ? 0.5 : 100), deep = log_between(random, 0.1, 10);
        BallHand<T> hand{terrain, static_cast<double>(stroke.radius),
                         step,    deep,
                         small,   static_cast<std::uint64_t>(random.whole(1, 1000000000))};
        auto tracker = make(terrain, grid, stroke.radius, stroke.kind);
        FollowedBall<T, decltype(tracker)> ball{terrain, stroke, tracker};
        vec3<T> before{std::numeric_limits<T>::max() / 4};
        for (int n = 0; n < 100 && done < updates; ++n, ++done) {
            const vec3<T> stylus = hand.next();
            const bool near = length(wide(stylus) - wide(before)) <= static_cast<Wide>(cell / 2);
            before = stylus;
            const auto answer =
                ball.update(stylus, {.flow = near && random.one_in(flow_every), .sweep = random.one_in(8)});
            ++tally.updates;
            tally.contacts += answer.found.touching();
            tally.narrow += answer.verdict.narrow;
            tally.flows += answer.flowed;
            tally.other_minima += answer.other_minimum;
            tally.penetration = std::max(tally.penetration, answer.verdict.penetration);
            tally.residual = std::max(tally.residual, answer.verdict.residual);
            if (answer.replay.empty()) continue;
            tally.faults += !answer.other_minimum;
            const std::string kind = answer.other_minimum
                                         ? "other minimum"
                                         : answer.verdict.fault.substr(0, answer.verdict.fault.find(':'));
            if (++tally.kinds[kind] <= tally.examples_of_a_kind) tally.examples.push_back(answer.replay);
            // What comes after a fault may come of it.
            if (!answer.other_minimum) break;
        }
    }
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_BALL_STROKES_HPP
