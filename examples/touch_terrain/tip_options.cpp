#include "tip_options.hpp"

#include "bad_input.hpp"
#include "command_options.hpp"
#include "numbers.hpp"

#include <CLI/CLI.hpp>

namespace demo {
namespace {

/// The radius that `text` is, from 0 on. A ball of more than a million kilometres is a mistake.
double radius_from(const std::string& option, const std::string& text, const std::string& unit) {
    constexpr double most = 1e9;
    const auto radius = parse_finite(text);
    if (!radius || !(*radius >= 0 && *radius <= most)) refuse(option, text, "a radius from 0 to 1e9 " + unit);
    return *radius;
}

} // namespace

TipCommandLine::TipCommandLine(CLI::App& app) : app_{&app} {
    app.add_option("--tip", on_terrain_,
                   "Touches with a ball of this radius, metres of terrain, in place of a point")
        ->type_name("RADIUS");
    app.add_option("--tip-hand", at_hand_,
                   "The same in millimetres of the hand: on the terrain the ball is as large as the scale "
                   "makes it")
        ->type_name("MM");
    app.add_option("--release", release_,
                   "A proxy that a ridge lets go glides on at so many millimetres of the hand an update; 0.5 "
                   "feels smooth. Default: it is at its new place at once")
        ->type_name("MM");
}

Tip TipCommandLine::tip() const {
    const bool on_terrain = app_->count("--tip") != 0, at_hand = app_->count("--tip-hand") != 0;
    if (on_terrain && at_hand)
        throw BadInput{"--tip and --tip-hand are both there, but the ball has one radius, in metres of "
                       "terrain or in millimetres of the hand."};
    Tip tip;
    if (on_terrain) tip.on_terrain = radius_from("--tip", on_terrain_, "metres");
    if (at_hand) tip.at_hand = 1e-3 * radius_from("--tip-hand", at_hand_, "millimetres");
    return tip;
}

double TipCommandLine::release_speed() const {
    return app_->count("--release") != 0 ? 1e-3 * number_from("--release", release_, false) : 0;
}

} // namespace demo
