#ifndef HFH_PROXY_TRACKER_HPP
#define HFH_PROXY_TRACKER_HPP

#include <hfh/contact.hpp>
#include <hfh/descent.hpp>
#include <hfh/first_hit.hpp>

#include <glm/geometric.hpp>

#include <type_traits>

// Based on: Potter, Johnson, Cohen, Height Field Haptics [P], §4.2-4.3.3; the proxy is that of Ruspini, Kolarov and
// Khatib (1997) and the god-object of Zilles and Salisbury (1995).

namespace hfh {

struct TrackerOptions {
    SurfaceKind surface = SurfaceKind::solid;
    /// Work allowed in one update, in patches (about 10-100 ns each). A sweep or a descent that needs more goes on
    /// in the next update, from where it came to towards wherever the stylus is then, and the status says so.
    int max_patches = 8192;
    /// Of these, the work of an update in contact: so many, and two more for each cell that the stylus moved. A ridge
    /// or a hollow can hold a proxy hundreds of cells away from a stylus that goes on below it; let go, it slides all of
    /// that way in one update, which takes up to 0.05 ms and ends in a jump of the force. With 8 here it glides there in
    /// some updates, and the force with it, and an update up to 5 cells on takes some 3 µs at the most. Of updates 5
    /// cells on and 5 cells below Sugarhouse one in 44 ends on the way, below ground as steep as ten times Moab one in
    /// 12; half a cell on and half a cell below them none and one in 900.
    int max_slide = 8192;
};

/// Everything a tracker remembers: a trivially copyable value, to be saved, restored or sent to another thread.
template <Real T>
struct TrackerState {
    glm::dvec3 swept_to{0.0}; ///< the stylus; free: the position up to which the surface has been searched
    SurfacePoint<T> proxy{};  ///< touching: the proxy
    Side side = Side::none;   ///< touching: the side that is felt; free: the side the stylus is on
    bool started = false;     ///< a stylus position has been seen
    bool touching = false;
    bool cut_short = false; ///< free: the search has not got to the stylus
};

/// Follows a stylus over a height field: the haptic update of §4.3 [P].
///
/// Two modes. *Free*: the segment from the last stylus position to this one is cast; the first crossing is the
/// first contact. *Touching*: the proxy slides downhill from where it was to the local closest point. While the
/// stylus is inside (proxy − stylus points out of the surface) the contact holds. When it is not, the segment
/// proxy → stylus is cast before the proxy is freed, for the stylus can have left one face and be below another
/// already; a crossing on it is a new contact in the same update (the paper frees at once). A proxy that has far to go
/// takes more than one update (`TrackerOptions`); on its way it is felt while the stylus has the surface over it.
///
/// On a solid without holes, for a stylus that was outside once and stays over the grid: never free while below the
/// surface. With status `contact` no patch at the proxy has a descent direction. A stylus that starts below the surface,
/// or comes in below it from the side, feels nothing until it has been outside. Edited heights are felt at the next
/// update. `update` is noexcept, allocates nothing and looks at no more than about `max_patches` patches.
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
    /// Not inlined: where GCC 12 sees how a float position was made, it forgets the rounding in (double)(float)x of a
    /// pair of x, and the stylus that is swept would not be the one that was given.
    [[nodiscard, gnu::noinline]] Contact<Scalar> update(const vec3<Scalar>& stylus) noexcept {
        if (!is_finite(stylus) || !field_->lattice().reaches(stylus) || !(std::abs(stylus.z) < highest)) {
            return {.status = ContactStatus::bad_input};
        }
        const glm::dvec3 to = widen(stylus);
        if (!state_.started) {
            state_.started = true;
            state_.swept_to = to;
        }
        if (state_.touching) return slide(state_.swept_to, stylus, 0);
        // What `sweep` comes to nearly always, without a look at anything else.
        if (state_.side != Side::below && options_.max_patches >= 4) {
            if (const Index cells = detail::passes_over(*field_, state_.swept_to, to); cells > 0) {
                state_.side = Side::above;
                state_.swept_to = to;
                state_.cut_short = false;
                return without_contact(ContactStatus::free, stylus, static_cast<int>(cells));
            }
        }
        return meet(stylus);
    }

