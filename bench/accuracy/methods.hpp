#ifndef HFH_BENCH_ACCURACY_METHODS_HPP
#define HFH_BENCH_ACCURACY_METHODS_HPP

#include "cheap_feet.hpp"
#include "oracle.hpp"
#include "paper_newton.hpp"

#include <hfh/geometry/global_closest_point.hpp>

#include <memory>
#include <string>
#include <utility>
#include <vector>

// All methods behind one face, so that they can take turns.

namespace accuracy {

enum class Family { vertical, triangles, paper, ours, complete };

struct Title {
    std::string name;
    Family family{};
    int steps = 0; ///< the most it may take, 0 where there is no such thing
};

/// What is said of one answer, in long double, from the query.
struct Claim {
    Wide u, v;
    Point foot, normal;
    bool gave_up;
};

template <Real T>
[[nodiscard]] SeenPatch seen(const Query<T>& query) {
    const auto wide = [](T x) { return static_cast<Wide>(x); };
    const auto& [p, q] = query;
    const Wide dx = wide(p.spacing.x), dy = wide(p.spacing.y), z = wide(q.z);
    return {-wide(q.u) * dx, -wide(q.v) * dy, dx, dy, wide(p.p00) - z, wide(p.p10) - z,
            wide(p.p01) - z, wide(p.p11) - z};
}

template <Real T>
[[nodiscard]] Claim claim(const SeenPatch& patch, const SurfaceFoot<T>& foot) {
    const Wide u = static_cast<Wide>(foot.u), v = static_cast<Wide>(foot.v);
    return {u, v, patch.at(u, v), patch.normal(u, v), foot.gave_up};
}
template <Real T>
[[nodiscard]] Claim claim(const SeenPatch& patch, const FacetFoot<T>& foot) {
    const Wide u = static_cast<Wide>(foot.u), v = static_cast<Wide>(foot.v);
    return {u,
            v,
            {patch.x + u * patch.dx, patch.y + v * patch.dy, static_cast<Wide>(foot.z)},
            patch.normal_of(static_cast<Wide>(foot.slope_u), static_cast<Wide>(foot.slope_v)),
            false};
}

template <Real T>
class Method {
public:
    explicit Method(Title its_title) : title{std::move(its_title)} {}
    virtual ~Method() = default;

    /// Answers queries first … last − 1 and keeps the answers.
    virtual void run(const std::vector<Query<T>>& queries, std::size_t first, std::size_t last) = 0;
    /// The answer to query k.
    [[nodiscard]] virtual Claim answer(const SeenPatch& patch, std::size_t k) const = 0;

    const Title title;
};

template <Real T, class Solve>
class SolvedBy final : public Method<T> {
public:
    SolvedBy(Title its_title, Solve solve) : Method<T>{std::move(its_title)}, solve_{std::move(solve)} {}

    void run(const std::vector<Query<T>>& queries, std::size_t first, std::size_t last) override {
        if (answers_.size() < queries.size()) answers_.resize(queries.size());
        for (std::size_t k = first; k < last; ++k) answers_[k] = solve_(queries[k]);
    }
    [[nodiscard]] Claim answer(const SeenPatch& patch, std::size_t k) const override {
        return claim(patch, answers_[k]);
    }

private:
    Solve solve_;
    std::vector<decltype(std::declval<Solve>()(std::declval<Query<T>>()))> answers_;
};

template <Real T>
[[nodiscard]] std::vector<std::unique_ptr<Method<T>>> methods() {
    std::vector<std::unique_ptr<Method<T>>> all;
    const auto add = [&](std::string name, Family family, int steps, auto solve) {
        all.push_back(
            std::make_unique<SolvedBy<T, decltype(solve)>>(Title{std::move(name), family, steps}, solve));
    };
    using Q = const Query<T>&;

    add("vertical projection", Family::vertical, 0, [](Q q) { return vertical_projection(q); });
    add("two triangles, p00-p11", Family::triangles, 0,
        [](Q q) { return two_triangles(q, Diagonal::from_p00); });
    add("two triangles, p10-p01", Family::triangles, 0,
        [](Q q) { return two_triangles(q, Diagonal::from_p10); });
    for (int steps = 1; steps <= 8; ++steps) {
        add("paper, " + std::to_string(steps), Family::paper, steps,
            [steps](Q q) { return paper_closest_point(q, steps, T(0)); });
    }
    // A step of √ε cells leaves nothing that a further one could mend.
    add("paper, until still", Family::paper, 64,
        [](Q q) { return paper_closest_point(q, 64, std::sqrt(hfh::epsilon<T>)); });
    for (const int steps : {1, 2, 3, 4, 8, 64}) {
        const hfh::NewtonOptions options{.max_iterations = steps};
        add("ours, " + std::to_string(steps), Family::ours, steps, [options](Q q) {
            const auto foot = hfh::newton_closest_point(q.patch, q.at, start(q), options);
            return SurfaceFoot<T>{foot.u, foot.v, foot.status == hfh::NewtonStatus::iteration_limit};
        });
    }
    add("complete", Family::complete, 0, [](Q q) {
        const auto foot = hfh::global_closest_point(q.patch, q.at);
        return SurfaceFoot<T>{foot.u, foot.v, foot.status == hfh::GlobalStatus::interval_limit};
    });
    return all;
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_METHODS_HPP
