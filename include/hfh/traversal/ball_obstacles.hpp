#ifndef HFH_TRAVERSAL_BALL_OBSTACLES_HPP
#define HFH_TRAVERSAL_BALL_OBSTACLES_HPP

#include <hfh/geometry/half_spaces.hpp>
#include <hfh/geometry/patch_minima.hpp>
#include <hfh/geometry/surface_point.hpp>
#include <hfh/terrain/height_field.hpp>
#include <hfh/traversal/descent.hpp>
#include <hfh/traversal/reach_search.hpp>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include <cmath>

// What keeps a ball away from where it is about to go: the local closest points of all patches around its centre, each of
// them a half-space.
//
//     n·(c' − q) ≥ r,   n = (c − q)/|c − q|                  q: a local closest point of a patch, seen from the centre c
//
// Where the surface is flat or sharp around q, no point of it comes nearer than r to a centre c' that keeps all half-spaces of
// the patches within r + |c' − c|, nor anywhere on the way there. Where a patch is curved by κ it is so but for κ|c' − c|²/2.

namespace hfh::detail {

/// What rounding makes of the distance of a ball from the surface, in metres.
template <Real T = double>
[[nodiscard]] double ball_rounding(const glm::dvec3& centre, double radius) noexcept {
    const double size = glm::max(glm::max(std::abs(centre.x), std::abs(centre.y)), std::abs(centre.z));
    return 1e-12 * radius + 2 * epsilon<double> * size;
}

/// A place that keeps a ball away.
struct BallObstacle {
    glm::dvec3 normal{0, 0, 1}; ///< unit
    double gap =
        0; ///< how far the centre may go against the normal, in metres; < 0: the ball is too near by so much
    double distance = 0;          ///< of the point from the centre, in metres
    SurfacePoint<double> point{}; ///< where it is
    bool on_rim = false;          ///< a cell that meets at the point has no patch
    bool from_below = false;      ///< the ball is below the patches that meet at the point
    bool is_plane = false;        ///< the plane of a patch and not the point itself: see `BallObstacles`

    [[nodiscard]] HalfSpace half_space() const noexcept { return {normal, -gap}; }
};

/// The second derivatives of the distance from a point of a patch to a centre: how its normal turns with the centre.
///
///     ∇²|c − q| = (I − n nᵀ − J A⁻¹ Jᵀ)/|c − q|,   A = JᵀJ − (c − q)·S_xy (0 1; 1 0)
///
/// with the directions J in which q may go on the patch: S_x and S_y inside, one of them on an edge, none at a vertex.
template <Real T = double>
[[nodiscard]] glm::dmat3 second_derivative(const RelativePatch& patch, const BallObstacle& at) noexcept {
    const glm::dvec3 n = at.normal;
    const double u = at.point.u, v = at.point.v;
    const glm::dvec3 sx{1, 0, patch.slope_u(v) / patch.dx}, sy{0, 1, patch.slope_v(u) / patch.dy};
    const auto is_inside = [](double w) { return w > 1e-9 && w < 1 - 1e-9; };
    const bool along_x = is_inside(u), along_y = is_inside(v);
    using glm::outerProduct;
    glm::dmat3 turned = glm::dmat3{1.0} - outerProduct(n, n);
    if (along_x && along_y) {
        const double xx = glm::dot(sx, sx), yy = glm::dot(sy, sy);
        const double xy = glm::dot(sx, sy) - at.distance * n.z * patch.twist() / (patch.dx * patch.dy);
        const double det = xx * yy - xy * xy;
        if (det > 0)
            turned -= (yy * outerProduct(sx, sx) + xx * outerProduct(sy, sy) -
                       xy * (outerProduct(sx, sy) + outerProduct(sy, sx))) /
                      det;
    } else if (along_x) {
        turned -= outerProduct(sx, sx) / glm::dot(sx, sx);
    } else if (along_y) {
        turned -= outerProduct(sy, sy) / glm::dot(sy, sy);
    }
    return turned / at.distance;
}

/// How far a ball goes at most, before the next look, where nothing is near.
template <HeightField Field>
[[nodiscard]] double longest_margin(const Field& field) noexcept {
    const glm::dvec2 spacing = field.lattice().spacing();
    return 4 * glm::min(spacing.x, spacing.y);
}

/// The obstacles around a centre, as far as the ball may go before the next look.
///
/// A local closest point on the border of its patch need not be one of the surface: where the distance falls on into a
/// neighbour it does not touch the ball. Across a ridge it says nothing, and is left out. In a valley the patch beyond is kept
/// away by its plane at that point, which the ball meets when it gets there; by the point itself only where it is so far from
/// touching that plane that the point allows as much.
template <HeightField Field>
class BallObstacles {
public:
    static constexpr int most = 40;

