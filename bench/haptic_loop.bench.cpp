#include "goals/race.hpp"
#include "run.hpp"
#include "terrain.hpp"

#include <hfh/loop/any_haptic_loop.hpp>

// What the erased loop adds to an update: a hand that slides in a circle, half a cell deep, half a cell an update, by the
// loop on the field's own type and by the same behind `AnyHapticLoop`, a slice of each in turn.

namespace hfh::bench {
namespace {

constexpr std::size_t slices = 16, length = 256;
constexpr double most = 1.03; ///< times an update of the loop on the field's own type

struct Stroke {
    WorkspaceFrame frame;
    std::vector<DeviceSample> samples;
};

[[nodiscard]] Stroke circle(const Terrain& ground) {
    const glm::dvec2 cell = ground.kind.spacing;
    Stroke stroke{{.scale = 1000 * cell.x}, {}}; // a cell is a millimetre of hand
    for (std::size_t k = 0; k < slices * length; ++k) {
        const double turn = 6.283185307179586 * static_cast<double>(k) / static_cast<double>(slices * length);
        const double cells = 0.5 * static_cast<double>(slices * length) / 6.283185307179586;
        const double wide =
            std::min(cells, 0.4 * static_cast<double>(std::min(ground.kind.columns, ground.kind.rows)));
        const double x = cell.x * (0.5 * static_cast<double>(ground.kind.columns) + wide * std::cos(turn));
        const double y = cell.y * (0.5 * static_cast<double>(ground.kind.rows) + wide * std::sin(turn));
        const glm::dvec3 at{x, y, ground.surface(x, y) - 0.5 * ground.cell()};
        stroke.samples.push_back({.position = at / stroke.frame.scale});
    }
    return stroke;
}

/// Goes along the stroke for ever, a slice a call, and counts the updates without contact.
template <class Loop>
class Stroking {
public:
    Stroking(Loop& loop, const Stroke& stroke) : loop_{&loop}, stroke_{&stroke} {
        DeviceSample above = stroke.samples[0];
        above.position.z += 1;
        benchmark::DoNotOptimize(loop_->update(above));
    }
    void run(std::size_t slice) {
        for (std::size_t k = slice * length; k < (slice + 1) * length; ++k) {
            DeviceSample sample = stroke_->samples[k];
            sample.time = 1e-3 * static_cast<double>(++updates_);
            benchmark::DoNotOptimize(loop_->update(sample));
            lost += !loop_->contact().touching();
        }
    }
    std::size_t lost = 0;

private:
    Loop* loop_;
    const Stroke* stroke_;
    std::size_t updates_ = 0;
};

template <Real T>
void compare(benchmark::State& state, const Terrain& ground, const Material& material) {
    const auto grid = ground.template grid<T>();
    using Grid = std::remove_const_t<decltype(grid)>;
    const Stroke stroke = circle(ground);
    const HapticLoopOptions options{
        .workspace = stroke.frame, .material = material, .limits = {.max_speed = 1e3}};
    HapticLoop loop{grid, options};
    FieldLoop<Grid> made{options, grid};
    AnyHapticLoop* any = &made;
    benchmark::DoNotOptimize(any); // so that the call is not taken for one of the type's own
    Stroking direct{loop, stroke};
    Stroking erased{*any, stroke};
    for (auto _ : state) {
        const auto paces = race({{slices, double(length), [&](std::size_t slice) { direct.run(slice); }},
                                 {slices, double(length), [&](std::size_t slice) { erased.run(slice); }}},
                                200);
        state.counters["direct_ns"] = paces[0].fastest;
        state.counters["erased_ns"] = paces[1].fastest;
        state.counters["ratio"] = paces[1].fastest / paces[0].fastest;
        if (paces[1].fastest > most * paces[0].fastest)
            fail(state, "the erased loop is slower than it may be");
    }
    state.SetLabel(ground.label());
    if (direct.lost + erased.lost > 2) fail(state, "the hand lost touch");
}

template <Real T>
void register_scalar(const TerrainKind& kind) {
    const auto register_one = [&](const char* what, const Material& material) {
        const std::string name =
            std::string{"haptic_loop/erased/"} + what + '/' + kind.name + '/' + scalar_name<T>;
        benchmark::RegisterBenchmark(name.c_str(), [kind, material](benchmark::State& state) {
            compare<T>(state, terrain(kind), material);
        })->Iterations(1);
    };
    register_one("plain", {});
    register_one("all", {.static_friction = 0.5, .dynamic_friction = 0.4, .damping = 1, .shading = true});
}

} // namespace

void register_benchmarks() {
    for (const TerrainKind& kind : {small_hills, spanish_peaks_10m}) {
        register_scalar<double>(kind);
        register_scalar<float>(kind);
    }
}

} // namespace hfh::bench
