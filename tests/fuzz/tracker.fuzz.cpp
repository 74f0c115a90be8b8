#include "bytes.hpp"

#include "support/limited_work.hpp"
#include "support/raw_field.hpp"
#include "support/reference.hpp"
#include "support/terrains.hpp"

#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>

#include <array>
#include <cstddef>
#include <vector>

// A tracker on a small terrain, with any limit of its work: moves of every size, positions that are none, edits, holes,
// heights of any size, reset, save and restore. What it answers is judged from outside, from the samples: every update by
// what holds whatever work is allowed, every fourth by all that is known of a contact, in long double, and by a twin. Of an endless loop libFuzzer's -timeout tells.
//
// The number of updates that were judged is printed at the end. (Twins that answer the same question again are not
// counted.)

namespace hfh::fuzz {
namespace {

using test::dot;
using test::length;
using test::Point;
using test::Surface;
using test::Terrain;
using test::wide;
using test::Wide;
using test::WideSurfacePoint;

/// What fuzzing has found and is not mended yet: not reported again while true.
struct Open {
    bool loops = false; ///< contact, release, contact at one point, until the work is used up
    bool level_on_a_cliff =
        true; ///< float, slopes of hundreds: at a crease or a rim no digits are left to tell the side by
    bool rounded_twist = false;    ///< slopes at u = 1 and v = 1 are off by the rounding of the twist
    bool hair_from_border = false; ///< a step of a denormal length gains nothing and is not taken
    /// Cliffs of more than 2·10⁵ cells a cell, in float 10⁴: what rounding leaves of such a height can be felt at rest, and
    /// in pieces the way to the ground beside it can end on another side of a needle.
    bool rest_on_cliffs = true;
};
constexpr Open open;

/// Counts the updates of the whole run.
struct Tally {
    long updates = 0;
    Tally() = default;
    Tally(const Tally&) = delete;
    Tally& operator=(const Tally&) = delete;
    ~Tally() { std::fprintf(stderr, "judged %ld tracker updates\n", updates); }
};
Tally tally;

/// A limit of work: every small one, those between, and none.
int any_limit(Bytes& bytes) {
    switch (bytes.byte() % 4) {
    case 0: return bytes.whole(1, 4);
    case 1: return bytes.whole(1, 40);
    case 2: return 1 + bytes.raw<std::uint16_t>() % 8192;
    default: return TrackerOptions{}.max_patches;
    }
}

template <Real T>
constexpr Wide eps = static_cast<Wide>(epsilon<T>);

/// Something that was done to the tracker or to its terrain.
template <Real T>
struct Event {
    enum Kind { update, edit, reset, save, restore, stroke } kind;
    vec3<T> stylus{T(0)};
    Index i = 0, j = 0;
    T height{};
};

template <Real T>
class Session {
public:
    explicit Session(Bytes& bytes) : bytes_{&bytes} {
        make_terrain();
        options_.surface = bytes.byte() % 4 == 0 ? SurfaceKind::sheet : SurfaceKind::solid;
        options_.max_patches = any_limit(bytes);
        options_.max_contact_patches = any_limit(bytes);
        constexpr std::array<T, 4> stiffnesses{T(500), T(0), T(1e30), std::numeric_limits<T>::max()};
        force_.stiffness = stiffnesses[bytes.byte() % stiffnesses.size()];
        constexpr std::array<T, 4> most{T(3.3), T(0), T(1e-30), T(1e30)};
        force_.max_force = most[bytes.byte() % most.size()];
        if (bytes.flag()) glide_speed_ = test::longest_patch(terrain_) / bytes.whole(1, 16);
        work_.emplace(terrain_, options_, glide_speed_);
        work_->judges_rest = rest_is_judged_;
        place(bytes.share(), bytes.share());
        lift(2 * stride_);
    }

    void run() {
        constexpr int most_events = 200;
        for (int n = 0; n < most_events && !bytes_->empty(); ++n) act();
        tally.updates += work_->updates;
    }

private:
    using Work = test::LimitedWork<T>;
    using Moment = typename Work::Moment;
    using Grid = typename Work::Grid;
    using Tracker = ProxyTracker<Grid>;

    /// What the judge remembers from update to update, saved and restored along with the tracker's state.
    struct Memory {
        vec3<T> last{T(0)};
        bool outside = false;   // has been above the surface, and over it ever since
        Side side = Side::none; // sheet: the side it was on, over the surface
        bool touching = false;
    };