    explicit BallObstacles(const Field& field) noexcept : field_{&field} {}

    /// Looks around a ball of this radius: at every patch that comes within radius + margin of the centre. False, and none
    /// are known, if that would be more than `work` patches and blocks. Counts them.
    [[nodiscard]] bool look(const glm::dvec3& centre, double radius, double margin, Index& work) noexcept;

    /// How far the centre may go and meet nothing that is not in the list. Less than it was asked for where there are too many.
    [[nodiscard]] double margin() const noexcept { return margin_; }
    [[nodiscard]] int size() const noexcept { return count_; }
    [[nodiscard]] const BallObstacle& operator[](int k) const noexcept { return items_[k]; }
    [[nodiscard]] const BallObstacle* begin() const noexcept { return items_; }
    [[nodiscard]] const BallObstacle* end() const noexcept { return items_ + count_; }
    /// The smallest gap, in metres; margin() where there is no obstacle.
    [[nodiscard]] double smallest_gap() const noexcept {
        double smallest = margin_;
        for (const BallObstacle& obstacle : *this) smallest = glm::min(smallest, obstacle.gap);
        return smallest;
    }
    /// The smallest gap to a patch that is bent, so that its half-space does not tell all on a way as long as the margin, or `longest_margin`; margin()
    /// where there is none.
    [[nodiscard]] double smallest_bent_gap() const noexcept { return glm::min(bent_gap_, margin_); }
    /// Unit, from the point of an obstacle to the centre: that of a plane is its own.
    [[nodiscard]] glm::dvec3 normal_at(const glm::dvec3& centre, const BallObstacle& at) const noexcept {
        RelativePatch patch;
        const ReachSearch<Field> search{*field_, centre, 0, 0};
        if (!at.is_plane || !search.read(at.point.cell, patch)) return at.normal;
        return glm::normalize(-patch.foot(at.point.u, at.point.v).offset);
    }
    /// How far along a way, 0 to 1, the ball may go before it meets the first obstacle.
    [[nodiscard]] double clear_part(const glm::dvec3& way, double rounding) const noexcept {
        double part = 1;
        for (const BallObstacle& obstacle : *this) {
            const double falls = -glm::dot(obstacle.normal, way);
            if (falls * part > glm::max(obstacle.gap, 0.0) + rounding)
                part = glm::max(obstacle.gap, 0.0) / falls;
        }
        return part;
    }
    /// Where the centre goes if it goes straight for a target and slides along what is in the way; steps are from the centre.
    [[nodiscard]] PolyhedronPoint nearest_to(const glm::dvec3& target, double rounding) const noexcept {
        HalfSpace half_spaces[most];
        for (int k = 0; k < count_; ++k) half_spaces[k] = items_[k].half_space();
        return nearest_in_polyhedron(
            target, std::span<const HalfSpace>{half_spaces, static_cast<std::size_t>(count_)}, rounding);
    }
    /// `second_derivative` of an obstacle; zero for a plane.
    [[nodiscard]] glm::dmat3 turn(const glm::dvec3& centre, const BallObstacle& at) const noexcept {
        RelativePatch patch;
        const ReachSearch<Field> search{*field_, centre, 0, 0};
        if (at.is_plane || !search.read(at.point.cell, patch)) return glm::dmat3{0.0};
        return second_derivative(patch, at);
    }

private:
    /// What becomes of a local closest point on the border of its patch.
    enum class Border : unsigned char { touches, plane, left_out };
    struct BorderPoint {
        Border is = Border::touches;
        bool on_rim = false;
        bool from_above =
            false; ///< the ball is above one of the patches that meet there, as far as their planes tell
    };

