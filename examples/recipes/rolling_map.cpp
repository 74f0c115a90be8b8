// A window that moves over a larger map: the elevation map around a robot, as ring buffers keep it (`grid_map` of ROS). The
// window moves by whole cells, and only the rows and columns that come in are written. Its samples stay where they are, and
// so does the proxy, because cells are numbered absolutely: cell (i, j) is the same place on earth however far the
// window has gone.
//
// Storage is as grid_map has it: column by column, the first index against +x, the second against +y, holes NaN, and a start
// index that goes round. To feel a `grid_map::GridMap`, take data(), getSize() and getStartIndex() of it.
//
// Here a window of 64 × 48 cells goes along 400 m with a hand that drags in it. Ends with 0 if every force is the same, to
// the bit, as on one map of all of it.

#include <hfh/hfh.hpp>

#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

namespace {

constexpr double resolution = 0.25; // m

double height(hfh::Index i, hfh::Index j) {
    const auto x = static_cast<double>(i), y = static_cast<double>(j);
    return 0.4 * std::sin(0.2 * x) * std::cos(0.3 * y) + 0.1 * std::sin(1.1 * x + 0.7 * y);
}

/// The vertices in [begin, begin + size) along both axes, in a ring buffer. A vertex is a place on earth: (i, j) times the
/// resolution.
class RollingGround {
public:
    using Scalar = double;

    RollingGround(hfh::Index columns, hfh::Index rows)
        : columns_{columns}, rows_{rows}, heights_(static_cast<std::size_t>(columns * rows), missing) {}

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return {{0.0, 0.0}, {resolution, resolution}}; }
    [[nodiscard]] hfh::CellRange cells() const noexcept {
        return {{begin_.i, begin_.j}, {begin_.i + columns_ - 1, begin_.j + rows_ - 1}};
    }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        if (!cells().contains(c)) return std::nullopt;
        const auto z = [&](hfh::Index i, hfh::Index j) {
            return static_cast<double>(heights_[slot({c.i + i, c.j + j})]);
        };
        const hfh::BilinearPatch<double> found{z(0, 0), z(1, 0), z(0, 1), z(1, 1), {resolution, resolution}};
        // A sum of four is NaN if one is.
        if (std::isnan(found.p00 + found.p10 + found.p01 + found.p11)) return std::nullopt;
        return found;
    }

    [[nodiscard]] bool holds(hfh::Vertex v) const noexcept {
        return v.i >= begin_.i && v.i < begin_.i + columns_ && v.j >= begin_.j && v.j < begin_.j + rows_;
    }
    /// Precondition: holds(v).
    void set(hfh::Vertex v, float metres) noexcept { heights_[slot(v)] = metres; }

    /// Moves the window; what comes in is unknown until it is set. Between two updates.
    void move_to(hfh::Vertex begin) noexcept {
        const hfh::Vertex before = begin_;
        begin_ = begin;
        for (hfh::Index j = begin.j; j < begin.j + rows_; ++j) {
            for (hfh::Index i = begin.i; i < begin.i + columns_; ++i) {
                const bool was_there =
                    i >= before.i && i < before.i + columns_ && j >= before.j && j < before.j + rows_;
                if (!was_there) set({i, j}, missing);
            }
        }
    }

private:
    static constexpr float missing = std::numeric_limits<float>::quiet_NaN();

    /// The same slot for every window that holds the vertex: its number modulo the size, counted against the axes.
    [[nodiscard]] std::size_t slot(hfh::Vertex v) const noexcept {
        const auto against = [](hfh::Index n, hfh::Index size) { return (size - 1 - n % size) % size; };
        const hfh::Index row = against(v.i, columns_), column = against(v.j, rows_);
        return static_cast<std::size_t>(row + column * columns_);
    }

    hfh::Index columns_, rows_;
    hfh::Vertex begin_{0, 0};
    std::vector<float> heights_;
};
static_assert(hfh::HeightField<RollingGround>);

} // namespace

int main() {
    constexpr hfh::Index long_way = 1700, width = 64, depth = 48;
    RollingGround ground{width, depth};
    for (hfh::Index j = 0; j < depth; ++j)
        for (hfh::Index i = 0; i < width; ++i) ground.set({i, j}, static_cast<float>(height(i, j)));
    std::vector<float> everything;
    for (hfh::Index j = 0; j < depth + 40; ++j)
        for (hfh::Index i = 0; i < long_way; ++i) everything.push_back(static_cast<float>(height(i, j)));
    const hfh::BilinearGrid whole{hfh::HeightView{everything.data(), long_way, depth + 40},
                                  {.spacing = {resolution, resolution}}};

    hfh::ProxyTracker rolling{ground};
    hfh::ProxyTracker fixed{whole};
    const hfh::ForceEvaluator<double> force{.stiffness = 2};
    int moves = 0, different = 0, touching = 0;
    hfh::Vertex begin{0, 0};
    for (int n = 0; n < 16000; ++n) {
        const double x = 8 + 0.025 * n, y = 6 + 0.0005 * n + std::sin(0.01 * n);
        // The window follows the hand by whole cells, and the sensor fills in what came.
        const hfh::Vertex wanted{static_cast<hfh::Index>(x / resolution) - width / 2,
                                 static_cast<hfh::Index>((6 + 0.0005 * n) / resolution) - depth / 2};
        if (wanted.i != begin.i || wanted.j != begin.j) {
            RollingGround before = ground;
            ground.move_to(wanted);
            for (hfh::Index j = wanted.j; j < wanted.j + depth; ++j)
                for (hfh::Index i = wanted.i; i < wanted.i + width; ++i)
                    if (!before.holds({i, j})) ground.set({i, j}, static_cast<float>(height(i, j)));
            begin = wanted;
            ++moves;
        }
        const hfh::vec3<double> hand{x, y, n == 0 ? 3.0 : -0.7};
        const auto one = rolling.update(hand), other = fixed.update(hand);
        different += force(one).newtons != force(other).newtons;
        touching += one.touching();
    }
    std::printf("%d moves of the window, in contact in %d of 16000 updates, forces that differ: %d\n", moves,
                touching, different);
    return moves > 1000 && touching > 15900 && different == 0 ? 0 : 1;
}