    void make_terrain() {
        if (bytes_->flag()) {
            const auto kind = static_cast<test::HardGround>(bytes_->byte() % test::hard_grounds);
            test::Random random{bytes_->raw<std::uint16_t>()};
            terrain_ = test::hard_ground<T>(kind, random);
            relief_ = stride() * std::ldexp(1.0, bytes_->whole(-10, 10)); // of edits
        } else {
            draw_terrain();
        }
        stride_ = stride();
        look_at_heights();
        grid_ = terrain_.grid();
    }
    void look_at_heights() {
        T low = test::no_height_from<T>, high = -low;
        for (const T height : terrain_.heights) {
            if (std::abs(height) < test::no_height_from<T>) {
                low = std::min(low, height);
                high = std::max(high, height);
            } else {
                holes_ = true;
            }
        }
        const double relief = (static_cast<double>(high) - static_cast<double>(low)) / stride_;
        tame_ = relief <= 4096;
        rest_is_judged_ = !open.rest_on_cliffs || relief <= (sizeof(T) == 4 ? 1e4 : 2e5);
    }
    [[nodiscard]] double stride() const {
        return std::min(terrain_.frame.spacing.x, terrain_.frame.spacing.y);
    }
    void draw_terrain() {
        Bytes& b = *bytes_;
        terrain_.columns = b.whole(2, 12);
        terrain_.rows = b.whole(2, 12);
        constexpr std::array<double, 6> spacings{1, 10, 0.1, 1000, 73.596, 0.03125};
        terrain_.frame.spacing.x = spacings[b.byte() % spacings.size()];
        terrain_.frame.spacing.y =
            b.byte() % 4 == 0 ? spacings[b.byte() % spacings.size()] : terrain_.frame.spacing.x;
        constexpr std::array<glm::dvec2, 4> origins{glm::dvec2{0, 0}, glm::dvec2{-7, 3},
                                                    glm::dvec2{5e5, 4.4e6}, glm::dvec2{1e7, -1e7}};
        const std::uint8_t place = b.byte();
        terrain_.frame.origin = place < 192 ? origins[0] : origins[place % origins.size()];
        const double relief = stride() * std::ldexp(1.0, b.whole(-10, 10)); // of the whole range of samples
        const int pattern = b.byte() % 6;
        std::uint64_t seed = b.byte() + 1u;
        terrain_.heights.resize(static_cast<std::size_t>(terrain_.columns * terrain_.rows));
        for (Index j = 0; j < terrain_.rows; ++j) {
            for (Index i = 0; i < terrain_.columns; ++i) {
                double sample = 0;
                switch (pattern) {
                case 0: sample = b.small() / 128; break;
                case 1: // any, from the seed
                    seed = seed * 6364136223846793005u + 1442695040888963407u;
                    sample = static_cast<double>(seed >> 40) * 0x1p-24;
                    break;
                case 2: // terraces, from the seed
                    seed = seed * 6364136223846793005u + 1442695040888963407u;
                    sample = static_cast<double>(seed >> 62) / 4;
                    break;
                case 3: sample = (i + j) % 2 == 0 ? 1 : 0; break;
                case 4:
                    sample = std::abs(static_cast<double>(2 * i - terrain_.columns)) /
                             static_cast<double>(terrain_.columns) * (seed % 2 == 0 ? 1 : -1);
                    break;
                default: break; // flat
                }
                terrain_.at(i, j) = static_cast<T>(relief * sample);
            }
        }
        relief_ = relief;
    }

    // Ways to move.

    [[nodiscard]] double world_x(double columns) const {
        return terrain_.frame.origin.x + columns * terrain_.frame.spacing.x;
    }
    [[nodiscard]] double world_y(double rows) const {
        return terrain_.frame.origin.y + rows * terrain_.frame.spacing.y;
    }
    void place(double share_x, double share_y) {
        stylus_.x = static_cast<T>(world_x(share_x * static_cast<double>(terrain_.columns - 1)));
        stylus_.y = static_cast<T>(world_y(share_y * static_cast<double>(terrain_.rows - 1)));
    }
    /// To `metres` over the surface, where there is one.
    void lift(double metres) {
        if (const auto z = surface_.height(wide(stylus_).x, wide(stylus_).y)) {
            stylus_.z = static_cast<T>(static_cast<double>(*z) + metres);
        }
    }
    [[nodiscard]] double step() { return bytes_->small() / 128 * step_ * stride_; }

