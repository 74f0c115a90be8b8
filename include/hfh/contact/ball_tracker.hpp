#ifndef HFH_CONTACT_BALL_TRACKER_HPP
#define HFH_CONTACT_BALL_TRACKER_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/traversal/ball_obstacles.hpp>
#include <hfh/traversal/ball_sweep.hpp>
#include <hfh/traversal/surface_at.hpp>

#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>

#include <cmath>
#include <limits>
#include <utility>

// Based on: Ruspini, Kolarov and Khatib, The Haptic Display of Complex Graphical Environments (1997): a proxy with a
// radius that is moved by half-spaces; Nocedal and Wright, Numerical Optimization (2006), ch. 18, for the second-order steps.

namespace hfh {

/// Everything that a ball's tracker remembers: a trivially copyable value.
template <Real T>
struct BallState {
    glm::dvec3 centre{0.0}; ///< world coordinates, metres
    glm::dvec3 stylus{0.0}; ///< of the last update
    SurfacePoint<T> foot{}; ///< in contact: where the ball touches with the largest share
    Side side = Side::none; ///< in contact: the side that is felt; else the side the ball is on
    TrackerPhase phase = TrackerPhase::unseen;
    bool is_buried =
        false; ///< the ball has overlapped the surface, or been below the solid, since it was seen first

    [[nodiscard]] constexpr bool touching() const noexcept { return phase >= TrackerPhase::contact; }
};

/// Follows a stylus with a ball of radius r at its end over a height field. The proxy is the ball's centre c.
///
///     minimise |c − stylus|  subject to  |c − x| ≥ r for every point x of the surface, and c on its own side
///
/// locally: the centre goes there from where it was, touches the ground all along, and never gets farther from the stylus.
/// Free it goes straight to the stylus, however far, and stops where the ball touches: it passes through no ridge, and no spike
/// thinner than itself. In contact up to three places hold it (`BallContact::touches`).
///
/// A rim of a hole or of the grid is a wire with no wall below it: the ball may rest on it, and on two sides of a hole
/// narrower than itself. Contact with a solid ends when nothing but rims touches and the force would point down.
template <HeightField Field>
class BallTracker {
public:
    using Scalar = typename Field::Scalar;
    using State = BallState<Scalar>;

    /// `radius` in metres, ≥ 0 and finite; anything else counts as 0.
    BallTracker(const Field& field, Scalar radius, const TrackerOptions& options = {}) noexcept
        : point_{field, options}, options_{options}, radius_{valid_radius(radius)} {}
    BallTracker(const Field&&, Scalar,
                const TrackerOptions& = {}) = delete; // the field must outlive the tracker

    /// One haptic update: the stylus is at `stylus` (world coordinates, metres).
    [[nodiscard]] BallContact<Scalar> update(const vec3<Scalar>& stylus) noexcept;

    /// Between updates, in contact as well: a ball that grows is lifted until it is clear.
    void set_radius(Scalar radius) noexcept;
    [[nodiscard]] constexpr Scalar radius() const noexcept { return radius_; }
    /// The centre of the ball in world coordinates, metres, in double: free: the stylus; in contact: the proxy.
    [[nodiscard]] constexpr const glm::dvec3& centre() const noexcept { return state_.centre; }

    constexpr void reset() noexcept {
        state_ = {};
        point_.reset();
    }
    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }
    [[nodiscard]] constexpr const Field& field() const noexcept { return point_.field(); }

private:
    using Obstacles = detail::BallObstacles<Field>;
    using Phase = TrackerPhase;

