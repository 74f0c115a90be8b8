#include "peers.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

// Embree 3 in float, the only scalar it has. The closest point of a triangle is ours to find: Embree's point query
// walks its tree and calls back with the triangles that come within the radius.

namespace hfh::bench {
namespace {

struct Vertex {
    float x, y, z;
};
Vertex operator-(Vertex a, Vertex b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vertex operator+(Vertex a, Vertex b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vertex operator*(float k, Vertex a) { return {k * a.x, k * a.y, k * a.z}; }
float dot(Vertex a, Vertex b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Ericson, Real-Time Collision Detection, 2005, §5.1.5.
Vertex closest_of_triangle(Vertex p, Vertex a, Vertex b, Vertex c) {
    const Vertex ab = b - a, ac = c - a, ap = p - a;
    const float d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Vertex bp = p - b;
    const float d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
    const Vertex cp = p - c;
    const float d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    const float scale = 1 / (va + vb + vc);
    return a + (vb * scale) * ab + (vc * scale) * ac;
}

/// A scene with one mesh.
class Scene {
public:
    Scene(const PeerHeights& heights, EmbreeMesh mesh) : device_{rtcNewDevice("threads=1")} {
        scene_ = rtcNewScene(device_);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
        const auto type = mesh == EmbreeMesh::triangles ? RTC_GEOMETRY_TYPE_TRIANGLE
                          : mesh == EmbreeMesh::quads   ? RTC_GEOMETRY_TYPE_QUAD
                                                        : RTC_GEOMETRY_TYPE_GRID;
        const RTCGeometry geometry = rtcNewGeometry(device_, type);
        const auto columns = static_cast<std::size_t>(heights.columns),
                   rows = static_cast<std::size_t>(heights.rows);
        auto* vertex = static_cast<Vertex*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vertex), columns * rows));
        vertices_ = vertex;
        for (std::int64_t j = 0; j < heights.rows; ++j) {
            for (std::int64_t i = 0; i < heights.columns; ++i) {
                *vertex++ = {static_cast<float>(static_cast<double>(i) * heights.spacing.x),
                             static_cast<float>(static_cast<double>(j) * heights.spacing.y),
                             static_cast<float>(heights(i, j))};
            }
        }
        const std::size_t cells = (columns - 1) * (rows - 1);
        if (mesh == EmbreeMesh::triangles) {
            auto* index = static_cast<std::uint32_t*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 2 * cells));
            indices_ = index;
            heights.triangles([&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                *index++ = a, *index++ = b, *index++ = c;
            });
        } else if (mesh == EmbreeMesh::quads) {
            auto* index = static_cast<std::uint32_t*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, cells));
            for (std::uint32_t j = 0; j + 1 < rows; ++j) {
                for (std::uint32_t i = 0; i + 1 < columns; ++i) {
                    const auto width = static_cast<std::uint32_t>(columns), at = i + j * width;
                    *index++ = at, *index++ = at + 1, *index++ = at + width + 1, *index++ = at + width;
                }
            }
        } else {
            auto* grid = static_cast<RTCGrid*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0,
                                                                       RTC_FORMAT_GRID, sizeof(RTCGrid), 1));
            *grid = {0, static_cast<unsigned>(columns), static_cast<std::uint16_t>(columns),
                     static_cast<std::uint16_t>(rows)};
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
        if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::runtime_error{"Embree made no scene"};
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    ~Scene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    [[nodiscard]] RTCScene scene() const noexcept { return scene_; }
    /// Of a triangle, of the mesh of triangles.
    [[nodiscard]] const Vertex& corner(unsigned triangle, unsigned k) const noexcept {
        return vertices_[indices_[3 * std::size_t{triangle} + k]];
    }

private:
    RTCDevice device_;
    RTCScene scene_;
    const Vertex* vertices_ = nullptr;
    const std::uint32_t* indices_ = nullptr;
};

class Casts : public CastPeer {
public:
    Casts(const PeerHeights& heights, EmbreeMesh mesh) : scene_{heights, mesh}, mesh_{mesh} {}

    void cast(const PeerSegment* segments, std::size_t count, double* t) override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t k = 0; k < count; ++k) {
            const glm::dvec3 &a = segments[k].a, along = segments[k].b - a;
            RTCRayHit ray;
            ray.ray.org_x = static_cast<float>(a.x);
            ray.ray.org_y = static_cast<float>(a.y);
            ray.ray.org_z = static_cast<float>(a.z);
            ray.ray.dir_x = static_cast<float>(along.x);
            ray.ray.dir_y = static_cast<float>(along.y);
            ray.ray.dir_z = static_cast<float>(along.z);
            ray.ray.tnear = 0;
            ray.ray.tfar = 1;
            ray.ray.time = 0;
            ray.ray.mask = ~0u;
            ray.ray.id = 0;
            ray.ray.flags = 0;
            ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene_.scene(), &context, &ray);
            t[k] = ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? 2.0 : static_cast<double>(ray.ray.tfar);
        }
    }
    std::string name() const override {
        return mesh_ == EmbreeMesh::triangles ? "Embree triangles"
               : mesh_ == EmbreeMesh::quads   ? "Embree quads"
                                              : "Embree grid";
    }

private:
    Scene scene_;
    EmbreeMesh mesh_;
};

/// rtcPointQuery, bounded by the distance to the last answer: that is a point of the surface, so the closest one is no
/// farther.
class PointQuery : public ClosestPeer {
public:
    explicit PointQuery(const PeerHeights& heights) : scene_{heights, EmbreeMesh::triangles} {}

    void follow(const glm::dvec3* queries, std::size_t count, glm::dvec3 last, glm::dvec3* found) override {
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        Nearest nearest{&scene_,
                        {},
                        {static_cast<float>(last.x), static_cast<float>(last.y), static_cast<float>(last.z)}};
        for (std::size_t k = 0; k < count; ++k) {
            nearest.query = {static_cast<float>(queries[k].x), static_cast<float>(queries[k].y),
                             static_cast<float>(queries[k].z)};
            const Vertex off = nearest.query - nearest.point;
            RTCPointQuery query;
            query.x = nearest.query.x;
            query.y = nearest.query.y;
            query.z = nearest.query.z;
            query.time = 0;
            query.radius = std::sqrt(dot(off, off)) * 1.000001f; // rounding may not hide the last answer
            rtcPointQuery(scene_.scene(), &query, &context, offer, &nearest);
            found[k] = {nearest.point.x, nearest.point.y, nearest.point.z};
        }
    }
    std::string name() const override { return "Embree point query"; }

private:
    struct Nearest {
        const Scene* scene;
        Vertex query, point;
    };
    static bool offer(RTCPointQueryFunctionArguments* args) {
        auto& nearest = *static_cast<Nearest*>(args->userPtr);
        const auto& scene = *nearest.scene;
        const Vertex point =
            closest_of_triangle(nearest.query, scene.corner(args->primID, 0), scene.corner(args->primID, 1),
                                scene.corner(args->primID, 2));
        const Vertex off = nearest.query - point;
        const float distance = std::sqrt(dot(off, off));
        if (distance >= args->query->radius) return false;
        args->query->radius = distance;
        nearest.point = point;
        return true;
    }

    Scene scene_;
};

} // namespace

std::unique_ptr<CastPeer> embree_casts(const PeerHeights& heights, EmbreeMesh mesh) {
    return std::make_unique<Casts>(heights, mesh);
}
std::unique_ptr<ClosestPeer> embree_point_query(const PeerHeights& heights) {
    return std::make_unique<PointQuery>(heights);
}

} // namespace hfh::bench