    void act() {
        Bytes& b = *bytes_;
        switch (b.byte() % 22) {
        case 0: step_ = std::ldexp(1.0, b.whole(-12, 7)); return;
        case 1:
        case 2:
        case 3:
            stylus_ += vec3<T>{static_cast<T>(step()), static_cast<T>(step()), static_cast<T>(step())};
            break;
        case 4: stylus_ += vec3<T>{static_cast<T>(step()), static_cast<T>(step()), T(0)}; break;
        case 5: stylus_.z += static_cast<T>(step()); break;
        case 6: {
            T& moves = b.flag() ? stylus_.x : b.flag() ? stylus_.y : stylus_.z;
            moves = moved_by_ulps(moves, b.whole(-3, 3));
            break;
        }
        case 7:
            place(b.share(), b.share());
            lift(step());
            break;
        case 8: // over a vertex or a line
            if (b.flag()) stylus_.x = static_cast<T>(world_x(b.whole(0, static_cast<int>(terrain_.columns))));
            if (b.flag()) stylus_.y = static_cast<T>(world_y(b.whole(0, static_cast<int>(terrain_.rows))));
            break;
        case 9: lift(step()); break;
        case 10: lift(0); break;
        case 11: { // far away, the way back in one move
            const vec3<T> here = stylus_;
            stylus_ +=
                vec3<T>{static_cast<T>(b.small() * stride_), static_cast<T>(b.small() * stride_), T(0)};
            if (b.flag()) stylus_.z += static_cast<T>(b.small() * std::max(stride_, relief_));
            update(stylus_);
            if (b.flag()) stylus_ = here;
            break;
        }
        case 12: refused(); return;
        case 13:
        case 14: edit(); break;
        case 15: {
            const Index i = b.whole(0, static_cast<int>(terrain_.columns - 1)),
                        j = b.whole(0, static_cast<int>(terrain_.rows - 1));
            switch (b.byte() % 4) {
            case 0: set(i, j, static_cast<T>(step())); break;
            case 1: set(i, j, b.raw<T>()); break; // of any size
            default: set(i, j, std::numeric_limits<T>::quiet_NaN()); break;
            }
            break;
        }
        case 16:
            if (b.byte() % 4 == 0) {
                events_.push_back({Event<T>::reset});
                work_->reset();
                memory_ = {};
                break;
            }
            return;
        case 17:
            events_.push_back({Event<T>::save});
            saved_ = work_->now();
            saved_memory_ = memory_;
            return;
        case 18:
            events_.push_back({Event<T>::restore});
            work_->go_back_to(saved_);
            memory_ = saved_memory_;
            break;
        case 19: stroke(); return;
        default: stand_still(); return;
        }
        update(stylus_);
    }

    /// Many moves at once, judged by what holds whatever work is allowed alone.
    void stroke() {
        test::Random random{bytes_->raw<std::uint32_t>()};
        events_.push_back({Event<T>::stroke});
        stroke_about(*work_, terrain_, random);
        tell_fault();
        memory_ = {};
    }
    void tell_fault() {
        if (!work_->fault().empty()) fail(work_->fault().c_str(), last_);
    }

    void edit() {
        Bytes& b = *bytes_;
        const Index i = b.whole(0, static_cast<int>(terrain_.columns - 1)),
                    j = b.whole(0, static_cast<int>(terrain_.rows - 1));
        const T before = terrain_.at(i, j);
        set(i, j, (is_finite(before) ? before : T(0)) + static_cast<T>(b.small() / 64 * relief_));
    }
    void set(Index i, Index j, T height) {
        events_.push_back({Event<T>::edit, {}, i, j, height});
        terrain_.at(i, j) = height;
        work_->edited();
        look_at_heights();
        work_->judges_rest = rest_is_judged_;
    }

