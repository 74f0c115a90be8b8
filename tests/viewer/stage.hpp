#ifndef HFH_TESTS_VIEWER_STAGE_HPP
#define HFH_TESTS_VIEWER_STAGE_HPP

#include "support/skip.hpp"

#include <offscreen.hpp>
#include <viewer.hpp>

#include <bad_input.hpp>
#include <terrain_options.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

// A viewer without a window, and a script in place of a person: every frame is 20 updates of the hand.

namespace viewer_tests {

using viewer::FrameInput;

/// A context without a window; none, and says that the test is skipped, where there cannot be one.
[[nodiscard]] inline std::unique_ptr<viewer::OffscreenContext> context_or_skip() {
    try {
        return std::make_unique<viewer::OffscreenContext>();
    } catch (const demo::BadInput& error) {
        hfh::test::skip(error.what());
        return nullptr;
    }
}

/// The bundled terrain, for editing.
[[nodiscard]] inline demo::Terrain bundled_terrain() {
    demo::TerrainOptions options;
    options.read.for_editing = true;
    return demo::open_terrain(options);
}

/// Samples from a formula; NaN makes a hole.
[[nodiscard]] inline demo::Terrain made_terrain(hfh::Index columns, hfh::Index rows,
                                                const std::function<double(double, double)>& height) {
    auto samples = std::make_shared<std::vector<float>>();
    for (hfh::Index j = 0; j < rows; ++j)
        for (hfh::Index i = 0; i < columns; ++i)
            samples->push_back(static_cast<float>(height(static_cast<double>(i), static_cast<double>(j))));
    demo::Terrain terrain{.name = "made",
                          .storage = samples,
                          .heights =
                              demo::Heights<float>{samples->data(), columns, rows, demo::NoData<float>{}},
                          .spacing = std::nullopt,
                          .assumed = {}};
    return terrain;
}

/// Hills of several sizes, up to 60 m over cells of 10 m.
[[nodiscard]] inline double hills(double i, double j) {
    return 40 * std::sin(0.021 * i + 0.3) * std::cos(0.017 * j) + 14 * std::sin(0.09 * i + 0.05 * j) +
           5 * std::sin(0.31 * i) * std::sin(0.27 * j) + 1.5 * std::cos(1.1 * i + 0.7 * j);
}

class Stage {
public:
    Stage(demo::Terrain terrain, const hfh::GridFrame& frame, const glm::ivec2& size,
          viewer::HapticsSettings settings = {})
        : touched{std::move(terrain), frame, std::move(settings)}, target{size}, shown{touched, 127, 1.0f} {}

    /// One frame, all that is to be seen loaded; then `look` at every update of the hand in it.
    viewer::FrameReport frame(const FrameInput& input,
                              const std::function<void(const viewer::HandState&)>& look = {}) {
        for (int k = 0; k < 20; ++k) {
            touched.haptics.tick();
            if (look) {
                viewer::HandState state;
                (void)touched.haptics.show(state);
                look(state);
            }
        }
        target.bind();
        shown.layer().begin_without_window(target.size(), 0.02f);
        return shown.frame(input, target.size(), 0.02, true);
    }
    viewer::FrameReport frames(int count, FrameInput input,
                               const std::function<void(const viewer::HandState&)>& look = {}) {
        viewer::FrameReport report;
        for (int k = 0; k < count; ++k) {
            report = frame(input, look);
            input.brush.reset();
            input.undoes = input.goes_home = false;
        }
        return report;
    }
    /// The pointer at a place of the picture, in parts of its width and height from the top left.
    [[nodiscard]] FrameInput pointing(double x, double y, bool pressing = false) const {
        FrameInput input;
        input.pointer = {x * target.size().x, y * target.size().y};
        input.has_pointer = true;
        input.pressing = pressing;
        return input;
    }
    [[nodiscard]] const viewer::HandState& hand() const { return shown.hand(); }

    viewer::TouchedTerrain touched;
    viewer::OffscreenFrame target;
    viewer::Viewer shown;
};

inline constexpr hfh::GridFrame bundled_frame{.spacing = {73.596, 92.491}};

} // namespace viewer_tests

#endif // HFH_TESTS_VIEWER_STAGE_HPP