    /// Where the centre is to go from where it is: steps, in metres.
    struct Move {
        glm::dvec3 second{0.0};         ///< of second order
        glm::dvec3 first{0.0};          ///< of first order: keeps all half-spaces
        detail::PolyhedronPoint held{}; ///< what holds the ball, if it touches
        double wanted =
            0; ///< how far the step of second order would go if nothing were in the way, in metres
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
        off_rim,   ///< the ball would come out below the solid: it has got round a rim
        work_limit
    };
    /// A centre, what is around it, and what the update may still do.
    class Place {
    public:
        Place(const Field& field, SurfaceKind surface, const glm::dvec3& centre, Index work) noexcept
            : centre{centre}, work{work}, looks_{Obstacles{field, surface}, Obstacles{field, surface}} {}

        [[nodiscard]] Obstacles& around() noexcept { return looks_[now_]; }
        [[nodiscard]] const Obstacles& around() const noexcept { return looks_[now_]; }
        /// Around a centre that is tried.
        [[nodiscard]] Obstacles& ahead() noexcept { return looks_[1 - now_]; }
        void move_to(const glm::dvec3& next, double step) noexcept {
            centre = next;
            last_step = step;
            now_ = 1 - now_;
        }

        glm::dvec3 centre;
        double last_step = std::numeric_limits<double>::max();
        Index work;

    private:
        Obstacles looks_[2];
        int now_ = 0;
    };

    [[nodiscard]] static constexpr Scalar valid_radius(Scalar radius) noexcept {
        return is_at_least_zero(radius) && is_height(radius) ? radius : Scalar(0);
    }
    [[nodiscard]] double wide_radius() const noexcept { return widen(radius_); }
    /// What rounding makes of a distance from the centre, in metres.
    [[nodiscard]] double rounding_at(const glm::dvec3& centre) const noexcept {
        const double size = glm::max(glm::max(std::abs(centre.x), std::abs(centre.y)), std::abs(centre.z));
        return 1e-12 * wide_radius() + 2 * epsilon<double> * size;
    }
    /// How many patches and blocks this update may look at: at least what it takes to go one step.
    [[nodiscard]] Index work_allowed() const noexcept;
    /// How many steps the ball may go in contact in an update in which the stylus moved here.
    [[nodiscard]] int steps_allowed(const glm::dvec3& to) const noexcept;

    [[nodiscard]] BallContact<Scalar> update_point(const vec3<Scalar>& stylus) noexcept;
    /// The first stylus, or still buried: whether the ball is clear here.
    [[nodiscard]] BallContact<Scalar> begin(const vec3<Scalar>& stylus) noexcept;
    /// Over to the foot of the stylus, if that is all there is to do: mostly it is. False, and nothing done, if not.
    [[nodiscard]] bool roll(const vec3<Scalar>& stylus, Index& work, BallContact<Scalar>& contact) noexcept;
    /// Step by step, whatever is in the way.
    [[nodiscard, gnu::noinline]] BallContact<Scalar> follow(const vec3<Scalar>& stylus, Index& work) noexcept;

    /// `free`: nothing was touched yet, and the ball goes straight.
    [[nodiscard]] Move plan(const Place& place, const glm::dvec3& to, bool free) const noexcept;
    /// The step of second order where obstacles hold the ball; that of first order where it is no better.
    void plan_second_step(const Place& place, const glm::dvec3& way, Move& move) const noexcept;
    [[nodiscard]] MoveEnd make_move(Place& place, const glm::dvec3& to, const Move& move) const noexcept;
    /// From where the distance is highest along a step: takes it, and goes on from there until the ball is nearer.
    [[nodiscard]] bool leave_crest(Place& place, const glm::dvec3& to,
                                   const glm::dvec3& aside) const noexcept;
    /// `wanted`: how far it would go if it could, in metres.
    [[nodiscard]] MoveEnd try_step(Place& place, const glm::dvec3& to, const glm::dvec3& step,
                                   double wanted) const noexcept;
    /// Moves the ball away from what it overlaps, and looks around there. False where it cannot.
    [[nodiscard]] bool push_clear(Place& place, glm::dvec3& centre, double margin) const noexcept;
    /// Lifts the ball (felt from below: lowers it) until it is clear. False where it cannot.
    [[nodiscard]] bool lift(Place& place) const noexcept;

