#include "hand.hpp"
#include "report.hpp"

#include <limits>

// By how much the force changes from one update to the next, against k·|Δhand|.

namespace closed_loop {
namespace {

constexpr double stiffness = 500;  // N/m
constexpr double unlimited = 1e30; // N

struct Ratios {
    std::vector<double> all;
    [[nodiscard]] double mean() const {
        double sum = 0;
        for (const double ratio : all) sum += ratio;
        return all.empty() ? 0 : sum / static_cast<double>(all.size());
    }
    /// Sorts.
    [[nodiscard]] double quantile(double share) {
        if (all.empty()) return 0;
        std::sort(all.begin(), all.end());
        return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
    }
};

/// Forces along a path, of which only updates count that are in contact or were so before. A stylus that has got below
/// the surface through a hole is put on from above again.
template <Real T>
class Steps {
public:
    Steps(Touching<T>& touching, Ratios& ratios) : touching_{touching}, ratios_{ratios} {}

    /// The hand has made `step` metres since the last call; `counts`: not while it settles into its path.
    [[nodiscard]] glm::dvec3 update(const glm::dvec3& position, double step, bool counts) {
        const bool was_touching = touching_.touching();
        glm::dvec3 newtons = touching_.update(position);
        if (counts && (touching_.touching() || was_touching))
            ratios_.all.push_back(glm::length(newtons - force_) / (stiffness * step));
        if (!touching_.touching()) {
            touching_.reset();
            (void)touching_.update(position + glm::dvec3{0, 0, 1});
            newtons = touching_.update(position);
        }
        force_ = newtons;
        return newtons;
    }

private:
    Touching<T>& touching_;
    Ratios& ratios_;
    glm::dvec3 force_{0.0};
};

[[nodiscard]] double step_to(const Path& path, std::size_t k) {
    return k > 0 ? glm::length(path[k] - path[k - 1]) : 0.0;
}

/// A hand that nothing moves from its path.
template <Real T>
void rigid(Touching<T>& touching, const Path& path, Ratios& ratios) {
    touching.reset();
    Steps<T> steps{touching, ratios};
    for (std::size_t k = 0; k < path.size(); ++k) (void)steps.update(path[k], step_to(path, k), k > 0);
}

/// A hand on the Touch; its path, not the device's, counts as its motion.
template <Real T>
void in_hand(Touching<T>& touching, const Path& path, Ratios& ratios) {
    touching.reset();
    Steps<T> steps{touching, ratios};
    hfh::SimulatedDevice device{hfh::simulated_touch, {}, Along{&path}, 60};
    auto sample = device.sample();
    for (std::size_t k = 0; k < path.size(); ++k)
        sample = device.step(steps.update(sample.position, step_to(path, k), k > 100));
}

/// How a hand moves, and over what.
struct Kind {
    const char* name;
    double cell, depth; // m, cells
    bool in_hand;
    hfh::TrackerOptions options{};
    Feel feel{};
};

/// All ways over one ground, at `cells` an update.
template <Real T>
Ratios on_ground(const hfh::test::Terrain<T>& terrain, const Kind& kind, double cells, int paths,
                 Findings& findings) {
    Site<T> site{terrain, 14};
    Touching<T> touching{terrain, stiffness,
                         kind.in_hand ? hfh::simulated_touch.capabilities.max_force : unlimited, kind.options,
                         kind.feel};
    Ratios ratios;
    for (int n = paths; n > 0; --n) {
        const auto path = site.wander(kind.depth * kind.cell, cells * kind.cell, kind.cell, 500);
        if (kind.in_hand)
            in_hand(touching, path, ratios);
        else
            rigid(touching, path, ratios);
    }
    const bool glides = kind.options.max_contact_patches < hfh::TrackerOptions{}.max_contact_patches;
    (glides ? findings.gliding : findings.lag).add(touching);
    return ratios;
}

/// Friction and shading, each and together. The goal is for both, on ground on which the force without either is steady
/// enough: not on the Kinect's depth image, with its cliffs.
template <Real T>
void friction_and_shading(const Effort& effort, Findings& findings) {
    const auto all = grounds<T>(1e-3);
    for (const auto& [what, feel] :
         {std::pair{"without either", Feel{}},
          {"with friction", Feel{.friction = true}},
          {"with shading", Feel{.shading = true}},
          {"with friction and shading", Feel{.friction = true, .shading = true}}}) {
        const Kind kind{what, 1e-3, 5, false, {}, feel};
        double most = 0, on_cliffs = 0;
        std::string where;
        Findings::Detail detail{
            text("ΔF/(k·Δhand) at 0.5 cells an update, 5 cells deep, %s: mean, 99 %%, largest", what), {}};
        for (const auto& ground : all) {
            auto ratios = on_ground(ground.terrain, kind, 0.5, effort.counted(40, 10), findings);
            const double mean = ratios.mean(), at_99 = ratios.quantile(0.99), top = ratios.quantile(1);
            detail.by_ground.push_back(text("%.2f, %.1f, %.0f", mean, at_99, top));
            if (ground.name == "kinect_boxes")
                on_cliffs = mean;
            else if (mean > most)
                most = mean, where = ground.name;
        }
        findings.details.push_back(detail);
        const bool has_goal = feel.friction && feel.shading;
        findings.rows.push_back(
            {text("force steps ΔF/(k·Δhand) at 0.5 cells an update, 5 cells deep, %s: mean", what),
             has_goal ? "≤ 1.0" : "",
             text("%.2f (%s); kinect_boxes, a depth image with cliffs: %.2f", most, where.c_str(), on_cliffs),
             has_goal ? verdict(most <= 1) : Verdict::none});
    }
}

/// A proxy that a ridge lets go glides at half a millimetre of hand an update. Here steps count only while contact lasts: at
/// the rim of a hole the proxy has nowhere to glide. A hand that rests anywhere on the way waits until the proxy has arrived.
template <Real T>
void release_at_a_speed(const Effort& effort, Findings& findings) {
    constexpr double cell = 0.2e-3, deep = 15 * cell, speed = 0.5e-3;
    for (const double release_speed : {std::numeric_limits<double>::infinity(), speed}) {
        const bool glides = release_speed == speed;
        const std::string what = glides ? "glides 0.5 mm an update" : "does not glide";
        double most_99 = 0, largest = 0, largest_in_alps = 0, in_alps = 0;
        long contacts = 0, under_way = 0, without_force = 0, contacts_in_alps = 0, under_way_in_alps = 0;
        int longest_rest = 0;
        Findings::Detail detail{text("ΔF/(k·Δhand) in contact, in the hand on the Touch, 15 cells deep, 0.5 "
                                     "cells an update, proxy %s: "
                                     "mean, 99 %%, largest",
                                     what.c_str()),
                                {}};
        for (const auto& ground : grounds<T>(cell)) {
            Site<T> site{ground.terrain, 14};
            Touching<T> touching{ground.terrain,
                                 stiffness,
                                 hfh::simulated_touch.capabilities.max_force,
                                 {},
                                 {.release_speed = release_speed}};
            Ratios ratios;
            long on_the_way = 0, updates = 0;
            for (int n = effort.counted(40, 4); n > 0; --n) {
                const auto path = site.wander(deep, 0.5 * cell, cell, 500);
                touching.reset();
                hfh::SimulatedDevice device{hfh::simulated_touch, {}, Along{&path}, 60};
                auto sample = device.sample();
                glm::dvec3 before{0.0};
                for (std::size_t k = 0; k < path.size(); ++k) {
                    const bool was_touching = touching.touching();
                    glm::dvec3 newtons = touching.update(sample.position);
                    if (k > 100 && touching.touching() && was_touching)
                        ratios.all.push_back(glm::length(newtons - before) / (stiffness * step_to(path, k)));
                    updates += touching.touching();
                    on_the_way += touching.is_under_way();
                    longest_rest = std::max(longest_rest, touching.updates_to_arrive(sample.position));
                    if (!touching.touching()) {
                        touching.reset();
                        (void)touching.update(sample.position + glm::dvec3{0, 0, 1});
                        newtons = touching.update(sample.position);
                    }
                    before = newtons;
                    sample = device.step(newtons);
                }
            }
            const double at_99 = ratios.quantile(0.99), top = ratios.quantile(1);
            detail.by_ground.push_back(text("%.2f, %.1f, %.0f", ratios.mean(), at_99, top));
            most_99 = std::max(most_99, at_99), largest = std::max(largest, top);
            contacts += updates, under_way += on_the_way, without_force += touching.without_force();
            if (ground.name == "swissalps_voids") {
                in_alps = at_99, largest_in_alps = top;
                contacts_in_alps = updates, under_way_in_alps = on_the_way;
            }
        }
        findings.details.push_back(detail);
        const auto goal = [glides](const char* text) { return std::string{glides ? text : ""}; };
        const auto judged = [glides](bool met) { return glides ? verdict(met) : Verdict::none; };
        const auto share = [](long part, long all) {
            return part > 0 ? text("one in %.0f", static_cast<double>(all) / static_cast<double>(part))
                            : "none";
        };
        findings.rows.push_back(
            {text("force steps ΔF/(k·Δhand) in contact, in the hand on the Touch, 15 cells deep in the Alps, "
                  "proxy %s: "
                  "99 %%, largest",
                  what.c_str()),
             goal("< 5, < 20"),
             text("%.1f, %.0f; on all ground %.1f, %.0f", in_alps, largest_in_alps, most_99, largest),
             judged(in_alps < 5 && largest_in_alps < 20)});
        if (!glides) continue;
        findings.rows.push_back(
            {"… updates in contact with the proxy under way, in the Alps", "≤ 1 in 30",
             share(under_way_in_alps, contacts_in_alps) + "; on all ground " + share(under_way, contacts),
             verdict(30 * under_way_in_alps <= contacts_in_alps)});
        findings.rows.push_back({"… updates in contact without a force", "0",
                                 text("%ld of %ld", without_force, contacts), verdict(without_force == 0)});
        findings.rows.push_back({"… the hand rests: the proxy has arrived after", "≤ 50 ms",
                                 text("%d ms", longest_rest), verdict(longest_rest <= 50)});
    }
}

} // namespace

template <Real T>
void steps(const Effort& effort, Findings& findings) {
    // The Touch goes 5 cells an update at 1 m/s.
    for (const Kind kind : {Kind{"half a cell deep", 1e-3, 0.5, false}, Kind{"3 cells deep", 1e-3, 3, false},
                            Kind{"in the hand on the Touch", 0.2e-3, 15, true},
                            Kind{"in the hand on the Touch, `max_contact_patches` = 8",
                                 0.2e-3,
                                 15,
                                 true,
                                 {.max_contact_patches = 8}}}) {
        const auto all = grounds<T>(kind.cell);
        for (const double cells : {0.5, 2.0, 5.0}) {
            double mean = 0, most_99 = 0, largest = 0;
            std::string where;
            Findings::Detail detail{
                text("ΔF/(k·Δhand) at %g cells an update, %s: mean, 99 %%, largest", cells, kind.name), {}};
            for (const auto& ground : all) {
                auto ratios = on_ground(ground.terrain, kind, cells, effort.counted(40), findings);
                const double here = ratios.mean(), at_99 = ratios.quantile(0.99), top = ratios.quantile(1);
                detail.by_ground.push_back(text("%.2f, %.1f, %.0f", here, at_99, top));
                if (here > mean) mean = here, where = ground.name;
                most_99 = std::max(most_99, at_99);
                largest = std::max(largest, top);
            }
            findings.details.push_back(detail);
            findings.rows.push_back(
                {text("force steps ΔF/(k·Δhand) at %g cells an update, %s: mean, 99 %%, largest", cells,
                      kind.name),
                 "≤ 1.0, < 9, < 126",
                 text("%.2f, %.1f, %.0f (mean: %s)", mean, most_99, largest, where.c_str()),
                 mean <= 1 && most_99 < 9 && largest < 126 ? Verdict::met
                 : kind.in_hand                            ? Verdict::known
                                                           : Verdict::not_met});
        }
    }
    friction_and_shading<T>(effort, findings);
    release_at_a_speed<T>(effort, findings);
}

template void steps<float>(const Effort&, Findings&);
template void steps<double>(const Effort&, Findings&);

} // namespace closed_loop
