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
    /// Work allowed in one update, in patches (about 10-100 ns each); at least 1. A sweep or a descent that needs more goes
    /// on in the next update, from where it came to towards wherever the stylus is then, and the status says so.
    int max_patches = 8192;
    /// Of these, what a proxy may slide over in an update in contact: so many, and two more for each cell that the stylus
    /// moved. A ridge or a hollow can hold a proxy hundreds of cells away from a stylus that goes on below it; let go, it
    /// slides all of that way in one update, which takes up to 0.05 ms and ends in a jump of the force. With 8 here it
    /// glides there in some updates, and the force with it, and an update up to 5 cells on takes some 3 µs at the most. Of
    /// updates 5 cells on and 5 cells below Sugarhouse one in 44 ends on the way, below ground as steep as ten times Moab
    /// one in 12; half a cell on and half a cell below them none and one in 900. The search that decides whether a
    /// stylus with the surface over it is free is no part of the slide: `max_patches` alone limits it.
    int max_contact_patches = 8192;
};

/// What a tracker is doing.
enum class TrackerPhase : unsigned char {
    unseen,    ///< no stylus position has been seen
    free,      ///< the surface has been searched up to the stylus
    searching, ///< free, but the search has not got to the stylus
    contact,   ///< the proxy is at its minimum and holds the stylus
    sliding, ///< in contact, and the proxy is on its way, or rests at a minimum that holds the stylus by rounding only
    releasing ///< at a minimum that does not hold the stylus: the way to it is searched, and not to its end yet
};

/// Everything a tracker remembers: a trivially copyable value, to be saved, restored or sent to another thread.
template <Real T>
struct TrackerState {
    glm::dvec3 swept_to{
        0.0}; ///< the stylus; searching and releasing: up to where the surface has been searched
    SurfacePoint<T> proxy{};       ///< touching: the proxy
    DescentProgress<T> progress{}; ///< sliding: of the descent to this stylus
    T left{}; ///< |proxy − stylus|² at the minimum that was left: releasing, and sliding and searching if `left_one`
    Side side = Side::none;       ///< touching: the side that is felt; free: the side the stylus is on
    Side side_there = Side::none; ///< releasing: the side on which the search is
    TrackerPhase phase = TrackerPhase::unseen;
    bool left_one = false; ///< sliding and searching: beyond a minimum that did not hold this stylus
    bool goes_in = false; ///< sliding, if `left_one`: the way from that minimum to the stylus goes in at once

    [[nodiscard]] constexpr bool touching() const noexcept { return phase >= TrackerPhase::contact; }
};

/// Follows a stylus over a height field: the haptic update of §4.3 [P].
///
/// Two modes. *Free*: the segment from the last stylus position to this one is cast; the first crossing is the
/// first contact. *Touching*: the proxy slides downhill from where it was to the local closest point. While the
/// stylus is inside (proxy − stylus points out of the surface) the contact holds. When it is not, the segment
/// proxy → stylus is cast before the proxy is freed, for the stylus can have left one face and be below another
/// already; a crossing on it is a new contact in the same update (the paper frees at once). Slide and search may take
/// more than one update (`TrackerOptions`): the contact holds until they have come to an end, and is felt while the
/// stylus has the surface over it, or is inside of the face that the proxy is on.
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
    using State = TrackerState<Scalar>;
    static_assert(std::is_trivially_copyable_v<State>, "a tracker's state can be copied like plain bytes");

    constexpr explicit ProxyTracker(const Field& field, const TrackerOptions& options = {}) noexcept
        : field_{&field}, options_{options} {}
    explicit ProxyTracker(const Field&&,
                          const TrackerOptions& = {}) = delete; // the field must outlive the tracker

    /// One haptic update: the stylus is at `stylus` (world coordinates, metres). NaN, infinity and positions beyond
    /// the reach of cell numbers or of the scalar's squares are refused: status bad_input, state unchanged.
    ///
    /// Not inlined: beside an update a call is nothing, and the code is large.
    [[nodiscard, gnu::noinline]] Contact<Scalar> update(const vec3<Scalar>& stylus) noexcept {
        if (!is_finite(stylus) || !field_->lattice().reaches(stylus) || !is_height(stylus.z)) {
            return {.status = ContactStatus::bad_input};
        }
        const glm::dvec3 to = widen(stylus);
        if (state_.phase == Phase::contact) return follow(state_.swept_to, stylus, 0);
        if (state_.touching()) return resume(stylus);
        if (state_.phase == Phase::unseen) state_.swept_to = to;
        // What `search` comes to nearly always, without a look at anything else.
        if (state_.side != Side::below && options_.max_patches >= 4) {
            if (const Index cells = detail::cells_below_short_segment(*field_, state_.swept_to, to);
                cells > 0) {
                state_.side = Side::above;
                state_.swept_to = to;
                state_.phase = Phase::free;
                return without_contact(ContactStatus::free, stylus, static_cast<int>(cells));
            }
        }
        return search(stylus);
    }

    /// Forgets the stylus: the next position is taken as the first one.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }
    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }

