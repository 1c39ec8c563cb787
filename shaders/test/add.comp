#version 460
// Adds a constant to every word, for tests/device/vulkan.rs.
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer SourceBlock { uint words[]; } source;
layout(set = 0, binding = 1, std430) buffer TargetBlock { uint words[]; } target;

layout(push_constant) uniform Push { uint summand; } push;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < target.words.length()) target.words[index] = source.words[index] + push.summand;
}
