#ifndef VIEWER_HAND_INPUT_HPP
#define VIEWER_HAND_INPUT_HPP

#include <tip_options.hpp>

#include <hfh/contact/contact.hpp>
#include <hfh/device/guard_limits.hpp>
#include <hfh/geometry/lattice.hpp>

#include <algorithm>
#include <cstdint>

// What the display tells the hand and what the hand tells the display. Both are plain values that go through a triple buffer,
// which may overwrite one before it was taken: so whatever must not get lost travels as a total since the start.

namespace viewer {

/// How the ground feels; the panel changes it.
struct Feel {
    double stiffness = 400; ///< N/m at the hand
    double friction = 0;    ///< coefficient at rest; sliding: four fifths of it
    double damping = 0;     ///< N·s/m at the hand
    bool shading = false;   ///< force directions interpolated over vertices
    demo::Tip tip;          ///< the ball that touches
    double release_speed =
        0; ///< m at the hand an update: of a proxy that a ridge lets go; 0: it does not glide
};

/// At which level of detail the ground is felt and drawn.
struct LevelChoice {
    bool by_scale = true;
    double level = 0;             ///< if not by scale
    double cell_at_hand = 0.5e-3; ///< m: by scale, what a cell measures in the hand
};

enum class BrushKind : unsigned char { none, dig, heap };

struct Brush {
    BrushKind kind = BrushKind::none;
    double radius = 6e-3; ///< m at the hand
    double rate = 4e-3;   ///< m at the hand per second and newton
};

/// Where a pointer is, as the ray that is seen as one pixel: in the hand's metres.
struct PointerRay {
    glm::dvec3 from{0.0};
    glm::dvec3 direction{0, 0, -1};
};

struct HandInput {
    PointerRay pointer;
    bool has_pointer = false; ///< else the hand stays where it is
    bool pressing = false;
    double firmness = 1; ///< N that a press begins with; it grows while the button is down
    double zoom = 0;     ///< total: log₂ of how many times larger the terrain is than at the start
    glm::dvec2 pan{0.0}; ///< total: m in the hand by which the terrain has been moved
    Feel feel;
    LevelChoice level;
    double finest_loaded = 1e9; ///< level whose samples around the hand are in memory; at first none
    Brush brush;
    unsigned undos = 0;           ///< total
    unsigned resets = 0;          ///< total: back to the whole terrain
    std::uint64_t edits_seen = 0; ///< `HandState::edit` of the last edit that the display has taken over
};

/// Samples (i, j) with begin ≤ (i, j) < end.
struct SampleRange {
    hfh::Cell begin{0, 0};
    hfh::Cell end{0, 0};
    [[nodiscard]] bool empty() const noexcept { return end.i <= begin.i || end.j <= begin.j; }
};

[[nodiscard]] inline SampleRange united(const SampleRange& a, const SampleRange& b) noexcept {
    if (a.empty() || b.empty()) return a.empty() ? b : a;
    return {{std::min(a.begin.i, b.begin.i), std::min(a.begin.j, b.begin.j)},
            {std::max(a.end.i, b.end.i), std::max(a.end.j, b.end.j)}};
}

struct HandState {
    double time = 0; ///< s since the start, of updates
    std::uint64_t updates = 0;
    glm::dvec3 wanted{0.0}; ///< where the hand wants to be; m at the hand
    glm::dvec3 hand{0.0};   ///< where the device is; m at the hand
    glm::dvec3 stylus{0.0}; ///< m of terrain
    glm::dvec3 proxy{0.0};  ///< m of terrain; out of contact: on the ground below the stylus, if there is any
    glm::dvec3 normal{0, 0, 1};
    double tip = 0;        ///< m of terrain: the radius of the ball that touches, whose centre is the proxy
    glm::dvec3 force{0.0}; ///< N at the hand, as felt
    bool over_ground = false;
    hfh::ContactStatus status = hfh::ContactStatus::free;
    hfh::GuardTrip trip = hfh::GuardTrip::none;
    double scale = 1;        ///< m of terrain per m of hand
    glm::dvec3 offset{0.0};  ///< m of terrain: where the middle of the workspace is
    double level = 0;        ///< at which the ground is felt
    double microseconds = 0; ///< that the last update took
    double wanted_level = 0; ///< at which it will be felt, once the samples are in memory
    std::uint64_t edit = 0;  ///< number of the last edit
    SampleRange edited{};    ///< all samples changed since the edit that the display has seen
    unsigned undoable = 0;   ///< strokes that can be undone
    bool has_touched = false;

    [[nodiscard]] bool touching() const noexcept {
        return status == hfh::ContactStatus::contact || status == hfh::ContactStatus::descent_limit;
    }
    [[nodiscard]] glm::dvec3 to_hand(const glm::dvec3& terrain) const noexcept {
        return (terrain - offset) / scale;
    }
};

} // namespace viewer

#endif // VIEWER_HAND_INPUT_HPP
