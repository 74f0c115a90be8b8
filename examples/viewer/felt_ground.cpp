#include "felt_ground.hpp"

#include "edits.hpp"

#include <bad_input.hpp>

#include <hfh/contact/ball_level_change.hpp>
#include <hfh/hfh.hpp>
#include <hfh/loop/ball_tip.hpp>
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
        : field_{hfh::StridedLevels{heights}, frame},
          smallest_cell_{std::min(frame.spacing.x, frame.spacing.y)}, edits_{heights, frame} {
        if (field_.status() != hfh::GridStatus::ok)
            throw demo::BadInput{
                "The terrain makes no surface: its spacing or its height scale is out of range."};
    }

    void begin(const hfh::HapticLoopOptions& options) noexcept override { loop_ = Loop{field_, options}; }
    double set_tip(double radius) noexcept override {
        const double cell = smallest_cell_ * std::exp2(field_.level());
        loop_.tracker().set_radius(std::min(radius, 16 * cell));
        return loop_.tracker().radius();
    }
    void set_release_speed(double release_speed) noexcept override {
        loop_.set_release_speed(release_speed > 0 ? release_speed : std::numeric_limits<double>::max());
    }
    Felt update(const hfh::DeviceSample& sample, const hfh::Material& material) noexcept override {
        loop_.set_material(material);
        (void)loop_.update(sample);
        return {loop_.contact(), loop_.asked(), loop_.force()};
    }
    [[nodiscard]] hfh::Workspace<double>& workspace() noexcept override { return loop_.workspace(); }
    [[nodiscard]] hfh::ForceGuard& guard() noexcept override { return loop_.guard(); }
    void reset() noexcept override { loop_.reset(); }

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
        return hfh::change_level(field_, std::clamp(level, 0.0, coarsest_level()), loop_.tracker(),
                                 loop_.friction(), loop_.glide());
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

    using Loop = hfh::HapticLoop<Field, hfh::BallTip>;

    Field field_;
    double smallest_cell_ = 0; ///< m, of the finest level
    Loop loop_{field_};
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
