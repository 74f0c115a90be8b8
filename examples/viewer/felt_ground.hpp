#ifndef VIEWER_FELT_GROUND_HPP
#define VIEWER_FELT_GROUND_HPP

#include "hand_input.hpp"

#include <terrain.hpp>

#include <hfh/loop/haptic_loop.hpp>

#include <memory>

namespace viewer {

/// What one update felt.
struct Felt {
    hfh::Contact<double> contact{};
    glm::dvec3 asked{0.0}; ///< N at the hand, before the guard
    hfh::GuardedForce force{};
};

/// A round spot of ground that is raised, or lowered where `amount` is below 0.
struct Spot {
    glm::dvec2 middle{0.0}; ///< m of terrain
    double radius = 0;      ///< m of terrain
    double amount = 0;      ///< m, at the middle; falls to nothing at the radius
};

/// A terrain under the hand, whatever the type of its samples. All calls but `read_level` are the haptic thread's: they do not
/// allocate and do not wait. It alone writes samples.
class FeltGround {
public:
    virtual ~FeltGround() = default;

    /// Makes the haptic loop anew.
    virtual void begin(const hfh::HapticLoopOptions& options) noexcept = 0;
    /// The radius of the ball that touches, m of terrain. Gives the radius that it has from now on: as large a ball as an
    /// update can pay for measures 16 cells of the level.
    virtual double set_tip(double radius) noexcept = 0;
    /// How fast a proxy glides that a ridge lets go, m at the hand an update; 0: it does not glide.
    virtual void set_release_speed(double release_speed) noexcept = 0;
    /// One update of the haptic loop.
    virtual Felt update(const hfh::DeviceSample& sample, const hfh::Material& material) noexcept = 0;
    /// The loop's, which zooms and moves between updates.
    [[nodiscard]] virtual hfh::Workspace<double>& workspace() noexcept = 0;
    /// The loop's.
    [[nodiscard]] virtual hfh::ForceGuard& guard() noexcept = 0;
    /// Forgets the stylus and the force.
    virtual void reset() noexcept = 0;
    /// The height of the ground at the level that is felt, m; NaN where there is none.
    [[nodiscard]] virtual double height(const glm::dvec2& at) const noexcept = 0;

    /// The level at which the ground is felt, and the coarsest one there is.
    [[nodiscard]] virtual double level() const noexcept = 0;
    [[nodiscard]] virtual double coarsest_level() const noexcept = 0;
    /// Changes the level, and touch goes along. Gives how far the ground rose there, in metres: the stylus has to be moved by as
    /// much before its next update.
    virtual double set_level(double level) noexcept = 0;

    /// Begins a stroke of the brush, which one `undo` takes back.
    virtual void begin_stroke() noexcept = 0;
    /// Changes some samples of a spot, row by row from `row` on, which it moves on; at the end it is past the spot's last
    /// one, and true comes back. `changed` grows by the samples that were changed.
    virtual bool paint(const Spot& spot, hfh::Index& row, SampleRange& changed) noexcept = 0;
    /// Takes the last stroke back, some samples a call; true once it is done.
    virtual bool undo(SampleRange& changed) noexcept = 0;
    [[nodiscard]] virtual unsigned undoable_strokes() const noexcept = 0;
    /// Metres by which a sample can change at least.
    [[nodiscard]] virtual double smallest_change() const noexcept = 0;
    /// The most metres that a spot's radius may have.
    [[nodiscard]] virtual double largest_radius() const noexcept = 0;
};

/// `terrain` was read for editing and must outlive what is returned. Throws BadInput where it makes no surface.
[[nodiscard]] std::unique_ptr<FeltGround> make_felt_ground(const demo::Terrain& terrain,
                                                           const hfh::GridFrame& frame);

} // namespace viewer

#endif // VIEWER_FELT_GROUND_HPP
