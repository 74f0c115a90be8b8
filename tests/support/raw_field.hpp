#ifndef HFH_TESTS_SUPPORT_RAW_FIELD_HPP
#define HFH_TESTS_SUPPORT_RAW_FIELD_HPP

#include "terrains.hpp"

#include <hfh/terrain/height_field.hpp>

namespace hfh::test {

/// A field of a user's own that breaks its contract: what its samples hold comes out as heights, NaN, infinity and numbers
/// without squares included.
template <Real T>
class RawField {
public:
    using Scalar = T;

    explicit RawField(const Terrain<T>& terrain) noexcept : terrain_{&terrain} {}

    [[nodiscard]] Lattice lattice() const noexcept {
        return {terrain_->frame.origin, terrain_->frame.spacing};
    }
    [[nodiscard]] CellRange cells() const noexcept {
        return {{0, 0}, {terrain_->columns - 1, terrain_->rows - 1}};
    }
    [[nodiscard]] std::optional<BilinearPatch<T>> patch(Cell c) const noexcept {
        if (!cells().contains(c)) return {};
        return BilinearPatch<T>{terrain_->at(c.i, c.j), terrain_->at(c.i + 1, c.j),
                                terrain_->at(c.i, c.j + 1), terrain_->at(c.i + 1, c.j + 1),
                                vec2<T>{terrain_->frame.spacing}};
    }

private:
    const Terrain<T>* terrain_;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_RAW_FIELD_HPP
