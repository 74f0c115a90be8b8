// A depth camera's picture, felt while it is replaced 30 times a second.
//
// *From a pinhole to a grid.* A camera's depth image is no orthographic height field: its rays spread, so pixels are not
// evenly spaced on what they see, and a vertical wall has pixels on it. So every pixel is put where it was seen,
//
//     x = (u − cu)·d/f,   y = (cv − v)·d/f,   z = −d          (camera looks along −z, d: depth along that axis)
//
// into the vertex of an orthographic grid that is nearest to it, and the one nearest to the camera counts where two meet. The
// grid's spacing is that of the pixels at the farthest depth of interest, d/f, or larger. Vertices that nothing fell on, and
// what lies in the shadow of something nearer, are holes; `BridgedField` spans the narrow ones.
//
// *From picture to picture.* If the heights were exchanged at once, every new picture would kick the hand. The field below
// blends from the last picture to the next in the time that a picture takes, as levels of detail are blended (Losasso and Hoppe,
// Geometry Clipmaps, 2004). It is bilinear at every α, and the last picture is always whole when the next one comes.
//
// Here a hand rests on a bump that a camera sees rise and fall by 20 mm/s. Ends with 0 if contact is kept and the blend steps
// the force by less than a tenth of what exchanging does.

#include <hfh/hfh.hpp>
#include <hfh/terrain/bridged_field.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

namespace {

constexpr float hole = std::numeric_limits<float>::quiet_NaN();

struct Camera {
    int width = 320, height = 240;
    double focal = 280, cu = 159.5, cv = 119.5; // pixels
};

/// A square grid in the camera's frame, as wide as the camera sees at depth `far` (m).
struct OrthoGrid {
    hfh::Index columns, rows;
    hfh::GridFrame frame;

    OrthoGrid(const Camera& camera, double far) {
        const double spacing = far / camera.focal;
        columns = camera.width, rows = camera.height;
        frame = {.origin = {-camera.cu * spacing, -camera.cv * spacing}, .spacing = {spacing, spacing}};
    }
};

/// Depths in metres, 0 where the camera saw nothing, to heights on the grid. By the camera's thread.
void project(const Camera& camera, const std::vector<float>& depths, const OrthoGrid& grid,
             std::vector<float>& heights) {
    std::fill(heights.begin(), heights.end(), hole);
    for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
            const float d = depths[static_cast<std::size_t>(u + v * camera.width)];
            if (!(d > 0)) continue;
            const double x = (u - camera.cu) * static_cast<double>(d) / camera.focal,
                         y = (camera.cv - v) * static_cast<double>(d) / camera.focal;
            const auto i = std::lround((x - grid.frame.origin.x) / grid.frame.spacing.x);
            const auto j = std::lround((y - grid.frame.origin.y) / grid.frame.spacing.y);
            if (i < 0 || j < 0 || i >= grid.columns || j >= grid.rows) continue;
            float& height = heights[static_cast<std::size_t>(i + j * grid.columns)];
            if (std::isnan(height) || -d > height) height = -d;
        }
    }
}

using Picture = hfh::BilinearGrid<double, hfh::HeightView<float>>;

/// Between two pictures, vertex by vertex. Each is bridged by itself first: specks are elsewhere in every picture, and a
/// vertex that were blended from one picture alone would jump at the next.
class BlendedPictures {
public:
    using Scalar = double;

    BlendedPictures(const Picture& one, const Picture& other) noexcept : pictures_{&one, &other} {}

    /// Between two updates: α goes from the last picture (0) to the next (1).
    void set_alpha(double alpha) noexcept { alpha_ = alpha; }
    /// The next picture becomes the last one. Returns the number of the one that is free for a new picture.
    std::size_t exchange() noexcept {
        last_ = 1 - last_;
        return 1 - last_;
    }

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return pictures_[0]->lattice(); }
    [[nodiscard]] hfh::CellRange cells() const noexcept { return pictures_[0]->cells(); }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        if (!cells().contains(c)) return std::nullopt;
        const auto z00 = height({c.i, c.j}), z10 = height({c.i + 1, c.j});
        const auto z01 = height({c.i, c.j + 1}), z11 = height({c.i + 1, c.j + 1});
        if (!z00 || !z10 || !z01 || !z11) return std::nullopt;
        return hfh::BilinearPatch<double>{*z00, *z10, *z01, *z11, lattice().spacing()};
    }

