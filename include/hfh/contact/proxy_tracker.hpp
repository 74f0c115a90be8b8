#ifndef HFH_CONTACT_PROXY_TRACKER_HPP
#define HFH_CONTACT_PROXY_TRACKER_HPP

#include <hfh/contact/contact.hpp>
#include <hfh/traversal/descent.hpp>
#include <hfh/traversal/first_hit.hpp>

#include <glm/geometric.hpp>

#include <type_traits>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.2-4.3.3; the proxy is that of Ruspini, Kolarov and
// Khatib (1997) and the god-object of Zilles and Salisbury (1995).

namespace hfh {

struct TrackerOptions {
    SurfaceKind surface = SurfaceKind::solid;
    /// Work allowed in one update, in patches; at least 1. A search or a descent that needs more goes
    /// on in the next update, from where it came to towards wherever the stylus is then, and the status says so.
    int max_patches = 8192;
    /// Of these, what a proxy may slide over in an update in contact: so many, and two more for each cell that the stylus
    /// moved. A ridge or a hollow can hold a proxy hundreds of cells away from a stylus that goes on below it. When that
    /// minimum ends, the proxy slides all of that way in one update, and the force jumps. With 8 here it glides there in
    /// some updates, and the force with it; on steep ground some updates then end on the way (`descent_limit`). The search
    /// that decides whether a stylus with the surface over it is free is no part of the slide: `max_patches` alone limits it.
    int max_contact_patches = 8192;
};

/// What a tracker is doing. From `contact` on the stylus is in contact.
enum class TrackerPhase : unsigned char {
    unseen,    ///< no stylus position has been seen
    free,      ///< the surface has been searched up to the stylus
    searching, ///< free, but the search has not got to the stylus
    contact,   ///< the proxy is at a minimum, which holds the stylus
    sliding, ///< in contact, and the proxy is on its way; or it rests at a minimum that was released, for none is nearer
    releasing ///< in contact, the proxy at a released minimum: the way to the stylus is searched, and not to its end yet
};

/// Everything a tracker remembers: a trivially copyable value, to be saved, restored or sent to another thread.
///
/// A minimum *holds* a stylus that is inside of the face there. One that does not is *released*: the way from it to the
/// stylus is searched for another face.
///
/// F is what the lattice of the field computes in.
template <Real T, Real F = double>
struct TrackerState {
    vec3<F> stylus{F(0)}; ///< of the last update
    /// Searching and releasing: where the search to the stylus began.
    vec3<F> search_from{F(0)};
    F searched{}; ///< searching and releasing: how much of the way from there to the stylus has been searched, from 0 to 1
    SurfacePoint<T> proxy{}; ///< in contact: the proxy; searching, if `after_release`: the released minimum
    DescentProgress<T> progress{}; ///< sliding: of the descent to this stylus
    /// |proxy − stylus|² in m² at the released minimum: releasing, and sliding and searching if `after_release`.
    T released_squared{};
    Side side = Side::none;        ///< in contact: the side that is felt; free: the side the stylus is on
    Side search_side = Side::none; ///< releasing: the side on which the search is
    TrackerPhase phase = TrackerPhase::unseen;
    /// Sliding and searching: a minimum that did not hold this stylus was released on the way here.
    bool after_release = false;
    /// Sliding, if `after_release`: the segment from that minimum to the stylus crosses the surface within rounding of its
    /// start.
    bool reenters_at_once = false;
    /// Releasing and searching: the search has not got off the surface at the released minimum yet.
    bool leaving = false;

