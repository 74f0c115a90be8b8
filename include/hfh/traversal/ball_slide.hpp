#ifndef HFH_TRAVERSAL_BALL_SLIDE_HPP
#define HFH_TRAVERSAL_BALL_SLIDE_HPP

#include <hfh/traversal/ball_obstacles.hpp>
#include <hfh/traversal/ball_sweep.hpp>
#include <hfh/traversal/surface_at.hpp>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include <cmath>
#include <limits>

// A ball slides over the surface to where its centre is nearest to a target, step by step.
//
//     minimise ½ |c − target|²  subject to  |c − q| ≥ r for all obstacles q
//
// A step of first order goes to the nearest point of the polyhedron that the obstacles leave. One of second order takes into
// account how their normals turn: H = I − Σ share·∇²|c − q| in place of I. Without that the centre would go to and fro where the
// ground is bent. After a step the ball is pushed clear, and the step counts only if the centre is nearer then.
//
// Based on: Ruspini, Kolarov and Khatib, The Haptic Display of Complex Graphical Environments (1997), for the polyhedron;
// Nocedal and Wright, Numerical Optimization (2006), ch. 18, for steps of second order.

namespace hfh::detail {

/// How a slide ended.
enum class BallSlideEnd : unsigned char {
    minimum,   ///< no step leads nearer to the target, and the ball touches
    at_target, ///< the centre is at the target
    off_rim,   ///< the ball has got round a rim of a solid and would be below it
    step_limit ///< of steps, or of patches and blocks
};

/// What a slide is about.
struct BallOnSurface {
    double radius;       ///< metres
    SurfaceKind surface; ///< a solid ends contact where the ball has got round a rim
    Side side;           ///< the side of the surface that the ball is on; none: beside it
    double stride = std::numeric_limits<double>::max(); ///< how far it goes in a step at most, in metres
};

/// A ball on its way, and what is around it. `run` goes on from where the last one ended.
template <HeightField Field>
class BallSlide {
public:
    /// At most so many patches and blocks are looked at.
    BallSlide(const Field& field, const BallOnSurface& ball, const glm::dvec3& centre,
              Index max_work) noexcept
        : field_{&field}, ball_{ball}, centre_{centre}, work_{max_work}, looks_{BallObstacles<Field>{field},
                                                                                BallObstacles<Field>{field}} {
    }

    [[nodiscard]] const glm::dvec3& centre() const noexcept { return centre_; }
    [[nodiscard]] Side side() const noexcept { return ball_.side; }
    [[nodiscard]] Index work_left() const noexcept { return work_; }
    [[nodiscard]] const BallObstacles<Field>& around() const noexcept { return looks_[now_]; }
    /// What holds the ball: which obstacles of `around`, and how the way to the target is shared among their normals.
    [[nodiscard]] const PolyhedronPoint& held() const noexcept { return move_.held; }
    /// It has touched something on its way.
    [[nodiscard]] bool touched() const noexcept { return touched_; }

    /// Looks around, so far that the ball may go `margin` metres before the next look. False if that is too much work.
    [[nodiscard]] bool look(double margin) noexcept {
        return looks_[now_].look(centre_, ball_.radius, margin, work_);
    }
    /// A solid: nothing holds the ball but rims and what is over it.
    [[nodiscard]] bool is_on_rims_alone() const noexcept;
    /// Whether the surface was raised under the ball, so that they overlap.
    [[nodiscard]] bool overlaps() const noexcept {
        return is_on_wrong_side(centre_) ||
               around().smallest_gap() < -5e-10 * ball_.radius - 4 * rounding_at(centre_);
    }
    /// Lifts the ball (felt from below: lowers it) until it is clear. False where it cannot, or that is too much work.
    [[nodiscard]] bool lift() noexcept;

    /// Slides to the minimum, after a look. `touched`: it goes on in contact; else it goes straight for the target until it
    /// touches. With friction it stops where the part of target − centre across what holds the ball is no more than `friction` times
    /// the part against it.
    [[nodiscard]] BallSlideEnd run(const glm::dvec3& target, bool touched, int max_steps,
                                   double friction = 0) noexcept;

