#include "window_indices.hpp"

#include <algorithm>

namespace viewer {
namespace {

/// The triangles of a block of a window, and what it has in common with others.
class BlockIndices {
public:
    BlockIndices(int n, std::vector<GLuint>& indices) : n_{static_cast<GLuint>(n)}, indices_{&indices} {}

    /// The last corner of a triangle says whether its cell exists: it is the south-western one of the cell.
    void add_cell(GLuint a, GLuint b) {
        const GLuint v00 = b * n_ + a, v10 = v00 + 1, v01 = v00 + n_, v11 = v01 + 1;
        indices_->insert(indices_->end(), {v10, v11, v00, v11, v01, v00});
    }
    /// Triangles without area along the border of the window, if the block is there: they close the pin-holes that rounding
    /// leaves beside the next coarser window.
    void add_seams(const WindowIndices::Block& block) {
        const auto a0 = static_cast<GLuint>(block.begin.x), a1 = static_cast<GLuint>(block.end.x),
                   b0 = static_cast<GLuint>(block.begin.y), b1 = static_cast<GLuint>(block.end.y);
        for (GLuint a = a0; a < a1; a += 2) {
            if (b0 == 0) add_seam(a, 1);
            if (b1 == n_ - 1) add_seam(b1 * n_ + a, 1);
        }
        for (GLuint b = b0; b < b1; b += 2) {
            if (a0 == 0) add_seam(b * n_, n_);
            if (a1 == n_ - 1) add_seam(b * n_ + a1, n_);
        }
    }

private:
    void add_seam(GLuint from, GLuint step) {
        indices_->insert(indices_->end(), {from + step, from + 2 * step, from});
    }

    GLuint n_;
    std::vector<GLuint>* indices_;
};

} // namespace

WindowIndices::WindowIndices(int n) : n_{n}, buffer_{make_buffer()} {
    std::vector<GLuint> indices;
    const int half = (n - 1) / 2, first = (n - 3) / 4;
    whole_ = blocks({0, 0}, 0, indices);
    for (int k = 0; k < 4; ++k)
        rings_[static_cast<std::size_t>(k)] = blocks({first + k % 2, first + k / 2}, half, indices);
    count_ = indices.size();
    glBindVertexArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes()), indices.data(), GL_STATIC_DRAW);
}

std::vector<WindowIndices::Block> WindowIndices::blocks(const glm::ivec2& hole, int hole_cells,
                                                        std::vector<GLuint>& indices) const {
    std::vector<Block> blocks;
    BlockIndices out{n_, indices};
    const auto in_hole = [&](int a, int b) {
        return a >= hole.x && a < hole.x + hole_cells && b >= hole.y && b < hole.y + hole_cells;
    };
    for (int b0 = 0; b0 < n_ - 1; b0 += block_cells) {
        for (int a0 = 0; a0 < n_ - 1; a0 += block_cells) {
            Block block{indices.size(),
                        0,
                        {a0, b0},
                        {std::min(a0 + block_cells, n_ - 1), std::min(b0 + block_cells, n_ - 1)}};
            for (int b = b0; b < block.end.y; ++b)
                for (int a = a0; a < block.end.x; ++a)
                    if (!in_hole(a, b)) out.add_cell(static_cast<GLuint>(a), static_cast<GLuint>(b));
            out.add_seams(block);
            block.count = static_cast<GLsizei>(indices.size() - block.first);
            if (block.count > 0) blocks.push_back(block);
        }
    }
    return blocks;
}

} // namespace viewer
