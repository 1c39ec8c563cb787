#version 460
#extension GL_GOOGLE_include_directive : require
// Lines and points over the picture: a rectangle of pixels about each line, with room for its round ends.
#include "frame.glsl"
#include "overlay.glsl"

layout(set = 0, binding = 1, std430) readonly buffer LineBlock { OverlayLine data[]; } lines;

layout(location = 0) out flat vec4 ends_px;
layout(location = 1) out flat vec2 inverse_depths;
layout(location = 2) out flat vec4 colour;
layout(location = 3) out flat vec2 radius_hidden;

vec2 pixels(vec4 clip) { return (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.size); }

void main() {
    OverlayLine line = lines.data[gl_InstanceIndex];
    vec4 from = frame.view_projection * vec4(line.from_width.xyz, 1.0);
    vec4 to = frame.view_projection * vec4(line.to_hidden.xyz, 1.0);
    // Cut off what lies before the near plane, where z is w: depth is reversed.
    float from_inside = from.w - from.z;
    float to_inside = to.w - to.z;
    gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    if (from_inside <= 0.0 && to_inside <= 0.0) return;
    if (from_inside < 0.0) from = mix(from, to, from_inside / (from_inside - to_inside));
    else if (to_inside < 0.0) to = mix(to, from, to_inside / (to_inside - from_inside));

    ends_px = vec4(pixels(from), pixels(to));
    inverse_depths = 1.0 / vec2(from.w, to.w);
    colour = line.colour;
    radius_hidden = vec2(0.5 * line.from_width.w, line.to_hidden.w);
    vec2 along = ends_px.zw - ends_px.xy;
    float length_px = length(along);
    along = length_px > 1e-3 ? along / length_px : vec2(1.0, 0.0);
    // Two triangles: bit 0 picks the end, bit 1 the side.
    const uint corners[6] = uint[6](0u, 1u, 2u, 2u, 1u, 3u);
    uint corner = corners[gl_VertexIndex];
    vec2 end = (corner & 1u) == 0u ? ends_px.xy - along * (radius_hidden.x + 1.0) : ends_px.zw + along * (radius_hidden.x + 1.0);
    vec2 side = vec2(-along.y, along.x) * (radius_hidden.x + 1.0);
    vec2 at = (corner & 2u) == 0u ? end - side : end + side;
    gl_Position = vec4(at / vec2(frame.size) * 2.0 - 1.0, 0.0, 1.0);
}
