#include "map_units.hpp"

#include "bad_input.hpp"
#include "numbers.hpp"
#include "units.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace demo {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::string upper(std::string_view text) {
    std::string out{text};
    for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return out;
}

/// KEYWORD["text", number, KEYWORD[...], ...] of well-known text. A bare word among the arguments is a text too.
struct Node {
    std::string keyword;
    std::vector<std::string> texts;
    std::vector<double> numbers;
    std::vector<Node> children;

    [[nodiscard]] bool is(std::initializer_list<std::string_view> keywords) const {
        return std::ranges::find(keywords, keyword) != keywords.end();
    }
    [[nodiscard]] const Node* child(std::initializer_list<std::string_view> keywords) const {
        const auto at = std::ranges::find_if(children, [&](const Node& node) { return node.is(keywords); });
        return at == children.end() ? nullptr : &*at;
    }
    /// Itself or the first below it, depth first.
    [[nodiscard]] const Node* find(std::initializer_list<std::string_view> keywords) const {
        if (is(keywords)) return this;
        for (const Node& node : children) {
            if (const Node* const found = node.find(keywords)) return found;
        }
        return nullptr;
    }
};

class WellKnownText {
public:
    explicit WellKnownText(std::string_view text) : rest_{text} {}

    /// All that stands side by side (ESRI writes a vertical system behind the horizontal one); empty if it is no such text.
    [[nodiscard]] std::vector<Node> read() {
        std::vector<Node> nodes;
        do {
            Node node;
            if (!read_argument(node, 0)) return {};
            std::ranges::move(node.children, std::back_inserter(nodes));
        } while (took(','));
        skip_blanks();
        return rest_.empty() ? nodes : std::vector<Node>{};
    }

private:
    static constexpr int deepest = 40; // more than any system has; the reader calls itself

    void skip_blanks() {
        while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front())) != 0)
            rest_.remove_prefix(1);
    }
    bool took(char wanted) {
        skip_blanks();
        if (rest_.empty() || rest_.front() != wanted) return false;
        rest_.remove_prefix(1);
        return true;
    }
    bool read_argument(Node& into, int depth) {
        if (depth > deepest) return false;
        if (took('"')) {
            const auto end = rest_.find('"');
            if (end == std::string_view::npos) return false;
            into.texts.emplace_back(rest_.substr(0, end));
            rest_.remove_prefix(end + 1);
            return true;
        }
        const auto end = std::min(rest_.find_first_of("[](),\" \t\r\n"), rest_.size());
        const std::string_view word = rest_.substr(0, end);
        if (word.empty()) return false;
        rest_.remove_prefix(end);
        const bool square = took('[');
        if (!square && !took('(')) {
            if (const auto number = parse_finite(word))
                into.numbers.push_back(*number);
            else
                into.texts.emplace_back(word);
            return true;
        }
        Node node{upper(word), {}, {}, {}};
        do {
            if (!read_argument(node, depth + 1)) return false;
        } while (took(','));
        into.children.push_back(std::move(node));
        return took(square ? ']' : ')');
    }

    std::string_view rest_;
};

/// Metres or radians in the unit of a system, which names it itself or, in newer text, for each axis.
std::optional<double> unit_of(const Node& system, std::initializer_list<std::string_view> keywords) {
    const Node* unit = system.child(keywords);
    for (const Node& part : system.children) {
        if (unit == nullptr && part.is({"CS", "AXIS"})) unit = part.find(keywords);
    }
    if (unit == nullptr || unit->numbers.empty() || !(unit->numbers[0] > 0)) return std::nullopt;
    return unit->numbers[0];
}

/// A name in the spelling in which the standards agree: "False_Northing" and "False northing" are "falsenorthing".
std::string plain(std::string_view name) {
    std::string out;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalnum(byte) != 0) out += static_cast<char>(std::tolower(byte));
    }
    return out;
}

/// The parameter of `system` under one of its names, times its own unit if it has one, else times `unit`.
std::optional<double> parameter(const Node& system, std::initializer_list<std::string_view> names,
                                double unit) {
    for (const Node& child : system.children) {
        if (child.is({"CONVERSION"})) {
            if (const auto inside = parameter(child, names, unit)) return inside;
        }
        if (!child.is({"PARAMETER"}) || child.texts.empty() || child.numbers.empty()) continue;
        if (std::ranges::find(names, plain(child.texts[0])) == names.end()) continue;
        const Node* const own = child.child({"LENGTHUNIT", "ANGLEUNIT", "SCALEUNIT", "UNIT"});
        return child.numbers[0] * (own != nullptr && !own->numbers.empty() ? own->numbers[0] : unit);
    }
    return std::nullopt;
}

