#ifndef VIEWER_WINDOW_INDICES_HPP
#define VIEWER_WINDOW_INDICES_HPP

#include "gl_objects.hpp"

#include <array>
#include <vector>

namespace viewer {

/// The triangles of a window of n × n vertices in an order that all windows share: with all cells, or with a hole in the middle
/// for the next finer one. In blocks of some cells, so that what is out of the picture is left out.
class WindowIndices {
public:
    /// The triangles of cells (a, b) with begin ≤ (a, b) < end.
    struct Block {
        std::size_t first = 0; ///< index
        GLsizei count = 0;
        glm::ivec2 begin{0}, end{0};
    };

    static constexpr int block_cells = 16; ///< along a side; an even number

    /// n = 4·m − 1.
    explicit WindowIndices(int n);

    [[nodiscard]] GLuint buffer() const noexcept { return buffer_.get(); }
    [[nodiscard]] std::size_t bytes() const noexcept { return count_ * sizeof(GLuint); }

    [[nodiscard]] const std::vector<Block>& whole() const noexcept { return whole_; }
    /// With a hole that begins at cell ((n − 3)/4 + x, (n − 3)/4 + y); x and y are 0 or 1.
    [[nodiscard]] const std::vector<Block>& ring(int x, int y) const noexcept {
        return rings_[static_cast<std::size_t>(2 * y + x)];
    }

private:
    [[nodiscard]] std::vector<Block> blocks(const glm::ivec2& hole, int hole_cells,
                                            std::vector<GLuint>& indices) const;

    int n_;
    GlBuffer buffer_;
    std::size_t count_ = 0;
    std::vector<Block> whole_;
    std::array<std::vector<Block>, 4> rings_;
};

} // namespace viewer

#endif // VIEWER_WINDOW_INDICES_HPP
