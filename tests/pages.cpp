// What the pages of the documentation show, so that it compiles: quotes.cmake compares the pages with this file. Nothing
// here runs. What the formatter would break stands as the pages have it.

#include <hfh/device/triple_buffer.hpp>
#include <hfh/hfh.hpp>
#include <hfh/loop.hpp>
#include <hfh/simulation/simulated_device.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <cstdint>
#include <cstdlib>
#include <vector>

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace pages {

struct Sink {
    void send(const glm::dvec3& newtons) { last = newtons; }
    glm::dvec3 last{0.0};
};

void shortest(const std::vector<float>& samples, std::size_t columns, std::size_t rows,
              const glm::dvec3& stylus, Sink& device);
void shortest(const std::vector<float>& samples, std::size_t columns, std::size_t rows,
              const glm::dvec3& stylus, Sink& device) {
    // clang-format off
    hfh::HeightView heights{samples.data(), columns, rows};
    hfh::BilinearGrid grid{heights, {.spacing = {10.0, 10.0}}};            // metres; nothing is copied
    hfh::ProxyTracker tracker{grid};
    hfh::ForceEvaluator<double> force{.stiffness = 0.5, .max_force = 3.3}; // N/m, N

    const auto contact = tracker.update(stylus); // once for each position of the device
    device.send(force(contact).newtons);
    // clang-format on
}

template <hfh::HeightField Field, hfh::Device Device>
void with_motors(const Field& grid, Device& device, const glm::dvec3& middle) {
    // clang-format off
    hfh::HapticLoop loop{grid,
                         {.workspace = {.scale = 4000, .offset = middle},
                          .material = {.stiffness = 400},
                          .limits = hfh::guard_limits(device.capabilities(), 400)}};
    device.run([&](const hfh::DeviceSample& sample) { return loop.update(sample); });
    // clang-format on
}
using Path = glm::dvec3 (*)(double);
template void with_motors(const hfh::BilinearGrid<float>&, hfh::SimulatedDevice<Path>&, const glm::dvec3&);

struct Picture {
    glm::dvec3 proxy{0.0}, stylus{0.0}, newtons{0.0};
};
void draw(const Picture& picture);

void recipes(const std::uint8_t* pixels, const std::int16_t* heights, const float* raster, std::size_t width,
             std::size_t height, const glm::dvec3& stylus, const glm::dvec3& newtons);
void recipes(const std::uint8_t* pixels, const std::int16_t* heights, const float* raster, std::size_t width,
             std::size_t height, const glm::dvec3& stylus, const glm::dvec3& newtons) {
    // clang-format off
    hfh::HeightView alpha{pixels + 3, width, height, 4, 4 * width};   // the alpha channel of RGBA pixels
    hfh::HeightView by_column{heights, width, height, height, 1};     // columns one after the other
    auto upright = hfh::HeightView{raster, width, height}.flipped_rows(); // northern row first
    // clang-format on

    const auto grid = hfh::make_grid<float>(by_column, {.spacing = {10.0, 10.0}});

    hfh::HeightView marked{heights, width, height, hfh::MissingValue{-9999}};
    hfh::HeightView masked{heights, width, height, [](auto sample) { return sample < 0; }};

    const hfh::ExtendedField endless{grid};
    hfh::ProxyTracker tracker{endless};

    const auto contact = hfh::Contact<double>{};
    Picture picture;
    // clang-format off
    hfh::TripleBuffer<Picture> pictures;            // one thread puts, one takes
    pictures.put({contact.proxy, stylus, newtons}); // haptic thread, in each update
    if (pictures.take(picture)) draw(picture);      // display, once a frame
    // clang-format on
    static_cast<void>(alpha.columns() + upright.columns() + marked.columns() + masked.columns());
    static_cast<void>(tracker.update(hfh::vec3<float>{0}));
}

#ifdef MADV_HUGEPAGE
void* vast_memory(std::size_t bytes);
void* vast_memory(std::size_t bytes) {
    void* memory = std::aligned_alloc(std::size_t{1} << 21, bytes); // bytes: a multiple of 2 MiB
    madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}
#endif

} // namespace pages