    [[nodiscard]] Side side_of(const glm::dvec3& at) const noexcept {
        const auto height = detail::height_over(field(), at.x, at.y);
        return !height ? Side::none : at.z < *height ? Side::below : Side::above;
    }
    /// Whether a centre has got to the other side of the surface than it was on.
    [[nodiscard]] bool is_on_wrong_side(const glm::dvec3& at) const noexcept {
        const Side here = side_of(at);
        if (state_.side == Side::none) return options_.surface == SurfaceKind::solid && here == Side::below;
        return here != Side::none && here != state_.side;
    }

    [[nodiscard]] BallContact<Scalar> without_contact(const vec3<Scalar>& stylus,
                                                      ContactStatus status) const noexcept {
        BallContact<Scalar> contact;
        contact.status = status;
        contact.side = state_.side;
        contact.proxy = stylus;
        return contact;
    }
    /// The ball is where the stylus is.
    [[nodiscard]] BallContact<Scalar> set_free(const vec3<Scalar>& stylus) noexcept;
    /// The ball has got round a rim.
    [[nodiscard]] BallContact<Scalar> leave(const vec3<Scalar>& stylus) noexcept;
    /// Goes on in the next update.
    [[nodiscard]] BallContact<Scalar> keep(const vec3<Scalar>& stylus, const Place& place,
                                           bool touched) noexcept;
    [[nodiscard]] BallContact<Scalar> make_contact(const Place& place, const detail::PolyhedronPoint& held,
                                                   ContactStatus status) noexcept;

    ProxyTracker<Field> point_;
    TrackerOptions options_;
    Scalar radius_;
    State state_{};
};

template <HeightField Field>
Index BallTracker<Field>::work_allowed() const noexcept {
    const double wide = wide_radius() + detail::widest_margin(field(), wide_radius());
    const glm::dvec2 cells = 2 * wide * field().lattice().cells_per_metre() + 3.0;
    const double least = 8 * glm::min(cells.x * cells.y, 1e9);
    return glm::max(static_cast<Index>(options_.max_patches), static_cast<Index>(least));
}

template <HeightField Field>
int BallTracker<Field>::steps_allowed(const glm::dvec3& to) const noexcept {
    constexpr int most = 4096;
    if (options_.max_contact_patches >= options_.max_patches) return most;
    const glm::dvec3 way = to - state_.stylus;
    const glm::dvec2 per_metre = field().lattice().cells_per_metre();
    const double cells = glm::max(std::abs(way.x) * per_metre.x, std::abs(way.y) * per_metre.y);
    return static_cast<int>(glm::min(glm::max(options_.max_contact_patches, 1) + 2 * cells, double(most)));
}