    /// Slides so many metres towards the target and no farther. False where that ends before, or is not possible.
    [[nodiscard]] bool glide(const glm::dvec3& target, double length) noexcept;

private:
    /// Where the centre is to go from where it is: steps, in metres.
    struct Move {
        glm::dvec3 second{0.0}; ///< of second order
        glm::dvec3 first{0.0};  ///< of first order: keeps all half-spaces
        PolyhedronPoint held{}; ///< what holds the ball, if it touches
        double wanted = 0;      ///< how far the step would go if nothing else were in the way, in metres
        bool touches = false;
        /// Where the distance is highest here: directions, across each other, along which it falls to both sides.
        glm::dvec3 crests[2]{glm::dvec3{0.0}, glm::dvec3{0.0}};
        int crest_count = 0;
        bool arrived = false; ///< touches, and the step is below what can be resolved
    };
    /// How a try to make a move ended.
    enum class MoveEnd : unsigned char {
        moved,
        no_nearer, ///< no part of the step leads nearer
        off_rim,
        work_limit
    };

    // What the distance is bent by along a step, of what it is in free space.
    static constexpr double flattest = 1e-6; ///< below it there is no step to a minimum
    static constexpr double crest = -1e-6;   ///< below it the distance is highest

    [[nodiscard]] double widest() const noexcept {
        return glm::min(widest_margin(*field_, ball_.radius), ball_.stride);
    }
    /// What rounding makes of a distance from the centre, in metres.
    [[nodiscard]] double rounding_at(const glm::dvec3& centre) const noexcept {
        return ball_rounding(centre, ball_.radius);
    }
    /// A step that is shorter cannot be told from none.
    [[nodiscard]] double shortest_step(const glm::dvec3& target) const noexcept {
        return 1e-9 * glm::min(glm::distance(centre_, target), ball_.radius) + rounding_at(centre_);
    }
    [[nodiscard]] bool is_on_wrong_side(const glm::dvec3& at) const noexcept {
        const Side here = side_of(*field_, at);
        if (ball_.side == Side::none) return ball_.surface == SurfaceKind::solid && here == Side::below;
        return here != Side::none && here != ball_.side;
    }

    /// The side on which a ball that came from beside the surface touches it.
    [[nodiscard]] Side touched_side() const noexcept {
        const bool from_below = around()[move_.held.faces[0]].from_below;
        return from_below && ball_.surface == SurfaceKind::sheet ? Side::below : Side::above;
    }
    [[nodiscard]] Move plan(const glm::dvec3& target, double friction) const noexcept;
    /// The step of second order where one or two obstacles hold the ball; that of first order where it is no better.
    void plan_second_step(const glm::dvec3& way, Move& move) const noexcept;
    /// On the line that two planes leave, and on one plane: the step, and the crests. False where there is none.
    [[nodiscard]] bool step_on_line(const glm::dvec3& way, const glm::dmat3& hessian, Move& move,
                                    glm::dvec3& step, bool& is_bent_down) const noexcept;
    [[nodiscard]] bool step_on_plane(const glm::dvec3& way, const glm::dmat3& hessian, Move& move,
                                     glm::dvec3& step, bool& is_bent_down) const noexcept;
    /// How far a step goes where the distance is bent down: near to where it is highest the way out is straight, and it may be
    /// long; farther off the ways part, and it has to be followed.
    [[nodiscard]] double longest_fall(const Move& move) const noexcept {
        const double first = glm::length(move.first);
        return glm::min(around().margin(), glm::max(first, glm::min(64 * first, ball_.radius / 16)));
    }
    [[nodiscard]] MoveEnd make_move(const glm::dvec3& target, const Move& move) noexcept;
    /// Takes a step, pushes the ball clear, and keeps that if the centre is nearer then. `wanted`: how far it would go if it could.
    [[nodiscard]] MoveEnd try_step(const glm::dvec3& target, const glm::dvec3& step, double wanted) noexcept;
    /// From a centre that is tried onto the obstacles that hold the ball there, of which the step has led off where they bend
    /// away. False where it cannot.
    [[nodiscard]] bool drop(const glm::dvec3& target, glm::dvec3& centre, double margin) noexcept;
    /// Takes a try that has led nearer to the target, on the side on which the ball is or round a rim.
    [[nodiscard]] MoveEnd keep_if_nearer(const glm::dvec3& target, const glm::dvec3& next,
                                         double length) noexcept;
    /// From where the distance is highest in a direction, to one side or the other.
    [[nodiscard]] MoveEnd leave_crests(const glm::dvec3& target, const Move& move) noexcept;
    /// From where the distance is highest along a step: takes it, and goes on from there until the centre is nearer.
    [[nodiscard]] bool leave_crest(const glm::dvec3& target, const glm::dvec3& aside) noexcept;
    /// Moves a centre away from what the ball overlaps there, and looks around. False where it cannot.
    [[nodiscard]] bool push_clear(glm::dvec3& centre, double margin) noexcept;
    /// Around a centre that is tried.
    [[nodiscard]] BallObstacles<Field>& ahead() noexcept { return looks_[1 - now_]; }
    void move_to(const glm::dvec3& centre, double step) noexcept {
        centre_ = centre;
        last_step_ = step;
        now_ = 1 - now_;
    }

