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

/// KEYWORD["text", number, KEYWORD[...], ...] of well-known text. Bare words among the arguments are left out.
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
            if (const auto number = parse_finite(word)) into.numbers.push_back(*number);
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

std::optional<MapUnits> units_of(const std::vector<Node>& nodes) {
    // The system itself may stand in a compound or a bound one.
    const auto find = [&](std::initializer_list<std::string_view> keywords) -> const Node* {
        for (const Node& node : nodes) {
            if (const Node* const found = node.find(keywords)) return found;
        }
        return nullptr;
    };
    MapUnits units;
    if (const Node* const vertical = find({"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"}))
        units.height = unit_of(*vertical, {"UNIT", "LENGTHUNIT"});
    if (const Node* const ellipsoid = find({"SPHEROID", "ELLIPSOID"})) {
        if (ellipsoid->numbers.size() >= 2 && ellipsoid->numbers[0] > 0 && ellipsoid->numbers[1] >= 0) {
            units.semi_major = ellipsoid->numbers[0];
            units.flattening = ellipsoid->numbers[1] > 1 ? 1 / ellipsoid->numbers[1] : 0;
        }
    }
    std::optional<double> size;
    if (const Node* const flat = find({"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS"})) {
        size = unit_of(*flat, {"UNIT", "LENGTHUNIT"});
    } else if (const Node* const round =
                   find({"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS"})) {
        size = unit_of(*round, {"UNIT", "ANGLEUNIT"});
        units.angular = true;
    }
    if (!size) return std::nullopt;
    units.size = *size;
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
    if (system.empty()) return std::nullopt;
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

struct Radii {
    double east, north; ///< N·cos φ and M
};
Radii radii_at(const MapUnits& units, double latitude) {
    const double squared = units.flattening * (2 - units.flattening); // e²
    const double rest = 1 - squared * std::pow(std::sin(latitude), 2);
    return {units.semi_major / std::sqrt(rest) * std::cos(latitude),
            units.semi_major * (1 - squared) / std::pow(rest, 1.5)};
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
    if (!units.angular) return checked_spacing(units.size * extent.cell, file);

    const double south = units.size * extent.south, north = units.size * extent.north;
    const double middle = (south + north) / 2;
    const double half_cell = 0.5 * units.size * extent.cell.y;
    constexpr double pole = std::numbers::pi / 2;
    // The last row of a map of the whole globe lies on the pole or half a cell before it.
    if (!(std::abs(south) <= pole + 1.01 * half_cell && std::abs(north) <= pole + 1.01 * half_cell &&
          std::abs(middle) < pole - half_cell)) {
        throw BadInput{file + " is in degrees from latitude " + rounded(south / degree, 6) + " to " +
                       rounded(north / degree, 6) +
                       ", where they cannot be turned into metres; --spacing gives the metres."};
    }
    const Radii radii = radii_at(units, middle);
    const glm::dvec2 metres = units.size * extent.cell * glm::dvec2{radii.east, radii.north};
    std::string sentence =
        "degrees are turned into metres at the middle latitude, " + rounded(middle / degree, 6);
    const auto width = [&](double latitude) {
        return std::max(0.0, radii_at(units, latitude).east) * units.size * extent.cell.x;
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
