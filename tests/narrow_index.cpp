// Built for a target on which an Index has 32 bits: an endless field a thousand kilometres from its origin is felt there as
// it is near by, and at the far end of its cells nothing overflows. A program of its own without a test framework, which is
// seldom there for the other target.

#include <hfh/contact/ball_tracker.hpp>
#include <hfh/contact/proxy_tracker.hpp>
#include <hfh/force/force_evaluator.hpp>
#include <hfh/terrain/bilinear_grid.hpp>
#include <hfh/terrain/extended_field.hpp>

#include <array>
#include <cstdio>

using namespace hfh;

static_assert(sizeof(Index) == 4, "this program is for targets where an Index has 32 bits");

namespace {

int failures = 0;

void check(bool holds, const char* what) {
    if (holds) return;
    ++failures;
    std::printf("FAILED: %s\n", what);
}

/// Level ground that goes on for ever, in cells of `cell` metres.
template <Real T>
struct Level {
    using Scalar = T;
    double cell;
    [[nodiscard]] Lattice lattice() const noexcept { return {{0, 0}, {cell, cell}}; }
    [[nodiscard]] static CellRange cells() noexcept { return CellRange::endless(); }
    [[nodiscard]] std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        if (!cells().contains(c)) return {};
        return BilinearPatch<T>{0, 0, 0, 0, vec2<T>{lattice().spacing()}};
    }
};

/// Strokes in steps of up to two thousand cells, pressed and lifted by turns; half a metre deep while pressed.
template <HeightField Field>
void check_strokes(const Field& field, glm::dvec2 at, double cell, const char* what) {
    using T = typename Field::Scalar;
    ProxyTracker tracker{field};
    const auto place = [&](double x, double y, double z) {
        return vec3<T>{static_cast<T>(at.x + x), static_cast<T>(at.y + y), static_cast<T>(z)};
    };
    for (const double step : {0.25, 3.0, 70.0, 1000.0}) {
        for (int k = 0; k < 8; ++k) {
            const double x = k % 2 * step * cell, y = k % 3 * step * cell;
            check(tracker.update(place(x, y, 1)).status == ContactStatus::free, what);
            const auto pressed = tracker.update(place(x, y, -0.5));
            check(pressed.status == ContactStatus::contact && pressed.depth == T(0.5), what);
            const auto slid = tracker.update(place(y, x, -0.5));
            check(slid.status == ContactStatus::contact && slid.depth == T(0.5), what);
            check(tracker.update(place(y, x, 1)).status == ContactStatus::free, what);
        }
    }
}

template <Real T>
void check_scalar() {
    // UTM, and farther: 10 000 km in cells of 2 cm are 500 million.
    const Level<T> metres{1}, centimetres{0.02};
    check_strokes(metres, {500'000, 5'300'000}, 1, "in UTM, in cells of a metre");
    if constexpr (std::same_as<T, double>) {
        check_strokes(centimetres, {500'000, 5'300'000}, 0.02, "in UTM, in cells of two centimetres");
        check_strokes(centimetres, {-9'999'000, 9'999'000}, 0.02,
                      "10 000 km away, in cells of two centimetres");
    }

    // At the last cells there are: whatever comes of it, it is in range and finite.
    const auto last = static_cast<double>(CellRange::endless().end.i);
    const Level<T>& field = metres;
    ProxyTracker tracker{field};
    const ForceEvaluator<T> force{};
    for (const double x : {0.0, last - 1, last, last + 1, -last, 1.0 - last, 0.0, 1e30, -1e30, last / 2}) {
        for (const double y : {0.0, last - 2, -last, 2.0 - last}) {
            for (const double z : {1.0, -0.5}) {
                const auto contact =
                    tracker.update({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
                check(is_finite(contact.depth) && is_finite(force(contact).newtons),
                      "at the end of the cells");
                check(contact.point.cell.i >= -CellRange::endless().end.i &&
                          contact.point.cell.i <= CellRange::endless().end.i,
                      "a cell that there is");
            }
        }
    }
    // The longest segments there are, with as much work as asked for and no more.
    const glm::dvec3 a{-last + 1, -last + 1, 1}, b{last - 1, last - 1, -1};
    const auto hit = first_hit(field, a, b, {.max_cells = 1000});
    check(hit.status == HitStatus::cell_limit && hit.t > 0 && hit.t < 1e-3, "a segment from end to end");
    check(first_hit(field, b, a, {.max_cells = 1000}).status != HitStatus::miss, "and back, from below");

    // A grid that goes on beyond its rim, and a ball on that.
    const std::array<T, 16> samples{};
    const BilinearGrid<T, HeightView<T>> grid{HeightView{samples.data(), 4, 4}, {}};
    const ExtendedField beyond{grid};
    check_strokes(beyond, {500'000, 5'300'000}, 1, "beyond a grid");
    BallTracker ball{beyond, T(0.25)};
    for (const double far : {0.0, 5'300'000.0, 300'000'000.0}) {
        ball.reset();
        const auto x = static_cast<T>(far);
        check(ball.update({x, x, 2}).status == ContactStatus::free, "a ball far out, above");
        const auto pressed = ball.update({x, x, -1});
        check(pressed.status == ContactStatus::contact && pressed.depth == T(1.25), "and pressed");
    }
}

} // namespace

int main() {
    check_scalar<double>();
    check_scalar<float>();
    std::printf("%s\n", failures == 0 ? "32 bits are enough" : "32 bits are not enough");
    return failures == 0 ? 0 : 1;
}