    const Field* field_;
    BallOnSurface ball_;
    glm::dvec3 centre_;
    double last_step_ = std::numeric_limits<double>::max();
    Index work_;
    bool touched_ = false;
    Move move_{};
    BallObstacles<Field> looks_[2];
    int now_ = 0;
};

template <HeightField Field>
BallSlideEnd BallSlide<Field>::run(const glm::dvec3& target, bool touched, int max_steps,
                                   double friction) noexcept {
    touched_ = touched;
    for (int step = 0;; ++step) {
        if (centre_ == target) return BallSlideEnd::at_target;
        move_ = plan(target, friction);
        touched_ = touched_ || move_.touches;
        const bool pushed_down = move_.held.step.z - (target.z - centre_.z) < 0;
        if (pushed_down && is_on_rims_alone()) return BallSlideEnd::off_rim;
        if (ball_.side == Side::none && move_.touches && move_.held.count > 0) ball_.side = touched_side();
        if (move_.arrived && move_.crest_count == 0) return BallSlideEnd::minimum;
        if (step >= max_steps) return BallSlideEnd::step_limit;
        switch (make_move(target, move_)) {
        case MoveEnd::moved: break;
        case MoveEnd::off_rim: return BallSlideEnd::off_rim;
        case MoveEnd::work_limit: return BallSlideEnd::step_limit;
        // None leads nearer: arrived, as far as roundings tell.
        case MoveEnd::no_nearer: return move_.touches ? BallSlideEnd::minimum : BallSlideEnd::step_limit;
        }
    }
}

template <HeightField Field>
bool BallSlide<Field>::glide(const glm::dvec3& target, double length) noexcept {
    // The last part is not worth a step of its own.
    for (double left = length; left > length / 64;) {
        const glm::dvec3 before = centre_;
        if (!look(glm::min(left, widest())) || overlaps()) return false;
        if (run(target, true, 1) != BallSlideEnd::step_limit) return false;
        const double gone = glm::distance(before, centre_);
        if (!(gone > length / 1024)) return false;
        left -= gone;
    }
    return true;
}

template <HeightField Field>
bool BallSlide<Field>::is_on_rims_alone() const noexcept {
    const double touching = ball_.radius / 1024;
    for (int k = 0; k < move_.held.count; ++k) {
        const BallObstacle& obstacle = around()[move_.held.faces[k]];
        if (!(obstacle.on_rim || obstacle.from_below) || obstacle.gap > touching) return false;
    }
    return ball_.surface == SurfaceKind::solid && move_.held.count > 0;
}

template <HeightField Field>
auto BallSlide<Field>::plan(const glm::dvec3& target, double friction) const noexcept -> Move {
    const glm::dvec3 way = target - centre_;
    const double left = glm::length(way), touching = rounding_at(centre_) + 1e-9 * ball_.radius;
    Move move;
    for (const auto& obstacle : around())
        move.touches = move.touches || (obstacle.gap <= touching && glm::dot(obstacle.normal, way) < 0);
    if (!touched_ && !move.touches) {
        const glm::dvec3 step = glm::min(around().margin() / left, 1.0) * way;
        const double part = around().clear_part(step, 0);
        move.first = move.second = part < 1 ? part * step : step;
        move.wanted = left;
        return move;
    }
    move.held = around().nearest_to(way, 1e-14 * (left + ball_.radius));
    move.first = move.held.step;
    plan_second_step(way, move);
    // What the ball is only about to touch holds nothing back.
    bool held_by_touches = move.touches;
    for (int k = 0; k < move.held.count; ++k)
        held_by_touches = held_by_touches && around()[move.held.faces[k]].gap <= touching;
    if (friction > 0 && held_by_touches) {
        const double across = glm::length(move.first), against = glm::distance(move.first, way);
        move.crest_count = 0;
        move.arrived = across <= friction * against * (1 + 1e-9);
        const double part = move.arrived ? 0 : 1 - friction * against / across;
        move.first *= part, move.second *= part, move.wanted *= part;
    } else {
        const double longest = glm::min(glm::length(move.first), glm::length(move.second));
        move.arrived = move.touches && longest <= shortest_step(target);
    }
    return move;
}

template <HeightField Field>
void BallSlide<Field>::plan_second_step(const glm::dvec3& way, Move& move) const noexcept {
    const PolyhedronPoint& held = move.held;
    move.second = move.first;
    move.wanted = glm::length(move.first);
    if (held.count == 0 || held.count == 3) return;
    // Minimise ½ sᵀHs − way·s on the planes that hold the ball, with H = I − Σ share·∇²distance.
    glm::dmat3 hessian{1.0};
    for (int k = 0; k < held.count; ++k) {
        const BallObstacle& obstacle = around()[held.faces[k]];
        hessian -= held.shares[k] * around().turn(centre_, obstacle);
    }
    glm::dvec3 step;
    bool is_bent_down = false;
    const bool is_there = held.count == 2 ? step_on_line(way, hessian, move, step, is_bent_down)
                                          : step_on_plane(way, hessian, move, step, is_bent_down);
    if (!is_there) return;
    const double clear = around().clear_part(step, 1e-12 * ball_.radius);
    if (clear > 0.25) {
        move.second = clear * step;
        // Where it falls on all along the ball may go farther the next time.
        move.wanted = (is_bent_down ? 3 : 1) * glm::length(step);
    }
}

template <HeightField Field>
bool BallSlide<Field>::step_on_line(const glm::dvec3& way, const glm::dmat3& hessian, Move& move,
                                    glm::dvec3& step, bool& is_bent_down) const noexcept {
    const BallObstacle &one = around()[move.held.faces[0]], &other = around()[move.held.faces[1]];
    const double c = glm::dot(one.normal, other.normal), det = 1 - c * c;
    const glm::dvec3 base =
        ((c * other.gap - one.gap) * one.normal + (c * one.gap - other.gap) * other.normal) / det;
    const glm::dvec3 along = glm::normalize(glm::cross(one.normal, other.normal));
    const double bend = glm::dot(along, hessian * along);
    if (bend < crest) move.crests[move.crest_count++] = along;
    const double fall = glm::dot(along, way - hessian * base);
    // Where the distance is bent down it falls on.
    is_bent_down = !(bend > flattest);
    step = base + (bend > flattest ? fall / bend : std::copysign(longest_fall(move), fall)) * along;
    return bend > flattest || std::abs(fall) > 0;
}

template <HeightField Field>
bool BallSlide<Field>::step_on_plane(const glm::dvec3& way, const glm::dmat3& hessian, Move& move,
                                     glm::dvec3& step, bool& is_bent_down) const noexcept {
    const BallObstacle& face = around()[move.held.faces[0]];
    const glm::dvec3 n = face.normal, base = -face.gap * n;
    const glm::dvec3 axis = std::abs(n.x) < 0.7 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0};
    const glm::dvec3 a = glm::normalize(glm::cross(n, axis)), b = glm::cross(n, a);
    const glm::dvec3 ha = hessian * a, hb = hessian * b, rest = way - hessian * base;
    const double aa = glm::dot(a, ha), ab = glm::dot(a, hb), bb = glm::dot(b, hb);
    const double mean = (aa + bb) / 2, apart = (aa - bb) / 2, spread = std::sqrt(apart * apart + ab * ab);
    if (mean - spread < crest) {
        // The vector of the smaller bend, and of the larger.
        const double x = apart > 0 ? ab : apart - spread, y = apart > 0 ? -(apart + spread) : ab;
        const double size = std::sqrt(x * x + y * y);
        const glm::dvec3 lowest = size > 0 ? (x * a + y * b) / size : a;
        move.crests[move.crest_count++] = lowest;
        if (mean + spread < crest) move.crests[move.crest_count++] = glm::cross(n, lowest);
    }
    const double fa = glm::dot(a, rest), fb = glm::dot(b, rest), fall = std::sqrt(fa * fa + fb * fb);
    if (mean - spread > flattest) {
        const double det = aa * bb - ab * ab;
        step = base + (fa * bb - fb * ab) / det * a + (fb * aa - fa * ab) / det * b;
        return true;
    }
    // Where the distance is bent down it falls on.
    if (!(fall > 0)) return false;
    is_bent_down = true;
    step = base + longest_fall(move) / fall * (fa * a + fb * b);
    return true;
}