    void offer(const ReachSearch<Field>& search, Cell cell, const RelativePatch& patch,
               const RelativePatch::Foot& foot, double distance) noexcept;
    /// `own`: along the normal of the patch at the foot, to the side of the ball; of any length.
    [[nodiscard]] BorderPoint classify_border(const ReachSearch<Field>& search, Cell cell,
                                              const RelativePatch::Foot& foot,
                                              const glm::dvec3& own) const noexcept;
    void keep(const BallObstacle& obstacle) noexcept;
    [[nodiscard]] bool is_known(const BallObstacle& obstacle) const noexcept;

    const Field* field_;
    double radius_ = 0;
    double margin_ = 0;
    double bent_gap_ = 0;
    int count_ = 0;
    BallObstacle items_[most];
};

template <HeightField Field>
bool BallObstacles<Field>::look(const glm::dvec3& centre, double radius, double margin,
                                Index& work) noexcept {
    count_ = 0;
    radius_ = radius;
    margin_ = margin;
    bent_gap_ = margin;
    const glm::dvec2 spacing = field_->lattice().spacing();
    const double longest = glm::max(margin, longest_margin(*field_));
    const double least_twist = 5e-10 * radius / (longest * longest) * spacing.x * spacing.y;
    if (field_->cells().empty()) return true;
    const auto reach_squared = [this] { return (radius_ + margin_) * (radius_ + margin_); };
    // The cell under the centre counts as well: looks that meet no other come to an end.
    ReachSearch<Field> search{*field_, centre, reach_squared(), work - 1};
    const auto look_at = [&](Cell cell, const RelativePatch& patch) {
        const glm::dvec3 middle = patch.middle();
        const double beyond = patch.least_along(middle);
        if (beyond > 0 && beyond * beyond >= search.reach_squared() * glm::dot(middle, middle)) return true;
        const bool is_bent = std::abs(patch.twist()) > least_twist;
        // A patch whose search is cut short has offered what it found.
        (void)visit_minima(patch, search.reach_squared(), [&](const RelativePatch::Foot& foot) {
            const double distance = std::sqrt(foot.squared);
            if (!(distance < radius_ + margin_)) return true;
            if (is_bent) bent_gap_ = glm::min(bent_gap_, distance - radius_);
            offer(search, cell, patch, foot, distance);
            return true;
        });
        // Where the list is full the ball may go less far.
        if (count_ == most) search.set_reach_squared(reach_squared());
        return true;
    };
    RelativePatch under;
    if (search.read(search.base(), under) && under.box_squared() < search.reach_squared())
        look_at(search.base(), under);
    const bool ran = work > 0 && (!search.reaches_out() || search.run(look_at));
    work = search.work_left();
    if (!ran) count_ = 0, margin_ = 0;
    return ran;
}

template <HeightField Field>
void BallObstacles<Field>::offer(const ReachSearch<Field>& search, Cell cell, const RelativePatch& patch,
                                 const RelativePatch::Foot& foot, double distance) noexcept {
    const glm::dvec3 upward = patch.upward(foot.u, foot.v), to_centre = -foot.offset;
    const double over = glm::dot(to_centre, upward);
    const SurfacePoint<double> at{cell, foot.u, foot.v};
    BorderPoint border{.from_above = !(over < 0)};
    const glm::dvec3 own = over < 0 ? -upward : upward;
    if (on_border(at)) border = classify_border(search, cell, foot, own);
    if (border.is == Border::left_out) return;
    BallObstacle obstacle{.normal = distance > 0 ? to_centre / distance : glm::normalize(upward),
                          .gap = distance - radius_,
                          .distance = distance,
                          .point = at,
                          .on_rim = border.on_rim,
                          .from_below = !border.from_above};
    if (border.is == Border::plane) {
        const double length = glm::length(own), plane_gap = std::abs(over) / length - radius_;
        if (plane_gap > obstacle.gap / 4) {
            obstacle.normal = own / length;
            obstacle.gap = plane_gap;
            obstacle.is_plane = true;
        }
    }
    if (!on_border(at) || !is_known(obstacle)) keep(obstacle);
}

template <HeightField Field>
auto BallObstacles<Field>::classify_border(const ReachSearch<Field>& search, Cell cell,
                                           const RelativePatch::Foot& foot,
                                           const glm::dvec3& own) const noexcept -> BorderPoint {
    constexpr double level = 1e-9 * 1e-9; // squared cosine of an angle that counts as right
    BorderPoint point;
    point.from_above = glm::dot(own, foot.offset) <= 0 && own.z > 0;
    double steepest = level * foot.squared;
    const SurfacePoint<double> at{cell, foot.u, foot.v};
    const Neighbours neighbours{foot.u, foot.v};
    for (const Neighbour n : neighbours) {
        const SurfacePoint<double> there = seen_from(n, at);
        RelativePatch patch;
        if (!search.read(there.cell, patch)) {
            point.on_rim = true;
            continue;
        }
        if (!point.from_above) point.from_above = glm::dot(patch.upward(there.u, there.v), foot.offset) <= 0;
        // Into the neighbour, along each parameter that has a border here: as long as the distance times the cosine.
        glm::dvec3 down{0.0};
        const auto fall_along = [&](double parameter, double spacing, double off, double slope,
                                    const glm::dvec2& axis) {
            const double rises = spacing * off + slope * foot.offset.z;
            if (parameter <= 0 ? !(rises < 0) : !(parameter >= 1 && rises > 0)) return;
            const double square = spacing * spacing + slope * slope;
            if (rises * rises > level * square * foot.squared)
                down -= rises / square * glm::dvec3{spacing * axis, slope};
        };
        fall_along(there.u, patch.dx, foot.offset.x, patch.slope_u(there.v), {1, 0});
        fall_along(there.v, patch.dy, foot.offset.y, patch.slope_v(there.u), {0, 1});
        const double falls = glm::dot(down, down);
        if (!(falls > steepest)) continue;
        steepest = falls;
        const double along = glm::dot(own, down);
        const bool is_valley = along > 0 && along * along > level * falls * glm::dot(own, own);
        point.is = is_valley ? Border::plane : Border::left_out;
    }
    return point;
}

template <HeightField Field>
bool BallObstacles<Field>::is_known(const BallObstacle& obstacle) const noexcept {
    for (const BallObstacle& other : *this) {
        const double apart = std::abs(other.gap - obstacle.gap);
        const glm::dvec3 turned = other.normal - obstacle.normal;
        if (apart <= 1e-12 * obstacle.distance && glm::dot(turned, turned) <= 1e-24) return true;
    }
    return false;
}

template <HeightField Field>
void BallObstacles<Field>::keep(const BallObstacle& obstacle) noexcept {
    if (count_ < most) {
        items_[count_++] = obstacle;
        return;
    }
    // Too many: what is farthest is left out, and the ball may go less far.
    int farthest = 0;
    for (int k = 1; k < count_; ++k) {
        if (items_[k].gap > items_[farthest].gap) farthest = k;
    }
    if (obstacle.gap < items_[farthest].gap) {
        margin_ = glm::min(margin_, glm::max(items_[farthest].gap, radius_ / 16));
        items_[farthest] = obstacle;
    } else {
        margin_ = glm::min(margin_, glm::max(obstacle.gap, radius_ / 16));
    }
}

/// A ball that rolls `from` → `to` and stands on the surface there, with this normal. In metres from its end, as a patch is.
template <Real T = double>
struct RollingBall {
    glm::dvec3 back; ///< to where it began
    glm::dvec3 normal;
    glm::dvec3 target; ///< its centre is to come nearer to that
    double radius;
    double rounding; ///< of a distance, in metres

