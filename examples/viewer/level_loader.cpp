#include "level_loader.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace viewer {
namespace {

/// After so long without anything new to show, what is there is shown.
constexpr std::chrono::milliseconds patience{25};

int coarsest_level(const DisplayedTerrain& terrain, int n, int coarsest_felt) noexcept {
    const hfh::Index longest = std::max(terrain.columns, terrain.rows) - 1;
    int level = coarsest_felt;
    // The middle may be anywhere on the terrain, and is up to two cells off the middle of the window.
    while (hfh::Index{(n - 1) / 2 - 2} << level < longest) ++level;
    return level;
}

float steepness(const std::vector<LevelVertex>& vertices) noexcept {
    double sum = 0;
    for (const LevelVertex& v : vertices) sum += static_cast<double>(std::hypot(v.slope.x, v.slope.y));
    return static_cast<float>(sum / static_cast<double>(vertices.size()));
}

} // namespace

std::optional<float> LoadedLevels::height_at(const glm::dvec2& at, int n) const noexcept {
    for (const auto& level : levels) {
        const glm::dvec2 vertex = at / std::exp2(level->level), corner = glm::floor(vertex);
        const hfh::Index a = static_cast<hfh::Index>(corner.x) - level->origin.i,
                         b = static_cast<hfh::Index>(corner.y) - level->origin.j;
        if (a < 0 || b < 0 || a + 1 >= n || b + 1 >= n) continue;
        const LevelVertex* const row = &level->vertices[static_cast<std::size_t>(b * n + a)];
        if (row->coarse_slope.y >= no_cell / 2) return std::nullopt;
        const glm::vec2 part{vertex - corner};
        return glm::mix(glm::mix(row[0].height, row[1].height, part.x),
                        glm::mix(row[n].height, row[n + 1].height, part.x), part.y);
    }
    return std::nullopt;
}

LevelLoader::LevelLoader(const DisplayedTerrain& terrain, int n, int coarsest_felt)
    : terrain_{&terrain}, n_{n}, coarsest_{coarsest_level(terrain, n, coarsest_felt)} {
    for (int level = 0; level <= coarsest_; ++level) windows_.emplace_back(terrain, level, n);
    loaded_.resize(windows_.size());
    thread_ = std::thread{[this] { run(); }};
}

LevelLoader::~LevelLoader() {
    {
        const std::lock_guard lock{mutex_};
        stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void LevelLoader::ask(const LevelRequest& request) {
    {
        const std::lock_guard lock{mutex_};
        const SampleRange waiting = request_ ? request_->changed : SampleRange{};
        request_ = request;
        request_->changed = united(request.changed, waiting);
    }
    changed_.notify_all();
}

std::shared_ptr<const LoadedLevels> LevelLoader::newest() const {
    const std::lock_guard lock{mutex_};
    return newest_;
}

void LevelLoader::wait() const {
    std::unique_lock lock{mutex_};
    changed_.wait(lock, [&] { return !request_ && !busy_; });
}

void LevelLoader::run() {
    std::unique_lock lock{mutex_};
    while (true) {
        changed_.wait(lock, [&] { return request_ || stopping_; });
        if (stopping_) return;
        const LevelRequest request = *request_;
        request_.reset();
        busy_ = true;
        lock.unlock();
        load(request);
        lock.lock();
        busy_ = false;
        changed_.notify_all();
    }
}

void LevelLoader::load(const LevelRequest& request) {
    using Clock = std::chrono::steady_clock;
    auto shown = Clock::now();
    const int finest = std::clamp(request.finest, 0, coarsest_);
    for (int level = coarsest_; level >= 0; --level) {
        LevelWindow& window = windows_[static_cast<std::size_t>(level)];
        if (!request.changed.empty()) window.read_again(request.changed);
        if (level < finest) continue;
        window.move_to(request.place);
        auto& loaded = loaded_[static_cast<std::size_t>(level)];
        if (!loaded || loaded->version != window.version()) {
            loaded = std::make_shared<const LoadedLevel>(
                LoadedLevel{level, window.origin(), window.version(), window.has_holes(), window.vertices()});
        }
        if (level > finest && Clock::now() - shown > patience) {
            publish(request, level);
            shown = Clock::now();
        }
    }
    publish(request, finest);
}

void LevelLoader::publish(const LevelRequest& request, int finest) {
    auto set = std::make_shared<LoadedLevels>();
    set->place = request.place;
    set->levels.assign(loaded_.begin() + finest, loaded_.end());
    set->steepness = steepness(set->levels.front()->vertices);
    set->edit = request.edit;
    for (const LevelWindow& window : windows_) set->samples_read += window.samples_read();
    const std::lock_guard lock{mutex_};
    newest_ = std::move(set);
}

} // namespace viewer
