#include "haptics.hpp"

#include <session_loop.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace viewer {
namespace {

constexpr unsigned clutch_button = 1u;
constexpr double zoom_rate = 6; ///< doublings of the scale per second, at most

const hfh::DeviceModel& model_of(DeviceKind kind) noexcept {
    return kind == DeviceKind::premium ? hfh::simulated_premium : hfh::simulated_touch;
}

/// What the driver of a real device does not tell is a Touch's.
hfh::DeviceModel model_of(const HapticsSettings& settings) noexcept {
    hfh::DeviceModel model = model_of(settings.device);
    if (!settings.real_device) return model;
    const hfh::DeviceCapabilities touch = model.capabilities;
    model.capabilities = *settings.real_device;
    if (!(model.capabilities.max_stiffness > 0)) model.capabilities.max_stiffness = touch.max_stiffness;
    if (!(model.capabilities.workspace.x > 0)) model.capabilities.workspace = touch.workspace;
    return model;
}

double whole_terrain_scale(const hfh::DeviceCapabilities& device, const glm::dvec2& size) noexcept {
    return std::max(size.x, size.y) / (0.9 * std::max(device.workspace.x, device.workspace.y));
}

/// The device's limits, for samples that are never late, and behind a virtual coupling.
hfh::GuardLimits limits_of(const hfh::DeviceCapabilities& device) noexcept {
    hfh::GuardLimits limits = hfh::guard_limits(device);
    limits.stiffness *= 1.75;
    return limits;
}

} // namespace

double whole_terrain_scale(DeviceKind device, const glm::dvec2& size) noexcept {
    return whole_terrain_scale(model_of(device).capabilities, size);
}

Haptics::Haptics(FeltGround& ground, HapticsSettings settings)
    : ground_{&ground}, settings_{std::move(settings)}, cell_{settings_.cell}, model_{model_of(settings_)},
      workspace_{ground.workspace()}, guard_{ground.guard()}, mouse_{hfh::HandGrip{}.stiffness,
                                                                     glm::dvec3{0.0}} {
    // Nobody holds a stylus on rails, and no damper is needed for it.
    ground_->begin({.limits = limits_of(model_.capabilities),
                    .lag = settings_.device == DeviceKind::none ? 0 : 0.5,
                    .clutch_buttons = clutch_button});
    show_whole_terrain();
    told_.feel.stiffness = before_.feel.stiffness = default_stiffness();
    told_.feel.tip = before_.feel.tip = default_tip();
    told_.feel.release_speed = before_.feel.release_speed = default_release_speed();
    if (!settings_.path.empty()) {
        path_.emplace(std::move(settings_.path));
        wanted_ = workspace_.to_hand(path_->at(0));
    } else {
        mouse_ = {hfh::HandGrip{}.stiffness, {0, 0, 0.02}};
        wanted_ = mouse_.update(told_, 0, told_.feel.stiffness, period());
        wanted_.z = 0.02;
    }
    if (settings_.device == DeviceKind::touch || settings_.device == DeviceKind::premium)
        device_.emplace(model_, hfh::HandGrip{}, Wanted{&wanted_}, std::numeric_limits<double>::infinity());
    publish(wanted_, workspace_.to_terrain(wanted_), {});
}

double Haptics::default_stiffness() const noexcept {
    return settings_.stiffness.value_or(0.8 * model_.capabilities.max_stiffness);
}

void Haptics::show_whole_terrain() noexcept {
    const double scale = whole_terrain_scale(model_.capabilities, settings_.size);
    const glm::dvec2 middle = settings_.size / 2.0;
    double height = ground_->height(middle);
    for (int k = 1; std::isnan(height) && k < 64; ++k) // a hole: some other place
        height = ground_->height(
            settings_.size * (0.5 + 0.45 * glm::dvec2{std::sin(k * 2.4), std::cos(k * 2.4)} * (k / 64.0)));
    workspace_ =
        hfh::Workspace<double>{{.scale = scale, .offset = {middle, std::isnan(height) ? 0.0 : height}}};
    largest_scale_ = 4 * scale;
    smallest_scale_ = scale / 1e7;
    last_ground_ = 0;
}

