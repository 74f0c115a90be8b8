#include "terrain_drawer.hpp"

#include "terrain_shaders.hpp"

#include <glm/ext/vector_int2.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

/// Of a window, from its border inwards: where the blend goes from 0 to 1.
double morph_width(int n) noexcept { return std::max(2.0, n / 10.0); }

/// For slopes of 0.45 in the mean, which shade well.
float fitting_relief(float steepness) noexcept {
    return std::clamp(0.45f / std::max(steepness, 1e-4f), 0.6f, 25.0f);
}

/// A direction that the eye would call so: right of where it looks, and up.
glm::vec3 light_from(const Camera& camera, double azimuth, double elevation) noexcept {
    const double at = camera.azimuth + azimuth;
    return glm::vec3{glm::dvec3{std::sin(at) * std::cos(elevation), std::cos(at) * std::cos(elevation),
                                std::sin(elevation)}};
}

/// Where in the levels the innermost window is: that of the hand's level, if it is there.
std::size_t innermost(const LoadedLevels& levels, double hand_level) noexcept {
    const int wanted = static_cast<int>(std::floor(hand_level)) - levels.levels.front()->level;
    return static_cast<std::size_t>(std::clamp(wanted, 0, static_cast<int>(levels.levels.size()) - 1));
}

} // namespace

TerrainDrawer::TerrainDrawer(const DisplayedTerrain& terrain, int n)
    : terrain_{&terrain}, n_{n}, program_{terrain_vertex_shader, terrain_fragment_shader},
      palette_{make_texture()}, indices_{make_buffer()} {
    make_indices();
}

void TerrainDrawer::make_indices() {
    const auto n = static_cast<GLuint>(n_);
    std::vector<GLuint> indices;
    // The last corner of a triangle says whether its cell exists: it is the south-western one of the cell.
    const auto add_cell = [&](GLuint a, GLuint b) {
        const GLuint v00 = b * n + a, v10 = v00 + 1, v01 = v00 + n, v11 = v01 + 1;
        indices.insert(indices.end(), {v10, v11, v00, v11, v01, v00});
    };
    // Triangles without area along the border: they close the pin-holes that rounding leaves beside the next coarser window.
    const auto add_seams = [&] {
        for (GLuint k = 0; k + 2 < n; k += 2) {
            for (const auto& [from, step] :
                 {std::pair{k, 1u}, {(n - 1) * n + k, 1u}, {k * n, n}, {k * n + n - 1, n}})
                indices.insert(indices.end(), {from + step, from + 2 * step, from});
        }
    };
    const auto add_piece = [&](Piece& piece, GLuint hole_a, GLuint hole_b, GLuint hole) {
        piece.first = indices.size();
        for (GLuint b = 0; b + 1 < n; ++b) {
            for (GLuint a = 0; a + 1 < n; ++a) {
                const bool inside = a >= hole_a && a < hole_a + hole && b >= hole_b && b < hole_b + hole;
                if (!inside) add_cell(a, b);
            }
        }
        add_seams();
        piece.count = static_cast<GLsizei>(indices.size() - piece.first);
    };
    const GLuint half = (n - 1) / 2, first = (n - 3) / 4;
    add_piece(whole_, 0, 0, 0);
    for (GLuint x = 0; x < 2; ++x)
        for (GLuint y = 0; y < 2; ++y) add_piece(rings_[x][y], first + x, first + y, half);
    index_count_ = indices.size();
    glBindVertexArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(GLuint)),
                 indices.data(), GL_STATIC_DRAW);
}

void TerrainDrawer::upload(const LoadedLevel& level, OnCard& card, DrawnTerrain& drawn) {
    if (card.used && card.version == level.version) return;
    const auto bytes = static_cast<GLsizeiptr>(level.vertices.size() * sizeof(LevelVertex));
    if (!card.used) {
        card.array = make_vertex_array();
        card.vertices = make_buffer();
        glBindVertexArray(card.array.get());
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.get());
        glBindBuffer(GL_ARRAY_BUFFER, card.vertices.get());
        const auto at = [](std::size_t offset) { return reinterpret_cast<const void*>(offset); };
        glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(LevelVertex),
                              at(offsetof(LevelVertex, height)));
        glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(LevelVertex),
                              at(offsetof(LevelVertex, slope)));
        glEnableVertexAttribArray(0);
        glEnableVertexAttribArray(1);
    }
    glBindBuffer(GL_ARRAY_BUFFER, card.vertices.get());
    glBufferData(GL_ARRAY_BUFFER, bytes, level.vertices.data(), GL_DYNAMIC_DRAW);
    card.version = level.version;
    card.used = true;
    drawn.uploaded_vertices += level.vertices.size();
}

double TerrainDrawer::blend(const LoadedLevels& levels, int level, const glm::dvec2& from_middle,
                            double hand_level) const noexcept {
    const double width = morph_width(n_), inner = 0.5 * (n_ - 1) - 2 - width;
    const double away = std::max(std::abs(from_middle.x), std::abs(from_middle.y)) - inner;
    const double morph = std::clamp(away / width, 0.0, 1.0);
    const bool is_first = level == levels.levels[innermost(levels, hand_level)]->level;
    return is_first ? std::max(std::clamp(hand_level - level, 0.0, 1.0), morph) : morph;
}

