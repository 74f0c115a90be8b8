#ifndef HFH_TESTS_SUPPORT_COUNTING_FIELD_HPP
#define HFH_TESTS_SUPPORT_COUNTING_FIELD_HPP

#include <hfh/terrain/height_field.hpp>

namespace hfh::test {

/// A field that counts how often it is asked for heights: what an update really looks at, whatever it says itself. A look
/// at six corners is one look, as one at a patch is.
template <HeightField Field>
class CountingField {
public:
    using Scalar = typename Field::Scalar;

    explicit CountingField(const Field& field) noexcept : field_{&field} {}
    CountingField(const Field&&) = delete; // the field must outlive it

    [[nodiscard]] auto lattice() const noexcept { return field_->lattice(); }
    [[nodiscard]] CellRange cells() const noexcept { return field_->cells(); }
    [[nodiscard]] std::optional<BilinearPatch<Scalar>> patch(Cell cell) const noexcept {
        ++looks_;
        return field_->patch(cell);
    }
    [[nodiscard]] bool corners_below(const Vertex (&corners)[6],
                                     Scalar z) const noexcept requires CorneredHeightField<Field> {
        ++looks_;
        return field_->corners_below(corners, z);
    }

    [[nodiscard]] long looks() const noexcept { return looks_; }
    void forget_looks() noexcept { looks_ = 0; }

private:
    const Field* field_;
    mutable long looks_ = 0;
};

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_COUNTING_FIELD_HPP
