#ifndef VIEWER_HAPTICS_HPP
#define VIEWER_HAPTICS_HPP

#include "felt_ground.hpp"
#include "mouse_hand.hpp"
#include "path_hand.hpp"
#include "row_queue.hpp"

#include <touch.hpp>

#include <hfh/device/force_guard.hpp>
#include <hfh/device/triple_buffer.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/simulation/simulated_device.hpp>

#include <optional>

namespace viewer {

enum class DeviceKind : unsigned char { touch, premium, none, phantom };

struct HapticsSettings {
    DeviceKind device = DeviceKind::touch;
    std::optional<double> stiffness; ///< N/m at the hand; none: the device's
    demo::Tip tip;                   ///< the ball that touches
    double release_speed =
        0; ///< m at the hand an update: of a proxy that a ridge lets go; 0: it does not glide
    std::optional<hfh::DeviceCapabilities> real_device; ///< of a `phantom`
    std::vector<demo::StylusSample> path;               ///< in the terrain; empty: the pointer moves the hand
    glm::dvec2 size{0.0}; ///< m of terrain, from the south-west sample to the north-east one
    double cell = 1;      ///< m of terrain between samples
};

/// m of terrain per m of hand at which all of a terrain of `size` (m) is within the device's reach.
[[nodiscard]] double whole_terrain_scale(DeviceKind device, const glm::dvec2& size) noexcept;

/// The half of the program that is about the hand: everything that happens in one update of a millisecond, and what goes to
/// and comes from the display without waiting.
///
/// A simulated device is held by a hand that wants to be where the pointer or a path says. Or there is no device, and the
/// stylus is where the hand wants to be, whatever the force. Or the hand is a person's, and holds a real device.
class Haptics {
public:
    using Rows = RowQueue<demo::Touch, 8192>;

    /// `ground` must outlive it.
    Haptics(FeltGround& ground, HapticsSettings settings);

    /// One update of the simulated device, or of a stylus without one.
    void tick() noexcept;
    /// One update of a real device, in place of `tick`. Its first button moves the hand without the stylus, its second one is
    /// as good as a press for the brush.
    hfh::DeviceCommand update(const hfh::DeviceSample& sample) noexcept;

    /// After the last update: no force any more.
    void end() noexcept;

    /// From one other thread.
    void tell(const HandInput& input) noexcept { input_.put(input); }
    bool show(HandState& state) noexcept { return shown_.take(state); }
    [[nodiscard]] Rows& rows() noexcept { return rows_; }

    /// Once no update runs any more.
    [[nodiscard]] const hfh::GuardCounts& guard_counts() const noexcept { return guard_.counts(); }
    [[nodiscard]] static constexpr double period() noexcept { return 1e-3; }
    /// Whether a real device is expected to call `update`.
    [[nodiscard]] bool is_in_a_hand() const noexcept { return settings_.device == DeviceKind::phantom; }
    /// The one that touches until the display says otherwise.
    [[nodiscard]] const demo::Tip& default_tip() const noexcept { return settings_.tip; }
    [[nodiscard]] double default_release_speed() const noexcept { return settings_.release_speed; }
    /// N/m at the hand, by default.
    [[nodiscard]] double default_stiffness() const noexcept;

private:
    struct Wanted {
        const glm::dvec3* position;
        [[nodiscard]] glm::dvec3 operator()(double) const noexcept { return *position; }
    };
    using Device = hfh::SimulatedDevice<Wanted>;

    void take_input() noexcept;
    void change_scale() noexcept;
    void change_level() noexcept;
    void move_hand() noexcept;
    void paint(bool presses) noexcept;
    hfh::GuardedForce feel(const hfh::DeviceSample& sample, const glm::dvec3& stylus) noexcept;
    void publish(const glm::dvec3& hand, const glm::dvec3& stylus, const hfh::GuardedForce& felt) noexcept;
    void show_whole_terrain() noexcept;
    [[nodiscard]] glm::dvec3 ground_normal(const glm::dvec2& terrain) const noexcept;
    /// m at the hand: where the stylus would touch.
    [[nodiscard]] double ground_at_hand(const glm::dvec2& terrain) const noexcept;

    FeltGround* ground_;
    HapticsSettings settings_;
    double cell_;
    hfh::DeviceModel model_;
    hfh::Workspace<double>& workspace_; ///< the ground's loop's
    hfh::ForceGuard& guard_;            ///< the ground's loop's

    glm::dvec3 wanted_{0.0}; ///< m at the hand
    MouseHand mouse_;
    std::optional<PathHand> path_;
    std::optional<Device> device_;
    glm::dvec3 newtons_{0.0}; ///< at the hand
    double last_ground_ = 0;  ///< m at the hand, where the stylus was last over ground
    glm::dvec3 last_stylus_{0.0};
    hfh::Contact<double> contact_{};
    std::uint64_t updates_ = 0;

    HandInput told_{}, before_{}; ///< what the display says, and what has been done of its totals
    double zoom_left_ = 0;        ///< log₂ of the scale, still to come
    double smallest_scale_ = 0, largest_scale_ = 0;
    bool painting_ = false;
    Spot spot_{};
    hfh::Index spot_row_ = 0;
    bool spot_is_open_ = false;
    double unpainted_ = 0; ///< m of terrain
    bool undoing_ = false;
    HandState state_{};

    hfh::TripleBuffer<HandInput> input_;
    hfh::TripleBuffer<HandState> shown_;
    Rows rows_;
};

} // namespace viewer

#endif // VIEWER_HAPTICS_HPP