    [[nodiscard]] constexpr bool touching() const noexcept { return phase >= TrackerPhase::contact; }
    /// Up to where the surface has been searched: the stylus, or a place on the way to it.
    [[nodiscard]] vec3<F> swept_to() const noexcept {
        const bool on_the_way = phase == TrackerPhase::searching || phase == TrackerPhase::releasing;
        return on_the_way ? point_on_segment(search_from, stylus, searched) : stylus;
    }
};

namespace detail {

/// Whether a stylus in contact has the surface right above it (felt from below: right below it), by more than rounding. Asked
/// while the proxy is on its way: the surface at the proxy is then too far from the stylus to decide that.
template <HeightField Field>
[[nodiscard, gnu::noinline]] bool
has_surface_over(const Field& field, const vec3<typename Field::Scalar>& stylus, Side felt) noexcept {
    using Scalar = typename Field::Scalar;
    using F = FrameScalar<Field>;
    const BasicLattice<F>& lattice = field.lattice();
    const vec3<F> at = widen_to<F>(stylus);
    const F u = lattice.u_of(at.x, 0), v = lattice.v_of(at.y, 0);
    // On a grid line, but for the rounding of u and v, cells on both sides are over it; beside a hole one of them has no patch.
    const auto rounding_of = [](F w) { return 4 * epsilon<F> * (1 + std::abs(w)); };
    const auto cell_of = [](F column, F row) {
        return Cell{static_cast<Index>(std::floor(column)), static_cast<Index>(std::floor(row))};
    };
    const Cell first = cell_of(u - rounding_of(u), v - rounding_of(v)),
               last = cell_of(u + rounding_of(u), v + rounding_of(v));
    for (Index j = first.j; j <= last.j; ++j) {
        for (Index i = first.i; i <= last.i; ++i) {
            const auto found = field.patch({i, j});
            if (!found) continue;
            const BilinearPatch<F> p = widen_to<F>(*found);
            const F above = p.height(lattice.u_of(at.x, i), lattice.v_of(at.y, j)) - at.z;
            // Of the height here, and of the offset from which the depth comes out in the end.
            const F rounding =
                8 * epsilon<F> * (std::abs(p.highest()) + std::abs(p.lowest()) + std::abs(at.z)) +
                8 * widen_to<F>(epsilon<Scalar>) * (p.highest() - p.lowest() + std::abs(above));
            if (felt == Side::below ? above < -rounding : above > rounding) return true;
        }
    }
    return false;
}

} // namespace detail

/// Follows a stylus over a height field: the haptic update of §4.3 [P].
///
/// *Free*: the segment from the last stylus position to this one is cast; the first crossing is the first contact.
/// *In contact*: the proxy slides downhill from where it was to the local closest point. While the stylus is inside
/// (proxy − stylus points out of the surface) the contact holds. When it is not, the segment proxy → stylus is cast before
/// the proxy is released, for the stylus can have left one face and be below another already; a crossing on it is a new
/// contact in the same update (the paper releases at once). Slide and search may take more than one update
/// (`TrackerOptions`): the contact holds until they have come to an end, and is felt while the stylus has the surface over
/// it, or is inside of the face that the proxy is on.
///
/// On a solid without holes, for a stylus that was outside once and stays over the grid: never free while below the
/// surface, and once in contact felt in every update in which it is below, whatever the options are. With status
/// `contact` no patch at the proxy has a descent direction. A stylus that starts below the surface, or comes in below it
/// from the side, feels nothing until it has been outside. Edited heights are felt at the next update. `update` is
/// noexcept, allocates nothing and looks at no more than `max_patches` + 16 patches, but for those at the proxy and over
/// the stylus, at which it looks once more. At rest the proxy arrives: with the same stylus again and again the updates
/// come to do the same, to the bit.
///
/// Keeps a pointer to the field, which must outlive it.
template <HeightField Field>
class ProxyTracker {
public:
    using Scalar = typename Field::Scalar;
    using State = TrackerState<Scalar, FrameScalar<Field>>;
    static_assert(std::is_trivially_copyable_v<State> || !std::is_trivially_copyable_v<vec3<Scalar>>,
                  "a tracker's state can be copied like plain bytes where GLM's vectors can");