    /// Whether a patch is not in its way. It is clear of the ball where it began, and has to be, but for rounding, at the end; on
    /// the way but for a 64th of the radius. Where it is not, as on a ridge over which the ball rolls, the ball has to go round
    /// the point that is in the way, and get nearer to the target then.
    [[nodiscard]] bool is_clear_of(const RelativePatch& patch) const noexcept {
        if (is_boxed_away(patch)) return true;
        // Planes keep it away: the one on which the ball stands, or one across the line to its middle.
        if (-patch.least_along(-normal) <= rounding - radius) return true;
        const glm::dvec3 middle = patch.middle();
        const double beyond = patch.least_along(middle) - glm::max(glm::dot(middle, back), 0.0);
        if (beyond > 0 && beyond * beyond >= radius * radius * glm::dot(middle, middle)) return true;
        const auto foot = closest_of_patch(patch);
        if (foot.squared < (radius - rounding) * (radius - rounding)) return false;
        if (glm::dot(foot.offset, normal) <= -radius * (1 - 1e-9)) return true; // where it stands
        return is_passed(foot.offset);
    }

private:
    /// The box that holds the patch is a radius away from the box that holds the way.
    [[nodiscard]] bool is_boxed_away(const RelativePatch& patch) const noexcept {
        const auto off = [](double begin, double end, double to) {
            return glm::max(glm::max(begin - glm::max(to, 0.0), glm::min(to, 0.0) - end), 0.0);
        };
        const double x = off(patch.x, patch.x + patch.dx, back.x),
                     y = off(patch.y, patch.y + patch.dy, back.y),
                     z = off(patch.lowest(), patch.highest(), back.z);
        return x * x + y * y + z * z >= radius * radius;
    }
    [[nodiscard]] bool is_passed(const glm::dvec3& point) const noexcept {
        constexpr double clear = 63.0 / 64, nearest = 7.0 / 8; // of the radius
        const double length_squared = glm::dot(back, back);
        const double part =
            length_squared > 0 ? glm::clamp(glm::dot(point, back) / length_squared, 0.0, 1.0) : 0.0;
        const double apart = glm::distance(point, part * back);
        if (apart >= clear * radius) return true;
        const glm::dvec3 out = glm::normalize(back - point), around = glm::dot(back, out) * out - back;
        return apart >= nearest * radius && glm::dot(back - target, around) <= 0;
    }
};

/// Whether nothing is in the way of a ball that rolls to `to`. Looks at all cells under it and its way, one after the other:
/// they are few, and mostly all of them are clear. Counts them; false as well if they are more than `work`.
template <HeightField Field>
[[nodiscard]] bool rolls_freely(const Field& field, const glm::dvec3& to, const RollingBall<>& ball,
                                Index& work) noexcept {
    const ReachSearch<Field> search{field, to, 0, 0};
    const CellRange cells = field.cells();
    const glm::dvec2 per_metre = field.lattice().cells_per_metre();
    const auto cells_to = [](double metres, double cells_per_metre) {
        return static_cast<Index>(glm::clamp(std::floor(metres * cells_per_metre), -1e6, 1e6));
    };
    if (!(ball.radius * glm::max(per_metre.x, per_metre.y) < 1e5)) return false;
    const glm::dvec3 low = glm::min(ball.back, 0.0) - ball.radius,
                     high = glm::max(ball.back, 0.0) + ball.radius;
    const glm::dvec2 corner = search.corner();
    const Cell base = search.base();
    const Cell begin{glm::max(base.i + cells_to(low.x - corner.x, per_metre.x), cells.begin.i),
                     glm::max(base.j + cells_to(low.y - corner.y, per_metre.y), cells.begin.j)};
    const Cell end{glm::min(base.i + cells_to(high.x - corner.x, per_metre.x) + 1, cells.end.i),
                   glm::min(base.j + cells_to(high.y - corner.y, per_metre.y) + 1, cells.end.j)};
    RelativePatch patch;
    for (Index j = begin.j; j < end.j; ++j) {
        for (Index i = begin.i; i < end.i; ++i) {
            if (--work < 0) return false;
            if (search.read({i, j}, patch) && !ball.is_clear_of(patch)) return false;
        }
    }
    return true;
}

} // namespace hfh::detail

#endif // HFH_TRAVERSAL_BALL_OBSTACLES_HPP
