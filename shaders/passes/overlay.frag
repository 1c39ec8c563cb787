#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lines and points over the picture: round ends, smooth edges; parts that surfaces in the picture hide are dimmed.
#include "frame.glsl"

layout(location = 0) in flat vec4 ends_px;
layout(location = 1) in flat vec2 inverse_depths;
layout(location = 2) in flat vec4 colour;
layout(location = 3) in flat vec2 radius_hidden;

layout(set = 0, binding = 2) uniform texture2D gbuffer_depth;

layout(location = 0) out vec4 out_colour;

// A point this much deeper than the surface still lies on it.
const float ON_SURFACE = 1.01;

void main() {
    // The nearest point of the line's axis; one over depth is linear in pixels.
    vec2 along = ends_px.zw - ends_px.xy;
    float part = clamp(dot(gl_FragCoord.xy - ends_px.xy, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
    vec2 axis = ends_px.xy + part * along;
    float cover = clamp(radius_hidden.x + 0.5 - distance(gl_FragCoord.xy, axis), 0.0, 1.0);
    float depth = 1.0 / mix(inverse_depths.x, inverse_depths.y, part);
    ivec2 pixel = clamp(ivec2(floor(axis)), ivec2(0), ivec2(frame.size) - 1);
    float surface = texelFetch(gbuffer_depth, pixel, 0).r;
    bool hidden = surface > 0.0 && depth > surface * ON_SURFACE;
    out_colour = vec4(colour.rgb, colour.a * cover * (hidden ? radius_hidden.y : 1.0));
}
