#ifndef VIEWER_PALETTES_HPP
#define VIEWER_PALETTES_HPP

#include <glm/common.hpp>
#include <glm/ext/vector_float3.hpp>

#include <array>
#include <cstddef>

namespace viewer {

/// Tints for heights, from the lowest to the highest. Each grows lighter all the way, so that eyes which do not tell red from
/// green, or no colours at all, see the order.
struct Palette {
    const char* name;
    std::array<glm::vec3, 6> colours;

    /// share: 0 to 1.
    [[nodiscard]] glm::vec3 at(float share) const noexcept {
        const float x = glm::clamp(share, 0.0f, 1.0f) * static_cast<float>(colours.size() - 1);
        const auto k = glm::min(static_cast<std::size_t>(x), colours.size() - 2);
        return glm::mix(colours[k], colours[k + 1], x - static_cast<float>(k));
    }
};

// Based on: Crameri, Scientific colour maps, 2018 (batlow); Nuñez, Anderton, Renslow, Optimizing colormaps with consideration
// for color vision deficiency, 2018 (cividis); both lightened at the dark end, so that shading has room below them.
inline constexpr std::array<Palette, 3> palettes{{{"earth",
                                                   {{{0.36f, 0.46f, 0.60f},
                                                     {0.42f, 0.58f, 0.58f},
                                                     {0.56f, 0.66f, 0.50f},
                                                     {0.78f, 0.71f, 0.49f},
                                                     {0.94f, 0.79f, 0.64f},
                                                     {1.00f, 0.94f, 0.90f}}}},
                                                  {"cividis",
                                                   {{{0.28f, 0.36f, 0.55f},
                                                     {0.42f, 0.47f, 0.56f},
                                                     {0.57f, 0.58f, 0.58f},
                                                     {0.73f, 0.69f, 0.55f},
                                                     {0.88f, 0.82f, 0.45f},
                                                     {1.00f, 0.95f, 0.45f}}}},
                                                  {"grey",
                                                   {{{0.55f, 0.55f, 0.55f},
                                                     {0.64f, 0.64f, 0.64f},
                                                     {0.73f, 0.73f, 0.73f},
                                                     {0.82f, 0.82f, 0.82f},
                                                     {0.91f, 0.91f, 0.91f},
                                                     {1.00f, 1.00f, 1.00f}}}}}};

} // namespace viewer

#endif // VIEWER_PALETTES_HPP