    constexpr explicit ProxyTracker(const Field& field, const TrackerOptions& options = {}) noexcept
        : field_{&field}, options_{options} {}
    explicit ProxyTracker(const Field&&,
                          const TrackerOptions& = {}) = delete; // the field must outlive the tracker

    /// One haptic update: the stylus is at `stylus` (world coordinates, metres). NaN, infinity and positions beyond
    /// the reach of cell numbers or of the scalar's squares are refused: status bad_input, state unchanged.
    ///
    /// Not inlined: beside an update a call is nothing, and the code is large.
    [[nodiscard, gnu::noinline]] Contact<Scalar> update(const vec3<Scalar>& stylus) noexcept;

    /// Forgets the stylus: the next position is taken as the first one.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }
    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }

private:
    using Phase = TrackerPhase;
    using F = FrameScalar<Field>;
    using Place = vec3<F>; ///< a position, in what places are computed in
    using Hit = HitOn<Field>;

    /// What an update has done and may still do.
    struct Work {
        int patches;        ///< looked at so far
        int slide;          ///< over how many the proxy may still slide
        bool after_release; ///< a minimum that does not hold this stylus was released on the way here
    };

    // The ways through an update, in the order in which it takes them.

    /// Free, with something in the way, or near it. Not inlined, so that an update that meets nothing needs no stack.
    [[nodiscard, gnu::noinline]] Contact<Scalar> search(const vec3<Scalar>& stylus) noexcept;
    /// In contact: slides the proxy, as far as is allowed for the way from the last stylus to this one. `patches` were looked
    /// at before. Mostly it comes to a minimum that holds the stylus.
    [[nodiscard, gnu::noinline]] Contact<Scalar> update_contact(const vec3<Scalar>& stylus,
                                                                int patches) noexcept;
    /// In contact, with something left to do from the last update.
    [[nodiscard, gnu::noinline]] Contact<Scalar> resume_contact(const vec3<Scalar>& stylus) noexcept;
    /// Slides the proxy, and goes on as `finish_slide` does.
    [[nodiscard]] Contact<Scalar> slide(const vec3<Scalar>& stylus, DescentProgress<Scalar> progress,
                                        Work work) noexcept;
    /// Goes on where a slide has come to `found` and not to a minimum that holds the stylus: keeps the contact for now,
    /// slides over another face that is between the proxy and the stylus, or ends the contact. Each minimum that is released
    /// is nearer to the stylus than the one before, but for rounding.
    [[nodiscard, gnu::noinline]] Contact<Scalar> finish_slide(const vec3<Scalar>& stylus,
                                                              DescentResult<Scalar> found,
                                                              DescentProgress<Scalar> progress,
                                                              Work work) noexcept;

    // What they do: each cast returns what it found, and these write it down.

