#ifndef HFH_TERRAIN_BRIDGED_FIELD_HPP
#define HFH_TERRAIN_BRIDGED_FIELD_HPP

#include <hfh/terrain/height_field.hpp>

#include <algorithm>

// Based on: Shepard, A two-dimensional interpolation function for irregularly-spaced data (1968): the mean weighted by the
// inverse distance, here of the up to four nearest vertices along the grid lines.

namespace hfh {

/// A height field that spans the narrow holes of another one: radar voids, specks without data.
///
/// A vertex is *known* where it is a corner of a patch of the field. A vertex that is not known is bridged along a grid line
/// where that line has a known vertex on either side of it, at distances a and b with a + b ≤ `widest` cells. Its height is
///
///     z  =  Σ zₖ/aₖ  /  Σ 1/aₖ          over the 2 or 4 ends of the lines along which it is bridged
///
/// On one line that is linear interpolation, and a hole in a plane is filled by that plane. The height is never above the
/// highest or below the lowest of the ends. A cell has a patch where each of its corners is known or bridged.
///
/// Where the field has a patch it is kept, to the bit. A hole that is wider stays a hole but for its narrow bays, and so does
/// what lies between a known vertex and the rim. A sample that is there and of which no patch is a corner, alone amid a hole,
/// counts as missing.
///
/// Nothing is stored: a vertex is computed from the ends when it is asked for, so an edit of them is felt at once, and
/// neighbouring patches agree on it to the bit. A patch that the field has costs nothing beside it, one that is bridged reads
/// at most 16·(widest + 1) patches of the field. Keeps a pointer to the field, which must outlive it; does not throw, does
/// not allocate.
template <HeightField Field>
class BridgedField {
public:
    using Scalar = typename Field::Scalar;

    /// `widest` in cells is clamped to 0 … 1000. With less than 2 nothing is bridged.
    constexpr BridgedField(const Field& field, Index widest) noexcept
        : field_{&field}, widest_{std::clamp<Index>(widest, 0, 1000)} {}
    BridgedField(const Field&&, Index) = delete; // the field must outlive this one

    [[nodiscard]] constexpr auto lattice() const noexcept { return field_->lattice(); }
    [[nodiscard]] constexpr CellRange cells() const noexcept { return field_->cells(); }
    [[nodiscard]] constexpr std::optional<BilinearPatch<Scalar>> patch(Cell c) const noexcept {
        auto found = field_->patch(c);
        if (found || !cells().contains(c)) return found;
        return bridge(c);
    }

    /// The height at a vertex, known or bridged, in metres; empty where it is neither. One function for all patches, not
    /// inlined, so that they agree on it to the bit where products are fused with sums.
    [[nodiscard, gnu::noinline]] constexpr std::optional<Scalar> height(Vertex v) const noexcept {
        for (const Index side : {Index{-1}, Index{1}})
            if (const auto known = height_ahead(v, {side, 0})) return known;
        Mean mean;
        add_line(mean, v, {1, 0});
        add_line(mean, v, {0, 1});
        return mean.value();
    }

    [[nodiscard]] constexpr const Field& field() const noexcept { return *field_; }

private:
    /// Along a grid line: one step to the next vertex.
    struct Step {
        Index i, j;
    };

    /// The weighted mean of the ends, as differences to the first, so that level ground stays level.
    struct Mean {
        Scalar first = 0, differences = 0, weights = 0;

        constexpr void add(Scalar height, Index distance) noexcept {
            if (weights == 0) first = height;
            const Scalar weight = 1 / static_cast<Scalar>(distance);
            differences += weight * (height - first);
            weights += weight;
        }
        [[nodiscard]] constexpr std::optional<Scalar> value() const noexcept {
            if (weights == 0) return std::nullopt;
            return first + differences / weights;
        }
    };

    [[nodiscard]] constexpr std::optional<BilinearPatch<Scalar>> bridge(Cell c) const noexcept {
        const auto z00 = height({c.i, c.j}), z10 = height({c.i + 1, c.j});
        if (!z00 || !z10) return std::nullopt;
        const auto z01 = height({c.i, c.j + 1}), z11 = height({c.i + 1, c.j + 1});
        if (!z01 || !z11) return std::nullopt;
        return BilinearPatch<Scalar>{*z00, *z10, *z01, *z11, vec2<Scalar>{lattice().spacing()}};
    }

    /// The height of a vertex if it is a corner of one of the two patches that lie ahead of it.
    [[nodiscard]] constexpr std::optional<Scalar> height_ahead(Vertex v, Step step) const noexcept {
        const Cell one{v.i - (step.i < 0), v.j - (step.j < 0)};
        const Cell other{step.i == 0 ? one.i - 1 : one.i, step.j == 0 ? one.j - 1 : one.j};
        for (const Cell c : {one, other})
            if (const auto patch = field_->patch(c)) return corner(*patch, v.i - c.i, v.j - c.j);
        return std::nullopt;
    }
    [[nodiscard]] static constexpr Scalar corner(const BilinearPatch<Scalar>& patch, Index i,
                                                 Index j) noexcept {
        return j == 0 ? (i == 0 ? patch.p00 : patch.p10) : (i == 0 ? patch.p01 : patch.p11);
    }

    struct End {
        Scalar height;
        Index distance; ///< cells; 0: there is none
    };
    /// The nearest known vertex from v, which is not known, in one direction and no farther than `reach`. Patches between it
    /// and the vertex before it would make that one known, so only those ahead are looked at.
    [[nodiscard]] constexpr End end_of(Vertex v, Step step, Index reach) const noexcept {
        for (Index k = 1; k <= reach; ++k) {
            const Vertex at{v.i + k * step.i, v.j + k * step.j};
            if (const auto height = height_ahead(at, step)) return {*height, k};
        }
        return {0, 0};
    }
    /// Adds the two ends of the line through v if they are there and near enough to each other.
    constexpr void add_line(Mean& mean, Vertex v, Step step) const noexcept {
        const End one = end_of(v, step, widest_ - 1);
        if (one.distance == 0) return;
        const End other = end_of(v, {-step.i, -step.j}, widest_ - one.distance);
        if (other.distance == 0) return;
        mean.add(one.height, one.distance);
        mean.add(other.height, other.distance);
    }

    const Field* field_;
    Index widest_;
};

} // namespace hfh

#endif // HFH_TERRAIN_BRIDGED_FIELD_HPP
