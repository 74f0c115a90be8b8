#ifndef HFH_GEOMETRY_HALF_SPACES_HPP
#define HFH_GEOMETRY_HALF_SPACES_HPP

#include <hfh/geometry/scalar.hpp>

#include <glm/geometric.hpp>

#include <span>

// The nearest point of a polyhedron that is given by its faces: where a ball may go that is kept away by planes.
//
// Based on: Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic programs (1983);
// Ruspini, Kolarov and Khatib, The Haptic Display of Complex Graphical Environments (1997), for a proxy among planes.

namespace hfh::detail {

/// The vectors s with normal·s ≥ offset.
struct HalfSpace {
    glm::dvec3 normal; ///< unit
    double offset;     ///< metres
};

/// The nearest point of a polyhedron, and which faces hold it.
struct PolyhedronPoint {
    glm::dvec3 step{0.0};
    double shares[3]{}; ///< point = target + Σ share·normal, ≥ 0
    int faces[3]{};     ///< their numbers
    int count = 0;
    bool found = true; ///< false: the half-spaces have no point in common, but for rounding
};

/// The point of the planes normal·s = offset of up to three half-spaces that is nearest to a target, and the shares of their
/// normals. False where the normals do not tell the planes apart, or a share is below 0.
[[nodiscard]] inline bool nearest_on_planes(const glm::dvec3& target, const HalfSpace* const planes[],
                                            int count, glm::dvec3& step, double shares[]) noexcept {
    constexpr double parallel = 1e-14; // squared sine
    const auto lacks = [&](int k) { return planes[k]->offset - glm::dot(planes[k]->normal, target); };
    if (count == 1) {
        shares[0] = lacks(0);
    } else if (count == 2) {
        const double c = glm::dot(planes[0]->normal, planes[1]->normal), det = 1 - c * c;
        if (!(det > parallel)) return false;
        shares[0] = (lacks(0) - c * lacks(1)) / det;
        shares[1] = (lacks(1) - c * lacks(0)) / det;
    } else {
        const glm::dvec3 a = planes[0]->normal, b = planes[1]->normal, c = planes[2]->normal;
        const glm::dvec3 bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
        const double det = glm::dot(a, bc);
        if (!(det * det > parallel)) return false;
        const glm::dvec3 off = (lacks(0) * bc + lacks(1) * ca + lacks(2) * ab) / det;
        // off = Σ share·normal, so each share is the part of it that is across the other two.
        shares[0] = glm::dot(off, bc) / det;
        shares[1] = glm::dot(off, ca) / det;
        shares[2] = glm::dot(off, ab) / det;
    }
    step = target;
    for (int k = 0; k < count; ++k) {
        if (!(shares[k] >= 0)) return false;
        step += shares[k] * planes[k]->normal;
    }
    return true;
}

/// The point of all half-spaces that is nearest to `target`. Where a half-space is missed by no more than `rounding` it counts
/// as kept. The half-space that is missed most joins up to three that hold the point, and a look at all choices of these four
/// tells which hold it then; the distance grows each time, so it ends.
template <Real T = double>
[[nodiscard]] PolyhedronPoint nearest_in_polyhedron(const glm::dvec3& target,
                                                    std::span<const HalfSpace> half_spaces,
                                                    double rounding) noexcept {
    PolyhedronPoint best;
    best.step = target;
    for (std::size_t turn = 0; turn < 4 * half_spaces.size() + 4; ++turn) {
        int worst = -1;
        double most = rounding;
        for (std::size_t k = 0; k < half_spaces.size(); ++k) {
            const double lacks = half_spaces[k].offset - glm::dot(half_spaces[k].normal, best.step);
            if (lacks > most) most = lacks, worst = static_cast<int>(k);
        }
        if (worst < 0) return best;

        // All that hold the point, and the new one last.
        int all[4];
        for (int k = 0; k < best.count; ++k) all[k] = best.faces[k];
        all[best.count] = worst;
        const int others = best.count;
        PolyhedronPoint next;
        next.found = false;
        for (unsigned chosen = 0; chosen < 1u << others && !next.found; ++chosen) {
            PolyhedronPoint trial;
            const HalfSpace* planes[3];
            const auto join = [&](int face) {
                trial.faces[trial.count] = face;
                planes[trial.count++] = &half_spaces[static_cast<std::size_t>(face)];
            };
            if (chosen == 7) continue; // four
            for (int k = 0; k < others; ++k) {
                if (chosen >> k & 1u) join(all[k]);
            }
            join(worst);
            if (!nearest_on_planes(target, planes, trial.count, trial.step, trial.shares)) continue;
            bool keeps = true;
            for (int k = 0; k < others; ++k) {
                const HalfSpace& other = half_spaces[static_cast<std::size_t>(all[k])];
                if (!(chosen >> k & 1u))
                    keeps = keeps && glm::dot(other.normal, trial.step) >= other.offset - rounding;
            }
            if (keeps) next = trial;
        }
        if (!next.found) break;
        best = next;
    }
    best.found = false;
    return best;
}

} // namespace hfh::detail

#endif // HFH_GEOMETRY_HALF_SPACES_HPP