void TerrainDrawer::set_uniforms(const LoadedLevels& levels, const TerrainView& view,
                                 const glm::ivec2& size) {
    const Look& look = view.look;
    program_.use();
    program_.set("n", n_);
    program_.set("last",
                 glm::ivec2{static_cast<int>(terrain_->columns - 1), static_cast<int>(terrain_->rows - 1)});
    const hfh::Cell reference{static_cast<hfh::Index>(levels.place.x),
                              static_cast<hfh::Index>(levels.place.y)};
    program_.set("reference", glm::ivec2{static_cast<int>(reference.i), static_cast<int>(reference.j)});
    const glm::dvec3 at{static_cast<double>(reference.i) * terrain_->spacing.x,
                        static_cast<double>(reference.j) * terrain_->spacing.y, terrain_->datum};
    program_.set("spacing", glm::vec2{terrain_->spacing});
    program_.set("reference_at_hand", glm::vec3{(at - view.offset) / view.scale});
    program_.set("to_hand", static_cast<float>(1 / view.scale));
    program_.set("matrix", glm::mat4{view.camera.matrix(size)});
    program_.set("morph_width", static_cast<float>(morph_width(n_)));
    program_.set("palette", 0);
    program_.set("tints", view.tints);
    const double exaggeration = view.camera.exaggeration;
    program_.set("relief", fitting_relief(levels.steepness) *
                               static_cast<float>(look.relief * std::sqrt(exaggeration)));
    program_.set("light", light_from(view.camera, look.light_azimuth, look.light_elevation));
    program_.set("fill_light", light_from(view.camera, look.light_azimuth + 2.4, 0.6));
    program_.set("contour_interval", look.contours ? static_cast<float>(view.contour_interval) : 0.0f);
    const double datum = terrain_->datum / (5 * view.contour_interval);
    program_.set("datum_in_intervals", static_cast<float>(5 * (datum - std::floor(datum))));
}

DrawnTerrain TerrainDrawer::draw(const LoadedLevels& levels, const TerrainView& view,
                                 const glm::ivec2& size) {
    DrawnTerrain drawn;
    const std::size_t first_level = innermost(levels, view.level);
    drawn.level = std::max(view.level, static_cast<double>(levels.levels[first_level]->level));
    for (const auto& level : levels.levels) {
        if (cards_.size() <= static_cast<std::size_t>(level->level))
            cards_.resize(static_cast<std::size_t>(level->level) + 1);
        upload(*level, cards_[static_cast<std::size_t>(level->level)], drawn);
    }
    if (palette_made_ != view.look.palette) {
        std::array<glm::vec3, 256> colours{};
        for (std::size_t k = 0; k < colours.size(); ++k)
            colours[k] = palettes[view.look.palette].at(static_cast<float>(k) / 255.0f);
        glBindTexture(GL_TEXTURE_1D, palette_.get());
        glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, 256, 0, GL_RGB, GL_FLOAT, colours.data());
        glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        palette_made_ = view.look.palette;
    }
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_1D, palette_.get());
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    set_uniforms(levels, view, size);

    hfh::Cell finer{};
    for (std::size_t k = first_level; k < levels.levels.size(); ++k) {
        const LoadedLevel& level = *levels.levels[k];
        const double vertex = std::exp2(level.level);
        program_.set("origin",
                     glm::ivec2{static_cast<int>(level.origin.i), static_cast<int>(level.origin.j)});
        program_.set("level", level.level);
        program_.set("middle",
                     glm::vec2{levels.place / vertex - glm::dvec2{static_cast<double>(level.origin.i),
                                                                  static_cast<double>(level.origin.j)}});
        program_.set("least_blend", k == first_level
                                        ? static_cast<float>(std::clamp(view.level - level.level, 0.0, 1.0))
                                        : 0.0f);
        const double pixels = vertex * terrain_->spacing.x / view.scale / view.camera.pixel_size(size);
        program_.set("cell_lines", view.look.cells && k == first_level
                                       ? static_cast<float>(std::clamp((pixels - 24) / 24, 0.0, 1.0))
                                       : 0.0f);
        Piece piece = whole_;
        if (k > first_level) {
            const hfh::Index first = (n_ - 3) / 4;
            const hfh::Index x = finer.i / 2 - level.origin.i - first,
                             y = finer.j / 2 - level.origin.j - first;
            piece = rings_[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)];
        }
        glBindVertexArray(cards_[static_cast<std::size_t>(level.level)].array.get());
        glDrawElements(GL_TRIANGLES, piece.count, GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(piece.first * sizeof(GLuint)));
        drawn.triangles += static_cast<std::uint64_t>(piece.count / 3);
        finer = level.origin;
    }
    glBindVertexArray(0);
    return drawn;
}

std::size_t TerrainDrawer::card_bytes() const noexcept {
    const auto used =
        static_cast<std::size_t>(std::ranges::count_if(cards_, [](const OnCard& c) { return c.used; }));
    return used * static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_) * sizeof(LevelVertex) +
           index_count_ * sizeof(GLuint);
}

} // namespace viewer
