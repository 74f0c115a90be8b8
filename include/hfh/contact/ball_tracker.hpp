#ifndef HFH_CONTACT_BALL_TRACKER_HPP
#define HFH_CONTACT_BALL_TRACKER_HPP

#include <hfh/contact/ball_contact.hpp>
#include <hfh/contact/ball_touches.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/traversal/ball_slide.hpp>

#include <glm/geometric.hpp>

#include <cmath>

// Based on: Ruspini, Kolarov and Khatib, The Haptic Display of Complex Graphical Environments (1997): a proxy with a radius.

namespace hfh {

/// Everything that a ball's tracker remembers: a trivially copyable value.
template <Real T>
struct BallState {
    glm::dvec3 centre{
        0.0}; ///< of the ball: in contact the proxy, free the stylus, or as far as the ball has got
    glm::dvec3 stylus{0.0}; ///< of the last update
    SurfacePoint<T> foot{}; ///< in contact: where the ball touches with the largest share
    Side side = Side::none; ///< in contact: the side that is felt; else the side the ball is on
    TrackerPhase phase = TrackerPhase::unseen;
    /// Since it was seen first, or got round a rim, the ball has overlapped the surface or been below the solid.
    bool is_buried = false;
    TrackerState<T> point{}; ///< with radius 0: that of the point's tracker; else as it is at the start

    [[nodiscard]] constexpr bool touching() const noexcept { return phase >= TrackerPhase::contact; }
};

/// Follows a stylus with a ball of radius r at its end over a height field. The proxy is the ball's centre c.
///
///     minimise |c − stylus|  subject to  |c − x| ≥ r for every point x of the surface, and c on its own side
///
/// locally: the centre slides there from where it was and never gets farther from the stylus. Free it goes straight to the
/// stylus, however far, until the ball touches: it passes through no ridge, and no spike thinner than itself. Up to three
/// places hold it in contact (`BallContact::touches`); their shares of the force add up to it.
///
/// The ball keeps r(1 − 1e-9) from the surface, and rounding of its coordinates. It rests where no step leads nearer, so on no
/// crest. A rim of a hole or of the grid is a wire with no wall below it: the ball may rest on it, and on a hole narrower
/// than itself. Contact with a solid ends when nothing but rims touches and the force would point down. A ball that overlaps
/// the surface at its first position, or is below a solid there, feels nothing until it is clear (`buried`). Edited heights are
/// felt at the next update: ground that rises lifts the ball vertically until it is clear. A sheet is felt from either side.
///
/// What `ProxyTracker` says of statuses, of limited work and of rest holds here as well, but that an update looks at no
/// less than it takes to go one step: `max_patches`, or 8 (2 a/dx + 3)(2 a/dy + 3) patches, where a is r and how far
/// the ball may go between two looks, if that is more. `max_contact_patches` limits the steps of a slide, each of which takes a look around the ball; so many, and two more
/// for each cell that the stylus moved.
///
/// With r = 0 it is a `ProxyTracker`, to the bit. Two balls on one field are two trackers. Computes in double. `update` is
/// noexcept and allocates nothing; its stack holds up to four lists of 40 obstacles (`detail::BallObstacles`).
///
/// Keeps a pointer to the field, which must outlive it.
template <HeightField Field>
class BallTracker {
public:
    using Scalar = typename Field::Scalar;
    using State = BallState<Scalar>;
    static_assert(std::same_as<FrameScalar<Field>, double>, "a ball's tracker computes places in double");

    /// `radius` in metres, ≥ 0 and below `longest`; anything else counts as 0.
    constexpr BallTracker(const Field& field, Scalar radius, const TrackerOptions& options = {}) noexcept
        : point_{field, options}, options_{options}, radius_{valid_radius(radius)} {}
    /// With radius 0, to be set later.
    constexpr explicit BallTracker(const Field& field, const TrackerOptions& options = {}) noexcept
        : BallTracker{field, Scalar(0), options} {}
    // The field must outlive the tracker.
    BallTracker(const Field&&, Scalar, const TrackerOptions& = {}) = delete;
    explicit BallTracker(const Field&&, const TrackerOptions& = {}) = delete;