/// True if the ellipsoid of the map is taken for a sphere, whatever it is.
bool is_web_mercator(const Node& system, const std::string& method) {
    if (method == "popularvisualisationpseudomercator" || method == "mercatorauxiliarysphere") return true;
    const Node* const extension = system.child({"EXTENSION"});
    return extension != nullptr && std::ranges::any_of(extension->texts, [](const std::string& text) {
               return text.find("+nadgrids=@null") != std::string::npos;
           });
}

/// The projection of `system`, whose units are known, if it is cylindrical and not transverse.
std::optional<CylindricalMap> cylindrical_of(const Node& system, const MapUnits& units) {
    using enum CylindricalMap::Kind;
    const Node* const named = system.find({"PROJECTION", "METHOD"});
    if (named == nullptr || named->texts.empty()) return std::nullopt;
    const std::string method = plain(named->texts[0]);
    const bool web = is_web_mercator(system, method);
    CylindricalMap map;
    if (web || method.starts_with("mercator"))
        map.kind = mercator;
    else if (method.starts_with("equidistantcylindrical") || method.starts_with("equirectangular") ||
             method == "platecarree")
        map.kind = equidistant;
    else if (method.find("cylindricalequalarea") != std::string::npos || method == "behrmann")
        map.kind = equal_area;
    else
        return std::nullopt;
    if (map.kind == mercator && !web) map.eccentricity_squared = units.flattening * (2 - units.flattening);
    map.false_northing = parameter(system, {"falsenorthing"}, units.size).value_or(0.0);
    if (map.kind == equidistant) {
        const auto origin = parameter(system, {"latitudeoforigin", "latitudeofnaturalorigin"}, degree);
        map.false_northing -= units.semi_major * origin.value_or(0.0);
    }
    const double parallel =
        parameter(system, {"standardparallel1", "latitudeof1ststandardparallel"}, degree).value_or(0.0);
    map.scale = parameter(system, {"scalefactor", "scalefactoratnaturalorigin"}, 1.0).value_or(1.0) *
                std::cos(parallel) /
                std::sqrt(1 - map.eccentricity_squared * std::pow(std::sin(parallel), 2));
    return map;
}

/// True if a vertical system counts downwards, as its axis or ESRI's parameter says.
bool counts_down(const Node& vertical) {
    if (parameter(vertical, {"direction"}, 1.0) == -1.0) return true;
    const Node* const axis = vertical.find({"AXIS"});
    return axis != nullptr && axis->texts.size() >= 2 && upper(axis->texts[1]) == "DOWN";
}

std::optional<MapUnits> units_of(const std::vector<Node>& nodes) {
    // The system itself may stand in a compound or a bound one.
    const auto find = [&](std::initializer_list<std::string_view> keywords) -> const Node* {
        for (const Node& node : nodes) {
            if (const Node* const found = node.find(keywords)) return found;
        }
        return nullptr;
    };
    MapUnits units;
    if (const Node* const vertical = find({"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"})) {
        units.height = unit_of(*vertical, {"UNIT", "LENGTHUNIT"});
        units.depths = counts_down(*vertical);
    }
    if (const Node* const ellipsoid = find({"SPHEROID", "ELLIPSOID"})) {
        if (ellipsoid->numbers.size() >= 2 && ellipsoid->numbers[0] > 0 && ellipsoid->numbers[1] >= 0) {
            units.semi_major = ellipsoid->numbers[0];
            units.flattening = ellipsoid->numbers[1] > 1 ? 1 / ellipsoid->numbers[1] : 0;
        }
    }
    std::optional<double> size;
    const Node* const flat = find({"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS"});
    if (flat != nullptr) {
        size = unit_of(*flat, {"UNIT", "LENGTHUNIT"});
    } else if (const Node* const round =
                   find({"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS"})) {
        size = unit_of(*round, {"UNIT", "ANGLEUNIT"});
        units.angular = true;
    }
    if (!size) return std::nullopt;
    units.size = *size;
    if (flat != nullptr) units.cylindrical = cylindrical_of(*flat, units);
    return units;
}

