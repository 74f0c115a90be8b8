#include "picture.hpp"

#include "gnuplot.hpp"
#include "numbers.hpp"
#include "relief.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace demo {
namespace {

// The sheet, in pixels.
constexpr int sheet_width = 1400;
constexpr int left = 92, right = 148, top = 92, gap = 84, force_height = 230, bottom = 68;
constexpr int widest = sheet_width - left - right, tallest = 780;

/// The ground around the path: wide enough to see where one is, shaped like the room on the sheet where the terrain
/// allows it.
Region region_around(const Ground& ground, const std::vector<TracePoint>& points) {
    glm::dvec2 low = ground.size, high{0.0};
    for (const TracePoint& point : points) {
        const glm::dvec2 at = glm::clamp(point.at, glm::dvec2{0.0}, ground.size);
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    glm::dvec2 size = (high - low) * 1.16;
    size = glm::max(size, 24.0 * ground.cell);
    constexpr double shape = static_cast<double>(widest) / tallest;
    if (size.x < size.y * shape) size.x = size.y * shape;
    if (size.y < size.x / shape) size.y = size.x / shape;
    size = glm::min(size, ground.size);
    low = glm::clamp((low + high - size) / 2.0, glm::dvec2{0.0}, ground.size - size);
    return {low, low + size};
}

/// The unit in which `length` metres are a number that people like.
struct Unit {
    const char* name;
    double metres;
};
Unit unit_for(double length) {
    for (const Unit unit : {Unit{"km", 1e3}, Unit{"m", 1.0}, Unit{"mm", 1e-3}}) {
        if (length >= 2 * unit.metres) return unit;
    }
    return {"µm", 1e-6};
}

/// A round number not below `value`: where the force axis ends.
double round_up(double value) {
    if (!(value > 0)) return 1.0;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double step : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0}) {
        if (value <= step * power) return step * power;
    }
    return 10 * power;
}

/// A round distance between eight to twenty ticks over `length`.
double tick_for(double length) {
    const double power = std::pow(10.0, std::floor(std::log10(length / 8)));
    for (const double step : {5.0, 2.0}) {
        if (step * power <= length / 8) return step * power;
    }
    return power;
}

/// A gnuplot script as it grows.
class Script {
public:
    Script& operator<<(std::string_view text) {
        text_ += text;
        return *this;
    }
    Script& operator<<(double number) {
        append_number(text_, number);
        return *this;
    }
    [[nodiscard]] const std::string& text() const noexcept { return text_; }

private:
    std::string text_;
};

/// A text for gnuplot, in its single quotes.
std::string in_quotes(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string{"''"} : std::string{c < ' ' && c >= 0 ? '?' : c};
    return out + "'";
}

/// A rectangle on the sheet, pixels from its top left corner.
struct Box {
    int left, top, width, height;
};

/// Where everything stands: the map as large as its shape allows, the force below, as wide as the sheet.
struct Layout {
    explicit Layout(const Region& region) {
        const double scale =
            std::min(widest / region.size().x, tallest / region.size().y); // pixels per metre
        map.width = std::max(1, static_cast<int>(std::lround(region.size().x * scale)));
        map.height = std::max(1, static_cast<int>(std::lround(region.size().y * scale)));
        map.left = left + (widest - map.width) / 2;
        force.top = top + map.height + gap;
        height = force.top + force.height + bottom;
    }
    [[nodiscard]] double x(int pixels) const { return static_cast<double>(pixels) / sheet_width; }
    [[nodiscard]] double y(int pixels) const { return 1 - static_cast<double>(pixels) / height; }

    Box map{left, top, widest, tallest};
    Box force{left, top, widest, force_height};
    int height = 0;
};

void place(Script& script, const Layout& layout, const Box& box) {
    script << "set lmargin at screen " << layout.x(box.left) << "\nset rmargin at screen "
           << layout.x(box.left + box.width) << "\nset tmargin at screen " << layout.y(box.top)
           << "\nset bmargin at screen " << layout.y(box.top + box.height) << "\n";
}

/// Named blocks for what follows: `$touch` and `$free` (the path in contact and not) in map units, `$start` (its first
/// point), and `$force` in seconds.
void define_data(Script& script, const Trace& trace, double unit) {
    const auto& path = trace.path.points();
    const auto in_air = [&](std::size_t k) { return k < path.size() && !path[k].contact; };
    script << "$touch << EOD\n";
    for (const TracePoint& point : path) {
        if (point.contact) script << point.at.x / unit << " " << point.at.y / unit << " " << point.force;
        script << "\n"; // an empty line lifts the pen
    }
    script << "EOD\n$free << EOD\n";
    for (std::size_t k = 0; k < path.size(); ++k) {
        const bool drawn = in_air(k) || in_air(k - 1) || in_air(k + 1); // up to the contact on either side
        if (drawn) script << path[k].at.x / unit << " " << path[k].at.y / unit;
        script << "\n";
    }
    script << "EOD\n$start << EOD\n" << path[0].at.x / unit << " " << path[0].at.y / unit << "\nEOD\n";
    script << "$force << EOD\n";
    for (const TracePoint& point : trace.force.points()) script << point.t << " " << point.force << "\n";
    script << "EOD\n";
}