    /// One haptic update: the stylus is at `stylus` (world coordinates, metres). What `ProxyTracker` refuses is refused:
    /// status bad_input, state unchanged.
    [[nodiscard, gnu::noinline]] BallContact<Scalar> update(const vec3<Scalar>& stylus) noexcept;

    /// Between updates, in contact as well: a ball that grows is lifted until it is clear, one that shrinks sinks.
    constexpr void set_radius(Scalar radius) noexcept;
    [[nodiscard]] constexpr Scalar radius() const noexcept { return radius_; }
    /// The centre of the ball in world coordinates, metres: the proxy before it is rounded to the scalar.
    [[nodiscard]] constexpr const glm::dvec3& centre() const noexcept { return state_.centre; }

    /// Forgets the stylus: the next position is taken as the first one.
    constexpr void reset() noexcept {
        state_ = {};
        point_.reset();
    }
    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept {
        state_ = state;
        point_.restore(state.point);
        if (state.point.phase == Phase::unseen) hand_to_point();
    }
    [[nodiscard]] constexpr const Field& field() const noexcept { return point_.field(); }

private:
    using Phase = TrackerPhase;
    using Slide = detail::BallSlide<Field>;

    [[nodiscard]] static constexpr Scalar valid_radius(Scalar radius) noexcept {
        return is_at_least_zero(radius) && is_height(radius) ? radius : Scalar(0);
    }
    /// The point's tracker goes on where the ball is.
    constexpr void hand_to_point() noexcept;
    /// How many patches and blocks an update may look at: at least what it takes to go one step.
    [[nodiscard]] Index work_allowed() const noexcept;
    /// How many steps the ball may go in contact in an update in which the stylus moved here.
    [[nodiscard]] int steps_allowed(const glm::dvec3& stylus) const noexcept;

    // The ways through an update.

    /// r = 0.
    [[nodiscard]] BallContact<Scalar> update_point(const vec3<Scalar>& stylus) noexcept;
    /// The first stylus, or still buried: whether the ball is clear here.
    [[nodiscard]] BallContact<Scalar> begin(const vec3<Scalar>& stylus) noexcept;
    /// A ball that stands on a point of the surface.
    struct Standing {
        SurfacePoint<Scalar> foot{};
        glm::dvec3 normal{0, 0, 1}; ///< unit, to the centre
        glm::dvec3 offset{0.0};     ///< centre − stylus
        glm::dvec3 centre{0.0};
    };
    [[nodiscard]] double longest_roll() const noexcept {
        return 2 * detail::widest_margin(field(), widen(radius_));
    }
    /// False where it cannot: at an edge under which the stylus is.
    [[nodiscard]] bool stand_on(const SurfacePoint<Scalar>& foot, const glm::dvec3& to,
                                Standing& ball) const noexcept;
    /// Rolls there, if nothing is in the way and it comes nearer to the stylus.
    [[nodiscard]] bool roll_to(const Standing& ball, const glm::dvec3& to, Index& work) noexcept;
    /// Whether a ball that rolls to a minimum seems to pass no other on its way, as far as its ends tell.
    [[nodiscard]] bool is_first_minimum(const Standing& ball, const glm::dvec3& to) const noexcept;
    /// How far a ball in contact goes about that the stylus leads to here, in metres.
    [[nodiscard]] double led_way(const glm::dvec3& to) const noexcept {
        return 1.25 * glm::distance(to, state_.stylus) + widen(radius_) / 16;
    }
    /// In contact: over to the foot of the stylus, if that is all there is to do: mostly it is. False if not; it may be on its
    /// way then.
    [[nodiscard]] bool roll(const vec3<Scalar>& stylus, Index& work, BallContact<Scalar>& contact) noexcept;
    /// Step by step, whatever is in the way.
    [[nodiscard, gnu::noinline]] BallContact<Scalar> follow(const vec3<Scalar>& stylus, Index& work) noexcept;