    /// From where a search to a stylus sets out, and where on the way it begins. One that was cut short goes on as if it had
    /// not been, if the stylus is where it was.
    struct Way {
        Place from, to;
        F begin_at;
    };
    [[nodiscard]] Way way_to(const vec3<Scalar>& stylus) const noexcept;
    [[nodiscard]] Hit cast(const Way& way, BasicFirstHitOptions<F> options, int max_cells) const noexcept;
    /// Casts on from a minimum that does not hold the stylus, which the proxy is at. Counts the cells to `work`; remembers
    /// how far it came if it was cut short.
    [[nodiscard, gnu::noinline]] Hit search_beyond(const vec3<Scalar>& stylus, int max_cells,
                                                   Work& work) noexcept;
    /// Within how many metres of the surface a search from a released minimum lies on it, until it has got off; < 0: it has.
    [[nodiscard]] F leaves_within(const vec3<Scalar>& stylus) const noexcept;
    /// `found` does not hold the stylus: the way from there is searched from now on.
    void release(const vec3<Scalar>& stylus, const DescentResult<Scalar>& found) noexcept;
    /// The proxy is on the face that was hit.
    void enter_face(const Hit& hit, Phase phase) noexcept;
    /// After a search from a released minimum that came to no other face: free, or, if it was cut short and the stylus has the
    /// surface over it, still in contact, unless there is no patch at that minimum any more. Inlined, so that what GCC 12 makes of an update does not depend on what else was
    /// included before.
    [[nodiscard, HFH_ALWAYS_INLINED]] Contact<Scalar> end_release(const vec3<Scalar>& stylus, const Hit& hit,
                                                                  const DescentResult<Scalar>& found,
                                                                  int patches) noexcept;
    /// The search was cut short: remembers how far it came.
    void stop_search(const Way& way, const Hit& hit) noexcept;
    /// Free so far: goes on with the search at the next update.
    [[nodiscard]] Contact<Scalar> keep_searching(Side side, const vec3<Scalar>& stylus, int patches) noexcept;
    /// Free: the surface has been searched up to the stylus, which is on this side.
    [[nodiscard]] Contact<Scalar> set_free(Side side, const vec3<Scalar>& stylus, int patches) noexcept;
    /// The proxy has slid off a rim: the stylus is wherever it is.
    [[nodiscard]] Contact<Scalar> release_at_rim(const vec3<Scalar>& stylus, DescentStatus rim,
                                                 int patches) noexcept;

    // What they ask.

    /// Whether the stylus is inside of the face at the point that was found.
    [[nodiscard]] bool holds(const DescentResult<Scalar>& found) const noexcept;
    [[nodiscard]] bool has_surface_over(const vec3<Scalar>& stylus) const noexcept {
        return detail::has_surface_over(*field_, stylus, state_.side);
    }
    /// Whether the point that was found is as far from the stylus as the minimum that was released, but for rounding.
    [[nodiscard]] bool is_as_far_as_released(const DescentResult<Scalar>& found) const noexcept;
    /// Where the proxy is, seen from this stylus.
    [[nodiscard]] DescentResult<Scalar> look_at_proxy(const vec3<Scalar>& stylus) const noexcept {
        return descend(*field_, stylus, state_.proxy, 0);
    }
    [[nodiscard]] int work_allowed() const noexcept { return glm::max(options_.max_patches, 1); }
    [[nodiscard]] int slide_allowed(const Work& work) const noexcept {
        return glm::min(work.slide, work_allowed() - work.patches);
    }
    /// Over how many patches the proxy may slide in an update in which the stylus moved here from `before`.
    [[nodiscard]] int slide_allowance(const Place& before, const vec3<Scalar>& stylus) const noexcept;
    /// A bound of how far rounding may leave a proxy off the surface, in metres: some ulps of the lengths that its offset
    /// from the stylus is made of.
    [[nodiscard]] static Scalar rounding_bound(const vec3<Scalar>& offset,
                                               const BilinearPatch<Scalar>& patch) noexcept;
    [[nodiscard]] Scalar rounding_bound(const DescentResult<Scalar>& found) const noexcept;

    /// In contact at `found`. Not `felt`: a stylus that is outside is not pulled back to the surface.
    [[nodiscard, HFH_ALWAYS_INLINED]] Contact<Scalar> make_contact(const vec3<Scalar>& stylus,
                                                                   const DescentResult<Scalar>& found,
                                                                   ContactStatus status, bool felt,
                                                                   int patches) const noexcept;
    [[nodiscard]] Contact<Scalar> without_contact(ContactStatus status, const vec3<Scalar>& stylus,
                                                  int patches) const noexcept {
        return {.status = status, .side = state_.side, .patches = patches, .proxy = stylus};
    }

    const Field* field_;
    TrackerOptions options_;
    State state_{};
};

