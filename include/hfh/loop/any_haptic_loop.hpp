#ifndef HFH_LOOP_ANY_HAPTIC_LOOP_HPP
#define HFH_LOOP_ANY_HAPTIC_LOOP_HPP

#include <hfh/loop/haptic_loop.hpp>

#include <utility>

namespace hfh {

/// A `HapticLoop` on a field whose type is known at run time only: what the samples are, the scalar, whether there are
/// bounds, a tip or an extension. Field, tracker and all the rest are behind one indirect call an update; everything inside
/// of it is compiled for the type. (A field that is erased by itself costs a call for each of its patches.)
///
///     std::unique_ptr<hfh::AnyHapticLoop> loop;
///     if (is_16_bit) loop = std::make_unique<hfh::FieldLoop<Grid16>>(options, heights16, frame);
///     else           loop = std::make_unique<hfh::FieldLoop<GridF>>(options, heights_f, frame);
///     device.run([&](const hfh::DeviceSample& sample) { return loop->update(sample); });
///
/// Each call is that of `HapticLoop`, in double whatever the scalar. Nothing here allocates, and who has no heap places
/// the `FieldLoop` anywhere else.
class AnyHapticLoop {
public:
    AnyHapticLoop(const AnyHapticLoop&) = delete;
    AnyHapticLoop& operator=(const AnyHapticLoop&) = delete;
    virtual ~AnyHapticLoop() = default;

    [[nodiscard]] virtual DeviceCommand update(const DeviceSample& sample) noexcept = 0;
    [[nodiscard]] virtual const Material& material() const noexcept = 0;
    virtual void set_material(const Material& material) noexcept = 0;
    virtual void set_release_speed(double release_speed) noexcept = 0;
    virtual void reset() noexcept = 0;
    /// `BallTracker::set_radius`, in metres of terrain; a point stays one.
    virtual void set_tip_radius(double radius) noexcept = 0;

    [[nodiscard]] virtual glm::dvec3 stylus() const noexcept = 0;
    [[nodiscard]] virtual Contact<double> contact() const noexcept = 0;
    [[nodiscard]] virtual const glm::dvec3& asked() const noexcept = 0;
    [[nodiscard]] virtual const GuardedForce& force() const noexcept = 0;
    [[nodiscard]] virtual ForceGuard& guard() noexcept = 0;

    [[nodiscard]] virtual const WorkspaceFrame& frame() const noexcept = 0;
    virtual WorkspaceStatus zoom(double scale, const glm::dvec3& about) noexcept = 0; ///< `Workspace::zoom`
    virtual WorkspaceStatus move(const glm::dvec3& by) noexcept = 0;                  ///< `Workspace::move`

protected:
    AnyHapticLoop() = default;
};

/// A field and the loop on it. The field is made here, of the arguments behind the options, and stays where it is, so it
/// may be a type of yours that holds a field and another one around it.
template <HeightField Field, class Tip = PointTip>
class FieldLoop final : public AnyHapticLoop {
public:
    using Scalar = typename Field::Scalar;

    template <class... Args>
    explicit FieldLoop(const HapticLoopOptions& options, Args&&... field) noexcept
        : field_(std::forward<Args>(field)...), loop_{field_, options} {}

    /// For edits of what the field keeps beside the samples, as its bounds, between updates.
    [[nodiscard]] Field& field() noexcept { return field_; }
    [[nodiscard]] HapticLoop<Field, Tip>& loop() noexcept { return loop_; }

    [[nodiscard]] DeviceCommand update(const DeviceSample& sample) noexcept override {
        return loop_.update(sample);
    }
    [[nodiscard]] const Material& material() const noexcept override { return loop_.material(); }
    void set_material(const Material& material) noexcept override { loop_.set_material(material); }
    void set_release_speed(double release_speed) noexcept override { loop_.set_release_speed(release_speed); }
    void reset() noexcept override { loop_.reset(); }
    void set_tip_radius(double radius) noexcept override {
        if constexpr (requires { loop_.tracker().set_radius(Scalar{}); })
            loop_.tracker().set_radius(static_cast<Scalar>(radius));
    }

    [[nodiscard]] glm::dvec3 stylus() const noexcept override { return widen(loop_.stylus()); }
    [[nodiscard]] Contact<double> contact() const noexcept override {
        const Contact<Scalar>& c = loop_.contact();
        return {.status = c.status,
                .side = c.side,
                .shaded = c.shaded,
                .patches = c.patches,
                .proxy = widen(c.proxy),
                .normal = widen(c.normal),
                .penetration = widen(c.penetration),
                .depth = widen(c.depth),
                .point = {c.point.cell, widen(c.point.u), widen(c.point.v)}};
    }
    [[nodiscard]] const glm::dvec3& asked() const noexcept override { return loop_.asked(); }
    [[nodiscard]] const GuardedForce& force() const noexcept override { return loop_.force(); }
    [[nodiscard]] ForceGuard& guard() noexcept override { return loop_.guard(); }

    [[nodiscard]] const WorkspaceFrame& frame() const noexcept override { return loop_.workspace().frame(); }
    WorkspaceStatus zoom(double scale, const glm::dvec3& about) noexcept override {
        return loop_.workspace().zoom(scale, about);
    }
    WorkspaceStatus move(const glm::dvec3& by) noexcept override { return loop_.workspace().move(by); }

private:
    Field field_;
    HapticLoop<Field, Tip> loop_;
};

} // namespace hfh

#endif // HFH_LOOP_ANY_HAPTIC_LOOP_HPP
