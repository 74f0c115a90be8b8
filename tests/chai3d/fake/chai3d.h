#ifndef HFH_TESTS_FAKE_CHAI3D_H
#define HFH_TESTS_FAKE_CHAI3D_H

// A stand-in for the few classes of CHAI3D 3.3 that examples/chai3d calls, written after its documentation, to test the glue
// without the library. Each behaves as the real one as far as the glue can tell.

#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace chai3d {

class cVector3d {
public:
    cVector3d() = default;
    cVector3d(double x, double y, double z) : at_{x, y, z} {}
    [[nodiscard]] double x() const { return at_[0]; }
    [[nodiscard]] double y() const { return at_[1]; }
    [[nodiscard]] double z() const { return at_[2]; }
    [[nodiscard]] double dot(const cVector3d& b) const { return x() * b.x() + y() * b.y() + z() * b.z(); }
    [[nodiscard]] double length() const { return std::sqrt(dot(*this)); }
    void zero() { at_ = {}; }
    friend cVector3d operator+(const cVector3d& a, const cVector3d& b) {
        return {a.x() + b.x(), a.y() + b.y(), a.z() + b.z()};
    }
    friend cVector3d operator-(const cVector3d& a, const cVector3d& b) {
        return {a.x() - b.x(), a.y() - b.y(), a.z() - b.z()};
    }
    friend cVector3d operator*(const cVector3d& a, double s) { return {a.x() * s, a.y() * s, a.z() * s}; }

private:
    std::array<double, 3> at_{};
};

class cMatrix3d {
public:
    cMatrix3d() = default;
    cMatrix3d(const cVector3d& row0, const cVector3d& row1, const cVector3d& row2)
        : rows_{row0, row1, row2} {}
    friend cVector3d operator*(const cMatrix3d& m, const cVector3d& v) {
        return {m.rows_[0].dot(v), m.rows_[1].dot(v), m.rows_[2].dot(v)};
    }
    [[nodiscard]] cMatrix3d transposed() const {
        const auto& r = rows_;
        return {
            {r[0].x(), r[1].x(), r[2].x()}, {r[0].y(), r[1].y(), r[2].y()}, {r[0].z(), r[1].z(), r[2].z()}};
    }

private:
    std::array<cVector3d, 3> rows_{};
};
inline cMatrix3d cTranspose(const cMatrix3d& m) { return m.transposed(); }
inline cMatrix3d cIdentity3d() { return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; }

class cMaterial {
public:
    void setStiffness(double stiffness) { stiffness_ = stiffness; }
    [[nodiscard]] double getStiffness() const { return stiffness_; }
    void setStaticFriction(double friction) { static_ = friction, friction_ = true; }
    void setDynamicFriction(double friction) { dynamic_ = friction, friction_ = true; }
    [[nodiscard]] double getStaticFriction() const { return static_; }
    [[nodiscard]] double getDynamicFriction() const { return dynamic_; }
    void setUseHapticFriction(bool use) { friction_ = use; }
    [[nodiscard]] bool getUseHapticFriction() const { return friction_; }
    void setUseHapticShading(bool use) { shading_ = use; }
    [[nodiscard]] bool getUseHapticShading() const { return shading_; }

private:
    double stiffness_ = 0, static_ = 0, dynamic_ = 0;
    bool friction_ = false, shading_ = false;
};

inline constexpr int C_EFFECT_MAX_IDN = 16;

class cGenericObject {
public:
    virtual ~cGenericObject() = default;
    [[nodiscard]] cVector3d getGlobalPos() const { return position_; }
    [[nodiscard]] cMatrix3d getGlobalRot() const { return rotation_; }
    void setLocalPos(const cVector3d& position) { position_ = position; }
    void setLocalRot(const cMatrix3d& rotation) { rotation_ = rotation; }
    [[nodiscard]] bool getEnabled() const { return enabled_; }
    void setEnabled(bool enabled) { enabled_ = enabled; }
    [[nodiscard]] bool getHapticEnabled() const { return haptic_; }
    void setHapticEnabled(bool enabled) { haptic_ = enabled; }
    virtual void computeLocalInteraction(const cVector3d&, const cVector3d&, const unsigned int) {}

