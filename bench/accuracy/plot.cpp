#include "plot.hpp"

#include "text.hpp"

#include <algorithm>
#include <iterator>

namespace accuracy {
namespace {

constexpr double floor_mark = 1e-16; ///< where errors of 0, or of rounding, are drawn

struct Look {
    Family family;
    const char* name;
    const char* colour;
    int point, open_point; ///< gnuplot's numbers: filled for 99.9 %, open for the mean
    bool joined;
};
constexpr Look looks[] = {
    {Family::vertical, "vertical projection", "#777777", 11, 10, false},
    {Family::triangles, "two triangles, either diagonal", "#c08000", 9, 8, false},
    {Family::paper, "the paper''s Newton, 1 to 8 iterations", "#1f5fbf", 7, 6, true},
    {Family::ours, "newton\\_closest\\_point, max\\_iterations 1 to 64", "#c8202c", 5, 4, true},
    {Family::complete, "global\\_closest\\_point", "#1a8a3a", 13, 12, false},
};

[[nodiscard]] double drawn(double error) { return error <= rounding_error("double") ? floor_mark : error; }

/// The settings beside the marks, "first–last" where several are too close to tell apart: those of the paper above,
/// ours below (and beside the line).
[[nodiscard]] std::string labels(const Measured& set, const Look& look) {
    std::string out;
    std::vector<const Figures*> close;
    const auto put = [&] {
        if (close.empty()) return;
        const bool above = look.family == Family::paper;
        double time = 1, place = above ? 0 : std::numeric_limits<double>::max();
        for (const Figures* f : close) {
            time *= std::pow(f->nanoseconds, 1 / static_cast<double>(close.size()));
            place = above ? std::max(place, drawn(f->distance.most))
                          : std::min({place, drawn(f->distance.most), drawn(f->distance.mean)});
        }
        std::string label = std::to_string(close.front()->title.steps);
        if (close.size() > 1) label += text("–%d", close.back()->title.steps);
        const char* const offset = above ? "0,0.7" : place == floor_mark ? "0,-0.75" : "1,-0.55";
        out += text("set label '%s' at %g,%g center offset %s textcolor rgb '%s' font ',9'\n", label.c_str(),
                    time, place, offset, look.colour);
        close.clear();
    };
    for (const Figures& f : set.methods) {
        if (f.title.family != look.family || f.title.name == "paper, until still") continue;
        // The paper's steps are equally long, so not every one need be named.
        if (look.family == Family::paper && (f.title.steps & (f.title.steps - 1)) != 0) continue;
        const double apart = look.family == Family::paper ? 1.1 : 2.0;
        if (!close.empty() && (std::max(f.nanoseconds, close[0]->nanoseconds) >
                                   apart * std::min(f.nanoseconds, close[0]->nanoseconds) ||
                               drawn(f.distance.most) < 0.01 * drawn(close[0]->distance.most)))
            put();
        close.push_back(&f);
    }
    put();
    return out;
}

/// The share of wrong answers, in the corner that no method reaches.
[[nodiscard]] std::string wrong_answers(const Measured& set) {
    std::string out = "set label 'wrong answers' at 1.1,1e-7 left font ',9'\n";
    double place = 1e-7;
    for (const Figures& f : set.methods) {
        const bool last =
            f.title.name == "paper, 8" || f.title.name == "ours, 64" || f.title.name == "complete";
        if (!last) continue;
        const Look& look = *std::find_if(std::begin(looks), std::end(looks),
                                         [&](const Look& l) { return l.family == f.title.family; });
        const std::string after = f.title.steps > 0 ? text(" after %d", f.title.steps) : std::string{};
        place /= 40;
        out += text("set label '%.2g %%%s' at 1.1,%g left textcolor rgb '%s' font ',9'\n", 100 * f.wrong,
                    after.c_str(), place, look.colour);
    }
    return out;
}

[[nodiscard]] std::string panel(const Measured& set, std::size_t number) {
    const std::size_t column = number / 2, row = number % 2;
    std::string out =
        text("set lmargin at screen %.4f\nset rmargin at screen %.4f\n"
             "set tmargin at screen %.4f\nset bmargin at screen %.4f\n",
             0.075 + 0.312 * static_cast<double>(column), 0.370 + 0.312 * static_cast<double>(column),
             row == 0 ? 0.955 : 0.530, row == 0 ? 0.590 : 0.165);
    out += filled("set title '{}' offset 0,-0.6 font ',12'\n", {set.name()});
    out += row == 0 ? "set xlabel ''\n" : "set xlabel 'nanoseconds a query' offset 0,0.4\n";
    out += column == 0 ? "set ylabel 'distance error, cells' offset 0.6,0\n" : "set ylabel ''\n";
    out += column == 0
               ? "set ytics (\"exact to\\nrounding\" 1e-16, '1e-12' 1e-12, '1e-9' 1e-9, '1e-6' 1e-6, '0.001' "
                 "1e-3, '1' 1, '1000' 1e3) font ',9'\n"
               : "set ytics ('' 1e-16, '' 1e-12, '' 1e-9, '' 1e-6, '' 1e-3, '' 1, '' 1e3)\n";
    out += "unset label\n";
    out += wrong_answers(set);
    std::string plots;
    for (const Look& look : looks) {
        out += look.joined ? labels(set, look) : "";
        std::string points;
        for (const Figures& f : set.methods) {
            if (f.title.family != look.family || f.title.name == "paper, until still") continue;
            points += text("%g %g %g\n", f.nanoseconds, drawn(f.distance.most), drawn(f.distance.mean));
        }
        const std::string block = text("$panel%zu_%d", number, static_cast<int>(look.family));
        const std::string colour = text("lc rgb '%s' notitle", look.colour);
        out += filled("{} << EOD\n{}EOD\n", {block, points});
        if (look.joined) plots += filled("{} using 1:2 with lines lw 1 {}, ", {block, colour});
        plots += filled("{} using 1:2:(0):($3-$2) with vectors nohead dt 3 lw 1 {}, ", {block, colour});
        plots += filled("{} using 1:3 with points pt {} ps 0.9 {}, ",
                        {block, std::to_string(look.open_point), colour});
        plots +=
            filled("{} using 1:2 with points pt {} ps 1.1 {}, ", {block, std::to_string(look.point), colour});
    }
    plots.resize(plots.size() - 2);
    return out + filled("plot {}\n", {plots});
}

/// The key, as a panel of its own below the others.
[[nodiscard]] std::string key() {
    std::string out =
        "unset title\nunset xlabel\nunset ylabel\nunset border\nunset xtics\nunset ytics\nunset grid\n"
        "unset object\nunset label\nset lmargin at screen 0.02\nset rmargin at screen 0.98\n"
        "set tmargin at screen 0.100\nset bmargin at screen 0.005\n"
        "set key center center horizontal Left reverse maxrows 3 width 2 samplen 1.5 spacing 1.25 font "
        "',11'\nplot ";
    for (const Look& look : looks) {
        out +=
            text("NaN with points pt %d ps 1.2 lc rgb '%s' title '%s', ", look.point, look.colour, look.name);
    }
    return out +
           "NaN with points pt 6 ps 1.0 lc rgb 'black' title 'filled: 99.9 % have no more; open: mean'\n";
}

} // namespace

std::string plot_script(const Run& run, const std::string& file) {
    std::string out =
        filled("set terminal pngcairo size 1500,940 font 'sans,11' background rgb 'white'\nset output '{}'\n",
               {file});
    out += "set encoding utf8\nset multiplot\nset logscale xy\nset xrange [0.8:6000]\n"
           "set yrange [3e-18:5e4]\nunset key\nset grid lc rgb '#dddddd' lw 1 dt 1\n"
           "set xtics (1, 10, 100, 1000) offset 0,0.3\nset tics scale 0.5\n"
           "set object 1 rectangle from graph 0, first 3e-18 to graph 1, first 9e-16 "
           "fillcolor rgb '#eef5ee' fillstyle solid noborder behind\n";
    std::size_t number = 0;
    for (const Measured& set : run.sets) {
        if (set.scalar == "double") out += panel(set, number++);
    }
    return out + key() + "unset multiplot\n";
}

} // namespace accuracy
