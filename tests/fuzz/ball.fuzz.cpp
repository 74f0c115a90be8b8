#include "bytes.hpp"

#include "support/ball_judge.hpp"
#include "support/counting_field.hpp"
#include "support/hard_ground.hpp"
#include "support/raw_field.hpp"

#include <hfh/contact/ball_tracker.hpp>

#include <array>
#include <vector>

// A ball's tracker on a small terrain, with any limit of its work: moves of every size, edits, holes, cliffs, heights of any
// size, positions that are none, radii that change while it touches. Every update is judged by what holds whatever work is
// allowed: it returns within its bound, with numbers, and with a force in contact only. With unlimited work a ball is never free
// in a solid, by every patch in reach. Of an endless loop libFuzzer's -timeout tells.
//
// The number of updates that were judged is printed at the end.

namespace hfh::fuzz {
namespace {

using test::BallSurface;
using test::Point;
using test::Terrain;
using test::wide;
using test::Wide;

/// What fuzzing has found and is not mended yet: not reported again while true.
struct Open {
    /// Held still, a ball of less than a twentieth of a cell takes thousands of updates to arrive, and one that may look at no more than
    /// one step takes may try the same step again and again.
    bool rest = true;
};
constexpr Open open;

/// Counts the updates of the whole run.
struct Tally {
    long updates = 0;
    Tally() = default;
    Tally(const Tally&) = delete;
    Tally& operator=(const Tally&) = delete;
    ~Tally() { std::fprintf(stderr, "judged %ld updates of a ball\n", updates); }
};
Tally tally;

/// Every small limit, those between, and none.
int any_limit(Bytes& bytes) {
    switch (bytes.byte() % 4) {
    case 0: return bytes.whole(1, 4);
    case 1: return bytes.whole(1, 40);
    case 2: return 1 + bytes.raw<std::uint16_t>() % 8192;
    default: return TrackerOptions{}.max_patches;
    }
}

template <Real T>
class Session {
public:
    explicit Session(Bytes& bytes) : bytes_{&bytes} {
        const auto kind = static_cast<test::HardGround>(bytes.byte() % test::hard_grounds);
        test::Random random{bytes.raw<std::uint16_t>()};
        terrain_ = test::hard_ground<T>(kind, random);
        if (bytes.byte() % 4 == 0) test::punch_holes(terrain_, bytes.whole(2, 40), bytes.byte());
        tame_ = kind < test::HardGround::no_data;
        cell_ = std::min(terrain_.frame.spacing.x, terrain_.frame.spacing.y);
        grid_ = terrain_.grid();
        options_.surface = bytes.byte() % 4 == 0 ? SurfaceKind::sheet : SurfaceKind::solid;
        options_.max_patches = any_limit(bytes);
        options_.max_contact_patches = any_limit(bytes);
        tracker_.emplace(counting_, any_radius(), options_);
        place(bytes.share(), bytes.share());
        lift(2 * static_cast<double>(tracker_->radius()) + cell_);
    }

    void run() {
        constexpr int most_events = 100;
        for (int n = 0; n < most_events && !bytes_->empty(); ++n) act();
    }

private:
    using Grid = typename Terrain<T>::Grid;
    using Counting = test::CountingField<Grid>;
    using Tracker = BallTracker<Counting>;

    /// 0, and 10⁻⁶ to 16 cells.
    [[nodiscard]] T any_radius() {
        Bytes& b = *bytes_;
        switch (b.byte() % 8) {
        case 0: return T(0);
        case 1: return static_cast<T>(cell_ * std::pow(10.0, -b.whole(0, 6)));
        default: return static_cast<T>(cell_ * std::ldexp(1 + b.share(), b.whole(-4, 2)));
        }
    }
    void place(double share_x, double share_y) {
        const auto& f = terrain_.frame;
        stylus_.x =
            static_cast<T>(f.origin.x + share_x * static_cast<double>(terrain_.columns - 1) * f.spacing.x);
        stylus_.y =
            static_cast<T>(f.origin.y + share_y * static_cast<double>(terrain_.rows - 1) * f.spacing.y);
    }
    /// To `metres` over the surface, where there is one.
    void lift(double metres) {
        const Point q = wide(stylus_);
        if (const auto z = surface_.surface().height(q.x, q.y))
            stylus_.z = static_cast<T>(static_cast<double>(*z) + metres);
    }
    [[nodiscard]] double step() { return bytes_->small() / 128 * step_ * cell_; }

