#ifndef VIEWER_QUANTITIES_HPP
#define VIEWER_QUANTITIES_HPP

#include <numbers.hpp>

#include <cmath>
#include <string>

// Lengths as text with their units, for people.

namespace viewer {

/// The largest of 1, 2, 5, 10, 20, 50, … times a power of ten that is at most x. Precondition: x > 0.
[[nodiscard]] inline double round_number(double x) noexcept {
    const double power = std::pow(10.0, std::floor(std::log10(x)));
    const double mantissa = x / power;
    return power * (mantissa >= 5 ? 5 : mantissa >= 2 ? 2 : 1);
}

/// "1.25 km", "3.2 mm"; with `feet` "4100 ft", "2.3 mi". `like`: a length whose unit is taken, so that numbers can be compared.
[[nodiscard]] inline std::string length_text(double metres, bool feet, int significant = 3, double like = 0) {
    const double size = std::abs(like != 0 ? like : metres);
    struct Unit {
        double metres;
        const char* name;
    };
    constexpr Unit metric[]{{1e3, " km"}, {1, " m"}, {1e-3, " mm"}, {1e-6, " µm"}};
    constexpr Unit imperial[]{{1609.344, " mi"}, {0.3048, " ft"}, {0.0254, " in"}, {0.0254e-3, " mil"}};
    const auto& units = feet ? imperial : metric;
    const Unit* unit = &units[3];
    for (const Unit& larger : units) {
        // Kilometres from ten on, so that a mountain is 3710 m high; all else from one on.
        const double from = larger.metres > 100 ? 10 * larger.metres : larger.metres;
        if (size >= from) {
            unit = &larger;
            break;
        }
    }
    if (size == 0) unit = &units[1];
    return demo::rounded(metres / unit->metres, significant) + unit->name;
}

} // namespace viewer

#endif // VIEWER_QUANTITIES_HPP
