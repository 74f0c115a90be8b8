#ifndef CHAI3D_HEIGHT_FIELD_PROXY_HPP
#define CHAI3D_HEIGHT_FIELD_PROXY_HPP

#include <chai3d.h>

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/terrain/dilated_field.hpp>

#include <array>
#include <concepts>
#include <utility>

// Height fields of hfh in CHAI3D 3.3: in the place of a tool's finger proxy, or as an object with effects. Field and object
// share one frame: the field's metres are the object's local coordinates, whose z is up.

namespace hfh_chai3d {

/// A tool in the hand moves by less than a cell in an update. What takes longer goes on in the next one; the ground raised by
/// a tip takes microseconds a patch.
inline constexpr hfh::TrackerOptions default_options{.max_patches = 200, .max_contact_patches = 8};

[[nodiscard]] inline hfh::vec3<double> to_hfh(const chai3d::cVector3d& v) noexcept {
    return {v.x(), v.y(), v.z()};
}
[[nodiscard]] inline chai3d::cVector3d to_chai3d(const hfh::vec3<double>& v) noexcept {
    return {v.x, v.y, v.z};
}

/// A tool's finger proxy on a height field. It takes the place of `cHapticPoint::m_algorithmFingerProxy`, so everything that
/// asks the tool for its proxy, its contacts and its forces gets those on the field:
///
///     auto* ground = new chai3d::cMesh();            // what is drawn; also any other object
///     world->addChild(ground);
///     hfh_chai3d::feel(*tool->m_hapticPoint, grid, *ground);
///
/// - The *proxy* is the centre of the tip. With the radius 0 it is on the ground, otherwise so far above it that the drawn
///   sphere touches it. `cToolCursor::setRadius` and `setRadiusContact` change it while touching.
/// - The *material* of the object acts live: stiffness in N/m of the world, static and dynamic friction, shading
///   (`setUseHapticFriction`, `setUseHapticShading`).
/// - The *object* may be moved and turned while it is touched. Ground that comes up from below meets the tool as a tool that
///   comes down does. As always in CHAI3D, call `world->computeGlobalPositions(true)` after it was moved.
/// - `reset` and `initialize`, of the tool, the haptic point or this proxy, make the next position count as the first one.
///   A tool that starts below the ground feels nothing until it was above.
/// - A position that is no number gives no force, and the proxy stays where it was.
/// - An object that is not enabled, or not for haptics (`setHapticEnabled(false)`), is not felt.
/// - `isInContact(object)`, `getNumCollisionEvents()` and the collision event have the contact: one event, of type
///   C_COL_NOT_DEFINED, because there is no triangle.
///
/// Meshes are not felt by a tool that has this proxy; objects with effects are, because the haptic point asks them by itself.
///
/// Keeps references to field and object, which must outlive the tool. No update allocates.
template <hfh::HeightField Field>
class HeightFieldProxy : public chai3d::cAlgorithmFingerProxy {
    static_assert(std::same_as<typename Field::Scalar, double>,
                  "CHAI3D computes in double, and so has the field to");

public:
    HeightFieldProxy(const Field& field, chai3d::cGenericObject& object,
                     const hfh::TrackerOptions& options = default_options)
        : object_{&object}, point_{field, options}, dilated_{field, 0}, ball_{dilated_, options} {}

    /// The tool is at `device`, in coordinates of the world. Returns the force in newtons, in the world's axes.
    chai3d::cVector3d computeForces(const chai3d::cVector3d& device, const chai3d::cVector3d&) override {
        if (was_reset()) forget();
        m_algoCounter = updated; // both ways to reset set it to 0
        m_deviceGlobalPos = device;
        if (!object_->getEnabled() || !object_->getHapticEnabled()) {
            forget();
            return tell({}, device, chai3d::cIdentity3d());
        }
        const chai3d::cVector3d origin = object_->getGlobalPos();
        const chai3d::cMatrix3d axes = object_->getGlobalRot();
        const auto stylus = to_hfh(chai3d::cTranspose(axes) * (device - origin));
        const auto contact = feel(stylus);
        if (contact.status == hfh::ContactStatus::bad_input) return tell(contact, m_proxyGlobalPos, axes);
        return tell(contact, contact.touching() ? origin + axes * to_chai3d(contact.proxy) : device, axes);
    }

    /// What the last update found, in the object's frame.
    [[nodiscard]] const hfh::Contact<double>& contact() const noexcept { return contact_; }

private:
    static constexpr unsigned updated = 1;

    [[nodiscard]] bool was_reset() const noexcept { return m_algoCounter != updated; }
    void forget() noexcept {
        point_.reset();
        ball_.reset();
        friction_.reset();
    }

    /// The contact as it is felt, shaded and held back.
    [[nodiscard]] hfh::Contact<double> feel(const hfh::vec3<double>& stylus) noexcept {
        if (!(m_radius > 0)) {
            if (radius_ > 0) point_.restore(ball_.state()); // the cells are the same
            radius_ = 0;
            return on(point_, stylus);
        }
        if (radius_ != m_radius) {
            if (!(radius_ > 0)) ball_.restore(point_.state());
            dilated_ = {point_.field(), m_radius}; // for the tracker an edit of the ground
            radius_ = m_radius;
        }
        return on(ball_, stylus);
    }
    template <class Ground>
    [[nodiscard]] hfh::Contact<double> on(hfh::ProxyTracker<Ground>& tracker,
                                          const hfh::vec3<double>& stylus) noexcept {
        const auto& material = *object_->m_material;
        auto contact = tracker.update(stylus);
        if (material.getUseHapticShading()) contact = hfh::shade_force(tracker.field(), contact);
        if (!material.getUseHapticFriction()) {
            friction_.reset();
            return contact;
        }
        const auto anchor = friction_.state(); // the coefficients may be others than before
        friction_ = hfh::Friction<double>{
            {.at_rest = material.getStaticFriction(), .sliding = material.getDynamicFriction()}};
        friction_.restore(anchor);
        return friction_.hold(tracker.field(), contact, stylus);
    }

