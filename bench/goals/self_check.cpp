#include "self_check.hpp"

#include "casts.hpp"
#include "strokes.hpp"

// A check that cannot fail is worth nothing, so each is given answers that are wrong by a millionth of a cell, every time
// the goals are measured.

namespace hfh::bench {
namespace {

/// The hills, said to lie elsewhere: the library's answers are wrong by that much there.
struct Elsewhere : Ground<std::int16_t> {
    double higher = 0;

    [[nodiscard]] double surface(double x, double y) const noexcept {
        return Ground<std::int16_t>::surface(x, y) + higher;
    }
};

template <class Action>
void must_fail(const char* what, Action&& action) {
    try {
        action();
    } catch (const Fault&) {
        return;
    }
    throw Fault{std::string{"a check does not check: "} + what};
}

} // namespace

void check_the_checks() {
    const Elsewhere hills{hills_in_memory("hills", 129, 129)};
    const double little = 1e-6 * hills.cell();

    const auto trace = stroke_trace<double>(hills, {"", Way::sliding, 0.5, 0.5}, 1'000, 100);
    const auto flight = stroke_trace<double>(hills, {"", Way::flying, 0.5, 0}, 100, 100);
    check_trace(hills, trace, "sliding on hills");
    check_trace(hills, flight, "flying over hills");
    for (const double off : {-little, little}) {
        Elsewhere wrong = hills;
        wrong.higher = off;
        must_fail("a proxy off the surface", [&] { check_trace(wrong, trace, ""); });
    }
    {
        Elsewhere wrong = hills;
        wrong.higher = 21 * hills.cell();
        must_fail("free below the surface", [&] { check_trace(wrong, flight, ""); });
    }

    const auto grid = hills.grid<double>();
    for (const double length : {3.0, 30.0}) {
        const auto set = cast_set<double>(grid, hills, length, casts_a_slice);
        check_casts(hills, set);
        for (const double off : {-little, little}) {
            auto wrong = set;
            for (auto& t : wrong.t) t += t <= 1 ? off / (length * hills.cell()) : 0;
            must_fail("a crossing moved aside", [&] { check_casts(hills, wrong); });
        }
        auto missed = set, rising = set;
        for (auto& t : missed.t) t = 2;
        must_fail("a crossing missed", [&] { check_casts(hills, missed); });
        // Out of the ground: it ends on the surface, but crossed it where it went in.
        for (auto& [a, b] : rising.queries) {
            b.z = hills.surface(b.x, b.y);
            a = {b.x, b.y, b.z - hills.cell()};
        }
        for (auto& t : rising.t) t = 1;
        must_fail("a crossing that is not the first", [&] { check_casts(hills, rising); });
    }
}

} // namespace hfh::bench
