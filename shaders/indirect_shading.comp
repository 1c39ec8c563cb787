#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Irradiance of each pixel from the VPLs of its class:
//   E = sum phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V        (Keller 1997, with a bounded geometry term)
#include "frame.glsl"
#include "gbuffer.glsl"
#include "vpls.glsl"
#include "class_pixel.glsl"
#include "interleave.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_position;
layout(set = 0, binding = 2) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 3, std430) readonly buffer VplBlock { GpuVpl data[]; } vpls;
layout(set = 0, binding = 4, std430) readonly buffer ClassBlock { uint data[]; } class_starts;
layout(set = 0, binding = 5, std430) readonly buffer MaskWords { uint words[]; } visibility;
// rgb: irradiance, as bits of floats; a: surface, see class_pixel.glsl.
layout(set = 0, binding = 6, rgba32ui) uniform uimage2D class_irradiance;

layout(push_constant) uniform Push { uint first_word; uint word_count; } push;

void main() {
    // In the order of the picture: unlike rays, sums gain nothing from neighbours of one class.
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size))) return;
    vec4 position = texelFetch(gbuffer_position, ivec2(pixel), 0);
    vec3 irradiance = vec3(0.0);
    vec2 packed_normal = texelFetch(gbuffer_normal, ivec2(pixel), 0).xy;
    if (position.w > 0.0) {
        vec3 n = octahedral_decode(packed_normal);
        uint pixel_class = class_of(pixel);
        uint class_end = class_starts.data[pixel_class + 1u];
        uint first = class_starts.data[pixel_class] + push.first_word * 32u;
        for (uint word = 0u; word < push.word_count; word++) {
            uint bits = visibility.words[(word * frame.size.y + pixel.y) * frame.size.x + pixel.x];
            uint begin = first + word * 32u;
            uint end = min(begin + 32u, class_end);
            for (uint i = begin; i < end; i++) {
                if ((bits >> (i - begin) & 1u) == 0u) continue;
                vec3 full = contribution(vpls.data[i], position.xyz, n);
                irradiance += full / max(ray_share(full), 1e-8);
            }
        }
        // Later chunks of the set's VPLs add to the earlier ones.
        if (push.first_word > 0u) irradiance += uintBitsToFloat(imageLoad(class_irradiance, ivec2(pixel)).rgb);
    }
    imageStore(class_irradiance, ivec2(pixel), uvec4(floatBitsToUint(irradiance), pack_surface(position.w, packed_normal)));
}