    /// NaN, infinity, numbers of cells that no double counts, heights whose squares are no numbers: nothing is felt, nothing changes.
    void refused() {
        constexpr std::array<T, 5> bad{std::numeric_limits<T>::quiet_NaN(),
                                       std::numeric_limits<T>::infinity(),
                                       -std::numeric_limits<T>::infinity(), std::numeric_limits<T>::max(),
                                       std::numeric_limits<T>::lowest()};
        const unsigned which = bytes_->byte(), where = which / 8 % 3;
        const T value = bad[which % bad.size()];
        vec3<T> at = stylus_;
        (where == 0 ? at.x : where == 1 ? at.y : at.z) = value;
        events_.push_back({Event<T>::update, at});
        const auto before = bits(tracker().state());
        const Contact<T> c = work_->update(at);
        if (c.status != ContactStatus::bad_input) fail("bad input was taken", c);
        if (bits(tracker().state()) != before) fail("bad input changed the state", c);
        if (c.touching() || c.depth != 0 || c.penetration != vec3<T>{T(0)} || !finite(c))
            fail("bad input is felt", c);
        if (force_(c).newtons != vec3<T>{T(0)}) fail("bad input pushes", c);
    }

    /// The proxy gets there, and does not drift by one ulp from then on.
    void stand_still() {
        update(stylus_);
        events_.push_back({Event<T>::update, stylus_});
        last_ = work_->rest(stylus_);
        tell_fault();
        if (const Contact<T> again = update(stylus_); again.touching() != last_.touching())
            fail("contact comes and goes at rest", again);
    }

    // The judge.

    using Bits = std::array<std::byte, sizeof(TrackerState<T>)>;
    [[nodiscard]] static Bits bits(const TrackerState<T>& state) {
        Bits bits;
        std::memcpy(bits.data(), &state, sizeof state);
        return bits;
    }
    [[nodiscard]] static bool finite(const Contact<T>& c) {
        return is_finite(c.proxy) && is_finite(c.normal) && is_finite(c.penetration) && is_finite(c.depth) &&
               is_finite(c.point.u) && is_finite(c.point.v);
    }

    Contact<T> update(const vec3<T>& stylus) {
        events_.push_back({Event<T>::update, stylus});
        const Moment before = work_->now();
        const Contact<T> c = last_ = work_->update(stylus);
        tell_fault();
        if (c.status == ContactStatus::bad_input) { // nothing changes
            if (is_height(stylus.z) && grid_.lattice().reaches(stylus)) fail("good input was refused", c);
            judge_force(c);
            return c;
        }
        // In long double it takes a hundred times as long as the update itself. Where the stylus was is in any case kept.
        if (tame_ && (work_->updates % 4 == 0 || c.status != was_)) {
            judge(stylus, before, c);
        } else {
            remember(stylus, c);
        }
        was_ = c.status;
        memory_.last = stylus;
        memory_.touching = c.touching();
        judge_force(c);
        if (work_->updates % 4 == 1) judge_twin(stylus, before, c);
        return c;
    }

    void judge_twin(const vec3<T>& stylus, const Moment& before, const Contact<T>& c) {
        Tracker twin{grid_, options_};
        twin.restore(before.state);
        ProxyGlide<T> glide{glide_speed_, options_.max_patches};
        glide.restore(before.glide);
        const Contact<T> same = glide.follow(grid_, twin.update(stylus), stylus);
        if (same.status != c.status || same.side != c.side || same.patches != c.patches ||
            same.proxy != c.proxy || same.normal != c.normal || same.penetration != c.penetration) {
            fail("restored, it answers otherwise", same);
        }
    }

    void judge_force(const Contact<T>& c) {
        const Force<T> f = force_(c);
        if (!is_finite(f.newtons)) fail("force is not finite", c);
        const Wide newtons = length(wide(f.newtons));
        const Wide most = static_cast<Wide>(force_.max_force);
        // The square of a smaller depth is no number of T, and the depth comes out as zero.
        const Wide unseen = static_cast<Wide>(force_.stiffness) * test::no_square<T>;
        if (newtons > most * (1 + 4 * eps<T>)+unseen) fail("force beyond its limit", c);
        if (!c.touching() && newtons > 0) fail("a force out of nothing", c);
        if (dot(wide(f.newtons), wide(c.penetration)) < 0) fail("force turned round", c);
    }

