#ifndef HFH_BENCH_GOALS_PEERS_HPP
#define HFH_BENCH_GOALS_PEERS_HPP

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

// Other libraries that answer the same queries on the same heights. Each is a file of its own and built where its
// package is found (HFH_HAS_EMBREE, HFH_HAS_CGAL, HFH_HAS_BULLET); where it is not, its maker returns nothing.

namespace hfh::bench {

/// Sample (i, j), i along x and j along y, at data[i + j * row_stride], lies at (i·spacing.x, j·spacing.y).
struct PeerHeights {
    const std::int16_t* data;
    std::int64_t columns, rows, row_stride;
    glm::dvec2 spacing;

    [[nodiscard]] std::int16_t operator()(std::int64_t i, std::int64_t j) const noexcept {
        return data[i + j * row_stride];
    }
    /// Calls `corner(sample number)` for the corners of both triangles of every cell, split from (0, 0) to (1, 1).
    template <class Visitor>
    void triangles(Visitor&& triangle) const {
        for (std::int64_t j = 0; j + 1 < rows; ++j) {
            for (std::int64_t i = 0; i + 1 < columns; ++i) {
                const auto at = static_cast<std::uint32_t>(i + j * columns),
                           up = at + static_cast<std::uint32_t>(columns);
                triangle(at, at + 1, up + 1);
                triangle(at, up + 1, up);
            }
        }
    }
};

/// In metres.
template <class T>
struct CastSegment {
    glm::vec<3, T> a, b;
};
using PeerSegment = CastSegment<double>;

/// Finds where segments first meet the surface.
struct CastPeer {
    virtual ~CastPeer() = default;
    /// How far along each segment the first crossing is, 0 to 1; 2: none.
    virtual void cast(const PeerSegment* segments, std::size_t count, double* t) = 0;
    [[nodiscard]] virtual std::string name() const = 0;
};

/// Finds closest points of a trajectory, each with the help of the one before.
struct ClosestPeer {
    virtual ~ClosestPeer() = default;
    /// `last`: a point of the surface to begin with. The closest point to each of the queries goes to `found`.
    virtual void follow(const glm::dvec3* queries, std::size_t count, glm::dvec3 last, glm::dvec3* found) = 0;
    [[nodiscard]] virtual std::string name() const = 0;
};

#ifdef HFH_HAS_EMBREE
enum class EmbreeMesh { triangles, quads, grid };
[[nodiscard]] std::unique_ptr<CastPeer> embree_casts(const PeerHeights&, EmbreeMesh);
[[nodiscard]] std::unique_ptr<ClosestPeer> embree_point_query(const PeerHeights&);
#endif
#ifdef HFH_HAS_CGAL
[[nodiscard]] std::unique_ptr<ClosestPeer> cgal_aabb_tree(const PeerHeights&);
#endif
#ifdef HFH_HAS_BULLET
[[nodiscard]] std::unique_ptr<CastPeer> bullet_height_field(const PeerHeights&, bool accelerator);
#endif

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_PEERS_HPP
