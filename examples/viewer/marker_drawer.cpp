#include "marker_drawer.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace viewer {
namespace {

constexpr const char* vertex_shader = R"(
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 direction;
uniform mat4 matrix, model;
out vec3 normal;
void main() {
    normal = normalize(mat3(model) * direction);
    gl_Position = matrix * model * vec4(place, 1.0);
}
)";

constexpr const char* fragment_shader = R"(
in vec3 normal;
uniform vec4 paint;
uniform vec3 light;
uniform float flat_paint;
out vec4 colour;
void main() {
    float lit = 0.62 + 0.38 * max(dot(normalize(normal), light), 0.0);
    colour = vec4(paint.rgb * mix(lit, 1.0, flat_paint), paint.a);
}
)";

glm::dmat4 placed(const glm::dvec3& at, const glm::dvec3& z, double radius, double length) noexcept {
    const glm::dvec3 helper = std::abs(z.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{1, 0, 0};
    const glm::dvec3 x = glm::normalize(glm::cross(helper, z)), y = glm::cross(z, x);
    return {glm::dvec4{x * radius, 0}, glm::dvec4{y * radius, 0}, glm::dvec4{z * length, 0},
            glm::dvec4{at, 1}};
}

} // namespace

MarkerDrawer::MarkerDrawer() : program_{vertex_shader, fragment_shader} {
    std::vector<glm::dvec2> circle, torus;
    for (int k = 0; k <= 12; ++k) {
        const double angle = std::numbers::pi * k / 12;
        circle.emplace_back(std::sin(angle), -std::cos(angle));
        torus.emplace_back(1 + 0.14 * std::cos(2 * angle), 0.14 * std::sin(2 * angle));
    }
    ball_ = lathe(circle);
    ring_ = lathe(torus);
    cylinder_ = lathe({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    cone_ = lathe({{0, 0}, {1, 0}, {0, 1}});
    pen_ = lathe({{0, 0}, {1, 0.24}, {1, 0.9}, {0.7, 1}, {0, 1}});
}

MarkerDrawer::Shape MarkerDrawer::lathe(const std::vector<glm::dvec2>& profile) {
    constexpr int sides = 20;
    std::vector<glm::vec3> vertices; // place, normal, …
    const auto put = [&](const glm::dvec2& p, const glm::dvec2& normal, int side) {
        const double angle = 2 * std::numbers::pi * side / sides;
        const glm::dvec2 around{std::cos(angle), std::sin(angle)};
        vertices.emplace_back(glm::dvec3{p.x * around, p.y});
        vertices.emplace_back(glm::dvec3{normal.x * around, normal.y});
    };
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
        const glm::dvec2 &a = profile[k], &b = profile[k + 1];
        const glm::dvec2 normal = glm::normalize(glm::dvec2{b.y - a.y, a.x - b.x});
        for (int side = 0; side < sides; ++side) {
            put(a, normal, side), put(a, normal, side + 1), put(b, normal, side + 1);
            put(a, normal, side), put(b, normal, side + 1), put(b, normal, side);
        }
    }
    Shape shape{make_vertex_array(), make_buffer(), static_cast<GLsizei>(vertices.size() / 2)};
    glBindVertexArray(shape.array.get());
    glBindBuffer(GL_ARRAY_BUFFER, shape.vertices.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(glm::vec3)),
                 vertices.data(), GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 2 * sizeof(glm::vec3), nullptr);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 2 * sizeof(glm::vec3),
                          reinterpret_cast<const void*>(sizeof(glm::vec3)));
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    glBindVertexArray(0);
    return shape;
}

