// A bump map: small relief that repeats, on top of a coarse terrain, as a picture has a bump map on its triangles. The
// terrain has a sample every 30 m; the ground under the hand shall be felt as gravel, a vertex every 25 cm.
//
// The field below lies on an integer sub-lattice: every cell of the terrain is divided into 120 × 120. There the terrain's
// patch, restricted to a fine cell, is bilinear still, so sum of terrain and bumps is a bilinear patch without error, and all
// that the library promises holds for it. Nothing is stored but the terrain and one period of the bumps.
//
// Ends with 0 if the field without bumps gives the terrain's forces and that with bumps is felt as rough.

#include <hfh/hfh.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

/// `Field` with `bumps` (metres, `period` × `period` samples, south row first) on it, `divisions` vertices a cell.
template <hfh::HeightField Field>
class BumpedField {
public:
    using Scalar = typename Field::Scalar;

    /// Precondition: divisions ≥ 1, and period² bumps outlive it, as the field does. `period` a power of two.
    BumpedField(const Field& field, hfh::Index divisions, const float* bumps, hfh::Index period) noexcept
        : field_{&field}, divisions_{divisions}, bumps_{bumps}, period_{period} {}

    [[nodiscard]] hfh::Lattice lattice() const noexcept {
        const hfh::Lattice coarse = field_->lattice();
        return {coarse.origin(), coarse.spacing() / static_cast<double>(divisions_)};
    }
    [[nodiscard]] hfh::CellRange cells() const noexcept {
        const hfh::CellRange range = field_->cells();
        return {{range.begin.i * divisions_, range.begin.j * divisions_},
                {range.end.i * divisions_, range.end.j * divisions_}};
    }
    [[nodiscard]] std::optional<hfh::BilinearPatch<Scalar>> patch(hfh::Cell c) const noexcept {
        if (!cells().contains(c)) return std::nullopt;
        // Index division rounds towards zero: for fields whose cells begin at 0, as those of a grid do.
        const hfh::Cell home{c.i / divisions_, c.j / divisions_};
        const auto ground = field_->patch(home);
        if (!ground) return std::nullopt;
        const auto z = [&](hfh::Index i, hfh::Index j) {
            const hfh::Index in_i = c.i + i - home.i * divisions_, in_j = c.j + j - home.j * divisions_;
            return height(*ground, in_i, in_j) + bump(c.i + i, c.j + j);
        };
        return hfh::BilinearPatch<Scalar>{z(0, 0), z(1, 0), z(0, 1), z(1, 1),
                                          hfh::vec2<Scalar>{lattice().spacing()}};
    }

private:
    /// The ground at a vertex in or on the border of a patch. Both patches at a border give the same, to the bit, because on
    /// it they read the same two corners and nothing else.
    [[nodiscard]] Scalar height(const hfh::BilinearPatch<Scalar>& p, hfh::Index i,
                                hfh::Index j) const noexcept {
        if (i == 0 || i == divisions_) return between(i == 0 ? p.p00 : p.p10, i == 0 ? p.p01 : p.p11, j);
        if (j == 0 || j == divisions_) return between(j == 0 ? p.p00 : p.p01, j == 0 ? p.p10 : p.p11, i);
        return between(between(p.p00, p.p10, i), between(p.p01, p.p11, i), j);
    }
    [[nodiscard]] Scalar between(Scalar a, Scalar b, hfh::Index n) const noexcept {
        if (n == divisions_) return b;
        return a + (b - a) * (static_cast<Scalar>(n) / static_cast<Scalar>(divisions_));
    }
    [[nodiscard]] Scalar bump(hfh::Index i, hfh::Index j) const noexcept {
        const hfh::Index at = (i & (period_ - 1)) + (j & (period_ - 1)) * period_;
        return static_cast<Scalar>(bumps_[at]);
    }

    const Field* field_;
    hfh::Index divisions_;
    const float* bumps_;
    hfh::Index period_;
};

/// Drags a stylus over a field and returns the mean step of the force from update to update, in newtons.
template <hfh::HeightField Field>
double mean_step(const Field& field, const hfh::ForceEvaluator<double>& force,
                 std::vector<hfh::vec3<double>>& forces) {
    hfh::ProxyTracker tracker{field};
    double sum = 0;
    forces.clear();
    for (int n = 0; n <= 4000; ++n) {
        const auto felt =
            force(tracker.update({200 + 0.05 * n, 310 + 0.02 * n, n == 0 ? 500.0 : 90.0})).newtons;
        if (n > 1) sum += glm::length(felt - forces.back());
        forces.push_back(felt);
    }
    return sum / 3999;
}

} // namespace

int main() {
    constexpr hfh::Index columns = 32, rows = 32, period = 64, divisions = 120;
    std::vector<float> terrain, bumps(period * period), none(period * period, 0.0f);
    for (hfh::Index j = 0; j < rows; ++j)
        for (hfh::Index i = 0; i < columns; ++i)
            terrain.push_back(
                static_cast<float>(100 + 8 * std::sin(0.4 * double(i)) * std::cos(0.3 * double(j))));
    unsigned bits = 1;
    for (float& bump : bumps) {
        bits = bits * 1664525u + 1013904223u;
        bump = static_cast<float>(bits >> 8) * 0x1p-24f * 0.08f; // up to 8 cm
    }
    const hfh::BilinearGrid grid{hfh::HeightView{terrain.data(), columns, rows}, {.spacing = {30, 30}}};
    const hfh::ForceEvaluator<double> force{.stiffness = 0.2};

    std::vector<hfh::vec3<double>> plain, smooth, rough;
    const double plain_step = mean_step(grid, force, plain);
    (void)mean_step(BumpedField{grid, divisions, none.data(), period}, force, smooth);
    const double rough_step = mean_step(BumpedField{grid, divisions, bumps.data(), period}, force, rough);
    double differ = 0;
    for (std::size_t n = 0; n < plain.size(); ++n)
        differ = std::max(differ, glm::length(plain[n] - smooth[n]));
    std::printf(
        "largest difference of a force without bumps: %.2g N; mean step of the force %.5f N, with bumps "
        "%.5f N\n",
        differ, plain_step, rough_step);
    return differ < 1e-9 && rough_step > 2 * plain_step ? 0 : 1;
}
