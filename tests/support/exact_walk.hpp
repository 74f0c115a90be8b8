#ifndef HFH_TESTS_SUPPORT_EXACT_WALK_HPP
#define HFH_TESTS_SUPPORT_EXACT_WALK_HPP

#include <hfh/geometry/lattice.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

// Which cells a segment meets, in whole numbers: no rounding, and nothing shared with the library's walker.

namespace hfh::test {

/// n/d, d > 0, small enough that products of two numerators and denominators fit (|n|, d < 2³¹).
struct Fraction {
    std::int64_t n = 0, d = 1;

    static Fraction of(std::int64_t n, std::int64_t d) { return d < 0 ? Fraction{-n, -d} : Fraction{n, d}; }
    friend bool operator<(Fraction a, Fraction b) { return a.n * b.d < b.n * a.d; }
    friend bool operator==(Fraction a, Fraction b) { return a.n * b.d == b.n * a.d; }
    /// Correctly rounded, since n and d are exact.
    [[nodiscard]] double value() const { return static_cast<double>(n) / static_cast<double>(d); }
};

/// The lattice and all points are whole multiples of `unit`, a power of two, counted from the lattice's origin.
struct WholeLattice {
    glm::dvec2 origin{0.0};
    double unit = 1;
    std::array<std::int64_t, 2> step{1, 1}; ///< spacing in units

    [[nodiscard]] Lattice lattice() const {
        return {origin, {unit * static_cast<double>(step[0]), unit * static_cast<double>(step[1])}};
    }
};

using WholePoint = std::array<std::int64_t, 2>; ///< in units from the lattice's origin

[[nodiscard]] inline glm::dvec2 place(const WholeLattice& w, WholePoint p) {
    return w.origin + w.unit * glm::dvec2{static_cast<double>(p[0]), static_cast<double>(p[1])};
}

struct ExactSpan {
    Cell cell;
    Fraction t_in, t_out;
};

/// The part of the closed segment a → b in the closed box low … high, if they meet.
[[nodiscard]] inline std::optional<std::pair<Fraction, Fraction>>
exact_overlap(WholePoint a, WholePoint b, WholePoint low, WholePoint high) {
    Fraction t_in{0, 1}, t_out{1, 1};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const std::int64_t d = b[axis] - a[axis];
        if (d == 0) {
            if (a[axis] < low[axis] || a[axis] > high[axis]) return std::nullopt;
            continue;
        }
        const Fraction one = Fraction::of(low[axis] - a[axis], d),
                       other = Fraction::of(high[axis] - a[axis], d);
        t_in = std::max(t_in, std::min(one, other));
        t_out = std::min(t_out, std::max(one, other));
    }
    if (t_out < t_in) return std::nullopt;
    return std::pair{t_in, t_out};
}

/// Every cell of `range` whose closed rectangle meets the closed segment, by asking each.
[[nodiscard]] inline std::vector<ExactSpan> exact_cells(const WholeLattice& w, const CellRange& range,
                                                        WholePoint a, WholePoint b) {
    std::vector<ExactSpan> found;
    for (Index j = range.begin.j; j < range.end.j; ++j) {
        for (Index i = range.begin.i; i < range.end.i; ++i) {
            const WholePoint low{i * w.step[0], j * w.step[1]}, high{low[0] + w.step[0], low[1] + w.step[1]};
            if (const auto t = exact_overlap(a, b, low, high)) found.push_back({{i, j}, t->first, t->second});
        }
    }
    return found;
}

[[nodiscard]] inline std::int64_t floor_division(std::int64_t n, std::int64_t d) {
    return n / d - (n % d != 0 && (n < 0) != (d < 0) ? 1 : 0);
}

/// The same for long segments: asks only the cells about the part of the segment in each column.
[[nodiscard]] inline std::vector<ExactSpan> exact_cells_by_column(const WholeLattice& w, WholePoint a,
                                                                  WholePoint b) {
    std::vector<ExactSpan> found;
    const Index west = floor_division(std::min(a[0], b[0]), w.step[0]) - 1;
    const Index east = floor_division(std::max(a[0], b[0]), w.step[0]) + 1;
    const std::int64_t south = std::min(a[1], b[1]) - w.step[1], north = std::max(a[1], b[1]) + w.step[1];
    for (Index i = west; i < east; ++i) {
        const auto t = exact_overlap(a, b, {i * w.step[0], south}, {(i + 1) * w.step[0], north});
        if (!t) continue;
        const auto row = [&](Fraction s) {
            return floor_division(a[1] * s.d + s.n * (b[1] - a[1]), w.step[1] * s.d);
        };
        const Index one = row(t->first), other = row(t->second);
        const auto column =
            exact_cells(w, {{i, std::min(one, other) - 1}, {i + 1, std::max(one, other) + 1}}, a, b);
        found.insert(found.end(), column.begin(), column.end());
    }
    return found;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_EXACT_WALK_HPP
