#ifndef VIEWER_TERRAIN_SHADERS_HPP
#define VIEWER_TERRAIN_SHADERS_HPP

namespace viewer {

inline constexpr const char* terrain_vertex_shader = R"(
layout(location = 0) in vec2 heights;      // of this level and of the next coarser one, m above the datum
layout(location = 1) in vec4 slopes;       // x, y of this level; x, y of the next coarser one
uniform int n;
uniform ivec2 origin;                      // of the window, in vertices of its level
uniform int level;
uniform ivec2 last;                        // sample
uniform ivec2 last_felt;                   // sample: the hand's level reaches so far
uniform ivec2 reference;                   // sample near the middle of the picture
uniform vec2 spacing;                      // m
uniform vec3 reference_at_hand;            // m at the hand
uniform float to_hand;                     // m at the hand in a metre of terrain
uniform mat4 matrix;
uniform vec2 middle;                       // of the windows, in vertices of the window from its origin
uniform float least_blend;
uniform float morph_width;                 // vertices
out float height;
out vec2 slope;
out vec2 cell;
flat out float exists;
out float gl_ClipDistance[2];

void main() {
    ivec2 vertex = ivec2(gl_VertexID % n, gl_VertexID / n);
    ivec2 at = clamp((origin + vertex) << level, ivec2(0), last);
    vec2 away = abs(vec2(vertex) - middle) - (0.5 * float(n - 1) - 2.0 - morph_width);
    float blend = max(least_blend, clamp(max(away.x, away.y) / morph_width, 0.0, 1.0));
    exists = slopes.w < 5e8 ? 1.0 : 0.0;
    vec2 coarse_slope = vec2(slopes.z, exists > 0.5 ? slopes.w : slopes.y);
    height = mix(heights.x, heights.y, blend);
    slope = mix(slopes.xy, coarse_slope, blend);
    cell = vec2(vertex);
    vec3 place = vec3(vec2(at - reference) * spacing, height) * to_hand + reference_at_hand;
    gl_Position = matrix * vec4(place, 1.0);
    gl_ClipDistance[0] = float(last_felt.x - at.x);
    gl_ClipDistance[1] = float(last_felt.y - at.y);
}
)";

inline constexpr const char* terrain_fragment_shader = R"(
in float height;
in vec2 slope;
in vec2 cell;
flat in float exists;
uniform sampler1D palette;
uniform vec2 tints;                        // lowest and highest height, m above the datum
uniform float relief;
uniform vec3 light, fill_light;
uniform float contour_interval;            // 0: none
uniform float datum_in_intervals;          // the fraction of the datum, in contour intervals
uniform float cell_lines;                  // 0 to 1
out vec4 colour;

// 1 on a line at whole numbers of x, 0 a pixel beside it. None where lines would be too close, or x hardly changes.
float line(float x, float width) {
    float change = max(fwidth(x), 1e-6);
    float away = abs(fract(x - 0.5) - 0.5) / change;
    return clamp(width + 0.5 - away, 0.0, 1.0) * clamp(1.4 - 3.0 * change, 0.0, 1.0) *
           clamp(3000.0 * change, 0.0, 1.0);
}

void main() {
    if (exists < 0.5) discard;
    vec3 normal = normalize(vec3(-slope * relief, 1.0));
    float lit = max(dot(normal, light), 0.0);
    float filled = max(dot(normal, fill_light), 0.0);
    float shade = 0.26 + 0.80 * lit + 0.28 * filled;
    vec3 tint = texture(palette, (height - tints.x) / max(tints.y - tints.x, 1e-6)).rgb;
    vec3 ground = tint * shade;
    if (contour_interval > 0.0) {
        float x = height / contour_interval + datum_in_intervals;
        float strength = max(0.30 * line(x, 0.5), 0.50 * line(x / 5.0, 1.0));
        ground = mix(ground, vec3(0.13, 0.09, 0.05), strength);
    }
    if (cell_lines > 0.0) {
        float grid = max(line(cell.x, 0.5), line(cell.y, 0.5));
        ground = mix(ground, vec3(0.06, 0.10, 0.22), 0.30 * cell_lines * grid);
    }
    ground = clamp(ground, 0.0, 1.0);
    colour = vec4(ground * (1.25 - 0.25 * ground), 1.0); // midtones a little lighter
}
)";

} // namespace viewer

#endif // VIEWER_TERRAIN_SHADERS_HPP
