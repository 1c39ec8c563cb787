#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Path-space filter in screen space (Meijer 2019, SSPSF): the mean irradiance of 9x9 pixels that see about the same surface. In:
// irradiance. Out: the same, filtered.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D irradiance;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D filtered;

layout(push_constant) uniform Push { float spread; } push; // of a pixel, over a distance of 1

const int RADIUS = 4;
// Least cosine between normals, and pixel footprints off the plane for each pixel between, of one surface.
const float SAME_NORMAL = 0.95;
const float SAME_PLANE = 1.0;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface centre = surface_at(pixel);
    vec4 own = imageLoad(irradiance, pixel);
    vec3 sum = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < (2 * RADIUS + 1) * (2 * RADIUS + 1); i++) {
        ivec2 offset = ivec2(i % (2 * RADIUS + 1), i / (2 * RADIUS + 1)) - RADIUS;
        ivec2 at = pixel + offset;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        Surface other = surface_at(at);
        if (other.depth == 0.0 || dot(other.shading, centre.shading) < SAME_NORMAL) continue;
        float tolerance = SAME_PLANE * push.spread * centre.depth * (1.0 + length(vec2(offset)));
        if (abs(dot(other.position - centre.position, centre.geometric)) > tolerance) continue;
        sum += imageLoad(irradiance, at).rgb;
        count += 1.0;
    }
    bool is_filtered = centre.depth > 0.0 && count > 0.0;
    imageStore(filtered, pixel, storable(vec4(is_filtered ? sum / count : own.rgb, own.a)));
}