private:
    static constexpr hfh::Index widest_hole = 6; // cells

    [[nodiscard]] std::optional<double> height(hfh::Vertex v) const noexcept {
        const auto last = hfh::BridgedField{*pictures_[last_], widest_hole}.height(v);
        const auto next = hfh::BridgedField{*pictures_[1 - last_], widest_hole}.height(v);
        if (!last || !next) return last ? last : next;
        return *last + alpha_ * (*next - *last);
    }

    const Picture* pictures_[2];
    std::size_t last_ = 0;
    double alpha_ = 1;
};
static_assert(hfh::HeightField<BlendedPictures>);

/// What the camera sees at `time` (s): a table 0.8 m away with a round bump that rises and falls.
void look(const Camera& camera, double time, std::vector<float>& depths) {
    for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
            const double x = (u - camera.cu) * 0.8 / camera.focal, y = (camera.cv - v) * 0.8 / camera.focal;
            const double bump = (0.05 + 0.004 * std::sin(5 * time)) * std::exp(-(x * x + y * y) / 0.02);
            // A camera has specks without an answer.
            const bool speck = (u * 7919 + v * 104729) % 97 == 0;
            depths[static_cast<std::size_t>(u + v * camera.width)] =
                speck ? 0.0f : static_cast<float>(0.8 - bump);
        }
    }
}

struct Result {
    double largest_step = 0; ///< N from update to update
    int lost = 0;
};

/// Two seconds of a resting hand.
Result rest(bool blend) {
    const Camera camera;
    const OrthoGrid ortho{camera, 0.8};
    const auto samples = static_cast<std::size_t>(camera.width * camera.height);
    std::vector<float> depths(samples),
        heights[2]{std::vector<float>(samples, hole), std::vector<float>(samples, hole)};
    const Picture one{{heights[0].data(), ortho.columns, ortho.rows}, ortho.frame};
    const Picture other{{heights[1].data(), ortho.columns, ortho.rows}, ortho.frame};
    BlendedPictures ground{one, other};
    hfh::ProxyTracker tracker{ground};
    const hfh::ForceEvaluator<double> force{.stiffness = 400};

    Result result;
    int taken = 0; // ms, when the last picture came
    hfh::vec3<double> last{0.0};
    for (int ms = 0; ms < 2000; ++ms) {
        if (ms % 33 == 0) {
            // What was the last picture is felt no more (α is 1), so its memory takes the new one. In a program the camera's
            // thread fills a third picture and hands it over by a TripleBuffer of pointers.
            look(camera, 0.001 * ms, depths);
            project(camera, depths, ortho, heights[ground.exchange()]);
            taken = ms;
        }
        ground.set_alpha(blend && ms >= 33 ? std::min(1.0, (ms - taken + 1) / 33.0) : 1.0);
        const auto contact = tracker.update({0.004, 0.003, ms == 0 ? -0.7 : -0.756});
        const auto felt = force(contact).newtons;
        if (ms > 1) {
            result.lost += !contact.touching();
            result.largest_step = std::max(result.largest_step, glm::length(felt - last));
        }
        last = felt;
    }
    return result;
}

} // namespace

int main() {
    const Result blended = rest(true), exchanged = rest(false);
    std::printf(
        "largest step of the force: %.4f N when pictures are exchanged, %.4f N when they are blended;\n"
        "contact lost %d times\n",
        exchanged.largest_step, blended.largest_step, blended.lost);
    return blended.lost == 0 && blended.largest_step < 0.1 * exchanged.largest_step ? 0 : 1;
}
