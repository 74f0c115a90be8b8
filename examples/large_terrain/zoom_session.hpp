#ifndef LARGE_TERRAIN_ZOOM_SESSION_HPP
#define LARGE_TERRAIN_ZOOM_SESSION_HPP

#include "level_residency.hpp"
#include "real_time_loop.hpp"

#include <hfh/contact/level_change.hpp>
#include <hfh/device/workspace.hpp>
#include <hfh/terrain/blended_field.hpp>

#include <glm/common.hpp>

#include <cmath>
#include <numbers>

// The real-time loop of a hand that zooms while it touches, and what the clock and the kernel say.

namespace large_terrain {

struct ZoomSession {
    glm::dvec2 spacing{1.0}; ///< metres
    int coarsest = 10;       ///< from here to level 0 and back: 1024 times
    int trips = 5;           ///< in and out, each to another place
    double seconds = 4;      ///< a trip
    bool paced = true;       ///< by the clock; else as fast as it goes
};

struct ZoomReport : SessionReport {
    LevelWaits waits;
    std::uint64_t lost = 0; ///< contacts that ended
};

/// Where the hand of a zoom session is over: the middle of the terrain at first.
[[nodiscard]] inline glm::dvec2 zoom_start(hfh::Index columns, hfh::Index rows,
                                           const glm::dvec2& spacing) noexcept {
    return 0.5 * spacing * glm::dvec2{static_cast<double>(columns - 1), static_cast<double>(rows - 1)};
}

/// A hand that presses with 1 N and goes round in a circle of 8 mm, or as wide as there is ground, once in 0.83 s. While
/// the terrain is small in the hand it goes to the place of the next trip as well.
///
/// The terrain's scale is as the trip says: a cell of the level wanted is half a millimetre wide in the hand.
template <class Heights>
class ZoomingHand {
public:
    ZoomingHand(const Heights& heights, const ZoomSession& session) noexcept
        : session_{session}, field_{hfh::StridedLevels{heights}, {.spacing = session.spacing}},
          size_{2.0 * zoom_start(heights.columns(), heights.rows(), session.spacing)} {
        level_ = field_.set_level(session.coarsest);
        const glm::dvec2 at = zoom_start(heights.columns(), heights.rows(), session.spacing);
        workspace_ = hfh::Workspace<double>{
            {.scale = scale_of(level_),
             .offset = {at, hfh::detail::height_over(field_, at.x, at.y).value_or(0.0)}}};
    }
    ZoomingHand(const ZoomingHand&) = delete; // the tracker refers to the field

    /// One update. `level_for(stylus, proxy, wanted)` says which level it is.
    template <class LevelFor>
    void update(LevelFor&& level_for) noexcept {
        const double trip = static_cast<double>(tick_++) / (1000 * session_.seconds);
        const double wanted = session_.coarsest * std::abs(1 - 2 * std::fmod(trip, 1.0));
        const glm::dvec3 before = workspace_.to_terrain(hand_);
        const glm::dvec3 touched = contact_.touching() ? glm::dvec3{contact_.proxy} : before;
        level_ = level_for(cell_at(before), cell_at(touched), wanted);

        const double rise = hfh::change_level(field_, level_, tracker_);
        (void)workspace_.move({0, 0, rise});
        (void)workspace_.zoom(scale_of(wanted), touched + glm::dvec3{0, 0, rise});
        move_hand(wanted, std::floor(trip));
        contact_ = tracker_.update(workspace_.update(hand_));
        const hfh::ForceEvaluator<double> spring{.stiffness = workspace_.terrain_stiffness(stiffness),
                                                 .max_force = workspace_.terrain_force(3.3)};
        newtons_ = workspace_.force_at_hand(spring(contact_).newtons);
    }

    [[nodiscard]] const hfh::Contact<double>& contact() const noexcept { return contact_; }
    [[nodiscard]] const glm::dvec3& newtons() const noexcept { return newtons_; } ///< at the hand
    [[nodiscard]] double level() const noexcept { return level_; }

private:
    static constexpr double stiffness = 500, press = 0.002;                     // N/m and m at the hand: 1 N
    static constexpr double radius = 0.004, turn = 2 * std::numbers::pi / 0.83; // m and 1/s
    static constexpr double fastest = 0.05; // m/s at the hand, to the place of a trip