template <HeightField Field>
auto BallSlide<Field>::make_move(const glm::dvec3& target, const Move& move) noexcept -> MoveEnd {
    const double least = shortest_step(target);
    if (move.arrived) return leave_crests(target, move);
    MoveEnd end = MoveEnd::no_nearer;
    // Of second order, and shorter while that is longer than one of first order.
    double part = 1;
    do {
        end = try_step(target, part * move.second, part * move.wanted);
        part /= 8;
    } while (end == MoveEnd::no_nearer && part * glm::length(move.second) > 2 * glm::length(move.first));
    if (end == MoveEnd::no_nearer && move.second != move.first)
        end = try_step(target, move.first, glm::length(move.first));
    glm::dvec3 step = move.first;
    const double most = around().margin();
    if (const double size = glm::length(step); size > most) step *= most / size;
    for (int halving = 0; halving < 16 && end == MoveEnd::no_nearer; ++halving) {
        step /= 2.0;
        if (!(glm::length(step) > least)) break;
        end = try_step(target, step, 2 * glm::length(step));
    }
    return end == MoveEnd::no_nearer ? leave_crests(target, move) : end;
}

template <HeightField Field>
auto BallSlide<Field>::leave_crests(const glm::dvec3& target, const Move& move) noexcept -> MoveEnd {
    for (int k = 0; k < move.crest_count; ++k) {
        const glm::dvec3 aside = ball_.radius / 16 * move.crests[k];
        if (leave_crest(target, aside) || leave_crest(target, -aside)) return MoveEnd::moved;
    }
    return MoveEnd::no_nearer;
}