template <HeightField Field>
auto BallTracker<Field>::update(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    if (!(radius_ > 0)) return update_point(stylus);
    if (!is_finite(stylus) || !field().lattice().reaches(stylus) || !is_height(stylus.z)) {
        BallContact<Scalar> refused;
        refused.status = ContactStatus::bad_input;
        return refused;
    }
    if (state_.phase == Phase::unseen || state_.is_buried) return begin(stylus);
    const Index allowed = work_allowed();
    Index work = allowed;
    BallContact<Scalar> contact;
    if (!(state_.phase == Phase::contact && roll(stylus, work, contact))) contact = follow(stylus, work);
    contact.patches = static_cast<int>(allowed - work);
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::update_point(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    BallContact<Scalar> contact;
    static_cast<Contact<Scalar>&>(contact) = point_.update(stylus);
    if (contact.status == ContactStatus::bad_input) return contact;
    const auto& point = point_.state();
    state_.centre = widen(contact.proxy);
    state_.stylus = widen(stylus);
    state_.foot = point.proxy;
    state_.side = point.side;
    state_.phase = point.phase;
    if (contact.touching()) {
        contact.touches[0] = {contact.point, contact.normal, contact.depth};
        contact.count = 1;
    }
    return contact;
}

template <HeightField Field>
void BallTracker<Field>::set_radius(Scalar radius) noexcept {
    const Scalar before = radius_;
    radius_ = valid_radius(radius);
    if (radius_ > 0 || !(before > 0)) return;
    // The point goes on from where the ball touches; free, from where the ball is.
    auto point = point_.state();
    point = {};
    if (!state_.is_buried && state_.phase != Phase::unseen) {
        point.swept_to = state_.touching() ? state_.stylus : state_.centre;
        point.proxy = state_.foot;
        point.side = state_.side;
        point.phase = state_.touching() ? Phase::contact : Phase::free;
    }
    point_.restore(point);
}

template <HeightField Field>
auto BallTracker<Field>::begin(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    const glm::dvec3 to = widen(stylus);
    Obstacles around{field(), SurfaceKind::sheet};
    Index work = work_allowed();
    const bool looked = around.look(to, wide_radius(), 0, work);
    state_ = {.centre = to, .stylus = to, .side = side_of(to), .phase = Phase::free};
    const bool below = state_.side == Side::below && options_.surface == SurfaceKind::solid;
    state_.is_buried = below || !looked || around.smallest_gap() < 0;
    return without_contact(stylus, state_.is_buried            ? ContactStatus::buried
                                   : state_.side == Side::none ? ContactStatus::off_surface
                                                               : ContactStatus::free);
}

template <HeightField Field>
bool BallTracker<Field>::roll(const vec3<Scalar>& stylus, Index& work,
                              BallContact<Scalar>& contact) noexcept {
    const glm::dvec3 to = widen(stylus);
    const double radius = wide_radius();
    const auto foot = descend(field(), stylus, state_.foot, options_.max_patches);
    work -= foot.patches;
    if (foot.status != DescentStatus::minimum) return false;
    const detail::ReachSearch<Field> from_stylus{field(), to, 0, 0};
    detail::RelativePatch patch;
    if (!from_stylus.read(foot.point.cell, patch)) return false;
    const double u = widen(foot.point.u), v = widen(foot.point.v);
    const glm::dvec3 to_foot = patch.foot(u, v).offset, upward = patch.patch().normal(u, v);
    glm::dvec3 normal = state_.side == Side::below ? -upward : upward;
    if (on_border(foot.point)) {
        // A ridge, with the stylus over it. Where the stylus lies on it the direction is lost in rounding.
        const double distance = glm::length(to_foot);
        if (!(glm::dot(to_foot, normal) < 0 && distance > radius / 256)) return false;
        normal = -to_foot / distance;
        if (options_.surface == SurfaceKind::solid && normal.z < 0) return false;
    }
    const glm::dvec3 offset = to_foot + radius * normal, centre = to + offset;
    const double share = glm::dot(offset, normal);
    // Never farther, and no farther on the way than a look around its end tells about.
    const glm::dvec3 before = state_.centre - to, way = centre - state_.centre;
    const double length = glm::length(way);
    const bool farther = glm::dot(offset, offset) > glm::dot(before, before) * (1 + 4 * epsilon<double>);
    if (!(share > 0) || farther || !(length <= 2 * detail::widest_margin(field(), radius))) return false;
    if (!detail::rolls_freely(field(), state_.centre, centre, to, normal, radius, rounding_at(centre), work))
        return false;
    state_.centre = centre;
    state_.stylus = to;
    state_.foot = foot.point;
    contact.status = ContactStatus::contact;
    contact.side = state_.side;
    contact.proxy = vec3<Scalar>{centre};
    contact.penetration = vec3<Scalar>{offset};
    contact.depth = glm::length(contact.penetration);
    contact.normal = vec3<Scalar>{normal};
    contact.point = foot.point;
    contact.touches[0] = {foot.point, contact.normal, static_cast<Scalar>(share)};
    contact.count = 1;
    return true;
}

template <HeightField Field>
auto BallTracker<Field>::follow(const vec3<Scalar>& stylus, Index& work) noexcept -> BallContact<Scalar> {
    const glm::dvec3 to = widen(stylus);
    const double widest = detail::widest_margin(field(), wide_radius());
    const int max_steps = steps_allowed(to);
    // A ball in contact goes about as far as the stylus went.
    const double expected = state_.touching() ? 1.25 * glm::distance(to, state_.stylus) + wide_radius() / 16
                                              : std::numeric_limits<double>::max();
    state_.stylus = to;
    Place place{field(), options_.surface, state_.centre, work};
    bool touched = state_.touching();
    const auto end = [&](const BallContact<Scalar>& contact) {
        work = place.work;
        return contact;
    };
    const auto look = [&] {
        const double margin = glm::min(glm::min(widest, expected), glm::distance(to, place.centre));
        return place.around().look(place.centre, wide_radius(), margin, place.work);
    };
    if (!look()) return end(keep(stylus, place, touched));
    if (is_on_wrong_side(place.centre) || place.around().smallest_gap() < -1e-6 * wide_radius()) {
        if (!lift(place) || !look()) return end(keep(stylus, place, touched));
        touched = true;
    }
    for (int step = 0;; ++step) {
        if (place.centre == to) return end(set_free(stylus));
        const Move move = plan(place, to, !touched);
        touched = touched || move.touches;
        if (move.arrived && move.crest_count == 0)
            return end(make_contact(place, move.held, ContactStatus::contact));
        if (step >= max_steps) return end(keep(stylus, place, touched));
        switch (make_move(place, to, move)) {
        case MoveEnd::moved: break;
        case MoveEnd::off_rim: return end(leave(stylus));
        case MoveEnd::work_limit: return end(keep(stylus, place, touched));
        case MoveEnd::no_nearer:
            if (!move.touches) return end(keep(stylus, place, touched));
            return end(make_contact(place, move.held, ContactStatus::contact));
        }
    }
}

template <HeightField Field>
auto BallTracker<Field>::plan(const Place& place, const glm::dvec3& to, bool free) const noexcept -> Move {
    const glm::dvec3 way = to - place.centre;
    const double left = glm::length(way), near = rounding_at(place.centre) + 1e-9 * wide_radius();
    Move move;
    for (const auto& obstacle : place.around())
        move.touches = move.touches || (obstacle.gap <= near && glm::dot(obstacle.normal, way) < 0);
    if (free && !move.touches) {
        const glm::dvec3 ahead = glm::min(place.around().margin() / left, 1.0) * way;
        const double part = place.around().clear_part(ahead, 0);
        move.first = move.second = part < 1 ? part * ahead : ahead;
        move.wanted = left;
        return move;
    }
    move.held = place.around().nearest_to(way, 1e-14 * (left + wide_radius()));
    move.first = move.held.step;
    plan_second_step(place, way, move);
    move.arrived = move.touches && glm::length(move.second) <= 1e-9 * left + epsilon<double> * wide_radius();
    return move;
}

template <HeightField Field>
void BallTracker<Field>::plan_second_step(const Place& place, const glm::dvec3& way,
                                          Move& move) const noexcept {
    constexpr double flattest = 0.02; // of what the distance is bent by in free space
    const detail::PolyhedronPoint& held = move.held;
    move.second = move.first;
    move.wanted = glm::length(move.first);
    if (held.count == 0 || held.count == 3) return;
    // Minimise ½ sᵀHs − way·s on the planes that hold the ball, with H = I − Σ share·∇²distance.
    glm::dmat3 hessian{1.0};
    for (int k = 0; k < held.count; ++k) {
        const auto& obstacle = place.around()[held.faces[k]];
        hessian -= held.shares[k] * place.around().turn(place.centre, obstacle);
    }
    const auto& face = place.around()[held.faces[0]];
    const glm::dvec3 n = face.normal;
    glm::dvec3 base = -face.gap * n, step;
    if (held.count == 2) {
        const auto& other = place.around()[held.faces[1]];
        const double c = glm::dot(n, other.normal), det = 1 - c * c;
        base = ((c * other.gap - face.gap) * n + (c * face.gap - other.gap) * other.normal) / det;
        const glm::dvec3 along = glm::normalize(glm::cross(n, other.normal));
        const double bend = glm::dot(along, hessian * along);
        if (bend < -1e-6) move.crests[move.crest_count++] = along;
        if (!(bend > flattest)) return;
        step = base + glm::dot(along, way - hessian * base) / bend * along;
    } else {
        const glm::dvec3 axis = std::abs(n.x) < 0.7 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0};
        const glm::dvec3 a = glm::normalize(glm::cross(n, axis)), b = glm::cross(n, a);
        const glm::dvec3 ha = hessian * a, hb = hessian * b, rest = way - hessian * base;
        const double aa = glm::dot(a, ha), ab = glm::dot(a, hb), bb = glm::dot(b, hb);
        const double mean = (aa + bb) / 2, apart = (aa - bb) / 2, spread = std::sqrt(apart * apart + ab * ab);
        if (mean - spread < -1e-6) {
            // The vector of the smaller bend.
            const double x = apart > 0 ? ab : apart - spread, y = apart > 0 ? -(apart + spread) : ab;
            const double size = std::sqrt(x * x + y * y);
            const glm::dvec3 most = size > 0 ? (x * a + y * b) / size : a;
            move.crests[move.crest_count++] = most;
            if (mean + spread < -1e-6) move.crests[move.crest_count++] = glm::cross(n, most);
        }
        if (!(mean - spread > flattest)) return;
        const double fa = glm::dot(a, rest), fb = glm::dot(b, rest), det = aa * bb - ab * ab;
        step = base + (fa * bb - fb * ab) / det * a + (fb * aa - fa * ab) / det * b;
    }
    const double clear = place.around().clear_part(step, 1e-12 * wide_radius());
    if (clear > 0.25) {
        move.second = clear * step;
        move.wanted = glm::length(step);
    }
}

