#version 460
#extension GL_GOOGLE_include_directive : require
// The random numbers of one frame and dimension, for tests/device/noise.rs: two a pixel.
#include "frame.glsl"
#include "scene_set.glsl"
#include "noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 2, std430) writeonly buffer NumberBlock { vec2 data[]; } numbers;

layout(push_constant) uniform Push { uint dimension; } push;

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uint index = gl_GlobalInvocationID.y * frame.size.x + gl_GlobalInvocationID.x;
    numbers.data[index] = noise(ivec2(gl_GlobalInvocationID.xy), push.dimension);
}