template <HeightField Field>
auto ProxyTracker<Field>::update(const vec3<Scalar>& stylus) noexcept -> Contact<Scalar> {
    if (!is_finite(stylus) || !field_->lattice().reaches(stylus) || !is_height(stylus.z)) {
        return {.status = ContactStatus::bad_input};
    }
    if (state_.phase == Phase::contact) return update_contact(stylus, 0);
    if (state_.touching()) return resume_contact(stylus);
    if (state_.phase != Phase::free) return search(stylus);

    const Place to = detail::widen_to<F>(stylus);
    // What a search comes to nearly always.
    if (state_.side != Side::below && options_.max_patches >= 4) {
        if (const Index cells = detail::cells_below_short_segment(*field_, state_.stylus, to); cells > 0) {
            state_.side = Side::above;
            state_.stylus = to;
            return without_contact(ContactStatus::free, stylus, static_cast<int>(cells));
        }
    }
    return search(stylus);
}

template <HeightField Field>
auto ProxyTracker<Field>::search(const vec3<Scalar>& stylus) noexcept -> Contact<Scalar> {
    if (state_.phase == Phase::unseen) state_.stylus = detail::widen_to<F>(stylus);
    const Way way = way_to(stylus);
    const bool went_on = state_.phase == Phase::searching;
    state_.leaving = went_on && state_.leaving;
    const auto hit = cast(way, {.side = state_.side, .leaves_within = leaves_within(stylus)}, work_allowed());
    const int patches = static_cast<int>(hit.cells);
    if (hit.status == HitStatus::miss) return set_free(hit.side, stylus, patches);
    if (hit.status == HitStatus::cell_limit) {
        state_.after_release = went_on && state_.after_release;
        stop_search(way, hit);
        return keep_searching(hit.side, stylus, patches);
    }
    const bool after_release =
        went_on && state_.after_release && is_as_far_as_released(look_at_proxy(stylus));
    state_.reenters_at_once = false;
    enter_face(hit, Phase::contact);
    if (after_release) return slide(stylus, {}, {patches, slide_allowance(state_.stylus, stylus), true});
    return update_contact(stylus, patches);
}

template <HeightField Field>
auto ProxyTracker<Field>::update_contact(const vec3<Scalar>& stylus, int patches) noexcept
    -> Contact<Scalar> {
    const Work work{patches, slide_allowance(state_.stylus, stylus), false};
    state_.stylus = detail::widen_to<F>(stylus);
    DescentProgress<Scalar> progress;
    const auto found =
        detail::descend_inline(*field_, stylus, state_.proxy, glm::max(1, slide_allowed(work)), progress);
    if (found.status == DescentStatus::minimum && holds(found)) [[likely]] {
        state_.proxy = found.point;
        return make_contact(stylus, found, ContactStatus::contact, true, patches + found.patches);
    }
    return finish_slide(stylus, found, progress, work);
}

template <HeightField Field>
auto ProxyTracker<Field>::resume_contact(const vec3<Scalar>& stylus) noexcept -> Contact<Scalar> {
    if (state_.phase == Phase::sliding && detail::widen_to<F>(stylus) != state_.stylus) {
        state_.phase = Phase::contact;
        return update_contact(stylus, 0);
    }
    Work work{0, slide_allowance(state_.stylus, stylus), state_.after_release};
    if (state_.phase == Phase::sliding) return slide(stylus, state_.progress, work);

    const auto released = look_at_proxy(stylus);
    work.after_release = is_as_far_as_released(released); // else this is another stylus
    state_.reenters_at_once = false;
    const auto hit = search_beyond(stylus, work_allowed(), work);
    if (hit.status != HitStatus::hit) return end_release(stylus, hit, released, work.patches);
    enter_face(hit, Phase::sliding);
    return slide(stylus, {}, work);
}

template <HeightField Field>
auto ProxyTracker<Field>::slide(const vec3<Scalar>& stylus, DescentProgress<Scalar> progress,
                                Work work) noexcept -> Contact<Scalar> {
    const auto found = detail::descend_on(*field_, stylus, state_.proxy, slide_allowed(work), progress);
    return finish_slide(stylus, found, progress, work);
}

