// Tiles that arrive and go. A loader thread reads tiles of a large map and hands them to the haptic thread, which alone
// puts them into its table and takes them out again, between two updates. What the loader may free comes back to it.
//
// Where a tile under the hand is late, there is no ground to feel. Contact is then held: the tracker is not updated, and the
// last contact is felt for up to 20 ms. If the tile has come by then, touch goes on as if nothing had been. If not, the force
// is ramped out, and the stylus has to come down from above again. A force that stays for longer would push a hand that has
// moved on by then.
//
// Here a hand is dragged over 8 × 2 tiles of which most arrive in time, one 15 ms late and one a second late. Ends with 0 if
// the first of these was not felt and the force of the second was ramped out.

#include "single_queue.hpp"

#include <hfh/hfh.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

namespace {

constexpr hfh::Index tile_cells = 64,
                     tile_samples = tile_cells + 1; // tiles share the samples of their borders
constexpr hfh::Index tiles_x = 8, tiles_y = 2;
constexpr double spacing = 10.0; // m

struct Tile {
    hfh::Cell at{}; ///< number of the tile
    std::array<float, tile_samples * tile_samples> heights{};
};

/// A height field of the tiles that are there. Cells of the others have no patch.
class TiledGround {
public:
    using Scalar = double;

    [[nodiscard]] hfh::Lattice lattice() const noexcept { return {{0.0, 0.0}, {spacing, spacing}}; }
    [[nodiscard]] hfh::CellRange cells() const noexcept {
        return {{0, 0}, {tiles_x * tile_cells, tiles_y * tile_cells}};
    }
    [[nodiscard]] std::optional<hfh::BilinearPatch<double>> patch(hfh::Cell c) const noexcept {
        const Tile* tile = cells().contains(c) ? tiles_[index(tile_of(c))] : nullptr;
        if (!tile) return std::nullopt;
        const hfh::Index at = c.i % tile_cells + c.j % tile_cells * tile_samples;
        const auto height = [&](hfh::Index n) {
            return static_cast<double>(tile->heights[static_cast<std::size_t>(at + n)]);
        };
        return hfh::BilinearPatch<double>{
            height(0), height(1), height(tile_samples), height(tile_samples + 1), {spacing, spacing}};
    }

    /// Between two updates, by the haptic thread. Returns the tile that was there, for whoever frees it.
    const Tile* put(hfh::Cell at, const Tile* tile) noexcept {
        return std::exchange(tiles_[index(at)], tile);
    }

    /// Whether a tile is missing from the rectangle over two points and the cells around it.
    [[nodiscard]] bool misses_between(const hfh::vec3<double>& a, const hfh::vec3<double>& b) const noexcept {
        const auto cell = [](double metres) { return static_cast<hfh::Index>(std::floor(metres / spacing)); };
        const auto range = cells();
        const auto first =
            tile_of({std::clamp(cell(std::min(a.x, b.x)) - 1, hfh::Index{0}, range.end.i - 1),
                     std::clamp(cell(std::min(a.y, b.y)) - 1, hfh::Index{0}, range.end.j - 1)});
        const auto last = tile_of({std::clamp(cell(std::max(a.x, b.x)) + 1, hfh::Index{0}, range.end.i - 1),
                                   std::clamp(cell(std::max(a.y, b.y)) + 1, hfh::Index{0}, range.end.j - 1)});
        for (hfh::Index j = first.j; j <= last.j; ++j)
            for (hfh::Index i = first.i; i <= last.i; ++i)
                if (!tiles_[index({i, j})]) return true;
        return false;
    }

private:
    [[nodiscard]] static hfh::Cell tile_of(hfh::Cell c) noexcept {
        return {c.i / tile_cells, c.j / tile_cells};
    }
    [[nodiscard]] static std::size_t index(hfh::Cell tile) noexcept {
        return static_cast<std::size_t>(tile.i + tile.j * tiles_x);
    }
    std::array<const Tile*, tiles_x * tiles_y> tiles_{};
};

/// A tracker that holds its contact while tiles are missing.
class TiledTouch {
public:
    static constexpr double held_for = 0.02, ramp = 0.1; // s

    explicit TiledTouch(const TiledGround& ground) noexcept : ground_{&ground}, tracker_{ground} {}

