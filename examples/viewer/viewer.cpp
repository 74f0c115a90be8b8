#include "viewer.hpp"

#include "quantities.hpp"
#include "save_terrain.hpp"

#include <bad_input.hpp>

#include <imgui.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace viewer {
namespace {

constexpr double radians_per_pixel = 0.006;
constexpr int few_cells = 4; ///< from the middle of the picture to its side

/// Contours are about 9 mm apart in the hand where the ground is as steep as in the mean.
double contour_interval(double scale, double steepness, bool feet) noexcept {
    const double unit = feet ? 0.3048 : 1.0;
    return unit * round_number(9e-3 * scale * std::clamp(steepness, 1e-3, 1.0) / unit);
}

} // namespace

Viewer::Viewer(TouchedTerrain& touched, int n, float pixels)
    : touched_{&touched}, displayed_{&touched.displayed}, haptics_{&touched.haptics},
      loader_{touched.displayed, n, static_cast<int>(touched.ground->coarsest_level())},
      terrain_drawer_{touched.displayed, n}, layer_{pixels}, renderer_{renderer_name()} {
    settings_.feel.stiffness = haptics_->default_stiffness();
    settings_.feel.tip = haptics_->default_tip();
    settings_.feel.release_speed = haptics_->default_release_speed();
    settings_.save_as = std::filesystem::path{touched.terrain.name}.stem().string() + "_edited.flt";
    renderer_ = renderer_.substr(0, renderer_.find(" ("));
    take_hand();
    ask_for_levels();
}

void Viewer::take_hand() {
    (void)haptics_->show(hand_);
    haptics_->rows().drain([&](const demo::Touch& touch) {
        force_.add(touch);
        if (record_ != nullptr) record_->add(touch);
    });
    if (hand_.has_touched) settings_.shows_hint = false;
}

void Viewer::tell_hand(const FrameInput& input, const glm::ivec2& size) {
    told_.has_pointer = input.has_pointer;
    if (input.has_pointer) told_.pointer = camera_.ray(input.pointer, size);
    told_.pressing = input.pressing;
    told_.firmness = settings_.firmness;
    told_.zoom += input.zoom;
    const double pixel = camera_.pixel_size(size);
    told_.pan +=
        pixel * (input.pan.x * camera_.right() - input.pan.y / std::sin(camera_.elevation) * camera_.ahead());
    told_.feel = settings_.feel;
    told_.level = settings_.level;
    told_.brush = settings_.brush;
    told_.undos += input.undoes;
    told_.resets += input.goes_home;
    told_.edits_seen = edits_asked_;
    if (levels_) told_.finest_loaded = levels_->levels.front()->level;
    haptics_->tell(told_);
}

/// The windows stay where they are while the stylus is well inside the finest one, so that the ground does not shimmer under a
/// hand that explores one place.
void Viewer::follow() {
    const glm::dvec2 at = glm::dvec2{hand_.proxy} / displayed_->spacing;
    const glm::dvec2 last{static_cast<double>(displayed_->columns - 1),
                          static_cast<double>(displayed_->rows - 1)};
    const double slack = placed_ ? std::exp2(std::floor(hand_.level)) * loader_.n() / 8.0 : 0.0;
    place_ = glm::clamp(glm::clamp(place_, at - slack, at + slack), glm::dvec2{0.0}, last);
    placed_ = true;
}

void Viewer::ask_for_levels() {
    follow();
    LevelRequest request{.place = place_, .finest = static_cast<int>(std::floor(hand_.wanted_level))};
    if (hand_.edit != edits_asked_) {
        request.changed = hand_.edited;
        edits_asked_ = hand_.edit;
    }
    request.edit = edits_asked_;
    const bool same = asked_ && asked_->place == request.place && asked_->finest == request.finest &&
                      asked_->edit == request.edit;
    if (same) return;
    asked_ = request;
    loader_.ask(request);
}

/// The eye follows the height of the ground in the middle of the hand's workspace.
void Viewer::look_at_middle(double share) {
    if (!levels_) return;
    const auto height = levels_->height_at(glm::dvec2{hand_.offset} / displayed_->spacing, loader_.n());
    if (!height) return;
    const double z = (displayed_->datum + static_cast<double>(*height) - hand_.offset.z) / hand_.scale;
    camera_.target.z += (z - camera_.target.z) * share;
}

