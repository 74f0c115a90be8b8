#ifndef TOUCH_TERRAIN_NO_DATA_HPP
#define TOUCH_TERRAIN_NO_DATA_HPP

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

namespace demo {

/// A "no data" value as a sample of type S, of at most 32 bits where that is an integer: nothing if no sample can equal it.
/// The lowest float is often written in so few digits that it lies beyond all floats; it is still that float.
template <class S>
[[nodiscard]] std::optional<S> as_sample(double value) {
    constexpr double least = static_cast<double>(std::numeric_limits<S>::lowest()),
                     most = static_cast<double>(std::numeric_limits<S>::max());
    if constexpr (std::is_floating_point_v<S>) {
        if (std::isfinite(value) && std::abs(value) > most) {
            if (std::abs(value) > most * (1 + 1e-6)) return std::nullopt;
            return static_cast<S>(std::copysign(most, value));
        }
    } else if (!(value >= least && value <= most && std::trunc(value) == value)) {
        return std::nullopt;
    }
    return static_cast<S>(value);
}

/// Says why integers are taken to have a sign.
[[nodiscard]] inline std::string sign_assumed(const std::string& header, const std::string& no_data) {
    return "samples are integers with a sign, for " + header + " has no PIXELTYPE, but a NODATA of " +
           no_data;
}

/// Says of a "no data" value, as `written` in `where`, that it means nothing for samples of the type `samples`.
[[nodiscard]] inline std::string unused_no_data(const std::string& where, const std::string& written,
                                                const std::string& samples) {
    return "no sample is \"no data\", for " + where + " says that it is " + written + ", which no " +
           samples + " can be";
}

} // namespace demo

#endif // TOUCH_TERRAIN_NO_DATA_HPP
