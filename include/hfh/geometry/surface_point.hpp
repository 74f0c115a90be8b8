#ifndef HFH_GEOMETRY_SURFACE_POINT_HPP
#define HFH_GEOMETRY_SURFACE_POINT_HPP

#include <hfh/geometry/lattice.hpp>

// The words in which the algorithms speak of the surface.

namespace hfh {

/// A solid is met from above only; a sheet has no inside and is met from either side.
enum class SurfaceKind : unsigned char { solid, sheet };

/// Which side of the surface a point is on; `none` where there is no surface above or below it.
enum class Side : signed char { below = -1, none = 0, above = 1 };

/// A point of the surface: a cell and where in it, 0 ≤ u, v ≤ 1. Its height is the patch's, whatever that is now,
/// so the point stays on the surface when the heights are edited.
template <Real T>
struct SurfacePoint {
    Cell cell{};
    T u{}, v{};
};

/// Whether the point lies on an edge or a vertex of its cell, which it then shares with other cells.
template <Real T>
[[nodiscard]] constexpr bool on_border(const SurfacePoint<T>& p) noexcept {
    return p.u <= 0 || p.u >= 1 || p.v <= 0 || p.v >= 1;
}

} // namespace hfh

#endif // HFH_GEOMETRY_SURFACE_POINT_HPP