    /// What the next updates are judged by: whether the stylus has been outside, and on which side it is. Returns what it
    /// was before.
    Memory remember(const vec3<T>& stylus, const Contact<T>& c) {
        const Point q = wide(stylus);
        under_ = surface_.under(
            q.x, q.y, 1e-12L * (1 + std::abs(surface_.column_of(q.x)) + std::abs(surface_.row_of(q.y))));
        // Where a proxy was let go, sides are decided from its place: a few roundings of the scalar.
        // And a depth whose square is no number comes out as zero.
        tolerance_ = under_ ? 32 * blur_around(*under_, q) + test::no_square<T> : 0;
        above_ = under_ ? q.z - surface_.patch(under_->i, under_->j)->height(under_->u, under_->v) : 0;
        const Memory was = memory_;
        // A sweep that was cut short has not got to the stylus yet; on the rim it may or may not be over the terrain.
        there_ = within_rim(q) && under_ && c.status != ContactStatus::sweep_limit;
        memory_.outside = there_ && ((was.outside && c.touching()) || above_ > tolerance_ ||
                                     (was.outside && c.status == ContactStatus::free));
        memory_.side = there_ ? c.side : Side::none;
        return was;
    }

    void judge(const vec3<T>& stylus, const Moment& last, const Contact<T>& c) {
        const bool solid = options_.surface == SurfaceKind::solid;
        const TrackerOptions ample;
        const bool limited = options_.max_patches < ample.max_patches ||
                             options_.max_contact_patches < ample.max_contact_patches;
        // An update may leave a search to the next one, rather than begin what it cannot end: that is some cells.
        const bool worked = glides() || (limited && c.patches + 6 >= std::min(options_.max_contact_patches,
                                                                              options_.max_patches));
        const Point q = wide(stylus);
        const Memory was = remember(stylus, c);
        const Wide tolerance = tolerance_, above = above_;
        const bool there = there_;

        if (!finite(c)) fail("not finite", c);
        if (c.patches < 0) fail("less than no work", c);
        if (c.touching() != tracker().state().touching()) fail("touching, and then not", c);
        if (c.touching()) {
            judge_contact(q, last, c, solid);
            if (c.status == ContactStatus::descent_limit) {
                if (!worked && !open.loops && !creeps(wide(c.point))) fail("ran out of work", c);
                const Wide over = c.side == Side::below ? -above : above;
                if (there && over < -tolerance && !(c.depth > 0)) fail("nothing felt on the way", c);
            }
            return;
        }
        if (c.proxy != stylus || c.penetration != vec3<T>{T(0)} || c.depth != 0 ||
            c.normal != vec3<T>{0, 0, 1}) {
            fail("not touching, but something is felt", c);
        }
        if (c.status == ContactStatus::sweep_limit && !worked && !open.loops) fail("ran out of work", c);
        judge_apart(q, was, c, solid);
    }

    /// Not in contact: whether the status fits the place.
    void judge_apart(const Point& q, const Memory& was, const Contact<T>& c, bool solid) {
        const auto& under = under_;
        const Wide tolerance = tolerance_, above = above_;
        switch (c.status) {
        case ContactStatus::sweep_limit: break;
        case ContactStatus::free:
            if (!under) fail("free over nothing", c);
            if (solid && above < -tolerance) fail("free below the surface", c);
            if (!solid && (c.side == Side::above ? above < -tolerance : above > tolerance))
                fail("on the other side", c);
            if (!solid && was.side != Side::none && c.side != was.side && all_over_surface(q, was))
                fail("through the sheet", c);
            break;
        case ContactStatus::buried:
            if (!solid || !under || above > tolerance) fail("buried, but not below the surface", c);
            if (was.outside && all_over_surface(q, was)) fail("buried after having been outside", c);
            break;
        case ContactStatus::off_surface:
            if (strictly_over(q)) fail("off_surface over a patch", c);
            break;
        case ContactStatus::left_at_border:
            if (strictly_over(q)) fail("slid off the border while over the surface", c);
            break;
        case ContactStatus::left_at_hole:
            if (!holes_) fail("slid off a hole that is not there", c);
            break;
        default: fail("impossible status", c);
        }
    }

