// Step 10: a surface of one's own, without samples.

#include <hfh/hfh.hpp>

#include <cmath>
#include <cstdio>
#include <optional>

/// Waves that go on for ever.
class Waves {
public:
    using Scalar = double;
    [[nodiscard]] hfh::Lattice lattice() const noexcept { return {{0.0, 0.0}, {1.0, 1.0}}; }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return hfh::CellRange::endless(); }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        return hfh::BilinearPatch<double>{
            height(c.i), height(c.i + 1), height(c.i), height(c.i + 1), {1.0, 1.0}};
    }

private:
    // The same line gets the same height from both its cells, so there are no cracks.
    [[nodiscard]] static double height(hfh::Index i) noexcept {
        return std::sin(0.2 * static_cast<double>(i));
    }
};
static_assert(hfh::HeightField<Waves>);

int main() {
    const Waves waves;
    hfh::ProxyTracker tracker{waves};
    int touching = 0;
    for (int k = 0; k < 10000; ++k) touching += tracker.update({1.0 * k, 0.5, k == 0 ? 5.0 : 0.0}).touching();
    std::printf("10 km over the waves at half their height: %d of 10000 updates in contact\n", touching);
    return touching > 4000 && touching < 6000 ? 0 : 1;
}