void Haptics::tick() noexcept {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    take_input();
    move_hand();
    glm::dvec3 hand = wanted_;
    hfh::GuardedForce felt;
    glm::dvec3 stylus;
    if (device_) {
        const hfh::DeviceSample sample = device_->step(newtons_);
        hand = sample.position;
        stylus = workspace_.update(hand);
        felt = feel(sample, stylus);
        newtons_ = felt.newtons;
    } else {
        stylus = path_ ? path_->at(static_cast<double>(updates_) * period()) : workspace_.update(hand);
        hand = workspace_.to_hand(stylus);
        felt = feel({.time = static_cast<double>(updates_) * period(), .position = hand}, stylus);
    }
    paint(told_.pressing);
    ++updates_;
    state_.microseconds = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    publish(hand, stylus, felt);
}

hfh::DeviceCommand Haptics::update(const hfh::DeviceSample& sample) noexcept {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    take_input();
    wanted_ = sample.position;
    const glm::dvec3 stylus = workspace_.update(sample.position, (sample.buttons & clutch_button) != 0);
    const hfh::GuardedForce felt = feel(sample, stylus);
    newtons_ = felt.newtons;
    paint(told_.pressing || (sample.buttons & 2u) != 0);
    ++updates_;
    state_.microseconds = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    publish(sample.position, stylus, felt);
    return {felt.newtons};
}

void Haptics::end() noexcept {
    newtons_ = state_.force = glm::dvec3{0.0};
    shown_.put(state_);
}

void Haptics::take_input() noexcept {
    (void)input_.take(told_);
    if (told_.resets != before_.resets) {
        before_.resets = told_.resets;
        const double up = last_ground_;
        show_whole_terrain();
        mouse_.shift(-up);
        zoom_left_ = 0;
        before_.zoom = told_.zoom;
        ground_->reset();
        guard_.restart();
    }
    zoom_left_ += told_.zoom - before_.zoom;
    before_.zoom = told_.zoom;
    if (told_.edits_seen == state_.edit) state_.edited = {};
    change_scale();
    change_level();
}

/// Zooms about what is touched, or about the ground below the stylus; and moves the terrain under the hand.
void Haptics::change_scale() noexcept {
    if (zoom_left_ != 0) {
        const double step = std::clamp(zoom_left_, -zoom_rate * period(), zoom_rate * period());
        zoom_left_ = std::abs(zoom_left_) <= std::abs(step) ? 0 : zoom_left_ - step;
        const double scale =
            std::clamp(workspace_.frame().scale * std::exp2(-step), smallest_scale_, largest_scale_);
        // What is touched stays in its place, and a ball that keeps its size in the hand stays on it.
        const double grows = told_.feel.tip.at_hand > 0 ? state_.tip : 0;
        const glm::dvec3 touched = contact_.proxy - grows * contact_.normal;
        (void)workspace_.zoom(scale, contact_.touching() ? touched : last_stylus_);
    }
    const glm::dvec2 moved = told_.pan - before_.pan;
    before_.pan = told_.pan;
    if (moved != glm::dvec2{0.0}) {
        // The ground comes along in height, so that it stays under the hand.
        const glm::dvec3 from{workspace_.to_terrain(wanted_)};
        const glm::dvec2 way = -workspace_.frame().scale * moved;
        const double rise =
            ground_->height({from.x + way.x, from.y + way.y}) - ground_->height({from.x, from.y});
        (void)workspace_.move({way, std::isfinite(rise) ? rise : 0.0});
        ground_->reset();
        guard_.restart();
    }
}

/// The level waits for its samples to be in memory, the hand does not.
void Haptics::change_level() noexcept {
    const LevelChoice& choice = told_.level;
    const double by_scale = hfh::suitable_level(workspace_.frame().scale, cell_, choice.cell_at_hand);
    const double wanted =
        std::clamp(choice.by_scale ? by_scale : choice.level, 0.0, ground_->coarsest_level());
    const double level = std::max(wanted, told_.finest_loaded);
    state_.wanted_level = wanted;
    if (level != ground_->level()) (void)workspace_.move({0, 0, ground_->set_level(level)});
}

double Haptics::ground_at_hand(const glm::dvec2& terrain) const noexcept {
    const double height = ground_->height(terrain);
    return std::isnan(height)
               ? last_ground_
               : (height + state_.tip - workspace_.frame().offset.z) / workspace_.frame().scale;
}

glm::dvec3 Haptics::ground_normal(const glm::dvec2& terrain) const noexcept {
    const double d = 0.25 * cell_ * std::exp2(std::floor(ground_->level()));
    const auto across = [&](const glm::dvec2& step) {
        return (ground_->height(terrain + step) - ground_->height(terrain - step)) / (2 * d);
    };
    const glm::dvec3 normal{-across({d, 0}), -across({0, d}), 1};
    return hfh::is_finite(normal) ? glm::normalize(normal) : glm::dvec3{0, 0, 1};
}