    void judge_contact(const Point& q, const Moment& last, const Contact<T>& c, bool solid) {
        const WideSurfacePoint at = wide(c.point);
        if (!(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1)) fail("proxy outside its cell", c);
        if (!surface_.patch(at.i, at.j)) fail("proxy on no patch", c);
        if (c.side == Side::none || (solid && c.side != Side::above)) fail("felt from no side", c);
        const Point proxy = surface_.position(at), offset = proxy - q;
        const Wide blur = surface_.blur(at, q, eps<T>) + surface_.blur(at, proxy, eps<T>) +
                          eps<T> * (std::abs(q.x) + std::abs(q.y) + surface_.dx() + surface_.dy());
        // The proxy is the stylus and an offset, which has a rounding of its own length.
        const Wide blur_of_offset = blur + eps<T> * length(offset);
        if (length(wide(c.proxy) - proxy) > 16 * blur_of_offset) fail("proxy off the surface", c);
        // The sum of the unit normals. One epsilon of the edge slopes turns a normal by as much times its z; and where
        // the normals nearly cancel, their roundings weigh more.
        Point sum;
        Wide turn = 4;
        surface_.each_patch_at(at, [&](const test::WidePatch& p, Wide u, Wide v, Index, Index) {
            const Point n = p.normal(u, v);
            sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
            turn += n.z * (std::max(std::abs(p.along_u(0)), std::abs(p.along_u(1))) / p.dx +
                           std::max(std::abs(p.along_v(0)), std::abs(p.along_v(1))) / p.dy);
        });
        const Wide total = length(sum);
        const Point n{sum.x / total, sum.y / total, sum.z / total};
        const Wide sign = c.side == Side::below ? -1 : 1;
        if (std::abs(length(wide(c.normal)) - 1) > 8 * eps<T>) fail("normal is not a unit", c);
        if (length(wide(c.normal) - Point{sign * n.x, sign * n.y, sign * n.z}) >
            8 * eps<T> * turn * std::max(1 / total, Wide(1)))
            fail("wrong normal", c);
        const Point penetration = wide(c.penetration);
        if (c.depth > 0 && length(penetration - offset) > 16 * blur_of_offset)
            fail("penetration is not proxy - stylus", c);
        if (std::abs(length(penetration) - static_cast<Wide>(c.depth)) >
            8 * eps<T> * length(penetration) + std::sqrt(static_cast<Wide>(std::numeric_limits<T>::min()))) {
            fail("depth is not the length of penetration", c);
        }
        // What counts as wrong for a distance.
        const Wide wrong = (sizeof(T) == 8 ? 1e-12L : 4e-6L) *
                               surface_.patch(at.i, at.j)->reach(surface_.seen_from(q, at.i, at.j)) +
                           4 * eps<T> * (std::abs(q.x) + std::abs(q.y));
        if (c.status == ContactStatus::contact && c.depth > 0 && !too_steep(at) && !hair_from_border(at) &&
            sign * dot(offset, n) < -wrong && !goes_in(proxy, q, sign))
            fail("pulls towards the surface", c);
        // Each patch adds the rounding of the heights over the query and of the places in cells to the distance.
        // A search from a released minimum that is under way goes on to where the stylus is now: what it comes to is another
        // contact, and may be farther.
        // So is the tracker's proxy, where a glide ends.
        const bool ends_glide = last.glide.is_under_way && !work_->now().glide.is_under_way;
        if (last.contact.touching() && last.state.phase != TrackerPhase::releasing && !ends_glide) {
            const WideSurfacePoint from = wide(last.contact.point);
            if (surface_.patch(from.i, from.j)) {
                const Wide began = length(surface_.position(from) - q), ended = length(offset);
                const Wide rounding = (4 + c.patches) * (4 * eps<T> * began + 4 * blur);
                if (ended > began + rounding) fail("the distance rose", c);
            }
        }
        if (c.status == ContactStatus::contact) {
            // Along the surface the proxy may be off by what the gradient does not resolve; across it not. A stylus on
            // the surface may be in contact from afar, with nothing felt.
            const Wide inwards = sign * dot(offset, n);
            if (!(c.depth > 0) && !too_steep(at) &&
                (inwards > wrong || (inwards < -wrong && std::abs(above_) > 64 * blur)))
                fail("in contact without penetration", c);
            if (!hair_from_border(at) && !rounded_twist(at) && surface_.template fall<T>(at, q) > 64)
                fail("a patch leads down", c);
        }
    }

