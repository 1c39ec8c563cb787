#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Adds a constant to every texel, for tests/device/vulkan.rs.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform texture2D source;
layout(set = 0, binding = 1, r32f) uniform writeonly image2D target;

layout(push_constant) uniform Push { float summand; } push;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    imageStore(target, texel, vec4(texelFetch(source, texel, 0).r + push.summand));
}