    // How it ends.

    [[nodiscard]] BallContact<Scalar> without_contact(ContactStatus status,
                                                      const vec3<Scalar>& stylus) const noexcept;
    /// The ball is where the stylus is.
    [[nodiscard]] BallContact<Scalar> set_free(const vec3<Scalar>& stylus) noexcept;
    /// Which rim a ball that touched in this cell last has left at.
    [[nodiscard]] ContactStatus rim_status(Cell cell) const noexcept;
    /// The ball has got round a rim.
    [[nodiscard]] BallContact<Scalar> leave_at_rim(const vec3<Scalar>& stylus) noexcept;
    /// Work or steps are used up: the ball goes on from here in the next update.
    [[nodiscard]] BallContact<Scalar> go_on_later(const vec3<Scalar>& stylus, const Slide& slide) noexcept;
    /// Held where the slide has come to.
    [[nodiscard]] BallContact<Scalar> make_contact(const Slide& slide, ContactStatus status) noexcept;

    ProxyTracker<Field> point_;
    TrackerOptions options_;
    Scalar radius_;
    State state_{};
};

template <HeightField Field>
Index BallTracker<Field>::work_allowed() const noexcept {
    const double radius = widen(radius_);
    const double wide = radius + detail::widest_margin(field(), radius);
    const glm::dvec2 cells = 2 * wide * field().lattice().cells_per_metre() + 3.0;
    const double least = 8 * glm::min(cells.x * cells.y, 2.5e8); // an Index of 32 bits holds it
    return glm::max(static_cast<Index>(options_.max_patches), static_cast<Index>(least));
}

template <HeightField Field>
int BallTracker<Field>::steps_allowed(const glm::dvec3& stylus) const noexcept {
    constexpr int most = 4096;
    if (options_.max_contact_patches >= options_.max_patches) return most;
    const glm::dvec3 way = stylus - state_.stylus;
    const glm::dvec2 per_metre = field().lattice().cells_per_metre();
    const double cells = glm::max(std::abs(way.x) * per_metre.x, std::abs(way.y) * per_metre.y);
    return static_cast<int>(
        glm::min(glm::max(options_.max_contact_patches, 1) + 2 * cells, static_cast<double>(most)));
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
    state_ = {.centre = point.touching() ? widen(contact.proxy) : point.swept_to(),
              .stylus = widen(stylus),
              .foot = point.proxy,
              .side = point.side,
              .phase = point.phase,
              .point = point};
    if (contact.touching()) {
        contact.centre = state_.centre;
        contact.touches[0] = {contact.point, contact.normal, contact.depth};
        contact.count = 1;
    }
    return contact;
}

template <HeightField Field>
constexpr void BallTracker<Field>::set_radius(Scalar radius) noexcept {
    const bool was_point = !(radius_ > 0);
    radius_ = valid_radius(radius);
    if (radius_ > 0) state_.point = {};
    if (!was_point && !(radius_ > 0)) hand_to_point();
}

template <HeightField Field>
constexpr void BallTracker<Field>::hand_to_point() noexcept {
    TrackerState<Scalar> point;
    if (!state_.is_buried && state_.phase != Phase::unseen) {
        const bool touching = state_.touching();
        point.stylus = touching ? state_.stylus : state_.centre;
        point.proxy = state_.foot;
        point.side = state_.side;
        point.phase = touching ? Phase::contact : Phase::free;
    }
    point_.restore(point);
}

template <HeightField Field>
auto BallTracker<Field>::begin(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    const glm::dvec3 to = widen(stylus);
    detail::BallObstacles<Field> around{field()};
    Index work = work_allowed();
    const bool clear = around.look(to, widen(radius_), 0, work) && around.smallest_gap() >= 0;
    const Side side = detail::side_of(field(), to);
    const bool below = side == Side::below && options_.surface == SurfaceKind::solid;
    state_ = {.centre = to, .stylus = to, .side = side, .phase = Phase::free, .is_buried = below || !clear};
    return without_contact(state_.is_buried     ? ContactStatus::buried
                           : side == Side::none ? ContactStatus::off_surface
                                                : ContactStatus::free,
                           stylus);
}

template <HeightField Field>
bool BallTracker<Field>::stand_on(const SurfacePoint<Scalar>& foot, const glm::dvec3& to,
                                  Standing& ball) const noexcept {
    const detail::ReachSearch<Field> from_stylus{field(), to, 0, 0};
    detail::RelativePatch patch;
    if (!from_stylus.read(foot.cell, patch)) return false;
    const double u = widen(foot.u), v = widen(foot.v), radius = widen(radius_);
    const glm::dvec3 to_foot = patch.foot(u, v).offset, upward = patch.patch().normal(u, v);
    glm::dvec3 normal = state_.side == Side::below ? -upward : upward;
    const auto is_inside = [](double w) { return w > 1e-9 && w < 1 - 1e-9; };
    if (!is_inside(u) || !is_inside(v)) {
        // A ridge, with the stylus over it. Where the stylus lies on it the direction is lost in rounding.
        const double distance = glm::length(to_foot);
        if (!(glm::dot(to_foot, normal) < 0 && distance > radius / 256)) return false;
        normal = -to_foot / distance;
        if (state_.side == Side::below ? normal.z > 0 : normal.z < 0) return false;
    }
    const glm::dvec3 offset = to_foot + radius * normal;
    ball = {foot, normal, offset, to + offset};
    return true;
}

template <HeightField Field>
bool BallTracker<Field>::roll_to(const Standing& ball, const glm::dvec3& to, Index& work) noexcept {
    // Never farther, and no farther on the way than a look around its end tells about.
    const glm::dvec3 before = state_.centre - to, way = ball.centre - state_.centre;
    const double radius = widen(radius_);
    const bool farther =
        glm::dot(ball.offset, ball.offset) > glm::dot(before, before) * (1 + 4 * epsilon<double>);
    if (farther || !(glm::length(way) <= longest_roll())) return false;
    const detail::RollingBall<> rolling{-way, ball.normal, -ball.offset, radius,
                                        detail::ball_rounding(ball.centre, radius)};
    if (!detail::rolls_freely(field(), ball.centre, rolling, work)) return false;
    state_.centre = ball.centre;
    state_.foot = ball.foot;
    return true;
}

template <HeightField Field>
bool BallTracker<Field>::is_first_minimum(const Standing& ball, const glm::dvec3& to) const noexcept {
    // From the slope at the start the fall lets off towards a minimum. Where it has grown instead, or the ball has dived over an
    // edge, it may have come out of another minimum on the way.
    constexpr double steepest_dive = 0.2, short_way = 1.0 / 16;
    const glm::dvec3 way = ball.centre - state_.centre, before = state_.centre - to;
    const double radius = widen(radius_), length = glm::length(way);
    if (length <= short_way * radius) return true;
    const detail::ReachSearch<Field> from_centre{field(), state_.centre, 0, 0};
    detail::RelativePatch patch;
    if (!from_centre.read(state_.foot.cell, patch)) return false;
    const glm::dvec3 normal = -patch.foot(widen(state_.foot.u), widen(state_.foot.v)).offset / radius;
    const double rise = glm::dot(way, normal);
    if (rise < -steepest_dive * length) return false;
    const glm::dvec3 along = way - rise * normal;
    const double fall = (glm::dot(before, before) - glm::dot(ball.offset, ball.offset)) / 2;
    return fall * glm::length(along) <= -length * glm::dot(before, along);
}

template <HeightField Field>
bool BallTracker<Field>::roll(const vec3<Scalar>& stylus, Index& work,
                              BallContact<Scalar>& contact) noexcept {
    const glm::dvec3 to = widen(stylus);
    const auto found = descend(field(), stylus, state_.foot, options_.max_patches);
    work -= found.patches;
    Standing ball;
    if (found.status != DescentStatus::minimum || !stand_on(found.point, to, ball)) return false;
    const double share = glm::dot(ball.offset, ball.normal);
    // On faces so steep that the scalar does not tell the foot to half its digits the slide computes in double.
    const glm::dvec3 across = ball.offset - share * ball.normal;
    const double allowed = widen(epsilon<Scalar>) * glm::dot(ball.offset, ball.offset);
    if (!(share > 0) || glm::dot(across, across) > allowed) return false;
    // Farther than the ball is led there is another minimum on the way, mostly.
    if (glm::distance(ball.centre, state_.centre) > led_way(to)) return false;
    // A long way in parts, along that of the foot.
    for (int parts = steps_allowed(to); glm::distance(ball.centre, state_.centre) > longest_roll();) {
        const auto part = detail::descend_no_farther(field(), stylus, state_.foot, options_.max_patches,
                                                     static_cast<Scalar>(longest_roll() * 0.75));
        work -= part.patches;
        Standing on_the_way;
        if (--parts < 0 || !stand_on(part.point, to, on_the_way) || !roll_to(on_the_way, to, work))
            return false;
    }
    if (!is_first_minimum(ball, to) || !roll_to(ball, to, work)) return false;
    state_.stylus = to;
    const double depth = glm::length(ball.offset);
    contact.status = ContactStatus::contact;
    contact.side = state_.side;
    contact.radius = radius_;
    contact.centre = ball.centre;
    contact.proxy = vec3<Scalar>{ball.centre};
    contact.normal = vec3<Scalar>{depth > 0 ? ball.offset / depth : ball.normal};
    contact.penetration = vec3<Scalar>{ball.offset};
    contact.depth = static_cast<Scalar>(depth);
    contact.point = ball.foot;
    contact.touches[0] = {ball.foot, vec3<Scalar>{ball.normal}, static_cast<Scalar>(share)};
    contact.count = 1;
    return true;
}

template <HeightField Field>
auto BallTracker<Field>::follow(const vec3<Scalar>& stylus, Index& work) noexcept -> BallContact<Scalar> {
    const glm::dvec3 to = widen(stylus);
    const double radius = widen(radius_), widest = detail::widest_margin(field(), radius);
    const int max_steps = steps_allowed(to);
    const bool was_touching = state_.touching();
    const double expected = was_touching ? led_way(to) : widest;
    // A ball that is led slowly is to stop at the first minimum on its way, which a longer step may pass.
    const double stride =
        was_touching ? glm::clamp(glm::distance(to, state_.stylus) / 2, widest / 16, widest) : widest;
    state_.stylus = to;
    Slide slide{field(), {radius, options_.surface, state_.side, stride}, state_.centre, work};
    const auto look = [&] {
        return slide.look(glm::min(glm::min(stride, expected), glm::distance(to, slide.centre())));
    };
    auto end = detail::BallSlideEnd::step_limit;
    bool looked = look(), lifted = false;
    if (looked && slide.overlaps()) looked = lifted = slide.lift() && look();
    if (looked) end = slide.run(to, was_touching || lifted, max_steps);
    work = slide.work_left();
    switch (end) {
    case detail::BallSlideEnd::minimum: return make_contact(slide, ContactStatus::contact);
    case detail::BallSlideEnd::at_target: return set_free(stylus);
    case detail::BallSlideEnd::off_rim: return leave_at_rim(stylus);
    case detail::BallSlideEnd::step_limit: break;
    }
    return go_on_later(stylus, slide);
}

template <HeightField Field>
auto BallTracker<Field>::without_contact(ContactStatus status, const vec3<Scalar>& stylus) const noexcept
    -> BallContact<Scalar> {
    BallContact<Scalar> contact;
    contact.status = status;
    contact.side = state_.side;
    contact.proxy = stylus;
    contact.radius = radius_;
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::set_free(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    const glm::dvec3 to = widen(stylus);
    const Side side = detail::side_of(field(), to);
    if (side == Side::below && options_.surface == SurfaceKind::solid) return leave_at_rim(stylus);
    // Beside the surface, lower than where it touched: it has slid off.
    const auto foot = detail::height_at(field(), state_.foot);
    const bool slid_off = state_.touching() && side == Side::none && foot && to.z < *foot;
    const ContactStatus status = slid_off             ? rim_status(state_.foot.cell)
                                 : side == Side::none ? ContactStatus::off_surface
                                                      : ContactStatus::free;
    state_ = {.centre = to, .stylus = to, .side = side, .phase = Phase::free};
    return without_contact(status, stylus);
}

template <HeightField Field>
ContactStatus BallTracker<Field>::rim_status(Cell cell) const noexcept {
    const CellRange cells = field().cells();
    const bool inside = cells.begin.i < cell.i && cell.i + 1 < cells.end.i && cells.begin.j < cell.j &&
                        cell.j + 1 < cells.end.j;
    return inside ? ContactStatus::left_at_hole : ContactStatus::left_at_border;
}

template <HeightField Field>
auto BallTracker<Field>::leave_at_rim(const vec3<Scalar>& stylus) noexcept -> BallContact<Scalar> {
    const bool was_touching = state_.touching();
    const Cell cell = state_.foot.cell;
    auto contact = begin(stylus);
    if (was_touching) contact.status = rim_status(cell);
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::go_on_later(const vec3<Scalar>& stylus, const Slide& slide) noexcept
    -> BallContact<Scalar> {
    if (!slide.touched() && !state_.touching()) {
        state_.centre = slide.centre();
        state_.phase = Phase::searching;
        return without_contact(ContactStatus::sweep_limit, stylus);
    }
    if (slide.is_on_rims_alone() && slide.centre().z < state_.stylus.z) return leave_at_rim(stylus);
    auto contact = make_contact(slide, ContactStatus::descent_limit);
    state_.phase = Phase::sliding;
    // A stylus at which the ball is clear is not pulled back to the surface.
    detail::BallObstacles<Field> there{field()};
    Index work = std::numeric_limits<Index>::max();
    const Side side = detail::side_of(field(), state_.stylus);
    const bool covered = side != Side::none && side != state_.side;
    if (!covered && there.look(state_.stylus, widen(radius_), 0, work) && there.smallest_gap() >= 0) {
        contact.penetration = vec3<Scalar>{Scalar(0)};
        contact.depth = 0;
        contact.count = 0;
    }
    return contact;
}

template <HeightField Field>
auto BallTracker<Field>::make_contact(const Slide& slide, ContactStatus status) noexcept
    -> BallContact<Scalar> {
    const glm::dvec3 penetration = slide.centre() - state_.stylus;
    const double depth = glm::length(penetration);
    BallContact<Scalar> contact;
    state_.side = slide.side();
    contact.status = status;
    contact.side = state_.side;
    contact.radius = radius_;
    contact.point = state_.foot;
    detail::list_touches(slide, contact);
    contact.penetration = vec3<Scalar>{penetration};
    contact.depth = static_cast<Scalar>(depth);
    if (depth > 0) contact.normal = vec3<Scalar>{penetration / depth};
    state_.foot = contact.point;
    state_.centre = slide.centre();
    state_.phase = Phase::contact;
    return contact;
}

} // namespace hfh

#endif // HFH_CONTACT_BALL_TRACKER_HPP
