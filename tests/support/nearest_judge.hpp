#ifndef HFH_TESTS_SUPPORT_NEAREST_JUDGE_HPP
#define HFH_TESTS_SUPPORT_NEAREST_JUDGE_HPP

#include "hard_patches.hpp"
#include "reference.hpp"

#include <hfh/traversal/nearest_point.hpp>

#include <string>

// Judges the nearest point of a field by brute force in long double: every patch that may come nearer than what is claimed,
// its edges and its inside scanned. Shares no code with the library.

namespace hfh::test {

/// By how much a distance may be too large, as a share of the largest length.
template <Real T>
inline constexpr Wide nearest_promise = std::is_same_v<T, float> ? 4e-6L : 1e-12L;

/// A query near a terrain: 10⁻⁶ to `farthest` cells off the surface, above and below, over holes, rims, vertices and beside
/// the grid.
template <Real T>
[[nodiscard]] vec3<T> nearest_query(Random& random, const Terrain<T>& ground, double farthest) {
    const Surface<T> surface{ground};
    const double columns = static_cast<double>(ground.columns - 1),
                 rows = static_cast<double>(ground.rows - 1);
    const glm::dvec2 spacing = ground.frame.spacing;
    const double off = 1e-6 * std::pow(farthest / 1e-6, random.unit()) * std::min(spacing.x, spacing.y);
    glm::dvec2 at{random.between(0, columns), random.between(0, rows)};
    switch (random.whole(0, 9)) {
    case 0: at.x = std::round(at.x); break;
    case 1: at = glm::round(at); break;
    case 2: at.x = random.one_in(2) ? 0 : columns; break;
    case 3: at.y = random.one_in(2) ? 0 : rows; break;
    case 4: at = {random.one_in(2) ? 0 : columns, random.one_in(2) ? 0 : rows}; break;
    default: break;
    }
    glm::dvec2 plan = ground.frame.origin + at * spacing;
    const auto under = surface.under(static_cast<Wide>(plan.x), static_cast<Wide>(plan.y));
    double z = under ? static_cast<double>(surface.position(*under).z) : 0;
    if (!under) { // over a hole: as high as some sample
        for (int tries = 0; tries < 100; ++tries) {
            const Index i = static_cast<Index>(random.whole(0, ground.columns - 1)),
                        j = static_cast<Index>(random.whole(0, ground.rows - 1));
            if (!surface.has_sample(i, j)) continue;
            z = static_cast<double>(surface.sample_at(i, j));
            break;
        }
    }
    glm::dvec3 way{0, 0, random.one_in(2) ? 1 : -1};
    switch (random.whole(0, 3)) {
    case 0: break;
    case 1:
        if (under) {
            const Point n = surface.normal(*under);
            way *= glm::dvec3{static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z)};
            way.x = way.z > 0 ? static_cast<double>(n.x) : -static_cast<double>(n.x);
            way.y = way.z > 0 ? static_cast<double>(n.y) : -static_cast<double>(n.y);
        }
        break;
    default: {
        const double angle = random.between(0, 6.283185307), up = random.between(-1, 1),
                     flat = std::sqrt(1 - up * up);
        way = {flat * std::cos(angle), flat * std::sin(angle), up};
    }
    }
    return vec3<T>{glm::dvec3{plan, z} + off * way};
}

/// What was found wrong, and by how much the distance is too large as a share of the largest length.
struct NearestVerdict {
    std::string fault;
    Wide error = 0;
};

template <Real T>
class NearestJudge {
public:
    explicit NearestJudge(const Terrain<T>& ground) : ground_{&ground}, surface_{ground} {}

