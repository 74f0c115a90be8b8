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

/// Where the vertices of a block are, in metres of terrain.
struct Box {
    glm::dvec3 low{0.0}, high{0.0};
    [[nodiscard]] bool is_empty() const noexcept { return high.x <= low.x || high.y <= low.y; }
};

Box box_of(const LoadedLevel& level, const WindowIndices::Block& block, const DisplayedTerrain& terrain,
           int n) {
    const auto place = [&](int a, int b) {
        const double step = std::exp2(level.level);
        const glm::dvec2 sample = step * glm::dvec2{static_cast<double>(level.origin.i + a),
                                                    static_cast<double>(level.origin.j + b)};
        return terrain.spacing * glm::clamp(sample, glm::dvec2{0.0},
                                            glm::dvec2{static_cast<double>(terrain.columns - 1),
                                                       static_cast<double>(terrain.rows - 1)});
    };
    Box box{{place(block.begin.x, block.begin.y), 1e300}, {place(block.end.x, block.end.y), -1e300}};
    if (box.is_empty()) return box;
    for (int b = block.begin.y; b <= block.end.y; ++b) {
        for (int a = block.begin.x; a <= block.end.x; ++a) {
            const LevelVertex& v = level.vertices[static_cast<std::size_t>(b * n + a)];
            box.low.z =
                std::min({box.low.z, static_cast<double>(v.height), static_cast<double>(v.coarse_height)});
            box.high.z =
                std::max({box.high.z, static_cast<double>(v.height), static_cast<double>(v.coarse_height)});
        }
    }
    box.low.z += terrain.datum;
    box.high.z += terrain.datum;
    return box;
}

/// False if all of the box is beyond one side of the picture.
bool may_be_seen(const Box& box, const TerrainView& view, const glm::dmat4& matrix) noexcept {
    unsigned beyond_all = 0x3f;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point{(corner & 1 ? box.high : box.low).x, (corner & 2 ? box.high : box.low).y,
                               (corner & 4 ? box.high : box.low).z};
        const glm::dvec4 at = matrix * glm::dvec4{(point - view.offset) / view.scale, 1};
        unsigned beyond = 0;
        for (int axis = 0; axis < 3; ++axis) {
            beyond |= at[axis] < -at.w ? 1u << (2 * axis) : 0u;
            beyond |= at[axis] > at.w ? 2u << (2 * axis) : 0u;
        }
        beyond_all &= beyond;
    }
    return beyond_all == 0;
}

} // namespace

TerrainDrawer::TerrainDrawer(const DisplayedTerrain& terrain, int n)
    : terrain_{&terrain}, n_{n}, program_{terrain_vertex_shader, terrain_fragment_shader},
      palette_{make_texture()}, indices_{n} {}

void TerrainDrawer::upload(const LoadedLevel& level, OnCard& card, DrawnTerrain& drawn) {
    if (card.used && card.version == level.version) return;
    const auto bytes = static_cast<GLsizeiptr>(level.vertices.size() * sizeof(LevelVertex));
    if (!card.used) {
        card.array = make_vertex_array();
        card.vertices = make_buffer();
        glBindVertexArray(card.array.get());
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.buffer());
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
    const int felt = levels.levels[innermost(levels, view.level)]->level;
    program_.set("last_felt", glm::ivec2{static_cast<int>((terrain_->columns - 1) >> felt << felt),
                                         static_cast<int>((terrain_->rows - 1) >> felt << felt)});
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

void TerrainDrawer::make_palette(std::size_t palette) {
    std::array<glm::vec3, 256> colours{};
    for (std::size_t k = 0; k < colours.size(); ++k)
        colours[k] = palettes[palette].at(static_cast<float>(k) / 255.0f);
    glBindTexture(GL_TEXTURE_1D, palette_.get());
    glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, 256, 0, GL_RGB, GL_FLOAT, colours.data());
    glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    palette_made_ = palette;
}

/// Those blocks that may be in the picture.
void TerrainDrawer::draw_window(const LoadedLevel& level, const std::vector<WindowIndices::Block>& blocks,
                                const TerrainView& view, const glm::ivec2& size, DrawnTerrain& drawn) {
    const glm::dmat4 matrix = view.camera.matrix(size);
    std::vector<GLsizei> counts;
    std::vector<const void*> starts;
    for (const WindowIndices::Block& block : blocks) {
        const Box box = box_of(level, block, *terrain_, n_);
        if (box.is_empty() || !may_be_seen(box, view, matrix)) continue;
        counts.push_back(block.count);
        starts.push_back(reinterpret_cast<const void*>(block.first * sizeof(GLuint)));
        drawn.triangles += static_cast<std::uint64_t>(block.count / 3);
    }
    glBindVertexArray(cards_[static_cast<std::size_t>(level.level)].array.get());
    glMultiDrawElements(GL_TRIANGLES, counts.data(), GL_UNSIGNED_INT, starts.data(),
                        static_cast<GLsizei>(counts.size()));
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
    if (palette_made_ != view.look.palette) make_palette(view.look.palette);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_1D, palette_.get());
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    set_uniforms(levels, view, size);

    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_CLIP_DISTANCE1);
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
        const hfh::Index first = (n_ - 3) / 4;
        const hfh::Index x = finer.i / 2 - level.origin.i - first, y = finer.j / 2 - level.origin.j - first;
        draw_window(level,
                    k > first_level ? indices_.ring(static_cast<int>(x), static_cast<int>(y))
                                    : indices_.whole(),
                    view, size, drawn);
        finer = level.origin;
    }
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_CLIP_DISTANCE1);
    glBindVertexArray(0);
    return drawn;
}

std::size_t TerrainDrawer::card_bytes() const noexcept {
    const auto used =
        static_cast<std::size_t>(std::ranges::count_if(cards_, [](const OnCard& c) { return c.used; }));
    return used * static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_) * sizeof(LevelVertex) +
           indices_.bytes();
}

} // namespace viewer
