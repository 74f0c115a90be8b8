// What the library answers, to the bit: strokes over hills, pressed and lifted, in float and double, through every piece
// that a loop may be made of. Built several times, each time as other people's projects would build it, and every build has
// to print the same. Written as a user writes it: sizes are std::size_t, and nothing is cast for the library's sake.

#include <hfh/contact.hpp>
#include <hfh/device.hpp>
#include <hfh/force.hpp>
#include <hfh/hfh.hpp>
#include <hfh/terrain.hpp>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

/// Folds numbers into one, by their bits (FNV-1a).
class Digest {
public:
    void add(std::uint64_t bits) { value_ = (value_ ^ bits) * 1099511628211U; }
    void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
    void add(float x) { add(std::uint64_t{std::bit_cast<std::uint32_t>(x)}); }
    template <hfh::Real T>
    void add(const hfh::vec3<T>& p) {
        add(p.x);
        add(p.y);
        add(p.z);
    }
    [[nodiscard]] unsigned long long value() const { return value_; }

private:
    std::uint64_t value_ = 14695981039346656037U;
};

/// Whole numbers from a fixed sequence, so that no function of the system's library has a part in the answers.
class Sequence {
public:
    unsigned next() { return (state_ = state_ * 1664525U + 1013904223U) >> 16U; }
    /// A number from −1 to 1, a multiple of 2⁻¹⁵.
    double signed_unit() { return next() / 32768.0 - 1.0; }

private:
    unsigned state_ = 1;
};

std::vector<std::int16_t> hills(std::size_t width, std::size_t height) {
    std::vector<std::int16_t> samples;
    Sequence random;
    for (std::size_t k = 0; k < width * height; ++k)
        samples.push_back(static_cast<std::int16_t>(random.next() % 30));
    return samples;
}

template <hfh::HeightField Field>
void stroke(const Field& field, hfh::SurfaceKind surface, const char* what) {
    using T = typename Field::Scalar;
    hfh::ProxyTracker tracker{field, {.surface = surface, .max_contact_patches = 8}};
    hfh::Friction<T> friction{{.at_rest = T(0.5), .sliding = T(0.4)}};
    const hfh::ForceEvaluator<T> force{.stiffness = T(0.5), .max_force = T(3.3)};
    hfh::VelocityFilter<T> velocity;
    const hfh::Damping<T> damping{.along_normal = T(0.001)};
    hfh::Workspace<T> workspace{{.scale = 4000.0}};
    hfh::ForceGuard guard{hfh::GuardLimits{}};
    Digest digest;
    Sequence random;
    int touching = 0;
    for (int k = 0; k < 2000; ++k) {
        const double t = k * 0.001;
        hfh::DeviceSample sample;
        sample.time = t;
        sample.position = {0.02 * (random.signed_unit() + 4 * t - 8) / 16, 0.01 * random.signed_unit() / 8,
                           k % 500 < 100 ? 0.012 : 0.0005 + 0.0002 * random.signed_unit()};
        const auto stylus = workspace.update(sample.position);
        auto contact = hfh::shade_force(field, tracker.update(stylus));
        contact = friction.hold(field, contact, stylus);
        const auto asked = damping(force, contact, velocity.update(stylus, T(0.001)));
        const auto sent = guard.update(sample, workspace.force_at_hand(asked.newtons));
        touching += contact.touching();
        digest.add(contact.proxy);
        digest.add(contact.normal);
        digest.add(contact.depth);
        digest.add(asked.newtons);
        digest.add(sent.newtons);
    }
    std::printf("%s: %d of 2000 updates in contact, %016llx\n", what, touching, digest.value());
}

template <hfh::Real T>
void strokes(const std::vector<std::int16_t>& samples, std::size_t width, std::size_t height,
             const char* what) {
    const hfh::HeightView heights{samples.data(), width, height};
    const auto grid = hfh::make_grid<T>(
        heights, {.origin = {-640.0, -640.0}, .spacing = {20.0, 20.0}, .height_scale = 0.5});
    std::printf("%s, grid %s\n", what, hfh::to_string(grid.status()));
    stroke(grid, hfh::SurfaceKind::solid, "solid");
    stroke(grid, hfh::SurfaceKind::sheet, "sheet");
    const hfh::ExtendedField endless{grid};
    stroke(hfh::DilatedField{endless, T(15), 1}, hfh::SurfaceKind::solid, "round tip");
}

} // namespace

int main() {
    const std::size_t width = 64, height = 64;
    const auto samples = hills(width, height);
    strokes<double>(samples, width, height, "double");
    strokes<float>(samples, width, height, "float");

    // Samples of the grid's own scalar need no second word.
    const std::vector<float> level(width * height);
    const hfh::BilinearGrid<float> grid{{level.data(), width, height}, {.spacing = {1.0, 1.0}}};
    std::printf("level, grid %s\n", hfh::to_string(grid.status()));
    return grid.status() == hfh::GridStatus::ok ? 0 : 1;
}