    [[nodiscard]] NearestVerdict operator()(const vec3<T>& query, Wide max_distance,
                                            const NearestPoint<T>& found) const {
        NearestVerdict verdict;
        const Point q = wide(query);
        const Wide cell = std::hypot(surface_.dx(), surface_.dy());
        const Wide promise = nearest_promise<T>;
        if (found.status == NearestStatus::none_within) {
            if (found.has_point()) verdict.fault = "none, and yet a point";
            if (std::isinf(max_distance)) {
                if (has_patches()) verdict.fault = "none, but there are patches";
            } else {
                const Nearer nearer = nearer_than(q, max_distance, nullptr);
                if (max_distance - nearer.distance > promise * std::max({cell, max_distance, nearer.relief}))
                    verdict.fault = "none within, but there is one";
            }
            return verdict;
        }
        if (found.status != NearestStatus::found) {
            verdict.fault = "status";
            return verdict;
        }
        const auto patch = surface_.patch(found.point.cell.i, found.point.cell.j);
        const Wide u = static_cast<Wide>(found.point.u), v = static_cast<Wide>(found.point.v);
        if (!patch || !(0 <= u && u <= 1 && 0 <= v && v <= 1)) {
            verdict.fault = "no point of the surface";
            return verdict;
        }
        const Point local = surface_.seen_from(q, found.point.cell.i, found.point.cell.j);
        const Point offset = patch->position(u, v) - local;
        const Wide claimed = length(offset), relief = patch->highest() - patch->lowest();
        const Wide size = std::max({cell, relief, claimed});
        // x − x₀ is rounded once, and so is the line that is subtracted.
        const Wide rounding = static_cast<Wide>(epsilon<double>) *
                              (std::abs(q.x - origin(0)) + std::abs(q.y - origin(1))) *
                              (1 + relief / std::min(surface_.dx(), surface_.dy()));
        const Wide allowed = promise * size + rounding;
        const Wide slack = allowed / 8;
        const Nearer nearer = nearer_than(q, claimed - slack, &offset);
        verdict.error = nearer.distance < claimed - slack
                            ? (claimed - nearer.distance) / std::max(size, nearer.relief)
                            : Wide(0);
        if (claimed - nearer.distance > std::max(allowed, promise * nearer.relief))
            verdict.fault = "not the nearest";
        if (std::abs(static_cast<Wide>(found.distance) - claimed) > allowed)
            verdict.fault = "the distance is not that of the point";
        if (length(wide(found.offset) - offset) > allowed * 2) verdict.fault = "offset";
        const Point at = wide(found.position) - Point{q.x + offset.x, q.y + offset.y, q.z + offset.z};
        const Wide coordinates = std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)}) + claimed;
        if (length(at) > allowed * 2 + 4 * static_cast<Wide>(epsilon<T>) * coordinates)
            verdict.fault = "position";
        if (claimed > max_distance + allowed) verdict.fault = "beyond the distance";
        judge_side(q, found, *patch, u, v, offset, allowed, verdict);
        return verdict;
    }

    struct Nearer {
        Wide distance, relief = 0;
    };
    /// The distance and the relief of the nearest patch that is nearer than `within`, which is the distance if there is none.
    /// A patch all of whose corners lie beyond the plane at the end of `plane` cannot be nearer than it is long.
    [[nodiscard]] Nearer nearer_than(const Point& q, Wide within, const Point* plane) const {
        Nearer result{within};
        Wide& nearest = result.distance;
        if (!(within > 0)) return result;
        const auto range = [&](Wide from, Wide to, Index count, Index& begin, Index& end) {
            begin = static_cast<Index>(std::clamp(std::floor(from) - 1, Wide(0), static_cast<Wide>(count)));
            end = static_cast<Index>(std::clamp(std::ceil(to) + 1, Wide(0), static_cast<Wide>(count)));
        };
        Index i0, i1, j0, j1;
        range(surface_.column_of(q.x - within), surface_.column_of(q.x + within), ground_->columns - 1, i0,
              i1);
        range(surface_.row_of(q.y - within), surface_.row_of(q.y + within), ground_->rows - 1, j0, j1);
        const Wide far = plane ? length(*plane) : Wide(0);
        SeenPatch seen{PatchCase<T>{}};
        for (Index j = j0; j < j1; ++j) {
            for (Index i = i0; i < i1; ++i) {
                const Point local = surface_.seen_from(q, i, j);
                const Wide x = std::max({-local.x, local.x - surface_.dx(), Wide(0)}),
                           y = std::max({-local.y, local.y - surface_.dy(), Wide(0)});
                if (x * x + y * y >= nearest * nearest) continue;
                const auto p = surface_.patch(i, j);
                if (!p) continue;
                const Wide z = std::max({p->lowest() - q.z, q.z - p->highest(), Wide(0)});
                if (x * x + y * y + z * z >= nearest * nearest) continue;
                if (plane && far > 0 && behind(*p, local, *plane, far, within)) continue;
                seen.patch = {p->p00 - q.z, p->p10 - q.z, p->p01 - q.z, p->p11 - q.z, p->dx, p->dy};
                seen.query = {local.x, local.y, 0};
                const Wide distance = scanned_distance(seen);
                if (distance < nearest) result = {distance, p->highest() - p->lowest()};
            }
        }
        return result;
    }