template <HeightField Field>
auto BallTracker<Field>::make_move(Place& place, const glm::dvec3& to, const Move& move) const noexcept
    -> MoveEnd {
    const double least = 1e-9 * glm::length(to - place.centre) + epsilon<double> * wide_radius();
    MoveEnd end = MoveEnd::no_nearer;
    if (move.arrived) {
        for (int k = 0; k < move.crest_count; ++k) {
            const glm::dvec3 aside = wide_radius() / 16 * move.crests[k];
            if (leave_crest(place, to, aside) || leave_crest(place, to, -aside)) return MoveEnd::moved;
        }
        return MoveEnd::no_nearer;
    }
    end = try_step(place, to, move.second, move.wanted);
    if (end == MoveEnd::no_nearer && move.second != move.first)
        end = try_step(place, to, move.first, glm::length(move.first));
    glm::dvec3 step = move.first;
    const double most = place.around().margin();
    if (const double size = glm::length(step); size > most) step *= most / size;
    for (int halving = 0; halving < 16 && end == MoveEnd::no_nearer; ++halving) {
        step /= 2.0;
        if (!(glm::length(step) > least)) break;
        end = try_step(place, to, step, 2 * glm::length(step));
    }
    return end;
}

template <HeightField Field>
bool BallTracker<Field>::leave_crest(Place& place, const glm::dvec3& to,
                                     const glm::dvec3& aside) const noexcept {
    const double size = glm::length(aside), before = glm::distance(place.centre, to);
    Place trial = place;
    glm::dvec3 next = place.centre + aside;
    const double margin = 8 * size;
    if (is_on_wrong_side(next) || !trial.ahead().look(next, wide_radius(), margin, trial.work) ||
        !push_clear(trial, next, margin))
        return false;
    trial.move_to(next, size);
    for (int step = 0; step < 4; ++step) {
        const Move move = plan(trial, to, false);
        if (move.arrived || try_step(trial, to, move.first, move.wanted) != MoveEnd::moved) return false;
        if (glm::distance(trial.centre, to) < before * (1 - 1e-12)) {
            place = trial;
            return true;
        }
    }
    return false;
}

