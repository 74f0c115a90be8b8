#include "peers.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <vector>

// CGAL's tree of boxes, in double. A query bounded by a hint, the last answer: the sphere it begins with is no larger
// than it has to be. No search structure of points is built; that serves queries without a hint.

namespace hfh::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

class AabbTree : public ClosestPeer {
public:
    explicit AabbTree(const PeerHeights& heights) {
        triangles_.reserve(static_cast<std::size_t>(2 * (heights.columns - 1) * (heights.rows - 1)));
        const auto vertex = [&](std::uint32_t number) {
            const std::int64_t i = number % heights.columns, j = number / heights.columns;
            return Kernel::Point_3{static_cast<double>(i) * heights.spacing.x,
                                   static_cast<double>(j) * heights.spacing.y,
                                   static_cast<double>(heights(i, j))};
        };
        heights.triangles([&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            triangles_.push_back({vertex(a), vertex(b), vertex(c)});
        });
        tree_.insert(triangles_.cbegin(), triangles_.cend());
        tree_.build();
    }

    void follow(const glm::dvec3* queries, std::size_t count, glm::dvec3 last, glm::dvec3* found) override {
        Kernel::Point_3 hint{last.x, last.y, last.z};
        for (std::size_t k = 0; k < count; ++k) {
            hint = tree_.closest_point({queries[k].x, queries[k].y, queries[k].z}, hint);
            found[k] = {hint.x(), hint.y(), hint.z()};
        }
    }
    std::string name() const override { return "CGAL AABB tree"; }

private:
    Triangles triangles_;
    Tree tree_;
};

} // namespace

std::unique_ptr<ClosestPeer> cgal_aabb_tree(const PeerHeights& heights) {
    return std::make_unique<AabbTree>(heights);
}

} // namespace hfh::bench
