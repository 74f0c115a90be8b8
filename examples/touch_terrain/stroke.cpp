#include "stroke.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace demo {
namespace {

constexpr std::size_t updates = 20000;
constexpr double rate = 1000.0; // Hz

/// 0 below 0, 1 above 1, and smooth between.
double smooth_step(double s) {
    s = std::clamp(s, 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

/// Seen from above, in parts of the terrain, for s from 0 to 1: three loops from west to east. On the bundled terrain
/// they pass over both summits.
glm::dvec2 seen_from_above(double s) {
    const double turn = 2 * std::numbers::pi * (3 * s - 1.0 / 16);
    const double width = 1 - std::pow(2 * s - 1, 4);
    return {0.11 + 0.78 * s + 0.08 * std::sin(turn), 0.55 + 0.11 * width * std::cos(turn)};
}

/// As steep as a hand climbs that keeps its touch: a wall is higher than what this slope takes it to.
constexpr double steepest = 2;

/// The lowest heights above `heights` that rise and fall no faster than `steepest`: where a hand would be that sees a wall
/// ahead, and comes down behind one. `steps`: metres over ground from each height to the next.
std::vector<double> climbable(std::vector<double> heights, const std::vector<double>& steps) {
    for (std::size_t k = 1; k < heights.size(); ++k)
        heights[k] = std::max(heights[k], heights[k - 1] - steepest * steps[k - 1]);
    for (std::size_t k = heights.size() - 1; k-- > 0;)
        heights[k] = std::max(heights[k], heights[k + 1] - steepest * steps[k]);
    return heights;
}

/// Fills holes with a straight line from rim to rim, and marks them.
std::vector<double> bridged(std::vector<double> heights, std::vector<bool>& is_hole) {
    is_hole.assign(heights.size(), false);
    std::size_t last = heights.size(); // none yet
    for (std::size_t k = 0; k < heights.size(); ++k) {
        if (std::isnan(heights[k])) {
            is_hole[k] = true;
            continue;
        }
        const std::size_t from = last == heights.size() ? 0 : last + 1;
        for (std::size_t hole = from; hole < k; ++hole) {
            const double share = static_cast<double>(hole + 1 - from) / static_cast<double>(k + 1 - from);
            heights[hole] = last == heights.size() ? heights[k] : std::lerp(heights[last], heights[k], share);
        }
        last = k;
    }
    const double rest = last == heights.size() ? 0.0 : heights[last];
    for (std::size_t hole = last == heights.size() ? 0 : last + 1; hole < heights.size(); ++hole)
        heights[hole] = rest;
    return heights;
}

/// The mean over `reach` neighbours to either side: where a hand would be that is too slow for the bumps.
std::vector<double> smoothed(const std::vector<double>& heights, std::size_t reach) {
    std::vector<double> sums(heights.size() + 1, 0.0);
    for (std::size_t k = 0; k < heights.size(); ++k) sums[k + 1] = sums[k] + heights[k];
    std::vector<double> out(heights.size());
    for (std::size_t k = 0; k < heights.size(); ++k) {
        const std::size_t from = k - std::min(k, reach), to = std::min(heights.size(), k + reach + 1);
        out[k] = (sums[to] - sums[from]) / static_cast<double>(to - from);
    }
    return out;
}

/// How firmly the hand presses, from 0 in the air to 1 on the ground: in the air over what it does not touch and at both
/// ends.
std::vector<double> pressing(const std::vector<bool>& in_air) {
    constexpr double at_ends = 0.6 * rate, at_rims = 0.15 * rate; // updates from air to ground
    const std::size_t count = in_air.size();
    std::vector<double> press(count);
    for (std::size_t k = 0; k < count; ++k) {
        press[k] = smooth_step(static_cast<double>(std::min(k, count - 1 - k)) / at_ends);
    }
    const auto lift = [&](std::size_t k, double& since_rim) {
        since_rim = in_air[k] ? -0.2 * at_rims : since_rim + 1; // the rim itself is left alone
        press[k] = std::min(press[k], smooth_step(since_rim / at_rims));
    };
    double since_rim = at_rims;
    for (std::size_t k = 0; k < count; ++k) lift(k, since_rim);
    since_rim = at_rims;
    for (std::size_t k = count; k-- > 0;) lift(k, since_rim);
    return press;
}

} // namespace

double stroke_depth(const Ground& ground) noexcept { return 0.2 * std::min(ground.cell.x, ground.cell.y); }

double default_stiffness(const Ground& ground) noexcept {
    return 2.0 / (0.25 * std::min(ground.cell.x, ground.cell.y));
}

std::vector<StylusSample> built_in_stroke(const Ground& ground, double depth, double tip) {
    std::vector<StylusSample> stroke(updates);
    std::vector<double> heights(updates);
    for (std::size_t k = 0; k < updates; ++k) {
        const glm::dvec2 at = seen_from_above(static_cast<double>(k) / (updates - 1)) * ground.size;
        stroke[k] = {static_cast<double>(k) / rate, {at.x, at.y, 0.0}};
        heights[k] = ground.height(at);
    }
    std::vector<double> steps(updates - 1);
    for (std::size_t k = 0; k < steps.size(); ++k) {
        const glm::dvec3 way = stroke[k + 1].position - stroke[k].position;
        steps[k] = std::hypot(way.x, way.y);
    }
    std::vector<bool> in_air;
    const std::vector<double> ground_heights = bridged(std::move(heights), in_air);
    heights = climbable(ground_heights, steps);
    for (std::size_t k = 0; k < updates; ++k) in_air[k] = in_air[k] || heights[k] - ground_heights[k] > depth;
    const std::vector<double> slow = smoothed(heights, 100), press = pressing(in_air);

    const double hover = 3 * depth;
    for (std::size_t k = 0; k < updates; ++k) {
        const double bump = depth * (1 + 0.6 * std::tanh((heights[k] - slow[k]) / depth));
        stroke[k].position.z = heights[k] + std::lerp(hover, -bump, press[k]) + tip;
    }
    return stroke;
}

} // namespace demo