    struct Felt {
        hfh::Contact<double> contact;
        double share = 1; ///< of its force that is to be felt
    };
    Felt update(const hfh::vec3<double>& stylus, double seconds) noexcept {
        if (!last_.touching()) return {last_ = tracker_.update(stylus)};
        if (!ground_->misses_between(last_.proxy, stylus)) {
            waited_ = 0;
            return {last_ = tracker_.update(stylus)};
        }
        waited_ += seconds;
        const double share = std::clamp(1 - (waited_ - held_for) / ramp, 0.0, 1.0);
        if (share > 0) return {last_, share};
        // Too late. The stylus may be deep below the ground that comes: nothing is felt until it was above.
        tracker_.reset();
        waited_ = 0;
        return {last_ = {}, 0};
    }

private:
    const TiledGround* ground_;
    hfh::ProxyTracker<TiledGround> tracker_;
    hfh::Contact<double> last_{};
    double waited_ = 0;
};

std::unique_ptr<Tile> read_tile(hfh::Cell at) {
    auto tile = std::make_unique<Tile>();
    tile->at = at;
    for (hfh::Index j = 0; j < tile_samples; ++j) {
        for (hfh::Index i = 0; i < tile_samples; ++i) {
            const auto x = static_cast<float>(at.i * tile_cells + i),
                       y = static_cast<float>(at.j * tile_cells + j);
            tile->heights[static_cast<std::size_t>(i + j * tile_samples)] =
                20 * std::sin(0.1f * x) * std::cos(0.07f * y);
        }
    }
    return tile;
}

/// When tile i of the row under the hand is there, in milliseconds. The hand is a cell away from it at 640·i − 110.
int arrives(hfh::Index i) {
    const int needed = static_cast<int>(640 * i - 110);
    return i == 3 ? needed + 15 : i == 5 ? needed + 1000 : needed - 100;
}

/// What reads tiles and what puts them into the ground. In a program, `load` and `free` run in a thread of their own.
class Loader {
public:
    /// By the loader's thread, each millisecond. False if a queue is full.
    [[nodiscard]] bool load(int ms) {
        for (hfh::Index i = 0; i < tiles_x; ++i) {
            if (ms != std::max(0, arrives(i))) continue;
            for (hfh::Index j = 0; j < tiles_y; ++j) {
                loaded_.push_back(read_tile({i, j}));
                if (!arrived_.push(loaded_.back().get())) return false;
            }
        }
        return true;
    }
    /// By the loader's thread: frees the tiles that are used no more. Returns how many.
    std::size_t free() {
        std::size_t freed = 0;
        for (const Tile* tile = nullptr; gone_.pop(tile);)
            freed += std::erase_if(loaded_, [&](const auto& one) { return one.get() == tile; });
        return freed;
    }

    /// By the haptic thread, between two updates: takes in what has arrived, and takes out what lies two tiles behind a hand at
    /// x metres. False if a queue is full.
    [[nodiscard]] bool exchange(TiledGround& ground, double x) noexcept {
        for (const Tile* tile = nullptr; arrived_.pop(tile);) (void)ground.put(tile->at, tile);
        const auto behind = static_cast<hfh::Index>(x / (spacing * tile_cells)) - 2;
        for (hfh::Index j = 0; j < tiles_y && behind >= 0; ++j) {
            const Tile* tile = ground.put({behind, j}, nullptr);
            if (tile && !gone_.push(tile)) return false;
        }
        return true;
    }

private:
    recipes::SingleQueue<const Tile*, 16> arrived_, gone_;
    std::vector<std::unique_ptr<Tile>> loaded_;
};

} // namespace

int main() {
    TiledGround ground;
    TiledTouch touch{ground};
    const hfh::ForceEvaluator<double> force{.stiffness = 0.1}; // N/m of terrain

    Loader loader;
    double largest_step = 0, last = 0, felt_when_late = 0;
    int held = 0, without = 0;
    std::size_t freed = 0; // six columns of two, at the end
    bool ramped_out = false, touches_again = false;
    for (int ms = 0; ms < 640 * 7; ++ms) {
        const double x = 100 + ms; // a metre of terrain a millisecond
        if (!loader.load(ms) || !loader.exchange(ground, x)) return 1;
        freed += loader.free();
        const hfh::vec3<double> hand{x, 640.0, ms == 0 || ms == 4200 ? 40.0 /* lifted */ : -25.0};
        const auto felt = touch.update(hand, 0.001);
        const double newtons = felt.share * glm::length(force(felt.contact).newtons);
        if (ms > 1 && ms < 4200) largest_step = std::max(largest_step, std::abs(newtons - last));
        touches_again = ms > 4200 && felt.contact.touching();
        last = newtons;
        held += felt.contact.touching() && felt.share < 1;
        if (felt.share == 0) ramped_out = true;
        if (ms > 1 && ms < 2600) without += !felt.contact.touching();
        if (ms > 3500 && ms < 4100) felt_when_late = std::max(felt_when_late, newtons);
    }
    std::printf("late by 15 ms: contact lost in %d updates; late by a second: ramped out %s, then %.2f N;\n"
                "largest step of the force %.3f N; %zu tiles freed\n",
                without, ramped_out ? "yes" : "no", felt_when_late, largest_step, freed);
    return freed == 12 && without == 0 && ramped_out && held > 50 && felt_when_late == 0 && touches_again &&
                   largest_step < 0.5
               ? 0
               : 1;
}