template <HeightField Field>
auto ProxyTracker<Field>::finish_slide(const vec3<Scalar>& stylus, DescentResult<Scalar> found,
                                       DescentProgress<Scalar> progress, Work work) noexcept
    -> Contact<Scalar> {
    for (;;) {
        work.patches += found.patches;
        work.slide -= found.patches;
        state_.proxy = found.point;
        state_.stylus = detail::widen_to<F>(stylus);
        // A user's own field may have heights that are none.
        const bool is_finite_there = is_finite(glm::dot(found.offset, found.offset));
        if (found.status == DescentStatus::off_border || found.status == DescentStatus::off_hole ||
            !is_finite_there) {
            return release_at_rim(stylus, found.status, work.patches);
        }
        const bool minimum = found.status == DescentStatus::minimum;
        if (minimum && holds(found)) {
            state_.phase = Phase::contact;
            return make_contact(stylus, found, ContactStatus::contact, true, work.patches);
        }
        // A minimum that is as far as the one released before: the same one, and there is no better. (It is never farther,
        // unless the ground was edited.)
        const bool arrived = minimum && work.after_release && is_as_far_as_released(found);
        if (!minimum || arrived) {
            state_.phase = Phase::sliding;
            state_.progress = minimum ? DescentProgress<Scalar>{} : progress;
            state_.after_release = work.after_release;
            const bool felt =
                holds(found) || (arrived && state_.reenters_at_once) || has_surface_over(stylus);
            return make_contact(stylus, found,
                                minimum ? ContactStatus::contact : ContactStatus::descent_limit, felt,
                                work.patches);
        }

        // Outside this face: free, unless another one lies between.
        release(stylus, found);
        work.after_release = true;
        auto hit = search_beyond(stylus, slide_allowed(work), work);
        // A stylus that has the surface over it is not free: it is searched for with all that is allowed.
        if (hit.status == HitStatus::cell_limit && work.patches < work_allowed() && has_surface_over(stylus))
            hit = search_beyond(stylus, work_allowed() - work.patches, work);
        if (hit.status != HitStatus::hit) return end_release(stylus, hit, found, work.patches);

        enter_face(hit, Phase::sliding);
        state_.reenters_at_once = hit.t * std::sqrt(detail::widen_to<F>(state_.released_squared)) <=
                                  detail::widen_to<F>(rounding_bound(found));
        progress = {};
        found = detail::descend_on(*field_, stylus, state_.proxy, slide_allowed(work), progress);
    }
}

template <HeightField Field>
auto ProxyTracker<Field>::way_to(const vec3<Scalar>& stylus) const noexcept -> Way {
    const Place to = detail::widen_to<F>(stylus);
    const bool on_the_way = state_.phase == Phase::searching || state_.phase == Phase::releasing;
    if (on_the_way && to == state_.stylus) return {state_.search_from, to, state_.searched};
    return {state_.swept_to(), to, 0};
}

template <HeightField Field>
auto ProxyTracker<Field>::cast(const Way& way, BasicFirstHitOptions<F> options, int max_cells) const noexcept
    -> Hit {
    options.surface = options_.surface;
    options.max_cells = max_cells;
    options.begin_at = way.begin_at;
    return detail::cast(*field_, way.from, way.to, options);
}

template <HeightField Field>
auto ProxyTracker<Field>::leaves_within(const vec3<Scalar>& stylus) const noexcept -> F {
    if (!state_.leaving) return -1;
    // The segment begins on the surface, as far as the proxy is on it.
    Scalar off_surface = 0;
    if (const auto patch = field_->patch(state_.proxy.cell)) {
        const SurfacePoint<Scalar>& at = state_.proxy;
        const CellPoint<Scalar> seen = field_->lattice().locate(stylus, at.cell);
        const vec3<Scalar> offset{patch->spacing.x * (at.u - seen.u), patch->spacing.y * (at.v - seen.v),
                                  DistanceFunction<Scalar>{*patch, seen}.gap(at.u, at.v)};
        off_surface = rounding_bound(offset, *patch);
    }
    return detail::widen_to<F>(off_surface) + 8 * epsilon<F> * std::abs(detail::widen_to<F>(stylus.z));
}