template <HeightField Field>
bool BallSlide<Field>::leave_crest(const glm::dvec3& target, const glm::dvec3& aside) noexcept {
    const double size = glm::length(aside), margin = 8 * size, before = glm::distance(centre_, target);
    BallSlide trial = *this;
    glm::dvec3 next = centre_ + aside;
    if (is_on_wrong_side(next) || !trial.ahead().look(next, ball_.radius, margin, trial.work_) ||
        !trial.push_clear(next, margin) || is_on_wrong_side(next))
        return false;
    trial.move_to(next, size);
    for (int step = 0; step < 4; ++step) {
        const Move move = trial.plan(target, 0);
        if (move.arrived || trial.try_step(target, move.first, move.wanted) != MoveEnd::moved) return false;
        if (glm::distance(trial.centre_, target) < before * (1 - 1e-12)) {
            *this = trial;
            return true;
        }
    }
    return false;
}

template <HeightField Field>
auto BallSlide<Field>::try_step(const glm::dvec3& target, const glm::dvec3& step, double wanted) noexcept
    -> MoveEnd {
    const double size = glm::length(step), most = around().margin(), length = glm::min(size, most);
    const glm::dvec3 way = target - centre_;
    glm::dvec3 next = size > most                               ? centre_ + most / size * step
                      : size == glm::length(way) && step == way ? target
                                                                : centre_ + step;
    // In so short a step it cannot have gone through the surface, but round a rim.
    const bool is_round_rim = is_on_wrong_side(next);
    if (is_round_rim && length > ball_.radius / 2) return MoveEnd::no_nearer;
    if (is_round_rim && ball_.surface == SurfaceKind::solid) return MoveEnd::off_rim;
    // As far as the ball may go from there: the rest of the step, or what a step of second order leaves.
    const double left = glm::max(wanted - length, length / 4);
    const double margin = glm::clamp(1.25 * left, ball_.radius / 64, widest());
    if (!ahead().look(next, ball_.radius, margin, work_)) return MoveEnd::work_limit;
    if (!(ahead().smallest_gap() > -ball_.radius / 2)) return MoveEnd::no_nearer;
    if (!push_clear(next, margin)) return work_ > 0 ? MoveEnd::no_nearer : MoveEnd::work_limit;
    MoveEnd end = keep_if_nearer(target, next, length);
    if (end == MoveEnd::no_nearer && touched_ && drop(target, next, margin))
        end = keep_if_nearer(target, next, length);
    return end == MoveEnd::no_nearer && work_ <= 0 ? MoveEnd::work_limit : end;
}