    void act() {
        Bytes& b = *bytes_;
        switch (b.byte() % 20) {
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
        case 8:
            place(b.share(), b.share());
            lift(step());
            break;
        case 9: lift(step()); break;
        case 10: lift(static_cast<double>(tracker_->radius())); break;
        case 11: { // far away, the way back in one move
            const vec3<T> here = stylus_;
            stylus_ += vec3<T>{static_cast<T>(b.small() * cell_), static_cast<T>(b.small() * cell_),
                               static_cast<T>(b.small() * cell_)};
            update(stylus_);
            if (b.flag()) stylus_ = here;
            break;
        }
        case 12: refused(); return;
        case 13:
        case 14: edit(); break;
        case 15:
            tracker_->set_radius(any_radius());
            changed_ = true;
            break;
        case 16:
            if (b.byte() % 4 != 0) return;
            tracker_->reset();
            changed_ = true;
            break;
        case 17: {
            const auto saved = tracker_->state();
            update(stylus_);
            tracker_->restore(saved);
            changed_ = true;
            break;
        }
        default: rest(); return;
        }
        update(stylus_);
    }

    void edit() {
        Bytes& b = *bytes_;
        T& sample = terrain_.at(b.whole(0, static_cast<int>(terrain_.columns - 1)),
                                b.whole(0, static_cast<int>(terrain_.rows - 1)));
        switch (b.byte() % 8) {
        case 0: sample = std::numeric_limits<T>::quiet_NaN(); break;
        case 1:
            sample = b.raw<T>(); // of any size
            tame_ = false;
            break;
        default: sample = (is_finite(sample) ? sample : T(0)) + static_cast<T>(step()); break;
        }
        changed_ = true;
    }

    /// Numbers that are none, or have no square: nothing is felt, nothing changes.
    void refused() {
        constexpr std::array<T, 4> bad{std::numeric_limits<T>::quiet_NaN(),
                                       std::numeric_limits<T>::infinity(), std::numeric_limits<T>::max(),
                                       std::numeric_limits<T>::lowest()};
        const unsigned which = bytes_->byte();
        vec3<T> at = stylus_;
        (which / 4 % 3 == 0 ? at.x : which / 4 % 3 == 1 ? at.y : at.z) = bad[which % bad.size()];
        const auto before = tracker_->state();
        const auto found = tracker_->update(at);
        const auto& after = tracker_->state();
        if (found.status != ContactStatus::bad_input || found.depth != 0 || found.count != 0)
            fail("bad input is felt", at, found);
        if (before.centre != after.centre || before.phase != after.phase || before.side != after.side)
            fail("bad input changed the state", at, found);
    }

    /// Held still the ball arrives: at a minimum, free, or away from the surface.
    void rest() {
        const glm::dvec3 way = tracker_->centre() - widen(stylus_);
        const double cells = glm::length(way) / cell_ + 1;
        if (open.rest || !tame_ || !(cells < 200)) {
            update(stylus_);
            return;
        }
        // Each update goes one step at least; steps are shortest where the ball turns round an edge.
        const double shortest = std::max(static_cast<double>(tracker_->radius()) / cell_, 0.5) / 64;
        const int most = static_cast<int>(64 + 4 * cells / shortest);
        for (int n = 0; n < most; ++n) {
            const auto found = update(stylus_);
            if (found.status != ContactStatus::descent_limit && found.status != ContactStatus::sweep_limit)
                return;
        }
        fail("does not arrive at rest", stylus_, update(stylus_));
    }

    /// What an update may look at, as the tracker's page has it, and an update that gives back as it ends.
    [[nodiscard]] long bound() const {
        const double radius = static_cast<double>(tracker_->radius());
        const double wide = radius + std::max(radius, cell_) / 2;
        const auto& spacing = terrain_.frame.spacing;
        const double least = 8 * (2 * wide / spacing.x + 3) * (2 * wide / spacing.y + 3);
        return static_cast<long>(std::max(static_cast<double>(options_.max_patches), least));
    }

    BallContact<T> update(const vec3<T>& stylus) {
        ++tally.updates;
        const bool was_free = tracker_->state().phase == TrackerPhase::free && !tracker_->state().is_buried;
        const bool was_touching = tracker_->state().touching();
        const Point last = wide(vec3<double>{tracker_->centre()});
        const long before = counting_.looks();
        const auto found = tracker_->update(stylus);
        if (tracker_->radius() > 0 && (found.patches < 0 || found.patches > 3 * bound()))
            fail("more work than is allowed", stylus, found);
        if (counting_.looks() - before > 40 * (bound() + 64)) fail("more looks than work", stylus, found);
        judge(stylus, found, was_free || was_touching, last);
        changed_ = false;
        return found;
    }

