#include "peers.hpp"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>

#include <algorithm>
#include <vector>

// Bullet's height field in the scalar of Debian's package, float. Its frame has the middle of the grid and of the
// heights as origin.

namespace hfh::bench {
namespace {

class First : public btTriangleRaycastCallback {
public:
    using btTriangleRaycastCallback::btTriangleRaycastCallback;
    btScalar reportHit(const btVector3&, btScalar fraction, int, int) override {
        m_hitFraction = fraction; // farther triangles are left out from here on
        return fraction;
    }
};

class HeightField : public CastPeer {
public:
    HeightField(const PeerHeights& heights, bool accelerator)
        : samples_(south_first(heights)), lowest_{*std::min_element(samples_.begin(), samples_.end())},
          highest_{*std::max_element(samples_.begin(), samples_.end())},
          shape_{static_cast<int>(heights.columns),
                 static_cast<int>(heights.rows),
                 samples_.data(),
                 1,
                 static_cast<btScalar>(lowest_),
                 static_cast<btScalar>(highest_),
                 2,
                 false},
          accelerator_{accelerator} {
        shape_.setLocalScaling(
            {static_cast<btScalar>(heights.spacing.x), static_cast<btScalar>(heights.spacing.y), 1});
        if (accelerator) shape_.buildAccelerator();
        middle_ = {heights.spacing.x * static_cast<double>(heights.columns - 1) / 2,
                   heights.spacing.y * static_cast<double>(heights.rows - 1) / 2,
                   (static_cast<double>(lowest_) + static_cast<double>(highest_)) / 2};
    }

    void cast(const PeerSegment* segments, std::size_t count, double* t) override {
        for (std::size_t k = 0; k < count; ++k) {
            const btVector3 a = local(segments[k].a), b = local(segments[k].b);
            First first{a, b};
            shape_.performRaycast(&first, a, b);
            t[k] = first.m_hitFraction < 1 ? static_cast<double>(first.m_hitFraction) : 2.0;
        }
    }
    std::string name() const override { return accelerator_ ? "Bullet with accelerator" : "Bullet"; }

private:
    static std::vector<short> south_first(const PeerHeights& heights) {
        std::vector<short> samples;
        samples.reserve(static_cast<std::size_t>(heights.columns * heights.rows));
        for (std::int64_t j = 0; j < heights.rows; ++j) {
            for (std::int64_t i = 0; i < heights.columns; ++i) samples.push_back(heights(i, j));
        }
        return samples;
    }
    [[nodiscard]] btVector3 local(const glm::dvec3& world) const {
        const glm::dvec3 from_middle = world - middle_;
        return {static_cast<btScalar>(from_middle.x), static_cast<btScalar>(from_middle.y),
                static_cast<btScalar>(from_middle.z)};
    }

    std::vector<short> samples_;
    short lowest_, highest_;
    btHeightfieldTerrainShape shape_;
    glm::dvec3 middle_{};
    bool accelerator_;
};

} // namespace

std::unique_ptr<CastPeer> bullet_height_field(const PeerHeights& heights, bool accelerator) {
    return std::make_unique<HeightField>(heights, accelerator);
}

} // namespace hfh::bench