    [[nodiscard]] double scale_of(double level) const noexcept {
        return std::exp2(level) * std::sqrt(session_.spacing.x * session_.spacing.y) / 0.5e-3;
    }
    [[nodiscard]] hfh::Cell cell_at(const glm::dvec3& at) const noexcept {
        return {static_cast<hfh::Index>(std::floor(at.x / session_.spacing.x)),
                static_cast<hfh::Index>(std::floor(at.y / session_.spacing.y))};
    }

    void move_hand(double wanted, double trip) noexcept {
        const double angle = turn * static_cast<double>(tick_) / 1000;
        const glm::dvec2 here{workspace_.to_terrain(hand_)}, to_rims = glm::min(here, size_ - here);
        const double room = 0.5 * std::max(0.0, std::min(to_rims.x, to_rims.y)) / workspace_.frame().scale;
        glm::dvec2 velocity = std::min(radius, room) * turn * glm::dvec2{-std::sin(angle), std::cos(angle)};
        if (wanted > session_.coarsest - 2) {
            // Somewhere else every time, in the inner 60 %.
            const glm::dvec2 share{std::fmod(0.5 + 0.6180 * trip, 1.0), std::fmod(0.5 + 0.7549 * trip, 1.0)};
            const glm::dvec3 there{size_ * (0.2 + 0.6 * share), 0};
            const glm::dvec2 way = glm::dvec2{workspace_.to_hand(there)} - glm::dvec2{hand_};
            velocity += way * std::min(10.0, fastest / std::max(glm::length(way), 1e-9));
        }
        hand_ += glm::dvec3{velocity / 1000.0, 0};
        const glm::dvec3 over = workspace_.to_terrain(hand_);
        const auto ground = hfh::detail::height_over(field_, over.x, over.y);
        // A stylus that is below the ground and not in contact has to come down from outside.
        const bool lift = tick_ == 1 || contact_.status == hfh::ContactStatus::buried;
        if (ground) hand_.z = workspace_.to_hand({over.x, over.y, *ground}).z + (lift ? 2 * press : -press);
    }

    ZoomSession session_;
    hfh::BlendedField<double, hfh::StridedLevels<Heights>> field_;
    glm::dvec2 size_;
    hfh::ProxyTracker<hfh::BlendedField<double, hfh::StridedLevels<Heights>>> tracker_{field_};
    hfh::Workspace<double> workspace_{{}};
    double level_ = 0;
    std::uint64_t tick_ = 0;
    glm::dvec3 hand_{0, 0, press};
    hfh::Contact<double> contact_;
    glm::dvec3 newtons_{0.0};
};

/// Runs a session in the calling thread. `helper` may be null: then the level is always the one wanted.
template <class Heights>
[[nodiscard]] ZoomReport run_zoom_session(ZoomingHand<Heights>& hand, const ZoomSession& session,
                                          LevelResidency* helper) {
    ZoomReport report;
    bool touched = false;
    const auto updates = static_cast<std::uint64_t>(session.trips * session.seconds * 1000);
    const auto update = [&] {
        hand.update([&](hfh::Cell stylus, hfh::Cell proxy, double wanted) {
            return helper != nullptr ? helper->level_for(stylus, proxy, wanted) : wanted;
        });
    };
    run_updates(report, updates, session.paced, update, [&] {
        const bool touches = hand.contact().touching();
        report.in_contact += touches;
        report.lost += touched && !touches;
        touched = touches;
        for (int k = 0; k < 3; ++k) {
            detail::digest(report.answers, hand.contact().proxy[k]);
            detail::digest(report.answers, hand.newtons()[k]);
        }
    });
    if (helper != nullptr) report.waits = helper->waits();
    return report;
}

} // namespace large_terrain

#endif // LARGE_TERRAIN_ZOOM_SESSION_HPP