template <HeightField Field>
auto BallTracker<Field>::try_step(Place& place, const glm::dvec3& to, const glm::dvec3& step,
                                  double wanted) const noexcept -> MoveEnd {
    const double size = glm::length(step), most = place.around().margin(), length = glm::min(size, most);
    const glm::dvec3 way = to - place.centre;
    glm::dvec3 next = size > most                               ? place.centre + most / size * step
                      : size == glm::length(way) && step == way ? to
                                                                : place.centre + step;
    if (is_on_wrong_side(next)) return length <= wide_radius() / 2 ? MoveEnd::off_rim : MoveEnd::no_nearer;
    // As far as the ball may go from there: the rest of the step, or what a step of second order leaves.
    const double left = glm::max(wanted - length, length / 4),
                 widest = detail::widest_margin(field(), wide_radius());
    const double margin = glm::clamp(1.25 * left, wide_radius() / 64, widest);
    if (!place.ahead().look(next, wide_radius(), margin, place.work)) return MoveEnd::work_limit;
    if (!(place.ahead().smallest_gap() > -wide_radius() / 2)) return MoveEnd::no_nearer;
    if (!push_clear(place, next, margin)) return place.work > 0 ? MoveEnd::no_nearer : MoveEnd::work_limit;
    const glm::dvec3 rest = to - next;
    const double before = glm::dot(way, way), after = glm::dot(rest, rest);
    const bool falls = after < before * (1 - 4 * epsilon<double>);
    // Nearer than the distance tells: the step gets shorter each time.
    const bool settles = length * length <= 1e-12 * before && length < place.last_step / 2 &&
                         after <= before * (1 + 4 * epsilon<double>);
    if (!falls && !settles) return MoveEnd::no_nearer;
    place.move_to(next, length);
    return MoveEnd::moved;
}