private:
    [[nodiscard]] static bool behind(const WidePatch& p, const Point& local, const Point& plane, Wide far,
                                     Wide within) {
        Wide least = std::numeric_limits<Wide>::max();
        for (const Wide v : {Wide(0), Wide(1)}) {
            for (const Wide u : {Wide(0), Wide(1)})
                least = std::min(least, dot(p.position(u, v) - local, plane));
        }
        return least / far >= within;
    }
    [[nodiscard]] Wide origin(int axis) const { return static_cast<Wide>(ground_->frame.origin[axis]); }
    [[nodiscard]] bool has_patches() const {
        for (Index j = 0; j + 1 < ground_->rows; ++j) {
            for (Index i = 0; i + 1 < ground_->columns; ++i) {
                if (surface_.patch(i, j)) return true;
            }
        }
        return false;
    }
    void judge_side(const Point& q, const NearestPoint<T>& found, const WidePatch& patch, Wide u, Wide v,
                    const Point& offset, Wide allowed, NearestVerdict& verdict) const {
        const Point n = patch.normal(u, v);
        const Wide steep = (patch.highest() - patch.lowest()) / std::min(patch.dx, patch.dy);
        const Wide unit = std::abs(length(wide(found.normal)) - 1);
        if (unit > 8 * static_cast<Wide>(epsilon<T>) || found.normal.z < 0) verdict.fault = "no unit normal";
        const bool inside = 0 < u && u < 1 && 0 < v && v < 1;
        if (inside && length(wide(found.normal) - n) > 1e3L * static_cast<Wide>(epsilon<T>) * (1 + steep))
            verdict.fault = "normal";
        const auto under = surface_.under(q.x, q.y);
        if (under) {
            const Wide above = q.z - surface_.position(*under).z;
            const auto p = surface_.patch(under->i, under->j);
            const Wide slack = allowed + 8 * surface_.blur(*under, q, static_cast<Wide>(epsilon<T>)) +
                               nearest_promise<T> * (p->highest() - p->lowest());
            const Side side = above < 0 ? Side::below : Side::above;
            if (std::abs(above) > slack && found.side != side)
                verdict.fault = "side of the patch over or under it";
        } else if (found.side == Side::none) {
            if (surface_.missing_at({found.point.cell.i, found.point.cell.j, u, v}) == 0)
                verdict.fault = "side unknown off a rim";
        } else if (inside) {
            const Side side = dot(offset, n) > 0 ? Side::below : Side::above;
            if (length(offset) > 100 * allowed && found.side != side && !near_rim(q)) verdict.fault = "side";
        }
    }
    /// Whether rounding may put the query on a patch.
    [[nodiscard]] bool near_rim(const Point& q) const {
        const Wide slack = 4 * static_cast<Wide>(epsilon<T>) *
                           (std::abs(q.x) / surface_.dx() + std::abs(q.y) / surface_.dy() + 1);
        return surface_.under(q.x, q.y, slack).has_value();
    }

    const Terrain<T>* ground_;
    Surface<T> surface_;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_NEAREST_JUDGE_HPP
