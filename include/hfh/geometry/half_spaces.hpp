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
/// normals. False where the normals do not tell the planes apart.
template <Real T = double>
[[nodiscard]] bool nearest_on_planes(const glm::dvec3& target, const HalfSpace* const planes[], int count,
                                     glm::dvec3& step, double shares[]) noexcept {
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
    for (int k = 0; k < count; ++k) step += shares[k] * planes[k]->normal;
    return true;
}

/// The half-space that a vector misses most, and by more than `rounding`; −1: it keeps all.
template <Real T = double>
[[nodiscard]] int most_missed(std::span<const HalfSpace> half_spaces, const glm::dvec3& step,
                              double rounding) noexcept {
    int worst = -1;
    double most = rounding;
    for (std::size_t k = 0; k < half_spaces.size(); ++k) {
        const double lacks = half_spaces[k].offset - glm::dot(half_spaces[k].normal, step);
        if (lacks > most) most = lacks, worst = static_cast<int>(k);
    }
    return worst;
}

/// The nearest point of four half-spaces at most: those that hold `before`, and a new one, which holds this one as well.
template <Real T = double>
[[nodiscard]] PolyhedronPoint add_half_space(const glm::dvec3& target, std::span<const HalfSpace> half_spaces,
                                             const PolyhedronPoint& before, int added,
                                             double rounding) noexcept {
    const auto half_space = [&](int face) { return &half_spaces[static_cast<std::size_t>(face)]; };
    constexpr unsigned all_three = 7;
    for (unsigned chosen = 0; chosen < 1u << before.count && chosen < all_three; ++chosen) {
        const auto is_chosen = [chosen](int k) { return (chosen >> k & 1u) != 0; };
        PolyhedronPoint trial;
        const HalfSpace* planes[3];
        const auto join = [&](int face) {
            trial.faces[trial.count] = face;
            planes[trial.count++] = half_space(face);
        };
        for (int k = 0; k < before.count; ++k) {
            if (is_chosen(k)) join(before.faces[k]);
        }
        join(added);
        bool keeps = nearest_on_planes(target, planes, trial.count, trial.step, trial.shares);
        for (int k = 0; k < trial.count; ++k) keeps = keeps && trial.shares[k] >= 0;
        for (int k = 0; k < before.count; ++k) {
            const HalfSpace& other = *half_space(before.faces[k]);
            keeps = keeps && (is_chosen(k) || glm::dot(other.normal, trial.step) >= other.offset - rounding);
        }
        if (keeps) return trial;
    }
    PolyhedronPoint none = before;
    none.found = false;
    return none;
}

/// The point of all half-spaces that is nearest to `target`. Where a half-space is missed by no more than `rounding` it counts
/// as kept. The half-space that is missed most joins up to three that hold the point, until none is missed; the distance grows
/// each time, so it ends.
template <Real T = double>
[[nodiscard]] PolyhedronPoint nearest_in_polyhedron(const glm::dvec3& target,
                                                    std::span<const HalfSpace> half_spaces,
                                                    double rounding) noexcept {
    PolyhedronPoint best;
    best.step = target;
    for (std::size_t turn = 0; turn < 4 * half_spaces.size() + 4 && best.found; ++turn) {
        const int worst = most_missed(half_spaces, best.step, rounding);
        if (worst < 0) return best;
        best = add_half_space(target, half_spaces, best, worst, rounding);
    }
    best.found = false;
    return best;
}

} // namespace hfh::detail

#endif // HFH_GEOMETRY_HALF_SPACES_HPP
