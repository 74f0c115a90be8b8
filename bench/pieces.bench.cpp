#include "run.hpp"
#include "terrain.hpp"

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/force_shading.hpp>
#include <hfh/contact/friction.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/damping.hpp>
#include <hfh/terrain/extended_field.hpp>

// What each optional piece adds to an update: a hand that slides in a circle, half a cell deep, half a cell an update.

namespace hfh::bench {
namespace {

enum class Piece { none, damping, shading, friction, extended_field, all_of_these };

constexpr std::size_t length = 4096;

/// A tracker with a piece behind it; the stylus is `lift` above where a point would be. The answer is checked for what a piece
/// cannot change: that it touches.
template <Piece piece, class Tracker>
void slide(benchmark::State& state, const Terrain& ground, Tracker tracker, double lift) {
    using T = typename Tracker::Scalar;
    const glm::dvec2 cell = ground.kind.spacing;
    std::vector<vec3<T>> path;
    for (std::size_t k = 0; k < length; ++k) {
        const double turn = 6.283185307179586 * static_cast<double>(k) / static_cast<double>(length);
        const double cells = 0.5 * static_cast<double>(length) / 6.283185307179586;
        const double wide =
            std::min(cells, 0.4 * static_cast<double>(std::min(ground.kind.columns, ground.kind.rows)));
        const double x = cell.x * (0.5 * static_cast<double>(ground.kind.columns) + wide * std::cos(turn));
        const double y = cell.y * (0.5 * static_cast<double>(ground.kind.rows) + wide * std::sin(turn));
        path.push_back({static_cast<T>(x), static_cast<T>(y),
                        static_cast<T>(ground.surface(x, y) + lift - 0.5 * ground.cell())});
    }
    const auto& field = tracker.field();
    Friction<T> friction{};
    VelocityFilter<T> velocity{};
    const Damping<T> damping{T(2), T(1)};
    const ForceEvaluator<T> force{.stiffness = 500, .max_force = T(3.3)};
    constexpr bool all = piece == Piece::all_of_these;
    static_cast<void>(tracker.update(path[0] + vec3<T>{T(0), T(0), T(10000)}));
    std::size_t touching = 0, updates = 0;
    while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(length))) {
        for (const auto& stylus : path) {
            auto contact = tracker.update(stylus);
            if constexpr (all || piece == Piece::shading) contact = shade_force(field, contact);
            if constexpr (all || piece == Piece::friction) contact = friction.hold(field, contact, stylus);
            if constexpr (all || piece == Piece::damping) {
                benchmark::DoNotOptimize(damping(force, contact, velocity.update(stylus, T(0.001))));
            } else {
                benchmark::DoNotOptimize(force(contact));
            }
            touching += contact.touching();
        }
        updates += length;
    }
    state.SetLabel(ground.label());
    if (touching < updates - 1) fail(state, "the hand lost touch");
}

template <Real T>
void register_scalar(const TerrainKind& kind) {
    const auto ground = [kind]() -> const Terrain& { return terrain(kind); };
    const auto name = [&](const std::string& piece) {
        return "pieces/" + piece + '/' + kind.name + '/' + scalar_name<T>;
    };
    const auto on_grid = [&]<Piece piece>(const char* what) {
        add(name(what), [=](benchmark::State& state) {
            const auto grid = ground().template grid<T>();
            slide<piece>(state, ground(), ProxyTracker{grid}, 0);
        });
    };
    on_grid.template operator()<Piece::none>("none");
    on_grid.template operator()<Piece::damping>("damping");
    on_grid.template operator()<Piece::shading>("shading");
    on_grid.template operator()<Piece::friction>("friction");
    add(name("extended_field"), [=](benchmark::State& state) {
        const auto grid = ground().template grid<T>();
        const ExtendedField field{grid};
        slide<Piece::none>(state, ground(), ProxyTracker{field}, 0);
    });
    on_grid.template operator()<Piece::all_of_these>("damping_shading_friction");
    for (const double cells : {0.5, 1.0, 2.0}) {
        add(name("ball_" + std::to_string(cells).substr(0, 3) + "_cells"), [=](benchmark::State& state) {
            const auto grid = ground().template grid<T>();
            const double r = cells * ground().cell();
            slide<Piece::none>(state, ground(), BallTracker{grid, static_cast<T>(r)}, r);
        });
    }
}

} // namespace

void register_benchmarks() {
    for (const TerrainKind& kind : {small_hills, spanish_peaks_10m}) {
        register_scalar<double>(kind);
        register_scalar<float>(kind);
    }
}

} // namespace hfh::bench
