#include "catch.hpp"

#include "drawn_field.hpp"
#include "stage.hpp"

#include <hfh/traversal/first_hit.hpp>

#include <glm/geometric.hpp>

#include <array>
#include <limits>
#include <random>

// What is seen is compared with what is known: pixels with rays that are cast onto the levels and the α which are drawn.

using namespace viewer_tests;

namespace {

/// A ray onto what should be drawn.
struct Answer {
    bool hits = false;
    double distance = 0;  ///< m of terrain from the eye
    double tolerance = 0; ///< m along the ray
};

/// A picture that was drawn, and what it should show.
class Picture {
public:
    explicit Picture(Stage& stage)
        : size_{stage.target.size()}, camera_{stage.shown.view().camera}, scale_{stage.shown.view().scale},
          offset_{stage.shown.view().offset}, field_{stage.shown, stage.touched.displayed},
          depths_{viewer::read_depths(size_)} {}

    [[nodiscard]] const glm::ivec2& size() const noexcept { return size_; }
    [[nodiscard]] const DrawnField& field() const noexcept { return field_; }

    [[nodiscard]] float depth(int x, int y) const {
        return depths_[static_cast<std::size_t>((size_.y - 1 - y) * size_.x + x)];
    }
    [[nodiscard]] bool is_ground(int x, int y) const { return depth(x, y) < 1; }