/// The older form: lines of a key and a value.
std::optional<MapUnits> units_in_lines(std::string_view text) {
    MapUnits units;
    std::string system, unit, height;
    while (!text.empty()) {
        const auto end = std::min(text.find_first_of("\r\n"), text.size());
        const std::string line = upper(trimmed(text.substr(0, end)));
        const auto key_end = std::min(line.find_first_of(" \t"), line.size());
        const std::string key = line.substr(0, key_end), value{trimmed(line.substr(key_end))};
        if (key == "PROJECTION") system = value;
        if (key == "UNITS") unit = value;
        if (key == "ZUNITS") height = value;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    // The parameters of a projection that would be needed for lengths on the ground are of too many forms.
    if (system.empty() || system == "MERCATOR" || system == "EQUIRECTANGULAR") return std::nullopt;
    units.height = metres_in(height);
    units.angular = system == "GEOGRAPHIC";
    if (units.angular) {
        units.size = unit == "DS" ? degree / 3600 : unit == "DM" ? degree / 60 : degree;
        return unit.empty() || unit.starts_with('D') ? std::optional{units} : std::nullopt;
    }
    const auto metres = metres_in(unit);
    if (!metres) return std::nullopt;
    units.size = *metres;
    return units;
}

/// The latitude, in radians, of a northing of the map in its own units. Not a number beyond the map's poles.
double latitude_of(const MapUnits& units, double northing) {
    if (units.angular) return units.size * northing;
    const CylindricalMap& map = *units.cylindrical;
    const double y = (units.size * northing - map.false_northing) / units.semi_major;
    if (map.kind == CylindricalMap::Kind::equidistant) return y;
    if (map.kind == CylindricalMap::Kind::equal_area) return std::asin(y * map.scale);
    double latitude = std::atan(std::sinh(y / map.scale));
    // Each step is e² times as long as the one before, and e² < 0.01 on any planet.
    const double e = std::sqrt(map.eccentricity_squared);
    for (int step = 0; step < 8; ++step)
        latitude = std::atan(std::sinh(y / map.scale + e * std::atanh(e * std::sin(latitude))));
    return latitude;
}

/// Metres on the ground in a metre, or a radian, of the map, east and north.
glm::dvec2 ground_per_unit(const MapUnits& units, double latitude) {
    const double squared = units.angular ? units.flattening * (2 - units.flattening)
                                         : units.cylindrical->eccentricity_squared; // e²
    const double rest = 1 - squared * std::pow(std::sin(latitude), 2);
    const double east = std::cos(latitude) / std::sqrt(rest);
    if (units.angular) return units.semi_major * glm::dvec2{east, (1 - squared) / std::pow(rest, 1.5)};
    const double factor = east / units.cylindrical->scale;
    using enum CylindricalMap::Kind;
    switch (units.cylindrical->kind) {
    case mercator: return {factor, factor};
    case equidistant: return {factor, 1};
    case equal_area: break;
    }
    return {factor, 1 / factor};
}

std::string name_of(const CylindricalMap& map) {
    using enum CylindricalMap::Kind;
    return map.kind == mercator      ? "Mercator"
           : map.kind == equidistant ? "equidistant cylindrical"
                                     : "equal-area cylindrical";
}

} // namespace

std::optional<MapUnits> read_map_units(std::string_view text) {
    const auto nodes = WellKnownText{text}.read();
    return nodes.empty() ? units_in_lines(text) : units_of(nodes);
}

glm::dvec2 checked_spacing(glm::dvec2 spacing, const std::string& file) {
    for (const double d : {spacing.x, spacing.y}) {
        if (d >= 1e-12 && d <= 1e12) continue;
        throw BadInput{file + " has samples every " + rounded(spacing.x) + " x " + rounded(spacing.y) +
                       " m, but they must lie from 1e-12 to 1e12 metres apart (--spacing gives them)."};
    }
    return spacing;
}

glm::dvec2 spacing_on_map(const MapUnits& units, const MapExtent& extent, const std::string& file,
                          std::vector<std::string>& assumed) {
    const glm::dvec2 cell = units.size * extent.cell;
    if (!units.needs_latitude()) return checked_spacing(cell, file);

    const double south = latitude_of(units, extent.south), north = latitude_of(units, extent.north);
    const double middle = latitude_of(units, (extent.south + extent.north) / 2);
    const double half_cell = units.angular ? 0.5 * cell.y : 0;
    constexpr double pole = std::numbers::pi / 2;
    // The last row of a map of the whole globe lies on the pole or half a cell before it.
    if (!(std::abs(south) <= pole + 1.01 * half_cell && std::abs(north) <= pole + 1.01 * half_cell &&
          std::abs(middle) < pole - std::max(half_cell, degree / 60))) {
        throw BadInput{file + " is " + (units.angular ? "in degrees" : "on a cylindrical map") +
                       " from latitude " + rounded(south / degree, 6) + " to " + rounded(north / degree, 6) +
                       ", where they cannot be turned into metres; --spacing gives the metres."};
    }
    const glm::dvec2 metres = cell * ground_per_unit(units, middle);
    std::string sentence =
        (units.angular ? "degrees are turned into metres at the middle latitude, "
                       : name_of(*units.cylindrical) +
                             " metres are turned into those on the ground at the middle latitude, ") +
        rounded(middle / degree, 6);
    const auto width = [&](double latitude) {
        return std::max(0.0, ground_per_unit(units, latitude).x) * cell.x;
    };
    const double at_north = width(north), at_south = width(south);
    if (std::abs(at_north - at_south) > 0.01 * metres.x || std::abs(at_north - metres.x) > 0.01 * metres.x) {
        sentence += "; samples are truly " + rounded(at_north, 4) + " m apart along the north rim, " +
                    rounded(at_south, 4) + " m along the south rim";
    }
    assumed.push_back(sentence + " (see --spacing)");
    return checked_spacing(metres, file);
}

} // namespace demo
