#include <level_residency.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

// A hand that asks for levels while the helper of large_terrain brings samples in: for the thread sanitizer.

int main() {
    using namespace large_terrain;
    constexpr hfh::Index side = 2048;
    const std::vector<std::int16_t> samples(side * side, 1);
    const hfh::HeightView heights{samples.data(), side, side};
    const LevelResidencySettings settings{.whole = 1 << 18, .pause = std::chrono::milliseconds{0}};
    LevelResidency residency{layout_of(heights), {1024, 1024}, 6, settings};
    bool right = true;
    for (int n = 0; n < 30'000; ++n) {
        const double turn = 1e-3 * n;
        const hfh::Cell at{static_cast<hfh::Index>(1024 + 900 * std::sin(turn)),
                           static_cast<hfh::Index>(1024 + 900 * std::cos(0.7 * turn))};
        const double level = residency.level_for(at, at, 5 + 5 * std::sin(1.3 * turn));
        right = right && level >= 0 && level <= 10;
        if (n % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    residency.stop();
    const LevelWaits& waits = residency.waits();
    right = right && waits.updates >= waits.waits && residency.report().rounds > 0;
    std::printf("%llu rounds, the level waited %llu times: %s\n",
                static_cast<unsigned long long>(residency.report().rounds),
                static_cast<unsigned long long>(waits.waits), right ? "as it should" : "FAILED");
    return right ? 0 : 1;
}