template <HeightField Field>
bool BallTracker<Field>::push_clear(Place& place, glm::dvec3& centre, double margin) const noexcept {
    Obstacles& around = place.ahead();
    for (int turn = 0; turn < 12; ++turn) {
        if (around.smallest_gap() >= -rounding_at(centre)) return true;
        const auto held = around.nearest_to(glm::dvec3{0.0}, 1e-15 * wide_radius());
        if (!held.found || !(glm::length(held.step) <= wide_radius())) return false;
        centre += held.step;
        if (!around.look(centre, wide_radius(), margin, place.work)) return false;
    }
    return around.smallest_gap() >= -1e-10 * wide_radius() - rounding_at(centre);
}

template <HeightField Field>
bool BallTracker<Field>::lift(Place& place) const noexcept {
    const double sign = state_.side == Side::below ? -1 : 1;
    const Lattice lattice = field().lattice();
    const CellRange cells = field().cells();
    const auto cell_of = [](double w, Index begin, Index end) {
        return static_cast<Index>(
            glm::clamp(std::floor(w), static_cast<double>(begin), static_cast<double>(end)));
    };
    const double radius = wide_radius();
    const glm::dvec3& c = place.centre;
    const Cell begin{cell_of(lattice.u_of(c.x - radius, 0) - 1, cells.begin.i, cells.end.i),
                     cell_of(lattice.v_of(c.y - radius, 0) - 1, cells.begin.j, cells.end.j)};
    const Cell last{cell_of(lattice.u_of(c.x + radius, 0) + 1, cells.begin.i, cells.end.i - 1),
                    cell_of(lattice.v_of(c.y + radius, 0) + 1, cells.begin.j, cells.end.j - 1)};
    double top = sign * c.z;
    for (Index j = begin.j; j <= last.j; ++j) {
        for (Index i = begin.i; i <= last.i; ++i) {
            if (const auto patch = field().patch({i, j}))
                top = glm::max(top, widen(sign > 0 ? patch->highest() : -patch->lowest()));
        }
    }
    const glm::dvec3 from{c.x, c.y, sign * (top + radius * (1 + 1e-6) + 1e-9 * std::abs(top))};
    const auto down = first_touch(field(), from, c, radius, SurfaceKind::sheet);
    if (down.status != BallSweepStatus::touch) return false;
    place.centre = from + down.t * (c - from);
    return true;
}

