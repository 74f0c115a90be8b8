// A height field of one's own: an endless procedural terrain that stores no sample. Every algorithm of the library
// takes it, because it has what `hfh::HeightField` asks for: a scalar, a lattice, a range of cells, and patches.

#include <hfh/hfh.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>

namespace {

/// Value noise: a hash gives every lattice point its height, summed over octaves that are each half as large.
/// The same (i, j) gives the same height from whichever patch it is asked, so the surface has no cracks.
class EndlessHills {
public:
    using Scalar = double;

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return {{0.0, 0.0}, {spacing, spacing}}; }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return hfh::CellRange::endless(); }

    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        return hfh::BilinearPatch<double>{height(c.i, c.j),
                                          height(c.i + 1, c.j),
                                          height(c.i, c.j + 1),
                                          height(c.i + 1, c.j + 1),
                                          {spacing, spacing}};
    }

private:
    static constexpr double spacing = 5.0; // metres

    [[nodiscard]] static double random(hfh::Index i, hfh::Index j) noexcept {
        auto bits = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15u ^
                    static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fu;
        bits = (bits ^ (bits >> 29)) * 0xbf58476d1ce4e5b9u;
        return static_cast<double>((bits ^ (bits >> 32)) >> 11) * 0x1p-53;
    }

    [[nodiscard]] static double height(hfh::Index i, hfh::Index j) noexcept {
        double sum = 0;
        for (int octave = 6; octave >= 2; --octave) {
            const hfh::Index mask = (hfh::Index{1} << octave) - 1, ci = i >> octave, cj = j >> octave;
            const double step = static_cast<double>(mask + 1);
            const hfh::BilinearPatch<double> coarse{random(ci, cj), random(ci + 1, cj), random(ci, cj + 1),
                                                    random(ci + 1, cj + 1)};
            sum += step *
                   coarse.height(static_cast<double>(i & mask) / step, static_cast<double>(j & mask) / step);
        }
        return sum; // metres: 64 m hills down to 4 m knolls
    }
};

static_assert(hfh::HeightField<EndlessHills>);

} // namespace

int main() {
    const EndlessHills hills;
    hfh::ProxyTracker tracker{hills};
    const hfh::ForceEvaluator<double> force{.stiffness = 2.0, .max_force = 3.3}; // N/m, N

    // A hundred kilometres in a straight line, four metres an update, between the valley floors and the hilltops.
    int touching = 0, patches = 0;
    double strongest = 0;
    const int updates = 25000;
    for (int k = 0; k < updates; ++k) {
        const auto contact = tracker.update({4.0 * k, 1.0 * k, k == 0 ? 200.0 : 60.0});
        touching += contact.touching();
        patches += contact.patches;
        strongest = std::fmax(strongest, glm::length(force(contact).newtons));
    }
    std::printf("%d updates, %d touching, %.1f patches each, strongest force %.2f N, no sample stored\n",
                updates, touching, static_cast<double>(patches) / updates, strongest);
}