    /// Forgets the stylus: the next position is taken as the first one.
    constexpr void reset() noexcept { state_ = {}; }

    [[nodiscard]] constexpr const State& state() const noexcept { return state_; }
    constexpr void restore(const State& state) noexcept { state_ = state; }
    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }

private:
    /// Beyond this height the fourth power of a distance overflows.
    static constexpr Scalar highest = std::same_as<Scalar, float> ? Scalar(0x1p31) : Scalar(0x1p255);

    /// Free, with something in the way, or near it. Not inlined, so that an update that meets nothing needs no stack.
    [[nodiscard, gnu::noinline]] Contact<Scalar> meet(const vec3<Scalar>& stylus) noexcept {
        // Behind a search that was cut short lies more than the way of one update.
        const glm::dvec3 before = state_.cut_short ? widen(stylus) : state_.swept_to;
        int patches = 0;
        const auto status = sweep(state_.swept_to, stylus, {}, options_.max_patches, patches);
        return state_.touching ? slide(before, stylus, patches) : without_contact(status, stylus, patches);
    }

    /// Casts from → stylus. Ends touching, at the first crossing, or with the status returned; with `enough` patches, it
    /// is cut short.
    [[nodiscard]] ContactStatus sweep(const glm::dvec3& from, const vec3<Scalar>& stylus,
                                      FirstHitOptions options, int enough, int& patches) noexcept {
        const glm::dvec3 to = widen(stylus);
        options.surface = options_.surface;
        options.side = state_.side;
        options.max_cells = glm::max(1, enough - patches);
        FirstHit<Scalar> hit;
        detail::search(*field_, from, to, options, hit);
        patches += static_cast<int>(hit.cells);
        state_.touching = hit.status == HitStatus::hit;
        state_.side = hit.side;
        state_.proxy = hit.point;
        state_.cut_short = hit.status == HitStatus::cell_limit;
        if (state_.touching) return ContactStatus::contact;

        state_.swept_to = state_.cut_short ? from + hit.t * (to - from) : to;
        const bool buried = hit.side == Side::below && options_.surface == SurfaceKind::solid;
        return state_.cut_short         ? ContactStatus::sweep_limit
               : hit.side == Side::none ? ContactStatus::off_surface
               : buried                 ? ContactStatus::buried
                                        : ContactStatus::free;
    }

    /// Contact: slides the proxy, then keeps the contact, finds a new one beyond it, or frees the stylus. Not inlined
    /// for the reason that `descend` is not.
    [[nodiscard, gnu::noinline]] Contact<Scalar> slide(const glm::dvec3& before, const vec3<Scalar>& stylus,
                                                       int patches) noexcept {
        const glm::dvec3 to = widen(stylus);
        const int enough = allowed_to_slide(to - before);
        state_.swept_to = to;
        Scalar nearest = std::numeric_limits<Scalar>::max();
        for (;;) {
            const auto found =
                detail::descend_inline(*field_, stylus, state_.proxy, glm::max(1, enough - patches));
            patches += found.patches;
            state_.proxy = found.point;
            if (found.status == DescentStatus::off_border || found.status == DescentStatus::off_hole) {
                return leave(stylus, found.status, patches);
            }
            const bool minimum = found.status == DescentStatus::minimum;
            const bool inside = state_.side == Side::below ? found.outward < 0 : found.outward > 0;
            if (inside && minimum) return touch(stylus, found, true, true, patches);
            const Scalar squared = glm::dot(found.offset, found.offset);
            // Of a second face: as far as the last, it is the same but for rounding; or the work is used up.
            const bool again = nearest < std::numeric_limits<Scalar>::max();
            const bool stalls = minimum && again && !(squared < nearest);
            const bool spent = again && patches >= enough;
            if (stalls || !minimum || spent) {
                return touch(stylus, found, inside || (!stalls && covered(stylus)), stalls, patches);
            }
            nearest = squared;
            // Outside this face: free, unless another one lies between. Each new contact is nearer than the last.
            const auto status =
                sweep(widen(stylus) + widen(found.offset), stylus,
                      {.leaves_within = blur(stylus, found.offset, found.point.cell)}, enough, patches);
            if (!state_.touching) return without_contact(status, stylus, patches);
        }
    }

    /// How many patches an update in contact may look at, for a stylus that moved by `way`.
    [[nodiscard]] int allowed_to_slide(const glm::dvec3& way) const noexcept {
        if (options_.max_slide >= options_.max_patches) return options_.max_patches;
        const glm::dvec2 per_metre = field_->lattice().cells_per_metre();
        const double cells = glm::max(std::abs(way.x) * per_metre.x, std::abs(way.y) * per_metre.y);
        return static_cast<int>(glm::min(static_cast<double>(options_.max_slide) + 2 * cells,
                                         static_cast<double>(options_.max_patches)));
    }

    /// Whether the stylus has the surface right above it (felt from below: right below it). While the proxy is on its
    /// way the plane at it does not tell, for the stylus is far from there.
    [[nodiscard, gnu::noinline]] bool covered(const vec3<Scalar>& stylus) const noexcept {
        const Lattice& lattice = field_->lattice();
        const double u = lattice.u_of(widen(stylus.x), 0), v = lattice.v_of(widen(stylus.y), 0);
        // On a grid line cells on both sides are under it; beside a hole one of them has no patch.
        const auto last = Cell{static_cast<Index>(std::floor(u)), static_cast<Index>(std::floor(v))};
        const Cell first{last.i - (u == static_cast<double>(last.i)),
                         last.j - (v == static_cast<double>(last.j))};
        for (Index j = first.j; j <= last.j; ++j) {
            for (Index i = first.i; i <= last.i; ++i) {
                const auto patch = field_->patch({i, j});
                if (!patch) continue;
                const auto seen = lattice.locate(stylus, {i, j});
                const Scalar above = patch->height(seen.u, seen.v) - seen.z;
                if (state_.side == Side::below ? above < 0 : above > 0) return true;
            }
        }
        return false;
    }

    /// How far the rounding of a proxy may leave it off the surface: some ulps, in the scalar, of the lengths that the
    /// offset is made of, and in double of the heights to which it is added.
    [[nodiscard]] double blur(const vec3<Scalar>& stylus, vec3<Scalar> offset, Cell cell) const noexcept {
        Scalar size = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
        if (const auto patch = field_->patch(cell)) size += 2 * (patch->highest() - patch->lowest());
        return widen(8 * epsilon<Scalar> * size) + 8 * epsilon<double> * std::abs(widen(stylus.z));
    }

    // Contacts are made in one piece: one filled in bit by bit is first cleared by GCC with rep stos, some 6 ns.
    [[nodiscard, gnu::always_inline]] Contact<Scalar> touch(const vec3<Scalar>& stylus,
                                                            const DescentResult<Scalar>& found, bool inside,
                                                            bool minimum, int patches) const noexcept {
        const vec3<Scalar> penetration =
            inside ? found.offset : vec3<Scalar>{0}; // never a pull towards the surface
        return {.status = minimum ? ContactStatus::contact : ContactStatus::descent_limit,
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

    /// The proxy has slid off a rim: the stylus is wherever it is.
    [[nodiscard]] Contact<Scalar> leave(const vec3<Scalar>& stylus, DescentStatus rim, int patches) noexcept {
        state_.side = Side::none;
        (void)sweep(widen(stylus), stylus, {}, options_.max_patches, patches);
        return without_contact(rim == DescentStatus::off_border ? ContactStatus::left_at_border
                                                                : ContactStatus::left_at_hole,
                               stylus, patches);
    }

    const Field* field_;
    TrackerOptions options_;
    State state_{};
};

} // namespace hfh

#endif // HFH_PROXY_TRACKER_HPP