template <HeightField Field>
auto BallTracker<Field>::set_free(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    state_.centre = state_.stylus;
    state_.phase = Phase::free;
    const Side side = side_of(state_.centre);
    if (side != Side::none || options_.surface == SurfaceKind::solid) state_.side = side;
    return without_contact(stylus, side == Side::none ? ContactStatus::off_surface : ContactStatus::free);
}

template <HeightField Field>
auto BallTracker<Field>::leave(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    const bool was_touching = state_.touching();
    const Cell cell = state_.foot.cell;
    auto contact = begin(stylus);
    if (was_touching) {
        const CellRange cells = field().cells();
        const bool inside = cells.begin.i < cell.i && cell.i + 1 < cells.end.i && cells.begin.j < cell.j &&
                            cell.j + 1 < cells.end.j;
        contact.status = inside ? ContactStatus::left_at_hole : ContactStatus::left_at_border;
    }
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::keep(const vec3<Scalar>& stylus, const Place& place, bool touched) noexcept
    -> BallContact<Scalar> {
    state_.centre = place.centre;
    if (!touched) {
        state_.phase = Phase::searching;
        return without_contact(stylus, ContactStatus::sweep_limit);
    }
    const auto held = place.around().nearest_to(state_.stylus - place.centre, 1e-14 * wide_radius());
    auto contact = make_contact(place, held, ContactStatus::descent_limit);
    state_.phase = Phase::sliding;
    Obstacles there{field(), options_.surface};
    Index work = std::numeric_limits<int>::max();
    const bool felt = is_on_wrong_side(state_.stylus) || !there.look(state_.stylus, wide_radius(), 0, work) ||
                      there.smallest_gap() < 0;
    if (!felt) contact.penetration = vec3<Scalar>{Scalar(0)}, contact.depth = 0, contact.count = 0;
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::make_contact(const Place& place, const detail::PolyhedronPoint& held,
                                      ContactStatus status) noexcept -> BallContact<Scalar> {
    const glm::dvec3 penetration = place.centre - state_.stylus;
    const double depth = glm::length(penetration);
    BallContact<Scalar> contact;
    contact.status = status;
    contact.side = state_.side;
    contact.proxy = vec3<Scalar>{place.centre};
    contact.penetration = vec3<Scalar>{penetration};
    contact.depth = static_cast<Scalar>(depth);
    if (depth > 0) contact.normal = vec3<Scalar>{penetration / depth};
    for (int k = 0; k < held.count; ++k) {
        const auto& obstacle = place.around()[held.faces[k]];
        if (!(held.shares[k] > 0)) continue;
        const BallTouch<Scalar> touch{{obstacle.point.cell, static_cast<Scalar>(obstacle.point.u),
                                       static_cast<Scalar>(obstacle.point.v)},
                                      vec3<Scalar>{obstacle.normal},
                                      static_cast<Scalar>(held.shares[k])};
        int at = contact.count++;
        for (; at > 0 && contact.touches[at - 1].share < touch.share; --at)
            contact.touches[at] = contact.touches[at - 1];
        contact.touches[at] = touch;
    }
    if (contact.count > 0) state_.foot = contact.touches[0].point;
    contact.point = state_.foot;
    state_.centre = place.centre;
    state_.phase = Phase::contact;
    return contact;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_TRACKER_HPP
