#ifndef HFH_TESTS_SUPPORT_LEVEL_ORACLE_HPP
#define HFH_TESTS_SUPPORT_LEVEL_ORACLE_HPP

#include "random.hpp"

#include <hfh/terrain/height_view.hpp>

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

namespace hfh::test {

using Metres = long double;

/// Levels of detail from their definition, in long double: sample by sample, without lattices, patches or strides.
struct LevelOracle {
    /// The height of sample (i, j) of level k in metres, if it is there; columns and rows are those of level 0.
    std::function<std::optional<Metres>(int k, Index i, Index j)> sample;
    Index columns = 0, rows = 0;

    [[nodiscard]] Index cells(int k, bool along_x) const {
        return ((along_x ? columns : rows) - 1) / (Index{1} << k);
    }
    [[nodiscard]] std::optional<Metres> at(int k, Index i, Index j) const {
        if (i < 0 || j < 0 || i > cells(k, true) || j > cells(k, false)) return {};
        return sample(k, i, j);
    }

    /// The surface of level k, not blended, at x and y counted in cells of level 0; empty where a corner is missing.
    [[nodiscard]] std::optional<Metres> surface(int k, Metres x, Metres y) const {
        const Metres width = static_cast<Metres>(Index{1} << k);
        const auto i = static_cast<Index>(std::floor(x / width)),
                   j = static_cast<Index>(std::floor(y / width));
        const Metres u = x / width - static_cast<Metres>(i), v = y / width - static_cast<Metres>(j);
        Metres sum = 0;
        for (Index b = 0; b < 2; ++b) {
            for (Index a = 0; a < 2; ++a) {
                const auto z = at(k, i + a, j + b);
                if (!z) return {};
                sum += (a ? u : 1 - u) * (b ? v : 1 - v) * *z;
            }
        }
        return sum;
    }

    /// The blended height of vertex (i, j) of level k: a corner keeps its own where something of level k+1 is missing.
    [[nodiscard]] std::optional<Metres> vertex(int k, Metres alpha, Index i, Index j) const {
        const auto own = at(k, i, j);
        if (!own) return {};
        Metres mean = 0;
        int count = 0;
        // Level k+1 has samples at even i and j.
        for (Index b = j - j % 2; b <= j + j % 2; b += 2) {
            for (Index a = i - i % 2; a <= i + i % 2; a += 2) {
                const auto z = at(k + 1, a / 2, b / 2);
                if (!z) return own;
                mean += *z;
                ++count;
            }
        }
        return (1 - alpha) * *own + alpha * mean / static_cast<Metres>(count);
    }
};

/// Samples of type S, some of them holes, that only `view` makes sense of: any strides, from any corner.
template <Sample S>
struct RandomSamples {
    static constexpr S hole = S(77);
    using View = HeightView<S, MissingValue<S>>;

    Index columns, rows, column_stride, row_stride;
    std::vector<S> store;
    std::size_t first;

    /// One sample in `one_in` is a hole; none if it is 0.
    RandomSamples(Random& random, Index width, Index depth, int one_in, double relief)
        : columns{width}, rows{depth}, column_stride{random.whole(1, 3)}, row_stride{column_stride * width +
                                                                                     random.whole(0, 4)},
          store(static_cast<std::size_t>(row_stride * depth)), first{0} {
        for (auto& s : store) {
            do {
                s = static_cast<S>(random.between(std::is_signed_v<S> ? -relief : 0.0, relief));
            } while (s == hole);
        }
        if (one_in > 0) {
            for (auto& s : store) {
                if (random.one_in(one_in)) s = hole;
            }
        }
        if (random.one_in(2)) { // south row last
            first += static_cast<std::size_t>(row_stride * (rows - 1));
            row_stride = -row_stride;
        }
        if (random.one_in(2)) {
            first += static_cast<std::size_t>(column_stride * (columns - 1));
            column_stride = -column_stride;
        }
    }

    [[nodiscard]] View view() const {
        return {store.data() + first, columns, rows, column_stride, row_stride, MissingValue<S>{hole}};
    }
    [[nodiscard]] S& at(Index i, Index j) {
        return store[static_cast<std::size_t>(static_cast<Index>(first) + i * column_stride +
                                              j * row_stride)];
    }
    [[nodiscard]] S at(Index i, Index j) const {
        return store[static_cast<std::size_t>(static_cast<Index>(first) + i * column_stride +
                                              j * row_stride)];
    }
    /// Every 2ᵏ-th of them.
    [[nodiscard]] LevelOracle oracle(double scale, double offset) const {
        return {[this, scale, offset](int k, Index i, Index j) -> std::optional<Metres> {
                    const S s = at(i << k, j << k);
                    if (s == hole) return {};
                    return static_cast<Metres>(offset) + static_cast<Metres>(scale) * static_cast<Metres>(s);
                },
                columns, rows};
    }
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_LEVEL_ORACLE_HPP