    /// Whether the segment from the proxy leads below the surface (sign 1; above it: −1) over its first hundredth of a
    /// cell. At a vertex among patches of very different slopes the averaged normal may be wrong about that.
    [[nodiscard]] bool goes_in(const Point& proxy, const Point& to, Wide sign) const {
        const Wide cells =
            std::max(std::abs(to.x - proxy.x) / surface_.dx(), std::abs(to.y - proxy.y) / surface_.dy());
        for (const Wide part : {0.01L, 0.003L, 0.001L}) {
            const Wide t = std::min(part / std::max(cells, Wide(1e-9L)), part);
            const auto z = surface_.height(proxy.x + t * (to.x - proxy.x), proxy.y + t * (to.y - proxy.y));
            if (!z || sign * (proxy.z + t * (to.z - proxy.z) - *z) >= 0) return false;
        }
        return true;
    }
    [[nodiscard]] bool within_rim(const Point& q) const {
        const Wide x = surface_.column_of(q.x), y = surface_.row_of(q.y), hair = 1e-9L;
        return x > hair && x < static_cast<Wide>(terrain_.columns - 1) - hair && y > hair &&
               y < static_cast<Wide>(terrain_.rows - 1) - hair;
    }
    /// So near a border that the gain of going there is no number.
    [[nodiscard]] static bool hair_from_border(const WideSurfacePoint& s) {
        const Wide hair = std::sqrt(static_cast<Wide>(std::numeric_limits<T>::min()));
        return open.hair_from_border && ((s.u > 0 && s.u < hair) || (s.v > 0 && s.v < hair));
    }
    /// Much steeper one way than the other.
    [[nodiscard]] bool rounded_twist(const WideSurfacePoint& s) const {
        bool found = false;
        surface_.each_patch_at(s, [&](const test::WidePatch& p, Wide, Wide, Index, Index) {
            const Wide mu = std::max(std::abs(p.along_u(0)), std::abs(p.along_u(1))) / p.dx,
                       mv = std::max(std::abs(p.along_v(0)), std::abs(p.along_v(1))) / p.dy;
            found = found || std::max(mu, mv) > 8 * std::min(mu, mv);
        });
        return open.rounded_twist && found;
    }
    /// Where float does not resolve the way along a cliff, the proxy may stop level with the stylus.
    [[nodiscard]] bool too_steep(const WideSurfacePoint& s) const {
        bool found = false;
        surface_.each_patch_at(s, [&](const test::WidePatch& p, Wide, Wide, Index, Index) {
            found = found || p.highest() - p.lowest() > 2 * std::min(p.dx, p.dy);
        });
        return open.level_on_a_cliff && sizeof(T) == 4 && found;
    }
    /// On cliffs Newton's method follows a bent valley by small steps, and has so many in an update.
    [[nodiscard]] bool creeps(const WideSurfacePoint& s) const {
        bool found = false;
        surface_.each_patch_at(s, [&](const test::WidePatch& p, Wide, Wide, Index, Index) {
            found = found || p.highest() - p.lowest() > 256 * std::min(p.dx, p.dy);
        });
        return found;
    }
    /// How uncertain the height over q is: so near a line that the next cell may count as well.
    [[nodiscard]] Wide blur_around(const WideSurfacePoint& s, const Point& q) const {
        Wide blur = 0;
        for (Index j = s.j - 1; j <= s.j + 1; ++j) {
            for (Index i = s.i - 1; i <= s.i + 1; ++i) {
                if (surface_.patch(i, j)) blur = std::max(blur, surface_.blur({i, j, 0, 0}, q, eps<T>));
            }
        }
        return blur;
    }
    /// Over a patch and not on its rim.
    [[nodiscard]] bool strictly_over(const Point& q) const {
        const auto s = surface_.under(q.x, q.y);
        return s && surface_.missing_at(*s) == 0 && s->u > 1e-9L && s->u < 1 - 1e-9L && s->v > 1e-9L &&
               s->v < 1 - 1e-9L;
    }
    /// Whether there was surface all the way from the last position to this one. Among holes that says something while
    /// the stylus is free only, for the proxy goes its own way.
    [[nodiscard]] bool glides() const { return glide_speed_ > 0; }
    [[nodiscard]] bool all_over_surface(const Point& to, const Memory& was) const {
        if (!holes_) return true;
        if (was.touching) return false;
        const Point from = wide(was.last);
        for (int k = 0; k <= 1000; ++k) {
            const Wide t = Wide(k) / 1000;
            const auto s = surface_.under(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            if (!s || surface_.missing_at(*s) > 0) return false;
        }
        return true;
    }

    [[noreturn]] void fail(const char* rule, const Contact<T>& c) const {
        std::string told = sizeof(T) == 8 ? "double, " : "float, ";
        const auto add = [&](auto... parts) { ((told += parts, told += ' '), ...); };
        const auto& f = terrain_.frame;
        add(options_.surface == SurfaceKind::solid ? "solid" : "sheet", "max_patches",
            std::to_string(options_.max_patches), "max_contact_patches",
            std::to_string(options_.max_contact_patches), "glide", test::digits(glide_speed_));
        add(std::to_string(terrain_.columns), "x", std::to_string(terrain_.rows), "origin",
            test::digits(f.origin.x), test::digits(f.origin.y));
        add("spacing", test::digits(f.spacing.x), test::digits(f.spacing.y), "heights now, south row first:");
        for (const T height : terrain_.heights) add(test::digits(height));
        for (const auto& e : events_) {
            switch (e.kind) {
            case Event<T>::update: add("\nupdate", test::digits(e.stylus)); break;
            case Event<T>::edit:
                add("\nedit", std::to_string(e.i), std::to_string(e.j), test::digits(e.height));
                break;
            case Event<T>::reset: add("\nreset"); break;
            case Event<T>::save: add("\nsave"); break;
            case Event<T>::restore: add("\nrestore"); break;
            case Event<T>::stroke: add("\nstroke"); break;
            }
        }
        add("\n", to_string(c.status), "proxy", test::digits(c.proxy), "in cell",
            std::to_string(c.point.cell.i), std::to_string(c.point.cell.j), "at", test::digits(c.point.u),
            test::digits(c.point.v));
        add("above", test::digits(static_cast<double>(above_)), "depth", test::digits(c.depth), "normal",
            test::digits(c.normal), "patches", std::to_string(c.patches));
        broken(rule, told);
    }

    Bytes* bytes_;
    Terrain<T> terrain_;
    Surface<T> surface_{terrain_};
    Grid grid_ = terrain_.grid();
    TrackerOptions options_;
    std::optional<Work> work_;
    [[nodiscard]] const auto& tracker() const { return work_->tracker(); }
    ForceEvaluator<T> force_;
    Memory memory_, saved_memory_;
    Moment saved_{};
    std::vector<Event<T>> events_;
    vec3<T> stylus_{T(0)};
    double stride_ = 1, step_ = 1, relief_ = 1;
    Contact<T> last_{};
    ContactStatus was_ = ContactStatus::free;
    // The last stylus: the place under it, its height above that, how much of it may be rounding, and whether all that
    // is to be relied on.
    std::optional<WideSurfacePoint> under_;
    Wide above_ = 0, tolerance_ = 0;
    bool there_ = false;
    bool holes_ = false; // there are, or were
    /// Cliffs are not so high that nothing but what holds in any case can be said of a contact.
    bool tame_ = true, rest_is_judged_ = true;
    double glide_speed_ = 0; // m an update; 0: none
};

/// A field that breaks its contract, with NaN, infinity and numbers without squares for heights: an update returns within
/// its bound, whatever it returns.
template <Real T>
void touch_raw_field(Bytes& bytes) {
    Terrain<T> terrain = test::plane<T>(bytes.whole(2, 5), bytes.whole(2, 5));
    for (T& height : terrain.heights)
        height = bytes.flag() ? bytes.raw<T>() : static_cast<T>(bytes.small() / 16);
    const test::RawField<T> field{terrain};
    const test::CountingField counting{field};
    const TrackerOptions options{.surface = bytes.flag() ? SurfaceKind::sheet : SurfaceKind::solid,
                                 .max_patches = any_limit(bytes),
                                 .max_contact_patches = any_limit(bytes)};
    ProxyTracker tracker{counting, options};
    for (int n = 0; n < 100 && !bytes.empty(); ++n, ++tally.updates) {
        const double x = 6 * bytes.share() - 1, y = 6 * bytes.share() - 1, z = bytes.small() / 16;
        const long before = counting.looks();
        const auto c = tracker.update({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
        if (c.patches > options.max_patches + 16 ||
            counting.looks() - before > 4 * (options.max_patches + 16L)) {
            Story story;
            for (const T height : terrain.heights) story("height", height);
            broken("more work than was allowed on a raw field", story("x", x)("y", y)("z", z).told());
        }
    }
}

} // namespace
} // namespace hfh::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace hfh::fuzz;
    return touch_in_either_scalar({data, size}, []<hfh::Real T>(Bytes& bytes, bool raw) {
        if (raw) {
            touch_raw_field<T>(bytes);
        } else {
            Session<T>{bytes}.run();
        }
    });
}