    /// Fills in what CHAI3D asks a finger proxy for. Returns the force.
    const chai3d::cVector3d& tell(const hfh::Contact<double>& contact, const chai3d::cVector3d& proxy,
                                  const chai3d::cMatrix3d& axes) {
        contact_ = contact;
        m_proxyGlobalPos = m_nextBestProxyGlobalPos = proxy;
        const chai3d::cVector3d normal = axes * to_chai3d(contact.normal);
        m_lastGlobalForce = axes * to_chai3d(object_->m_material->getStiffness() * contact.penetration);
        m_normalForce = normal * m_lastGlobalForce.dot(normal);
        m_tangentialForce = m_lastGlobalForce - m_normalForce;

        auto& event = m_collisionRecorderConstraint0.m_nearestCollision;
        event.clear();
        m_numCollisionEvents = contact.touching() ? 1 : 0;
        if (contact.touching()) {
            event.m_object = object_;
            event.m_localPos = to_chai3d(contact.proxy);
            event.m_globalPos = proxy;
            event.m_localNormal = to_chai3d(contact.normal);
            event.m_globalNormal = normal;
        }
        return m_lastGlobalForce;
    }

    chai3d::cGenericObject* object_;
    hfh::ProxyTracker<Field> point_;
    hfh::DilatedField<Field> dilated_; ///< the ground raised by the tip
    hfh::ProxyTracker<hfh::DilatedField<Field>> ball_;
    hfh::Friction<double> friction_;
    double radius_ = 0; ///< of the last update
    hfh::Contact<double> contact_{};
};

/// Gives a haptic point a proxy on a height field, in the place of the one that it has. The point owns it; its radius and
/// its world are those of the one before.
template <hfh::HeightField Field>
HeightFieldProxy<Field>& feel(chai3d::cHapticPoint& point, const Field& field, chai3d::cGenericObject& object,
                              const hfh::TrackerOptions& options = default_options) {
    chai3d::cAlgorithmFingerProxy* const before = point.m_algorithmFingerProxy;
    auto* const proxy = new HeightFieldProxy<Field>(field, object, options);
    proxy->setProxyRadius(before->getProxyRadius());
    proxy->initialize(before->getWorld(), before->getDeviceGlobalPosition());
    point.m_algorithmFingerProxy = proxy;
    delete before;
    return *proxy;
}
template <hfh::HeightField Field>
void feel(chai3d::cHapticPoint&, const Field&&, chai3d::cGenericObject&,
          const hfh::TrackerOptions& = default_options) = delete;

/// A height field as an object with effects: for tools with several haptic points of which each shall feel it beside meshes,
/// and for what effects add (`createEffectSurface`, `createEffectStickSlip`, viscosity, vibration).
///
///     auto* ground = new hfh_chai3d::HeightFieldObject(grid);
///     ground->createEffectSurface();
///     world->addChild(ground);
///
/// Its effects act while a tool is in the ground; the point of the surface that they are given is the proxy, so it is not
/// the nearest one but that which a stylus slides to, and holds behind ridges. Tools are told apart by the number of their
/// algorithm, of which CHAI3D allows `C_EFFECT_MAX_IDN`; one with a larger number feels nothing. The tip is a point. It
/// draws nothing: make what is drawn its child.
///
/// Keeps a reference to the field, which must outlive it. No update allocates.
template <hfh::HeightField Field>
class HeightFieldObject : public chai3d::cGenericObject {
    static_assert(std::same_as<typename Field::Scalar, double>,
                  "CHAI3D computes in double, and so has the field to");

public:
    explicit HeightFieldObject(const Field& field) : HeightFieldObject(field, Numbers{}) {}
    explicit HeightFieldObject(const Field&&) = delete;

    /// Forgets all tools, as after one was set to another place.
    void reset() noexcept {
        for (auto& tracker : trackers_) tracker.reset();
    }

    void computeLocalInteraction(const chai3d::cVector3d& tool, const chai3d::cVector3d&,
                                 const unsigned int number) override {
        m_interactionInside = false;
        if (number >= trackers_.size()) return;
        const auto contact = trackers_[number].update(to_hfh(tool));
        m_interactionInside = contact.touching();
        m_interactionPoint = to_chai3d(contact.proxy);
        m_interactionNormal = to_chai3d(contact.normal);
    }

private:
    static constexpr std::size_t tools = chai3d::C_EFFECT_MAX_IDN;
    using Numbers = std::make_index_sequence<tools>;

    template <std::size_t... N>
    HeightFieldObject(const Field& field, std::index_sequence<N...>)
        : trackers_{((void)N, hfh::ProxyTracker<Field>{field, default_options})...} {}

    std::array<hfh::ProxyTracker<Field>, tools> trackers_;
};

} // namespace hfh_chai3d

#endif // CHAI3D_HEIGHT_FIELD_PROXY_HPP