private:
    using Phase = TrackerPhase;

    /// Free, with something in the way, or near it. Not inlined, so that an update that meets nothing needs no stack.
    [[nodiscard, gnu::noinline]] Contact<Scalar> search(const vec3<Scalar>& stylus) noexcept {
        const glm::dvec3 from = state_.swept_to, to = widen(stylus);
        const bool went_on = state_.phase == Phase::searching;
        const auto hit = cast(from, to, {.side = state_.side}, work_allowed());
        const int patches = static_cast<int>(hit.cells);
        if (hit.status == HitStatus::miss) return set_free(hit.side, stylus, patches);
        if (hit.status == HitStatus::cell_limit) {
            state_.left_one = went_on && state_.left_one;
            state_.swept_to = along(from, to, hit.t);
            return search_on(hit.side, stylus, patches);
        }
        const bool left_one = went_on && state_.left_one && still_left(stylus);
        state_.goes_in = false;
        state_.phase = Phase::contact;
        state_.side = hit.side;
        state_.proxy = hit.point;
        // The way of one update counts for the slide; behind a search that was cut short lies more.
        if (!left_one) return follow(went_on ? to : from, stylus, patches);
        Work work{.patches = patches, .slide = slide_allowance(to, stylus)};
        DescentProgress<Scalar> progress;
        return pursue(stylus, slide(stylus, work, progress), progress, work, true);
    }

    /// Free so far: goes on with the search at the next update.
    [[nodiscard]] Contact<Scalar> search_on(Side side, const vec3<Scalar>& stylus, int patches) noexcept {
        state_.phase = Phase::searching;
        state_.side = side;
        return without_contact(ContactStatus::sweep_limit, stylus, patches);
    }

    [[nodiscard]] FirstHit<Scalar> cast(const glm::dvec3& from, const glm::dvec3& to, FirstHitOptions options,
                                        int max_cells) const noexcept {
        options.surface = options_.surface;
        options.max_cells = max_cells;
        return detail::cast(*field_, from, to, options);
    }

    /// Contact, and the stylus was at `before`: slides the proxy. Mostly it comes to a minimum that holds the stylus.
    [[nodiscard, gnu::noinline]] Contact<Scalar> follow(const glm::dvec3& before, const vec3<Scalar>& stylus,
                                                        int patches) noexcept {
        Work work{.patches = patches, .slide = slide_allowance(before, stylus)};
        state_.swept_to = widen(stylus);
        DescentProgress<Scalar> progress;
        const auto found =
            detail::descend_inline(*field_, stylus, state_.proxy, glm::max(1, slide_work(work)), progress);
        if (found.status == DescentStatus::minimum && holds(found)) [[likely]] {
            state_.proxy = found.point;
            return touch(stylus, found, ContactStatus::contact, true, patches + found.patches);
        }
        return pursue(stylus, found, progress, work, false);
    }

    /// What an update has looked at, and over how much the proxy may still slide.
    struct Work {
        int patches, slide;
    };

    /// In contact, with something left to do.
    [[nodiscard, gnu::noinline]] Contact<Scalar> resume(const vec3<Scalar>& stylus) noexcept {
        const bool releasing = state_.phase == Phase::releasing;
        const glm::dvec3 to = widen(stylus);
        if (!releasing && to != state_.swept_to) {
            state_.phase = Phase::contact;
            return follow(state_.swept_to, stylus, 0);
        }
        Work work{.patches = 0, .slide = slide_allowance(to, stylus)};
        DescentProgress<Scalar> progress = state_.progress;
        bool left_one = state_.left_one;
        if (releasing) {
            left_one = still_left(stylus);
            state_.goes_in = false;
            const auto hit = search_beyond(stylus, work_allowed(), work.patches);
            if (hit.status == HitStatus::miss) return set_free(hit.side, stylus, work.patches);
            if (hit.status == HitStatus::cell_limit) {
                if (!covered(stylus)) return search_on(hit.side, stylus, work.patches);
                return touch(stylus, descend(*field_, stylus, state_.proxy, 0), ContactStatus::descent_limit,
                             true, work.patches);
            }
            progress = {};
        }
        return pursue(stylus, slide(stylus, work, progress), progress, work, left_one);
    }

    /// Goes on where a slide has ended without a contact that holds: keeps the old one for now, finds one beyond it, or
    /// frees the stylus. `left_one`: a minimum that does not hold this stylus has been left before.
    [[nodiscard, gnu::noinline]] Contact<Scalar> pursue(const vec3<Scalar>& stylus,
                                                        DescentResult<Scalar> found,
                                                        DescentProgress<Scalar> progress, Work work,
                                                        bool left_one) noexcept {
        for (;;) {
            work.patches += found.patches;
            work.slide -= found.patches;
            state_.proxy = found.point;
            state_.swept_to = widen(stylus);
            const Scalar squared = glm::dot(found.offset, found.offset);
            // A user's own field may have heights that are none.
            if (found.status == DescentStatus::off_border || found.status == DescentStatus::off_hole ||
                !is_finite(squared)) {
                return leave(stylus, found.status, work.patches);
            }
            const bool minimum = found.status == DescentStatus::minimum;
            if (minimum && holds(found)) {
                state_.phase = Phase::contact;
                return touch(stylus, found, ContactStatus::contact, true, work.patches);
            }
            // A minimum beyond another one that is as far but for rounding: the same one, and there is no better. (It is
            // never farther, unless the ground was edited.)
            const bool settled = minimum && left_one && as_far(squared, rounding(found.offset, found.point));
            if (!minimum || settled) {
                state_.phase = Phase::sliding;
                state_.progress = minimum ? DescentProgress<Scalar>{} : progress;
                state_.left_one = left_one;
                return touch(stylus, found, minimum ? ContactStatus::contact : ContactStatus::descent_limit,
                             holds(found) || (settled && state_.goes_in) || covered(stylus), work.patches);
            }
            // Outside this face: free, unless another one lies between.
            state_.phase = Phase::releasing;
            state_.swept_to = widen(stylus) + widen(found.offset);
            state_.side_there = state_.side;
            state_.left = squared;
            state_.left_one = left_one = true;
            auto hit = search_beyond(stylus, slide_work(work), work.patches);
            if (hit.status == HitStatus::cell_limit) {
                // Free so far. A stylus that has the surface over it is not: it is searched for with all that is allowed,
                // and in contact until then.
                if (!covered(stylus)) return search_on(hit.side, stylus, work.patches);
                if (work.patches < work_allowed())
                    hit = search_beyond(stylus, work_allowed() - work.patches, work.patches);
                if (hit.status == HitStatus::cell_limit)
                    return touch(stylus, found, ContactStatus::descent_limit, true, work.patches);
            }
            if (hit.status == HitStatus::miss) return set_free(hit.side, stylus, work.patches);
            state_.goes_in = hit.t * std::sqrt(widen(squared)) <= widen(rounding(found.offset, found.point));
            progress = {};
            found = slide(stylus, work, progress);
        }
    }

    [[nodiscard]] DescentResult<Scalar> slide(const vec3<Scalar>& stylus, const Work& work,
                                              DescentProgress<Scalar>& progress) const noexcept {
        return detail::descend_on(*field_, stylus, state_.proxy, slide_work(work), progress);
    }
    [[nodiscard]] int slide_work(const Work& work) const noexcept {
        return glm::min(work.slide, work_allowed() - work.patches);
    }
    /// Whether the stylus is inside of the face at the proxy.
    [[nodiscard]] bool holds(const DescentResult<Scalar>& found) const noexcept {
        return state_.side == Side::below ? found.outward < 0 : found.outward > 0;
    }

    /// Goes on with the search from a minimum that does not hold the stylus. If there is another face, the proxy is on it.
    [[nodiscard, gnu::noinline]] FirstHit<Scalar> search_beyond(const vec3<Scalar>& stylus, int max_cells,
                                                                int& patches) noexcept {
        const glm::dvec3 to = widen(stylus);
        const auto patch = field_->patch(state_.proxy.cell);
        const Scalar blur = patch ? rounding(offset_from(stylus, *patch), *patch) : Scalar(0);
        const auto hit =
            cast(state_.swept_to, to,
                 {.side = state_.side_there,
                  .leaves_within = widen(blur) + 8 * epsilon<double> * std::abs(widen(stylus.z))},
                 glm::max(1, max_cells));
        patches += static_cast<int>(hit.cells);
        if (hit.status == HitStatus::hit) {
            state_.phase = Phase::sliding;
            state_.side = hit.side;
            state_.proxy = hit.point;
        } else if (hit.status == HitStatus::cell_limit) {
            state_.swept_to = along(state_.swept_to, to, hit.t);
            state_.side_there = hit.side;
        }
        return hit;
    }
    /// Whether the proxy is as far from the stylus as when it was left, but for rounding: so this is the same stylus.
    [[nodiscard]] bool still_left(const vec3<Scalar>& stylus) const noexcept {
        const auto found = descend(*field_, stylus, state_.proxy, 0);
        return found.status == DescentStatus::work_limit &&
               as_far(glm::dot(found.offset, found.offset), rounding(found.offset, found.point));
    }
    /// Proxy − stylus, where the proxy is on this patch.
    [[nodiscard]] vec3<Scalar> offset_from(const vec3<Scalar>& stylus,
                                           const BilinearPatch<Scalar>& patch) const noexcept {
        const SurfacePoint<Scalar>& at = state_.proxy;
        const CellPoint<Scalar> seen = field_->lattice().locate(stylus, at.cell);
        return {patch.spacing.x * (at.u - seen.u), patch.spacing.y * (at.v - seen.v),
                DistanceFunction<Scalar>{patch, seen}.gap(at.u, at.v)};
    }

    [[nodiscard]] int work_allowed() const noexcept { return glm::max(options_.max_patches, 1); }
    /// How many patches the proxy may slide over in an update in which the stylus moved here from `before`.
    [[nodiscard]] int slide_allowance(const glm::dvec3& before, const vec3<Scalar>& stylus) const noexcept {
        if (options_.max_contact_patches >= work_allowed()) return work_allowed();
        const glm::dvec3 way = widen(stylus) - before;
        const glm::dvec2 per_metre = field_->lattice().cells_per_metre();
        const double cells = glm::max(std::abs(way.x) * per_metre.x, std::abs(way.y) * per_metre.y);
        return static_cast<int>(
            glm::min(static_cast<double>(glm::max(options_.max_contact_patches, 1)) + 2 * cells,
                     static_cast<double>(work_allowed())));
    }

    /// Whether the stylus has the surface right above it (felt from below: right below it), by more than rounding. While
    /// the proxy is on its way the plane at it does not tell, for the stylus is far from there.
    [[nodiscard, gnu::noinline]] bool covered(const vec3<Scalar>& stylus) const noexcept {
        const Lattice& lattice = field_->lattice();
        const glm::dvec3 at = widen(stylus);
        const double u = lattice.u_of(at.x, 0), v = lattice.v_of(at.y, 0);
        // On a grid line cells on both sides are over it; beside a hole one of them has no patch.
        const auto last = Cell{static_cast<Index>(std::floor(u)), static_cast<Index>(std::floor(v))};
        const Cell first{last.i - (u == static_cast<double>(last.i)),
                         last.j - (v == static_cast<double>(last.j))};
        for (Index j = first.j; j <= last.j; ++j) {
            for (Index i = first.i; i <= last.i; ++i) {
                const auto found = field_->patch({i, j});
                if (!found) continue;
                const auto p = widen(*found);
                const double above = p.height(lattice.u_of(at.x, i), lattice.v_of(at.y, j)) - at.z;
                // Of the height here, and of the offset from which the depth comes out in the end.
                const double rounding =
                    8 * epsilon<double> * (std::abs(p.highest()) + std::abs(p.lowest()) + std::abs(at.z)) +
                    8 * widen(epsilon<Scalar>) * (p.highest() - p.lowest() + std::abs(above));
                if (state_.side == Side::below ? above < -rounding : above > rounding) return true;
            }
        }
        return false;
    }

    /// How far the rounding of a proxy may leave it off the surface: some ulps of the lengths that the offset is made of.
    [[nodiscard]] static Scalar rounding(const vec3<Scalar>& offset,
                                         const BilinearPatch<Scalar>& patch) noexcept {
        const Scalar size = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
        return 8 * epsilon<Scalar> * (size + 2 * (patch.highest() - patch.lowest()));
    }
    [[nodiscard]] Scalar rounding(const vec3<Scalar>& offset, const SurfacePoint<Scalar>& at) const noexcept {
        const auto patch = field_->patch(at.cell);
        return patch ? rounding(offset, *patch) : Scalar(0);
    }

    /// Whether a distance with this square is that of the minimum that was left, but for its rounding.
    [[nodiscard]] bool as_far(Scalar squared, Scalar rounding) const noexcept {
        const auto nearer = [rounding](Scalar one, Scalar other) {
            return one < other - rounding * (2 * std::sqrt(other) + rounding);
        };
        return !nearer(squared, state_.left) && !nearer(state_.left, squared);
    }

    // Contacts are made in one piece: one filled in bit by bit is first cleared by GCC with rep stos, some 6 ns.
    [[nodiscard, gnu::always_inline]] Contact<Scalar> touch(const vec3<Scalar>& stylus,
                                                            const DescentResult<Scalar>& found,
                                                            ContactStatus status, bool felt,
                                                            int patches) const noexcept {
        // A stylus that is outside is not pulled back to the surface.
        const vec3<Scalar> penetration = felt ? found.offset : vec3<Scalar>{0};
        return {.status = status,
                .side = state_.side,
                .patches = patches,
                .proxy = stylus + found.offset,
                .normal = state_.side == Side::below ? -found.normal : found.normal,
                .penetration = penetration,
                .depth = glm::length(penetration),
                .point = found.point};
    }

    [[nodiscard]] Contact<Scalar> without_contact(ContactStatus status, const vec3<Scalar>& stylus,
                                                  int patches) const noexcept {
        return {.status = status, .side = state_.side, .patches = patches, .proxy = stylus};
    }

    /// Free: the surface has been searched up to the stylus, which is on this side.
    [[nodiscard]] Contact<Scalar> set_free(Side side, const vec3<Scalar>& stylus, int patches) noexcept {
        state_.phase = Phase::free;
        state_.side = side;
        state_.swept_to = widen(stylus);
        const bool buried = side == Side::below && options_.surface == SurfaceKind::solid;
        return without_contact(side == Side::none ? ContactStatus::off_surface
                               : buried           ? ContactStatus::buried
                                                  : ContactStatus::free,
                               stylus, patches);
    }

    /// The proxy has slid off a rim: the stylus is wherever it is.
    [[nodiscard]] Contact<Scalar> leave(const vec3<Scalar>& stylus, DescentStatus rim, int patches) noexcept {
        const glm::dvec3 here = widen(stylus);
        const auto hit = cast(here, here, {}, 1);
        Contact<Scalar> left = set_free(hit.side, stylus, patches + static_cast<int>(hit.cells));
        left.status =
            rim == DescentStatus::off_border ? ContactStatus::left_at_border : ContactStatus::left_at_hole;
        return left;
    }

    const Field* field_;
    TrackerOptions options_;
    State state_{};
};

} // namespace hfh

#endif // HFH_CONTACT_PROXY_TRACKER_HPP
