#ifndef HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
#define HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP

#include <hfh/traversal/first_hit.hpp>

namespace hfh::test::plain {

/// hfh::first_hit without any skipping: the library's own traversal and crossing test, of every cell under the segment.
/// Skipping must not change the answer by a bit.
template <HeightField Field>
[[nodiscard]] FirstHit<typename Field::Scalar> first_hit(const Field& field, const glm::dvec3& a,
                                                         const glm::dvec3& b,
                                                         const FirstHitOptions& options = {}) noexcept {
    FirstHit<typename Field::Scalar> result;
    hfh::detail::CrossingTest<Field> test{field, a, b, options, result};
    const CellRange range = field.cells();
    hfh::detail::CellWalk walk{field.lattice(), {a.x, a.y}, {b.x, b.y}};
    if (walk.enter(range)) walk.visit(range, range, test);
    test.finish();
    return result;
}

} // namespace hfh::test::plain

#endif // HFH_TESTS_SUPPORT_PLAIN_FIRST_HIT_HPP