    void judge(const vec3<T>& stylus, const BallContact<T>& found, bool was_outside, const Point& last) {
        const auto holds = [](const vec3<T>& p) {
            return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
        };
        bool all = holds(found.proxy) && holds(found.normal) && holds(found.penetration) &&
                   is_finite(found.depth) && 0 <= found.count && found.count <= BallContact<T>::max_touches;
        for (int n = 0; all && n < found.count; ++n)
            all = holds(found.touches[n].normal) && is_finite(found.touches[n].share) &&
                  holds(vec3<T>{found.touches[n].point.u, found.touches[n].point.v, T(0)});
        if (!all) fail("not a number", stylus, found);
        if (!(found.depth >= 0)) fail("a depth below zero", stylus, found);
        if (found.status != ContactStatus::bad_input && found.touching() != tracker_->state().touching())
            fail("touching, and then not", stylus, found);
        if (!found.touching()) {
            if (found.depth != 0 || found.count != 0 || found.penetration != vec3<T>{T(0)} ||
                found.proxy != stylus)
                fail("not touching, but something is felt", stylus, found);
            judge_freedom(stylus, found, was_outside);
            return;
        }
        // Never farther, if nothing has changed under it.
        if (tame_ && !changed_ && was_outside && tracker_->radius() > 0) {
            const Point to = wide(stylus), centre = test::centre_of(stylus, found);
            const Wide before = test::length(last - to), after = test::length(centre - to);
            const Wide rounding = 8 * static_cast<Wide>(epsilon<T>) *
                                  (test::largest_coordinate(to) + test::largest_coordinate(centre) + before);
            if (after > before + rounding + 1e-9L * static_cast<Wide>(tracker_->radius()) && found.depth > 0)
                fail("farther than the last centre", stylus, found);
        }
    }

    /// A solid: never free where the ball overlaps it, nor below it.
    void judge_freedom(const vec3<T>& stylus, const BallContact<T>& found, bool was_outside) {
        const Wide r = static_cast<Wide>(tracker_->radius());
        if (!tame_ || !(r > 0) || found.status != ContactStatus::free ||
            options_.surface == SurfaceKind::sheet)
            return;
        const test::BallJudge<T> judge{terrain_};
        const auto verdict = judge({{},
                                    was_outside ? ContactStatus::free : ContactStatus::buried,
                                    stylus,
                                    found,
                                    r,
                                    options_.surface});
        if (!verdict.fault.empty()) fail(verdict.fault.c_str(), stylus, found);
    }

    [[noreturn]] void fail(const char* rule, const vec3<T>& stylus, const BallContact<T>& found) const {
        std::string told = sizeof(T) == 8 ? "double, " : "float, ";
        const auto add = [&](auto... parts) { ((told += parts, told += ' '), ...); };
        add(options_.surface == SurfaceKind::solid ? "solid" : "sheet", "max_patches",
            std::to_string(options_.max_patches), "max_contact_patches",
            std::to_string(options_.max_contact_patches), "radius", test::digits(tracker_->radius()), "\n");
        const auto& f = terrain_.frame;
        add(std::to_string(terrain_.columns), "x", std::to_string(terrain_.rows), "origin",
            test::digits(f.origin.x), test::digits(f.origin.y), "spacing", test::digits(f.spacing.x),
            test::digits(f.spacing.y), "heights, south row first:");
        for (const T height : terrain_.heights) add(test::digits(height));
        add("\nstylus", test::digits(stylus), to_string(found.status), "proxy", test::digits(found.proxy),
            "depth", test::digits(found.depth), "patches", std::to_string(found.patches), "of",
            std::to_string(bound()));
        broken(rule, told);
    }

    Bytes* bytes_;
    Terrain<T> terrain_;
    BallSurface<T> surface_{terrain_};
    Grid grid_ = terrain_.grid();
    Counting counting_{grid_};
    TrackerOptions options_;
    std::optional<Tracker> tracker_;
    vec3<T> stylus_{T(0)};
    double cell_ = 1, step_ = 1;
    bool changed_ = true; ///< ground, radius or state, since the last update
    bool tame_ = true;    ///< no heights too far apart to be told by distances
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
    BallTracker tracker{counting,
                        static_cast<T>(bytes.byte() / 32.0),
                        {.surface = bytes.flag() ? SurfaceKind::sheet : SurfaceKind::solid,
                         .max_patches = any_limit(bytes),
                         .max_contact_patches = any_limit(bytes)}};
    for (int n = 0; n < 100 && !bytes.empty(); ++n, ++tally.updates) {
        const double x = 6 * bytes.share() - 1, y = 6 * bytes.share() - 1, z = bytes.small() / 16;
        const long before = counting.looks();
        (void)tracker.update({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
        if (counting.looks() - before > 1'000'000) {
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