    /// Where pixel (x, y), from the top left, was drawn: metres of terrain from the eye.
    [[nodiscard]] double drawn_distance(int x, int y) const {
        const glm::dvec2 at{2 * (x + 0.5) / size_.x - 1, 1 - 2 * (y + 0.5) / size_.y};
        const glm::dvec4 point =
            glm::inverse(camera_.matrix(size_)) * glm::dvec4{at, 2 * static_cast<double>(depth(x, y)) - 1, 1};
        return scale_ * glm::length(glm::dvec3{point} / point.w - eye());
    }
    /// What the ray through a place of the picture should meet.
    [[nodiscard]] Answer cast(double x, double y) const {
        const viewer::PointerRay ray = camera_.ray({x, y}, size_);
        const glm::dvec3 from = offset_ + scale_ * eye();
        const glm::dvec3 to = from + 30 * scale_ * glm::normalize(ray.direction);
        const auto hit = hfh::first_hit(field_, from, to);
        if (hit.status != hfh::HitStatus::hit) return {};
        const auto cell = field_.drawn_cell(hit.point.cell);
        const glm::dvec3 along = glm::normalize(to - from);
        const auto patch = field_.patch(hit.point.cell);
        const glm::dvec3 normal =
            glm::normalize(glm::dvec3{-patch->slope_u(hit.point.v) / patch->spacing.x,
                                      -patch->slope_v(hit.point.u) / patch->spacing.y, 1});
        const double distance = hit.t * glm::length(to - from);
        // A quarter of the twist is how far two triangles are off the patch. A pixel is as wide as the eye sees it from there.
        const double twist = std::abs(cell->p11 - cell->p10 - cell->p01 + cell->p00);
        const double pixel = 2 * std::tan(viewer::Camera::field_of_view / 2) / size_.y * distance;
        const double rounding = 1e-6 * distance * distance / (scale_ * camera_.near());
        const double tolerance =
            (twist / 4 * normal.z + pixel) / std::max(1e-6, std::abs(glm::dot(along, normal))) + rounding;
        return {true, distance, tolerance};
    }
    /// The point that was drawn at a pixel, in the terrain.
    [[nodiscard]] glm::dvec3 drawn_point(int x, int y) const {
        const viewer::PointerRay ray = camera_.ray({x + 0.5, y + 0.5}, size_);
        return offset_ + scale_ * eye() + drawn_distance(x, y) * glm::normalize(ray.direction);
    }
    /// Whether what was drawn at a pixel is what the ray through it meets, or one a pixel beside it: at an outline they
    /// differ.
    [[nodiscard]] bool is_right(int x, int y) const {
        constexpr std::array<glm::dvec2, 5> beside{{{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
        for (const glm::dvec2& step : beside) {
            const Answer answer = cast(x + 0.5 + step.x, y + 0.5 + step.y);
            if (answer.hits != is_ground(x, y)) continue;
            if (!answer.hits || std::abs(drawn_distance(x, y) - answer.distance) <= answer.tolerance)
                return true;
        }
        return false;
    }

private:
    /// As the matrix has it, where heights are exaggerated: the point that all rays come from.
    [[nodiscard]] glm::dvec3 eye() const {
        glm::dvec3 eye = camera_.eye();
        eye.z = camera_.target.z + (eye.z - camera_.target.z) / camera_.exaggeration;
        return eye;
    }

    glm::ivec2 size_;
    viewer::Camera camera_;
    double scale_;
    glm::dvec3 offset_;
    DrawnField field_;
    std::vector<float> depths_;
};

/// Compares `count` pixels that show ground, and says where and how far the first one is off.
void check_pixels(Stage& stage, int count) {
    const Picture picture{stage};
    std::mt19937 random{7};
    std::uniform_int_distribution<int> column{0, picture.size().x - 1}, row{0, picture.size().y - 1};
    int ground = 0, wrong = 0;
    for (int tries = 0; ground < count && tries < 20 * count; ++tries) {
        const int x = column(random), y = row(random);
        if (!picture.is_ground(x, y)) continue;
        ++ground;
        if (picture.is_right(x, y)) continue;
        if (wrong++ == 0) {
            const Answer answer = picture.cast(x + 0.5, y + 0.5);
            UNSCOPED_INFO("pixel " << x << ", " << y << ": drawn at " << picture.drawn_distance(x, y)
                                   << " m, known at " << answer.distance << " m, tolerance "
                                   << answer.tolerance << ", hits " << answer.hits);
        }
    }
    CHECK(ground == count);
    CHECK(wrong == 0);
}

/// No pixel shows the background where ground is known to be.
void check_no_gaps(Stage& stage) {
    const Picture picture{stage};
    int gaps = 0;
    for (int y = 1; y + 1 < picture.size().y; ++y) {
        for (int x = 1; x + 1 < picture.size().x; ++x)
            if (!picture.is_ground(x, y)) gaps += !picture.is_right(x, y);
    }
    CHECK(gaps == 0);
}

/// Where ground is drawn it is felt: there is ground at the hand's level, a pixel to the inside.
void check_all_felt(Stage& stage) {
    const Picture picture{stage};
    const glm::dvec2 middle{stage.touched.displayed.spacing *
                            glm::dvec2{stage.touched.displayed.columns, stage.touched.displayed.rows} / 2.0};
    const double pixel = 1.5 * stage.shown.camera().pixel_size(picture.size()) * stage.shown.view().scale;
    int nowhere = 0;
    for (int y = 0; y < picture.size().y; ++y) {
        for (int x = 0; x < picture.size().x; ++x) {
            if (!picture.is_ground(x, y)) continue;
            const glm::dvec2 at{picture.drawn_point(x, y)}, inside = glm::clamp(middle - at, -pixel, pixel);
            nowhere += std::isnan(stage.touched.ground->height(at + inside));
        }
    }
    CHECK(nowhere == 0);
}

/// The markers are not ground: they are left out of the picture while depths are compared.
void look(Stage& stage, const FrameInput& input) {
    stage.shown.hide_markers();
    (void)stage.frames(4, input); // the level comes by then
}

} // namespace

TEST_CASE("a thousand pixels are where a ray meets the levels that are drawn", "[pixels]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{bundled_terrain(), bundled_frame, {480, 270}};
    SECTION("the whole terrain") { look(stage, stage.pointing(0.5, 0.5)); }
    SECTION("from far away, at a coarse level by hand") {
        stage.shown.settings().level = {.by_scale = false, .level = 1.37};
        look(stage, stage.pointing(0.3, 0.6));
    }
    SECTION("near, from low, with heights exaggerated") {
        stage.shown.camera().elevation = 0.3;
        stage.shown.settings().exaggeration = 1.8;
        FrameInput zoom = stage.pointing(0.55, 0.5);
        zoom.zoom = 0.1;
        (void)stage.frames(25, zoom);
        look(stage, stage.pointing(0.55, 0.5));
    }
    check_pixels(stage, 1000);
    check_no_gaps(stage);
}

TEST_CASE("windows of a large terrain join without gaps at any level and place", "[pixels]") {
    const auto context = context_or_skip();
    if (!context) return;
    Stage stage{made_terrain(1025, 1025, hills), {.spacing = {10, 10}}, {240, 160}};
    for (const double level : {0.0, 0.5, 1.25, 2.9}) {
        stage.shown.settings().level = {.by_scale = false, .level = level};
        stage.shown.camera().elevation = level == 0.5 ? 0.35 : 1.5;
        look(stage, stage.pointing(0.3 + 0.1 * level, 0.7 - 0.15 * level));
        INFO("level " << level);
        check_no_gaps(stage);
        check_pixels(stage, 150);
    }
}

TEST_CASE("the far rims are drawn where they are felt, at levels that do not fit the terrain", "[pixels]") {
    const auto context = context_or_skip();
    if (!context) return;
    // The hand is near the far corner, or far from it.
    for (const hfh::Index columns : {194, 199}) {
        Stage stage{made_terrain(columns, columns - 5, hills), {.spacing = {10, 10}}, {240, 160}};
        for (const double level : {0.6, 1.5, 2.8, 3.0, 3.9}) {
            stage.shown.settings().level = {.by_scale = false, .level = level};
            const double at = columns == 199 ? 0.4 : 0.7;
            look(stage, stage.pointing(at, 1 - at));
            INFO(columns << " columns, level " << level);
            REQUIRE(stage.shown.view().level == level);
            check_pixels(stage, 300);
            check_no_gaps(stage);
            check_all_felt(stage);
        }
    }
}

TEST_CASE("holes are holes", "[pixels]") {
    const auto context = context_or_skip();
    if (!context) return;
    const auto with_holes = [](double i, double j) {
        const bool hole =
            std::hypot(i - 40, j - 44) < 6 || (i == 70 && j == 64) || (i > 80 && i < 92 && j > 20 && j < 24);
        return hole ? std::numeric_limits<double>::quiet_NaN() : hills(i, j);
    };
    Stage stage{made_terrain(129, 129, with_holes), {.spacing = {10, 10}}, {400, 300}};
    stage.shown.settings().level = {.by_scale = false, .level = 0};
    look(stage, stage.pointing(0.5, 0.5));
    check_pixels(stage, 500);
    check_no_gaps(stage);
    const viewer::HandState& hand = stage.hand();
    const glm::dvec3 middle =
        stage.shown.camera().pixel(hand.to_hand({400, 440, hills(40, 44)}), stage.target.size());
    CHECK_FALSE(Picture{stage}.is_ground(static_cast<int>(middle.x), static_cast<int>(middle.y)));
}
