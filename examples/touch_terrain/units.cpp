#include "units.hpp"

#include <array>
#include <cctype>
#include <string>

namespace demo {
namespace {

struct NamedUnit {
    std::string_view name;
    double metres;
};

constexpr double us_foot = 1200.0 / 3937.0;
constexpr std::array units{
    NamedUnit{"m", 1},
    NamedUnit{"metre", 1},
    NamedUnit{"meter", 1},
    NamedUnit{"km", 1e3},
    NamedUnit{"kilometre", 1e3},
    NamedUnit{"kilometer", 1e3},
    NamedUnit{"dm", 1e-1},
    NamedUnit{"decimetre", 1e-1},
    NamedUnit{"decimeter", 1e-1},
    NamedUnit{"cm", 1e-2},
    NamedUnit{"centimetre", 1e-2},
    NamedUnit{"centimeter", 1e-2},
    NamedUnit{"mm", 1e-3},
    NamedUnit{"millimetre", 1e-3},
    NamedUnit{"millimeter", 1e-3},
    NamedUnit{"um", 1e-6},
    NamedUnit{"\u00b5m", 1e-6},
    NamedUnit{"\u03bcm", 1e-6},
    NamedUnit{"micron", 1e-6},
    NamedUnit{"micrometre", 1e-6},
    NamedUnit{"micrometer", 1e-6},
    NamedUnit{"nm", 1e-9},
    NamedUnit{"nanometre", 1e-9},
    NamedUnit{"nanometer", 1e-9},
    NamedUnit{"ft", 0.3048},
    NamedUnit{"foot", 0.3048},
    NamedUnit{"feet", 0.3048},
    NamedUnit{"footintl", 0.3048},
    NamedUnit{"internationalfoot", 0.3048},
    NamedUnit{"internationalfeet", 0.3048},
    NamedUnit{"usft", us_foot},
    NamedUnit{"ftus", us_foot},
    NamedUnit{"footus", us_foot},
    NamedUnit{"usfoot", us_foot},
    NamedUnit{"usfeet", us_foot},
    NamedUnit{"ussurveyfoot", us_foot},
    NamedUnit{"ussurveyfeet", us_foot},
    NamedUnit{"surveyfoot", us_foot},
    NamedUnit{"in", 0.0254},
    NamedUnit{"inch", 0.0254},
    NamedUnit{"inches", 0.0254},
    NamedUnit{"yd", 0.9144},
    NamedUnit{"yard", 0.9144},
    NamedUnit{"mi", 1609.344},
    NamedUnit{"mile", 1609.344},
    NamedUnit{"fathom", 1.8288},
    NamedUnit{"nauticalmile", 1852},
};

} // namespace

std::optional<double> metres_in(std::string_view name) {
    std::string plain;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalpha(byte) != 0 || byte >= 0x80)
            plain += static_cast<char>(std::tolower(byte));
        else if (std::isdigit(byte) != 0)
            return std::nullopt; // "m2" and "0.1 m" are something else
    }
    for (const NamedUnit& unit : units) {
        if (plain == unit.name) return unit.metres;
        const bool is_plural = unit.name.size() > 2 && plain.ends_with('s');
        if (is_plural && std::string_view{plain}.substr(0, plain.size() - 1) == unit.name) return unit.metres;
    }
    return std::nullopt;
}

} // namespace demo