    std::shared_ptr<cMaterial> m_material = std::make_shared<cMaterial>();
    cVector3d m_interactionPoint, m_interactionNormal;
    bool m_interactionInside = false;

private:
    cVector3d position_;
    cMatrix3d rotation_ = cIdentity3d();
    bool enabled_ = true, haptic_ = true;
};

class cWorld : public cGenericObject {};

struct cCollisionEvent {
    cGenericObject* m_object = nullptr;
    cVector3d m_localPos, m_globalPos, m_localNormal, m_globalNormal;
    void clear() { *this = {}; }
};
struct cCollisionRecorder {
    cCollisionEvent m_nearestCollision;
};

class cAlgorithmFingerProxy {
protected:
    cCollisionRecorder m_collisionRecorderConstraint0, m_collisionRecorderConstraint1,
        m_collisionRecorderConstraint2;

public:
    cAlgorithmFingerProxy() = default;
    cAlgorithmFingerProxy(const cAlgorithmFingerProxy&) = delete;
    virtual ~cAlgorithmFingerProxy() { ++destroyed; }
    [[nodiscard]] cWorld* getWorld() { return m_world; }
    void initialize(cWorld* world, const cVector3d& position) {
        m_world = world;
        m_deviceGlobalPos = m_proxyGlobalPos = position;
        m_lastGlobalForce.zero();
        m_numCollisionEvents = 0;
        m_algoCounter = 0;
    }
    void reset() { initialize(m_world, m_deviceGlobalPos); }
    virtual cVector3d computeForces(const cVector3d&, const cVector3d&) { return {}; }
    void setProxyRadius(const double& radius) { m_radius = radius; }
    [[nodiscard]] double getProxyRadius() const { return m_radius; }
    [[nodiscard]] cVector3d getProxyGlobalPosition() const { return m_proxyGlobalPos; }
    [[nodiscard]] cVector3d getDeviceGlobalPosition() const { return m_deviceGlobalPos; }
    [[nodiscard]] cVector3d getNormalForce() { return m_normalForce; }
    [[nodiscard]] cVector3d getTangentialForce() { return m_tangentialForce; }
    [[nodiscard]] int getNumCollisionEvents() { return static_cast<int>(m_numCollisionEvents); }

    cCollisionEvent* m_collisionEvents[3]{&m_collisionRecorderConstraint0.m_nearestCollision,
                                          &m_collisionRecorderConstraint1.m_nearestCollision,
                                          &m_collisionRecorderConstraint2.m_nearestCollision};
    static inline int destroyed = 0; ///< for the tests

protected:
    cWorld* m_world = nullptr;
    cVector3d m_proxyGlobalPos, m_deviceGlobalPos, m_lastGlobalForce, m_nextBestProxyGlobalPos;
    cVector3d m_normalForce, m_tangentialForce;
    unsigned int m_numCollisionEvents = 0, m_algoCounter = 0;
    double m_radius = 0;
};

class cHapticPoint {
public:
    cHapticPoint() = default;
    cHapticPoint(const cHapticPoint&) = delete;
    ~cHapticPoint() { delete m_algorithmFingerProxy; }
    void setRadius(double radius) { m_algorithmFingerProxy->setProxyRadius(radius); }
    [[nodiscard]] bool isInContact(cGenericObject* object) const {
        return m_algorithmFingerProxy->m_collisionEvents[0]->m_object == object;
    }
    cAlgorithmFingerProxy* m_algorithmFingerProxy = new cAlgorithmFingerProxy();
};

} // namespace chai3d

#endif // HFH_TESTS_FAKE_CHAI3D_H