FrameReport Viewer::frame(const FrameInput& input, const glm::ivec2& size, double seconds, bool waits) {
    frame_seconds_ = waits ? 0 : frame_seconds_ + (seconds - frame_seconds_) * std::min(1.0, 4 * seconds);
    camera_.turn(-radians_per_pixel * input.turn.x, radians_per_pixel * input.turn.y);
    camera_.exaggeration = settings_.exaggeration;
    if (input.toggles_keys) settings_.shows_keys = !settings_.shows_keys;
    if (input.toggles_panel) settings_.shows_panel = !settings_.shows_panel;
    if (input.brush) settings_.brush.kind = *input.brush;

    take_hand();
    tell_hand(input, size);
    ask_for_levels();
    if (waits) loader_.wait();
    levels_ = loader_.newest();
    look_at_middle(waits ? 1.0 : std::min(1.0, 8 * seconds));

    adapt_tints(size, waits ? 1.0 : std::min(1.0, 3 * seconds));
    view_ = {.camera = camera_,
             .scale = hand_.scale,
             .offset = hand_.offset,
             .level = hand_.level,
             .contour_interval = contour_interval(
                 hand_.scale, levels_ ? static_cast<double>(levels_->steepness) : 1.0, settings_.feet),
             .tints = tints_,
             .look = settings_.look};
    glViewport(0, 0, size.x, size.y);
    glClearColor(0.72f, 0.79f, 0.86f, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    report_ = {};
    if (levels_) {
        report_.terrain = terrain_drawer_.draw(*levels_, view_, size);
        report_.samples_read = levels_->samples_read;
        report_.has_terrain = true;
    }
    if (shows_markers_) draw_markers(size);
    draw_text(size, seconds);
    return report_;
}

void Viewer::draw_markers(const glm::ivec2& size) {
    marker_drawer_.draw({.stylus = hand_.to_hand(hand_.stylus),
                         .proxy = hand_.to_hand(hand_.proxy),
                         .normal = hand_.normal,
                         .tip = hand_.tip / hand_.scale,
                         .wanted = hand_.wanted,
                         .newtons = hand_.force,
                         .touching = hand_.touching(),
                         .over_ground = hand_.over_ground,
                         .pixel = std::max(static_cast<double>(layer_.pixels()), size.y / 900.0)},
                        camera_, size);
}

/// The lowest and the highest height, m above the datum, at some places up to so many samples from the middle of the workspace.
/// For pictures of few cells, whose vertices are out of the picture.
glm::vec2 Viewer::heights_within(double samples) const {
    constexpr int steps = 4;
    glm::vec2 range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
    const glm::dvec2 middle = glm::dvec2{hand_.offset} / displayed_->spacing;
    for (int b = -steps; b <= steps; ++b) {
        for (int a = -steps; a <= steps; ++a) {
            if (const auto z = levels_->height_at(middle + samples / steps * glm::dvec2{a, b}, loader_.n()))
                range = {std::min(range.x, *z), std::max(range.y, *z)};
        }
    }
    return range;
}

/// The tints are those of the heights that are about in the picture, so that a single slope shows its forms as well as a range of
/// mountains does.
void Viewer::adapt_tints(const glm::ivec2& size, double share) {
    if (!levels_) return;
    // Samples from the middle to the side of the picture, and the finest level whose window reaches so far.
    const double wide = 0.5 * camera_.pixel_size(size) * size.x * hand_.scale / displayed_->spacing.x;
    const int n = loader_.n(), finest = levels_->levels.front()->level;
    const int level = static_cast<int>(std::ceil(std::log2(std::max(1.0, 2 * wide / n)))) - finest;
    const LoadedLevel& seen = *levels_->levels[static_cast<std::size_t>(
        std::clamp(level, 0, static_cast<int>(levels_->levels.size()) - 1))];
    const int reach = std::min(static_cast<int>(wide / std::exp2(seen.level)), n / 2);
    const glm::dvec2 middle = glm::dvec2{hand_.offset} / displayed_->spacing / std::exp2(seen.level);
    const auto first = [&](double at, hfh::Index origin) {
        return std::clamp(static_cast<int>(at) - static_cast<int>(origin) - reach, 0, n - 1);
    };
    const auto last = [&](double at, hfh::Index origin) {
        return std::clamp(static_cast<int>(at) - static_cast<int>(origin) + reach + 1, 0, n - 1);
    };
    glm::vec2 range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
    for (int b = first(middle.y, seen.origin.j); b <= last(middle.y, seen.origin.j); ++b) {
        for (int a = first(middle.x, seen.origin.i); a <= last(middle.x, seen.origin.i); ++a) {
            const LevelVertex& v = seen.vertices[static_cast<std::size_t>(b * n + a)];
            if (v.coarse_slope.y < no_cell / 2)
                range = {std::min(range.x, v.height), std::max(range.y, v.height)};
        }
    }
    if (reach < few_cells) range = heights_within(wide);
    if (range.x > range.y) return;
    range.y =
        std::max(range.y, range.x + 1e-3f * static_cast<float>(hand_.scale)); // flat ground has one tint
    tints_ = tints_ == glm::vec2{0.0f} ? range : glm::mix(tints_, range, static_cast<float>(share));
}

void Viewer::draw_text(const glm::ivec2& size, double seconds) {
    message_left_ -= seconds;
    if (message_left_ <= 0) message_.clear();
    if (shows_text_) {
        OverlayText text{.hand = hand_,
                         .slope = std::acos(std::clamp(hand_.normal.z, -1.0, 1.0)),
                         .frames_per_second = frame_seconds_ > 0 ? 1 / frame_seconds_ : 0,
                         .real_time = real_time_,
                         .renderer = renderer_,
                         .message = message_,
                         .feet = settings_.feet,
                         .shows_hint = settings_.shows_hint,
                         .in_a_hand = haptics_->is_in_a_hand(),
                         .shows_keys = settings_.shows_keys,
                         .shows_panel = settings_.shows_panel,
                         .lowest = displayed_->datum + static_cast<double>(tints_.x),
                         .highest = displayed_->datum + static_cast<double>(tints_.y),
                         .palette = settings_.look.palette,
                         .contour_interval = settings_.look.contours ? view_.contour_interval : 0,
                         .triangles = report_.terrain.triangles};
        draw_overlay(text, force_, camera_, size, layer_.pixels());
        if (settings_.shows_panel) {
            const PanelWishes wishes =
                draw_panel(settings_, hand_, loader_.coarsest(), size, layer_.pixels());
            told_.undos += wishes.undo;
            told_.resets += wishes.home;
            if (wishes.save) save();
        }
    }
    layer_.draw();
}

void Viewer::save() {
    try {
        save_terrain(touched_->terrain, touched_->frame, settings_.save_as);
        say("Saved as " + settings_.save_as + " (the file that was opened is as it was).");
    } catch (const demo::BadInput& error) {
        say(error.what());
    }
}

} // namespace viewer