void Haptics::move_hand() noexcept {
    if (path_) {
        wanted_ = workspace_.to_hand(path_->at(static_cast<double>(updates_) * period()));
        return;
    }
    // The hand knows the ground by what it touches, and by sight where it does not.
    last_ground_ = contact_.touching() ? workspace_.to_hand(contact_.proxy).z
                                       : ground_at_hand({last_stylus_.x, last_stylus_.y});
    wanted_ = mouse_.update(told_, last_ground_, told_.feel.stiffness, period());
    if (contact_.status == hfh::ContactStatus::buried) wanted_.z += 0.01; // out, to come down from outside
}

hfh::GuardedForce Haptics::feel(const hfh::DeviceSample& sample, const glm::dvec3& stylus) noexcept {
    const Feel& feel = told_.feel;
    state_.tip = ground_->set_tip(feel.tip.radius(workspace_.frame().scale));
    ground_->set_release_speed(feel.release_speed);
    const Felt felt = ground_->update(sample, {.stiffness = feel.stiffness,
                                               .static_friction = feel.friction,
                                               .dynamic_friction = 0.8 * feel.friction,
                                               .damping = feel.damping,
                                               .shading = feel.shading});
    contact_ = felt.contact;
    last_stylus_ = stylus;
    // Nobody holds a stylus on rails: no force moves it, and none can hurt.
    if (!device_ && settings_.device == DeviceKind::none) return {felt.asked};
    return felt.force;
}

/// Digs and heaps where the hand presses, as much as it presses.
void Haptics::paint(bool presses) noexcept {
    SampleRange changed;
    const bool wants = told_.brush.kind != BrushKind::none && contact_.touching() && presses;
    if (wants && !painting_) ground_->begin_stroke();
    painting_ = wants;
    if (wants) {
        const double scale = workspace_.frame().scale;
        const double sign = told_.brush.kind == BrushKind::dig ? -1 : 1;
        unpainted_ += sign * told_.brush.rate * scale * glm::length(newtons_) * period();
        const double least = std::max(ground_->smallest_change(), 0.02e-3 * scale);
        if (!spot_is_open_ && std::abs(unpainted_) >= least) {
            spot_ = {{contact_.proxy.x, contact_.proxy.y},
                     std::min(told_.brush.radius * scale, ground_->largest_radius()),
                     std::exchange(unpainted_, 0.0)};
            spot_row_ = 0;
            spot_is_open_ = true;
        }
    }
    if (spot_is_open_) spot_is_open_ = !ground_->paint(spot_, spot_row_, changed);
    if (told_.undos != before_.undos && !spot_is_open_) {
        if (ground_->undo(changed)) ++before_.undos;
    }
    if (!changed.empty()) {
        ++state_.edit;
        state_.edited = united(state_.edited, changed);
    }
    state_.undoable = ground_->undoable_strokes();
}

void Haptics::publish(const glm::dvec3& hand, const glm::dvec3& stylus,
                      const hfh::GuardedForce& felt) noexcept {
    state_.time = static_cast<double>(updates_) * period();
    state_.updates = updates_;
    state_.wanted = wanted_;
    state_.hand = hand;
    state_.stylus = stylus;
    state_.status = contact_.status;
    state_.trip = felt.trip;
    state_.force = felt.newtons;
    state_.normal = contact_.touching() ? contact_.normal : ground_normal({stylus.x, stylus.y});
    state_.has_touched = state_.has_touched || contact_.touching();
    const double height = ground_->height({stylus.x, stylus.y});
    state_.over_ground = !std::isnan(height);
    state_.proxy = contact_.touching()  ? contact_.proxy
                   : state_.over_ground ? glm::dvec3{stylus.x, stylus.y, height}
                                        : stylus;
    state_.scale = workspace_.frame().scale;
    state_.offset = workspace_.frame().offset;
    state_.level = ground_->level();
    shown_.put(state_);
    if (updates_ == 0) return;
    rows_.put({.t = state_.time - period(),
               .stylus = stylus,
               .contact = contact_.touching(),
               .proxy = contact_.proxy,
               .normal = contact_.normal,
               .force = felt.newtons,
               .patches = contact_.patches,
               .status = to_string(contact_.status),
               .guard = demo::what_acted(felt)});
}

} // namespace viewer