template <HeightField Field>
auto ProxyTracker<Field>::search_beyond(const vec3<Scalar>& stylus, int max_cells, Work& work) noexcept
    -> Hit {
    const Way way = way_to(stylus);
    const auto hit = cast(way, {.side = state_.search_side, .leaves_within = leaves_within(stylus)},
                          glm::max(1, max_cells));
    work.patches += static_cast<int>(hit.cells);
    if (hit.status == HitStatus::cell_limit) {
        stop_search(way, hit);
        state_.search_side = hit.side;
    }
    return hit;
}

template <HeightField Field>
void ProxyTracker<Field>::release(const vec3<Scalar>& stylus, const DescentResult<Scalar>& found) noexcept {
    state_.phase = Phase::releasing;
    // In its own cell, however it is rounded: from a rim a search would begin beside the surface.
    const BasicLattice<F>& lattice = field_->lattice();
    const vec2<F> origin = lattice.origin(), spacing = lattice.spacing(),
                  per_metre = lattice.cells_per_metre();
    Place from = detail::widen_to<F>(stylus) + detail::widen_to<F>(found.offset);
    from.x = detail::into_cell(from.x, found.point.cell.i, origin.x, spacing.x, per_metre.x);
    from.y = detail::into_cell(from.y, found.point.cell.j, origin.y, spacing.y, per_metre.y);
    state_.search_from = from;
    state_.searched = 0;
    state_.search_side = state_.side;
    state_.released_squared = glm::dot(found.offset, found.offset);
    state_.after_release = true;
    state_.leaving = true;
}

template <HeightField Field>
void ProxyTracker<Field>::enter_face(const Hit& hit, Phase phase) noexcept {
    state_.phase = phase;
    state_.side = hit.side;
    state_.proxy = hit.point;
}

template <HeightField Field>
inline auto ProxyTracker<Field>::end_release(const vec3<Scalar>& stylus, const Hit& hit,
                                             const DescentResult<Scalar>& found, int patches) noexcept
    -> Contact<Scalar> {
    if (hit.status == HitStatus::miss) return set_free(hit.side, stylus, patches);
    const bool edited_away = found.status == DescentStatus::off_hole;
    if (edited_away || !has_surface_over(stylus)) return keep_searching(hit.side, stylus, patches);
    return make_contact(stylus, found, ContactStatus::descent_limit, true, patches);
}

template <HeightField Field>
void ProxyTracker<Field>::stop_search(const Way& way, const Hit& hit) noexcept {
    state_.search_from = way.from;
    state_.stylus = way.to;
    state_.searched = hit.t;
    state_.leaving = hit.leaving;
}

template <HeightField Field>
auto ProxyTracker<Field>::keep_searching(Side side, const vec3<Scalar>& stylus, int patches) noexcept
    -> Contact<Scalar> {
    state_.phase = Phase::searching;
    state_.side = side;
    return without_contact(ContactStatus::sweep_limit, stylus, patches);
}

template <HeightField Field>
auto ProxyTracker<Field>::set_free(Side side, const vec3<Scalar>& stylus, int patches) noexcept
    -> Contact<Scalar> {
    state_.phase = Phase::free;
    state_.side = side;
    state_.stylus = detail::widen_to<F>(stylus);
    const bool buried = side == Side::below && options_.surface == SurfaceKind::solid;
    return without_contact(side == Side::none ? ContactStatus::off_surface
                           : buried           ? ContactStatus::buried
                                              : ContactStatus::free,
                           stylus, patches);
}