void MarkerDrawer::draw_items(const std::vector<Item>& items, const Camera& camera, const glm::ivec2& size,
                              float outline, float alpha) {
    // Places are exaggerated with the ground, shapes are not.
    Camera plain = camera;
    plain.exaggeration = 1;
    program_.use();
    program_.set("matrix", glm::mat4{plain.matrix(size)});
    program_.set("light", glm::vec3{glm::normalize(glm::dvec3{-camera.right() * 0.5, 0.0} +
                                                   (camera.eye() - camera.target) / camera.distance)});
    program_.set("flat_paint", outline > 0 ? 1.0f : 0.0f);
    for (const Item& item : items) {
        if (alpha < 1 && !item.through_ground) continue;
        const auto rim = static_cast<double>(outline);
        glm::dvec3 at = item.at - rim * item.direction;
        if (item.shape == &ball_ || item.shape == &ring_) at = item.at;
        at.z = camera.target.z + camera.exaggeration * (at.z - camera.target.z);
        program_.set("model",
                     glm::mat4{placed(at, item.direction, item.radius + rim, item.length + 2 * rim)});
        program_.set("paint",
                     outline > 0 ? glm::vec4{0.05f, 0.05f, 0.07f, alpha} : glm::vec4{item.colour, alpha});
        glBindVertexArray(item.shape->array.get());
        glDrawArrays(GL_TRIANGLES, 0, item.shape->count);
    }
}

void MarkerDrawer::draw(const TouchMarkers& touch, const Camera& camera, const glm::ivec2& size) {
    const double pixel = camera.pixel_size(size) * touch.pixel;
    std::vector<Item> items;
    const glm::dvec3 lean = glm::normalize(glm::dvec3{camera.right() * 0.75 + camera.ahead() * 0.1, 0.62});
    items.push_back({&pen_, touch.stylus, lean, 5.5 * pixel, 90 * pixel, colours::stylus, true});
    items.push_back({&ball_, touch.stylus, {0, 0, 1}, 4 * pixel, 4 * pixel, colours::stylus, true});
    const double ball = std::max(touch.tip, proxy_radius * pixel);
    if (touch.touching || touch.tip > 0) {
        // Exaggerated with the ground, so that it rests on it.
        const double high = touch.tip > 0 ? ball * camera.exaggeration : ball;
        const glm::dvec3 middle = touch.touching ? touch.proxy : touch.stylus;
        items.push_back({&ball_, middle, {0, 0, 1}, ball, high, colours::proxy, true});
    }
    if (touch.touching) {
        const glm::dvec3 way = touch.proxy - touch.stylus;
        if (const double deep = glm::length(way); deep > 2 * pixel)
            items.push_back({&cylinder_, touch.stylus, way / deep, 1.2 * pixel, deep, colours::proxy, true});
        const double newtons = glm::length(touch.newtons), length = newtons * metres_per_newton;
        if (length > 6 * pixel) {
            const glm::dvec3 ahead = touch.newtons / newtons;
            const double head = std::min(14 * pixel, 0.6 * length);
            items.push_back(
                {&cylinder_, touch.proxy, ahead, 2.4 * pixel, length - head, colours::force, true});
            items.push_back({&cone_, touch.proxy + ahead * (length - head), ahead, 6.5 * pixel, head,
                             colours::force, true});
        }
    } else if (touch.over_ground) {
        // Where the stylus would touch down: a ring on the ground, and a line down to it.
        items.push_back({&ring_, touch.proxy, touch.normal, 7 * pixel, 7 * pixel, colours::proxy, false});
        const glm::dvec3 way = touch.proxy - touch.stylus;
        if (const double high = glm::length(way); high > 2 * pixel)
            items.push_back(
                {&cylinder_, touch.stylus, way / high, 0.8 * pixel, high, colours::wanted, false});
    }
    const float outline = static_cast<float>(1.5 * pixel);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    draw_items(items, camera, size, 0.0f, 0.6f);
    glDisable(GL_BLEND);
    glDepthFunc(GL_LEQUAL);
    // Rims first, without depth, so that they come behind all else.
    draw_items(items, camera, size, outline, 1.0f);
    glDepthMask(GL_TRUE);
    draw_items(items, camera, size, 0.0f, 1.0f);
    glBindVertexArray(0);
}

} // namespace viewer
