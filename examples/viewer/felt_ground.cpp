#include "felt_ground.hpp"

#include "edits.hpp"

#include <bad_input.hpp>

#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/level_change.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/hfh.hpp>
#include <hfh/terrain/blended_field.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace viewer {
namespace {

template <hfh::Sample S>
class GroundOf final : public FeltGround {
public:
    GroundOf(const demo::Heights<S>& heights, const hfh::GridFrame& frame)
        : field_{hfh::StridedLevels{heights}, frame}, edits_{heights, frame} {
        if (field_.status() != hfh::GridStatus::ok)
            throw demo::BadInput{
                "The terrain makes no surface: its spacing or its height scale is out of range."};
    }

    Felt update(const glm::dvec3& stylus, const glm::dvec3& velocity,
                const TerrainFeel& feel) noexcept override {
        Felt felt{tracker_.update(stylus), {}};
        if (feel.shading) felt.contact = hfh::shade_force(field_, felt.contact);
        if (feel.friction != friction_coefficient_) {
            friction_coefficient_ = feel.friction;
            friction_ = hfh::Friction<double>{{.at_rest = feel.friction, .sliding = 0.8 * feel.friction}};
        }
        if (feel.friction > 0) felt.contact = friction_.hold(field_, felt.contact, stylus);
        const hfh::ForceEvaluator<double> spring{.stiffness = feel.stiffness};
        const hfh::Damping<double> damping{.along_normal = feel.damping};
        felt.newtons = damping(spring, felt.contact, velocity).newtons;
        return felt;
    }
    void reset() noexcept override { tracker_.reset(); }

    [[nodiscard]] double height(const glm::dvec2& at) const noexcept override {
        constexpr double none = std::numeric_limits<double>::quiet_NaN();
        const hfh::CellRange cells = field_.cells();
        const double u = field_.lattice().u_of(at.x, 0), v = field_.lattice().v_of(at.y, 0);
        if (!(u >= 0 && v >= 0 && u <= static_cast<double>(cells.end.i) &&
              v <= static_cast<double>(cells.end.j)))
            return none;
        const hfh::Cell cell{std::min(static_cast<hfh::Index>(u), cells.end.i - 1),
                             std::min(static_cast<hfh::Index>(v), cells.end.j - 1)};
        const auto patch = field_.patch(cell);
        return patch ? patch->height(u - static_cast<double>(cell.i), v - static_cast<double>(cell.j)) : none;
    }

    [[nodiscard]] double level() const noexcept override { return field_.level(); }
    [[nodiscard]] double coarsest_level() const noexcept override {
        // Eight cells across are the fewest that look like a terrain.
        return std::max(0, field_.level_count() - 4);
    }
    double set_level(double level) noexcept override {
        return hfh::change_level(field_, std::clamp(level, 0.0, coarsest_level()), tracker_, friction_);
    }

    void begin_stroke() noexcept override { edits_.begin_stroke(); }
    bool paint(const Spot& spot, hfh::Index& row, SampleRange& changed) noexcept override {
        return edits_.paint(spot, row, changed);
    }
    bool undo(SampleRange& changed) noexcept override { return edits_.undo(changed); }
    [[nodiscard]] unsigned undoable_strokes() const noexcept override { return edits_.undoable_strokes(); }
    [[nodiscard]] double smallest_change() const noexcept override { return edits_.smallest_change(); }
    [[nodiscard]] double largest_radius() const noexcept override { return edits_.largest_radius(); }

private:
    using Field = hfh::BlendedField<double, hfh::StridedLevels<demo::Heights<S>>>;

    Field field_;
    hfh::ProxyTracker<Field> tracker_{field_, {.max_contact_patches = 8}};
    hfh::Friction<double> friction_{};
    double friction_coefficient_ = -1;
    Edits<S> edits_;
};

} // namespace

std::unique_ptr<FeltGround> make_felt_ground(const demo::Terrain& terrain, const hfh::GridFrame& frame) {
    return std::visit(
        [&]<class S>(const demo::Heights<S>& heights) -> std::unique_ptr<FeltGround> {
            return std::make_unique<GroundOf<S>>(heights, frame);
        },
        terrain.heights);
}

} // namespace viewer
