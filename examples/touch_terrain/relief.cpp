#include "relief.hpp"

#include <glm/common.hpp>
#include <glm/ext/vector_double3.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace demo {
namespace {

using Colour = glm::dvec3;

/// Low ground to high: meadow, straw, stone, snow. Pale, so that the path stands out.
Colour tint(double share) {
    static constexpr std::array<Colour, 6> stops{Colour{150, 168, 152}, Colour{189, 197, 170},
                                                 Colour{217, 211, 188}, Colour{204, 189, 170},
                                                 Colour{190, 178, 170}, Colour{247, 246, 244}};
    const double at = std::clamp(share, 0.0, 1.0) * (stops.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    return glm::mix(stops[k], stops[k + 1], at - static_cast<double>(k));
}

constexpr Colour hole{226, 229, 234};

struct Look {
    double height;
    glm::dvec2 slope; ///< metres per metre
};

/// Height and slope over a step as wide as a cell or a pixel, whichever is wider: differences of the surface itself
/// would show every edge between patches.
Look look_at(const Ground& ground, glm::dvec2 at, glm::dvec2 step) {
    const double here = ground.height(at);
    const auto slope = [&](glm::dvec2 along, double length) {
        const double ahead = ground.height(at + along), behind = ground.height(at - along);
        if (std::isnan(ahead) && std::isnan(behind)) return 0.0;
        if (std::isnan(ahead)) return (here - behind) / length;
        if (std::isnan(behind)) return (ahead - here) / length;
        return (ahead - behind) / (2 * length);
    };
    return {here, {slope({step.x, 0}, step.x), slope({0, step.y}, step.y)}};
}

/// 0 in shade to 1 facing the light; level ground has 0.71. Three lamps, the main one in the north-west.
double light(glm::dvec2 slope) {
    static const std::array<glm::dvec3, 3> lamps{glm::normalize(glm::dvec3{-1, 1, 1.42}),
                                                 glm::normalize(glm::dvec3{-1, -0.3, 1.05}),
                                                 glm::normalize(glm::dvec3{0.3, 1, 1.05})};
    static constexpr std::array<double, 3> share{0.7, 0.15, 0.15};
    const glm::dvec3 normal = glm::normalize(glm::dvec3{-slope, 1.0});
    double sum = 0;
    for (std::size_t k = 0; k < lamps.size(); ++k)
        sum += share[k] * std::max(0.0, glm::dot(normal, lamps[k]));
    return sum;
}

} // namespace

Raster shaded_relief(const Ground& ground, const Region& region, int columns, int rows) {
    const glm::dvec2 pixel = region.size() / glm::dvec2{columns, rows}, step = glm::max(ground.cell, pixel);
    const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    std::vector<Look> looks;
    looks.reserve(count);
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, squares = 0;
    std::size_t solid = 0;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const Look look = look_at(ground, region.low + (glm::dvec2{i, j} + 0.5) * pixel, step);
            looks.push_back(look);
            if (std::isnan(look.height)) continue;
            lowest = std::min(lowest, look.height);
            highest = std::max(highest, look.height);
            squares += std::min(glm::dot(look.slope, look.slope), 4.0);
            ++solid;
        }
    }
    if (solid == 0) lowest = highest = 0;

    constexpr double wanted = 0.45; // root mean square of the slopes shown
    const double mean = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, solid)));
    const double exaggeration = mean > 0 ? std::clamp(wanted / mean, 0.2, 50.0) : 1.0;
    const double range = highest > lowest ? highest - lowest : 1.0;

    Raster raster{columns, rows, {}, lowest, highest};
    raster.rgb.reserve(3 * count);
    for (const Look& look : looks) {
        const double lit = light(exaggeration * look.slope) / light({0.0, 0.0});
        // Shade turns a little blue, light a little warm, as out of doors.
        const Colour shade = lit < 1 ? glm::mix(Colour{0.30, 0.34, 0.46}, Colour{1.0}, lit)
                                     : glm::mix(Colour{1.0}, Colour{1.22, 1.20, 1.12}, (lit - 1) / 0.41);
        const Colour colour = std::isnan(look.height) ? hole : tint((look.height - lowest) / range) * shade;
        for (const double channel : {colour.x, colour.y, colour.z}) {
            raster.rgb.push_back(static_cast<std::uint8_t>(std::clamp(channel, 0.0, 255.0)));
        }
    }
    return raster;
}

} // namespace demo
