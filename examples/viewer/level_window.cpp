#include "level_window.hpp"

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

/// The samples nearest to vertices `first` … of a level, along one axis.
hfh::Index sample_of(hfh::Index vertex, int level, hfh::Index count) noexcept {
    return std::clamp(vertex * (hfh::Index{1} << level), hfh::Index{0}, count - 1);
}

/// The height of the coarser level at a vertex between others of it, from them; `own` where one of them is a hole.
float between(float own, float a, float b, float t) noexcept {
    const float height = a + t * (b - a);
    return std::isnan(height) ? own : height;
}

/// (b − a)/d, from one side where the other one is a hole; 0 where both are or nothing lies between.
float slope_between(float a, float own, float b, float before, float after) noexcept {
    if (std::isnan(a)) a = own, before = 0;
    if (std::isnan(b)) b = own, after = 0;
    const float d = before + after;
    return d > 0 && !std::isnan(a) && !std::isnan(b) ? (b - a) / d : 0.0f;
}

} // namespace

LevelWindow::LevelWindow(const DisplayedTerrain& terrain, int level, int n)
    : terrain_{&terrain}, level_{level}, n_{n},
      heights_(static_cast<std::size_t>(n + 2 * margin) * static_cast<std::size_t>(n + 2 * margin)) {}

hfh::Cell LevelWindow::origin_for(const glm::dvec2& place, int level, int n) noexcept {
    const double coarse = std::exp2(level + 1);
    const hfh::Index half = (n - 3) / 4;
    return {2 * (static_cast<hfh::Index>(std::floor(place.x / coarse)) - half),
            2 * (static_cast<hfh::Index>(std::floor(place.y / coarse)) - half)};
}

float LevelWindow::read(hfh::Index a, hfh::Index b) noexcept {
    ++samples_read_;
    const double height = terrain_->sample(sample_of(origin_.i + a, level_, terrain_->columns),
                                           sample_of(origin_.j + b, level_, terrain_->rows));
    return static_cast<float>(height - terrain_->datum);
}

void LevelWindow::move_to(const glm::dvec2& place) {
    const hfh::Cell to = origin_for(place, level_, n_);
    if (filled_ && to == origin_) return;
    const hfh::Index di = to.i - origin_.i, dj = to.j - origin_.j;
    const int size = n_ + 2 * margin;
    const std::vector<float> before = heights_;
    const auto held = [&](hfh::Index a, hfh::Index b) {
        return filled_ && 0 <= a && a < size && 0 <= b && b < size;
    };
    origin_ = to;
    holes_ = 0;
    for (int b = 0; b < size; ++b) {
        for (int a = 0; a < size; ++a) {
            const hfh::Index old_a = a + di, old_b = b + dj;
            float& height = heights_[static_cast<std::size_t>(b * size + a)];
            height = held(old_a, old_b) ? before[static_cast<std::size_t>(old_b * size + old_a)]
                                        : read(a - margin, b - margin);
            holes_ += std::isnan(height);
        }
    }
    filled_ = true;
    ++version_;
}

void LevelWindow::read_again(const SampleRange& changed) {
    if (!filled_) return;
    const int size = n_ + 2 * margin;
    bool any = false;
    const auto within = [&](hfh::Index sample, hfh::Index begin, hfh::Index end) {
        return begin <= sample && sample < end;
    };
    for (int b = 0; b < size; ++b) {
        const hfh::Index j = sample_of(origin_.j + b - margin, level_, terrain_->rows);
        if (!within(j, changed.begin.j, changed.end.j)) continue;
        for (int a = 0; a < size; ++a) {
            const hfh::Index i = sample_of(origin_.i + a - margin, level_, terrain_->columns);
            if (!within(i, changed.begin.i, changed.end.i)) continue;
            heights_[static_cast<std::size_t>(b * size + a)] = read(a - margin, b - margin);
            any = true;
        }
    }
    version_ += any;
}

std::vector<LevelVertex> LevelWindow::vertices() const {
    std::vector<LevelVertex> vertices(static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_));
    // Metres from vertex to vertex: less at the border of the terrain, none beyond it.
    const auto distances = [&](hfh::Index origin, hfh::Index count, double spacing) {
        std::vector<float> places(static_cast<std::size_t>(n_ + 2 * margin));
        for (int a = -margin; a < n_ + margin; ++a)
            places[static_cast<std::size_t>(a + margin)] =
                static_cast<float>(spacing * static_cast<double>(sample_of(origin + a, level_, count) -
                                                                 sample_of(origin, level_, count)));
        return places;
    };
    const std::vector<float> x = distances(origin_.i, terrain_->columns, terrain_->spacing.x),
                             y = distances(origin_.j, terrain_->rows, terrain_->spacing.y);
    const auto step = [](const std::vector<float>& places, int from, int to) {
        return places[static_cast<std::size_t>(to + margin)] -
               places[static_cast<std::size_t>(from + margin)];
    };
    const auto share = [&](const std::vector<float>& places, int a) {
        const float whole = step(places, a - 1, a + 1);
        return whole > 0 ? step(places, a - 1, a) / whole : 0.5f;
    };
    // Whether the coarser level does not reach to a vertex between others of it, because the terrain ends before.
    const auto is_cut = [&](hfh::Index vertex, hfh::Index count) {
        const hfh::Index samples = hfh::Index{1} << level_;
        return vertex % 2 != 0 && vertex * samples < count && (vertex + 1) * samples >= count;
    };
    for (int b = 0; b < n_; ++b) {
        const bool odd_b = b % 2 != 0, cut_b = is_cut(origin_.j + b, terrain_->rows);
        for (int a = 0; a < n_; ++a) {
            const bool odd_a = a % 2 != 0;
            LevelVertex& v = vertices[static_cast<std::size_t>(b * n_ + a)];
            const float z = at(a, b);
            v.height = std::isnan(z) ? 0.0f : z;
            v.coarse_height = v.height;
            // Halfway, but beyond the border where all vertices lie on it. A vertex that the coarser level does not reach keeps
            // its height, as in `hfh::BlendedField`.
            const float tx = share(x, a), ty = share(y, b);
            if (cut_b || is_cut(origin_.i + a, terrain_->columns))
                v.coarse_height = v.height;
            else if (odd_a && odd_b)
                v.coarse_height =
                    between(v.height, at(a - 1, b - 1) + tx * (at(a + 1, b - 1) - at(a - 1, b - 1)),
                            at(a - 1, b + 1) + tx * (at(a + 1, b + 1) - at(a - 1, b + 1)), ty);
            else if (odd_a)
                v.coarse_height = between(v.height, at(a - 1, b), at(a + 1, b), tx);
            else if (odd_b)
                v.coarse_height = between(v.height, at(a, b - 1), at(a, b + 1), ty);
            v.slope = {slope_between(at(a - 1, b), z, at(a + 1, b), step(x, a - 1, a), step(x, a, a + 1)),
                       slope_between(at(a, b - 1), z, at(a, b + 1), step(y, b - 1, b), step(y, b, b + 1))};
            v.coarse_slope = {
                slope_between(at(a - 2, b), z, at(a + 2, b), step(x, a - 2, a), step(x, a, a + 2)),
                slope_between(at(a, b - 2), z, at(a, b + 2), step(y, b - 2, b), step(y, b, b + 2))};
            if (std::isnan(z + at(a + 1, b) + at(a, b + 1) + at(a + 1, b + 1))) v.coarse_slope.y += no_cell;
        }
    }
    return vertices;
}

} // namespace viewer