template <HeightField Field>
auto ProxyTracker<Field>::release_at_rim(const vec3<Scalar>& stylus, DescentStatus rim, int patches) noexcept
    -> Contact<Scalar> {
    const Place here = detail::widen_to<F>(stylus);
    const auto hit = cast({here, here, 0}, {}, 1); // for the side that the stylus is on
    Contact<Scalar> left = set_free(hit.side, stylus, patches + static_cast<int>(hit.cells));
    left.status =
        rim == DescentStatus::off_border ? ContactStatus::left_at_border : ContactStatus::left_at_hole;
    return left;
}

template <HeightField Field>
bool ProxyTracker<Field>::holds(const DescentResult<Scalar>& found) const noexcept {
    return state_.side == Side::below ? found.signed_depth < 0 : found.signed_depth > 0;
}

template <HeightField Field>
bool ProxyTracker<Field>::is_as_far_as_released(const DescentResult<Scalar>& found) const noexcept {
    if (found.status == DescentStatus::off_hole) return false; // edited away
    // A stylus on the surface is as far from it as u and v are rounded.
    const vec2<F> spacing = field_->lattice().spacing();
    const Scalar rounding =
        rounding_bound(found) + 8 * epsilon<Scalar> * static_cast<Scalar>(spacing.x + spacing.y);
    const auto nearer = [rounding](Scalar one, Scalar other) {
        return one < other - rounding * (2 * std::sqrt(other) + rounding);
    };
    const Scalar squared = glm::dot(found.offset, found.offset);
    return !nearer(squared, state_.released_squared) && !nearer(state_.released_squared, squared);
}

template <HeightField Field>
int ProxyTracker<Field>::slide_allowance(const Place& before, const vec3<Scalar>& stylus) const noexcept {
    if (options_.max_contact_patches >= work_allowed()) return work_allowed();
    const Place way = detail::widen_to<F>(stylus) - before;
    const vec2<F> per_metre = field_->lattice().cells_per_metre();
    const F cells = glm::max(std::abs(way.x) * per_metre.x, std::abs(way.y) * per_metre.y);
    return static_cast<int>(glm::min(static_cast<F>(glm::max(options_.max_contact_patches, 1)) + 2 * cells,
                                     static_cast<F>(work_allowed())));
}

template <HeightField Field>
auto ProxyTracker<Field>::rounding_bound(const vec3<Scalar>& offset,
                                         const BilinearPatch<Scalar>& patch) noexcept -> Scalar {
    const Scalar size = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
    return 8 * epsilon<Scalar> * (size + 2 * (patch.highest() - patch.lowest()));
}

template <HeightField Field>
auto ProxyTracker<Field>::rounding_bound(const DescentResult<Scalar>& found) const noexcept -> Scalar {
    const auto patch = field_->patch(found.point.cell);
    return patch ? rounding_bound(found.offset, *patch) : Scalar(0);
}

// A contact is made in one piece: one that is filled in bit by bit is cleared first by GCC.
template <HeightField Field>
inline auto ProxyTracker<Field>::make_contact(const vec3<Scalar>& stylus, const DescentResult<Scalar>& found,
                                              ContactStatus status, bool felt, int patches) const noexcept
    -> Contact<Scalar> {
    const vec3<Scalar> penetration = felt ? found.offset : vec3<Scalar>{0};
    return {
        .status = status,
        .side = state_.side,
        .patches = patches,
        // Not as a sum of vectors: with GLM's GCC 12 would make of it what depends on what else was included.
        .proxy = {stylus.x + found.offset.x, stylus.y + found.offset.y, stylus.z + found.offset.z},
        .normal = state_.side == Side::below ? -found.normal : found.normal,
        .penetration = penetration,
        .depth = glm::length(penetration),
        .point = found.point};
}

} // namespace hfh

#endif // HFH_CONTACT_PROXY_TRACKER_HPP