void begin_sheet(Script& script, const Layout& layout, const std::string& title,
                 const std::string& subtitle) {
    script
        << "set encoding utf8\n"
        << "set terminal pngcairo noenhanced rounded size " << sheet_width << "," << layout.height
        << " background '#ffffff' font 'Sans,13'\n"
        << "set multiplot\nunset key\n"
        << "set tics out nomirror textcolor '#3a3f46'\n"
        << "set palette defined (0 '#fff9c4', 0.25 '#ffc53a', 0.5 '#f7651f', 0.75 '#d0103a', 1 '#6e0a5a')\n"
        << "set label 1 " << in_quotes(title) << " at screen " << layout.x(left) << "," << layout.y(34)
        << " left font 'Sans Bold,19' textcolor '#1d2127'\n"
        << "set label 2 " << in_quotes(subtitle) << " at screen " << layout.x(left) << "," << layout.y(66)
        << " left font 'Sans,12' textcolor '#5a5f66'\n";
}

void draw_map(Script& script, const Layout& layout, const Raster& relief, const Region& region, Unit unit,
              double force_end) {
    const Box& box = layout.map;
    const glm::dvec2 low = region.low / unit.metres, high = region.high / unit.metres;
    const glm::dvec2 pixel = (high - low) / glm::dvec2{relief.columns, relief.rows};
    const double tick = tick_for(high.x - low.x);
    place(script, layout, box);
    script << "set border 15 lc '#5a5f66' lw 1\n"
           << "set xrange [" << low.x << ":" << high.x << "]\nset yrange [" << low.y << ":" << high.y << "]\n"
           << "set xtics " << tick << "\nset ytics " << tick << "\n"
           << "set xlabel 'east (" << unit.name << ")' textcolor '#3a3f46'\n"
           << "set label 3 'north (" << unit.name << ")' at screen " << layout.x(24) << ","
           << layout.y(box.top + box.height / 2) << " center rotate textcolor '#3a3f46'\n"
           << "set cbrange [0:" << force_end
           << "]\nset cblabel 'force (N)' offset 0.6,0 textcolor '#3a3f46'\n"
           << "set colorbox user origin screen " << layout.x(box.left + box.width + 22) << ",screen "
           << layout.y(box.top + box.height) << " size screen " << layout.x(20) << ",screen "
           << layout.y(box.top) - layout.y(box.top + box.height) << "\n"
           << "plot '-' binary array=(" << relief.columns << "," << relief.rows
           << ") format='%uchar%uchar%uchar' dx=" << pixel.x << " dy=" << pixel.y << " origin=("
           << low.x + pixel.x / 2 << "," << low.y + pixel.y / 2 << ") using 1:2:3 with rgbimage, "
           << "$free using 1:2 with lines lc '#ffffff' lw 4, "
           << "$free using 1:2 with lines lc '#20242b' lw 2 dt (5,5), "
           << "$touch using 1:2 with lines lc '#20242b' lw 7.5, "
           << "$touch using 1:2:3 with lines lc palette lw 5, "
           << "$start using 1:2 with points pt 7 ps 1.5 lc '#20242b', "
           << "$start using 1:2 with points pt 7 ps 0.9 lc '#ffffff'\n"
           << std::string_view{reinterpret_cast<const char*>(relief.rgb.data()), relief.rgb.size()};
}

void draw_force(Script& script, const Layout& layout, double first_t, double last_t, double force_end) {
    const Box& box = layout.force;
    place(script, layout, box);
    script << "unset label\nunset colorbox\n"
           << "set label 3 'force (N)' at screen " << layout.x(24) << ","
           << layout.y(box.top + box.height / 2) << " center rotate textcolor '#3a3f46'\n"
           << "set border 3 lc '#5a5f66' lw 1\nset grid ytics lc '#dfe2e6' lw 1 dt 1\n"
           << "set xrange [" << first_t << ":" << last_t << "]\nset yrange [0:" << force_end << "]\n"
           << "set xtics autofreq\nset ytics autofreq\nset xlabel 'time (s)'\n"
           << "plot $force using 1:2 with filledcurves y1=0 fc '#f6ebe1' fs solid noborder, "
           << "$force using 1:2:2 with lines lc palette lw 2\n";
}

} // namespace

void draw_picture(OutputFile& file, const Ground& ground, const Trace& trace, const std::string& title,
                  const std::string& subtitle) {
    const auto& forces = trace.force.points();
    const Region region = region_around(ground, trace.path.points());
    const Layout layout{region};
    const Raster relief = shaded_relief(ground, region, layout.map.width, layout.map.height);
    const Unit unit = unit_for(std::max(region.size().x, region.size().y));
    const double force_end = round_up(std::ranges::max(forces, {}, &TracePoint::force).force);
    const double first_t = forces.front().t, last_t = std::max(forces.back().t, first_t + 1e-3);
    const double update = (last_t - first_t) / static_cast<double>(forces.size());

    Script script;
    define_data(script, trace, unit.metres);
    begin_sheet(script, layout, title, subtitle);
    draw_map(script, layout, relief, region, unit, force_end);
    draw_force(script, layout, first_t, last_t + update, force_end);
    script << "unset multiplot\n";
    file.write(run_gnuplot(script.text()));
}

} // namespace demo
