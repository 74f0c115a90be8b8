#ifndef HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
#define HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP

#include <hfh/traversal/first_hit.hpp>

namespace hfh::test::plain {

/// hfh::first_hit without any skipping: the library's own walk over every cell under the segment, each judged. Skipping
/// must not change the answer by a bit.
template <HeightField Field>
[[nodiscard]] FirstHit<typename Field::Scalar> first_hit(const Field& field, const glm::dvec3& a,
                                                         const glm::dvec3& b,
                                                         const FirstHitOptions& options = {}) noexcept {
    FirstHit<typename Field::Scalar> result;
    hfh::detail::Judge<Field> judge{field, a, b, options, result};
    const CellRange range = field.cells();
    const Lattice& lattice = field.lattice();
    hfh::detail::CellWalk walk{
        lattice, hfh::detail::SplitEnds{lattice, {a.x, a.y}, {b.x, b.y}}, {b.x - a.x, b.y - a.y}};
    if (walk.enter(range)) walk.visit(range, range, judge);
    judge.end();
    return result;
}

} // namespace hfh::test::plain

#endif // HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