template <HeightField Field>
auto BallSlide<Field>::keep_if_nearer(const glm::dvec3& target, const glm::dvec3& next,
                                      double length) noexcept -> MoveEnd {
    // Where the ball was pushed clear it may stand on the other side of a thin ridge.
    const bool is_round_rim = is_on_wrong_side(next);
    if (is_round_rim && glm::distance(centre_, next) > ball_.radius / 2) return MoveEnd::no_nearer;
    if (is_round_rim && ball_.surface == SurfaceKind::solid) return MoveEnd::off_rim;
    const glm::dvec3 way = target - centre_, rest = target - next;
    const double before = glm::dot(way, way), after = glm::dot(rest, rest);
    const bool falls = after < before * (1 - 4 * epsilon<double>);
    // Nearer than the distance tells, which is no better than the place where the ball is clear: the step gets shorter each time.
    const double rounding = 4 * epsilon<double> * before + 2 * std::sqrt(before) * rounding_at(next);
    const bool settles =
        length * length <= 1e-10 * before && length < last_step_ / 2 && after <= before + rounding;
    if (!falls && !settles) return MoveEnd::no_nearer;
    if (is_round_rim) ball_.side = side_of(*field_, next);
    move_to(next, length);
    return MoveEnd::moved;
}

template <HeightField Field>
bool BallSlide<Field>::drop(const glm::dvec3& target, glm::dvec3& centre, double margin) noexcept {
    const auto held = ahead().nearest_to(target - centre, 1e-14 * ball_.radius);
    HalfSpace planes[3];
    const HalfSpace* pointers[3];
    for (int k = 0; k < held.count; ++k) {
        planes[k] = ahead()[held.faces[k]].half_space();
        pointers[k] = &planes[k];
    }
    glm::dvec3 step;
    double shares[3];
    if (held.count == 0 || !nearest_on_planes(glm::dvec3{0.0}, pointers, held.count, step, shares))
        return false;
    if (!(glm::length(step) <= ahead().margin())) return false;
    centre += step;
    return ahead().look(centre, ball_.radius, margin, work_) && push_clear(centre, margin);
}

template <HeightField Field>
bool BallSlide<Field>::push_clear(glm::dvec3& centre, double margin) noexcept {
    BallObstacles<Field>& around = ahead();
    for (int turn = 0; turn < 12; ++turn) {
        if (around.smallest_gap() >= -rounding_at(centre)) return true;
        const auto held = around.nearest_to(glm::dvec3{0.0}, 1e-15 * ball_.radius);
        if (!held.found || !(glm::length(held.step) <= ball_.radius)) return false;
        centre += held.step;
        if (!around.look(centre, ball_.radius, margin, work_)) return false;
    }
    return around.smallest_gap() >= -1e-10 * ball_.radius - rounding_at(centre);
}

template <HeightField Field>
bool BallSlide<Field>::lift() noexcept {
    const double sign = ball_.side == Side::below ? -1 : 1;
    const Lattice lattice = field_->lattice();
    const CellRange cells = field_->cells();
    const auto cell_of = [](double w, Index begin, Index end) {
        return static_cast<Index>(
            glm::clamp(std::floor(w), static_cast<double>(begin), static_cast<double>(end)));
    };
    const double radius = ball_.radius;
    const glm::dvec3 c = centre_;
    const Cell begin{cell_of(lattice.u_of(c.x - radius, 0) - 1, cells.begin.i, cells.end.i),
                     cell_of(lattice.v_of(c.y - radius, 0) - 1, cells.begin.j, cells.end.j)};
    const Cell last{cell_of(lattice.u_of(c.x + radius, 0) + 1, cells.begin.i, cells.end.i - 1),
                    cell_of(lattice.v_of(c.y + radius, 0) + 1, cells.begin.j, cells.end.j - 1)};
    const double looks =
        static_cast<double>(last.i - begin.i + 1) * static_cast<double>(last.j - begin.j + 1);
    if (!(looks <= static_cast<double>(work_))) return false;
    work_ -= static_cast<Index>(looks);
    double top = sign * c.z;
    for (Index j = begin.j; j <= last.j; ++j) {
        for (Index i = begin.i; i <= last.i; ++i) {
            if (const auto patch = field_->patch({i, j}))
                top = glm::max(top, widen(sign > 0 ? patch->highest() : -patch->lowest()));
        }
    }
    const glm::dvec3 from{c.x, c.y, sign * (top + radius * (1 + 1e-6) + 1e-9 * std::abs(top))};
    const auto down = first_touch(*field_, from, c, radius, work_);
    work_ -= down.work;
    if (down.status != BallSweepStatus::touch) return false;
    centre_ = from + down.t * (c - from);
    return true;
}

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_BALL_SLIDE_HPP
