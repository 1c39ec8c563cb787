#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Sums the n x n classes around each pixel, from pixels whose normals agree and whose positions lie
// near the centre's plane, scaled up by what the missing classes would have brought (the discontinuity
// buffer of Wald et al. 2002). Out: the set buffer, irradiance and view depth.
#include "frame.glsl"
#include "gbuffer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_position;
layout(set = 0, binding = 2) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 3) uniform texture2D class_irradiance;
layout(set = 0, binding = 4, std430) readonly buffer FluxBlock { float data[]; } class_flux;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2DArray set_buffers;

const float MIN_NORMAL_COSINE = 0.9;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(frame.size);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec3 target = ivec3(pixel, int(frame.set));
    vec4 centre = texelFetch(gbuffer_position, pixel, 0);
    if (centre.w <= 0.0) {
        imageStore(set_buffers, target, vec4(0.0));
        return;
    }
    vec4 normals = texelFetch(gbuffer_normal, pixel, 0);
    vec3 shading = octahedral_decode(normals.xy);
    vec3 geometric = octahedral_decode(normals.zw);
    float tolerance = 0.25 * frame.position_cutoff * centre.w;
    int n = int(frame.interleave);

    // Moved inside at the borders, the window still holds every class once.
    ivec2 corner = clamp(pixel - (n - 1) / 2, ivec2(0), max(size - n, ivec2(0)));
    vec3 sum = vec3(0.0);
    float present = 0.0;
    float total = 0.0;
    for (int k = 0; k < n * n; k++) {
        ivec2 at = corner + ivec2(k % n, k / n);
        uint pixel_class = uint(at.x % n + at.y % n * n);
        float flux = class_flux.data[pixel_class];
        total += flux;
        if (any(greaterThanEqual(at, size))) continue;
        vec4 other = texelFetch(gbuffer_position, at, 0);
        if (other.w <= 0.0 || abs(dot(geometric, other.xyz - centre.xyz)) > tolerance) continue;
        vec3 normal = octahedral_decode(texelFetch(gbuffer_normal, at, 0).xy);
        if (dot(normal, shading) < MIN_NORMAL_COSINE) continue;
        sum += texelFetch(class_irradiance, at, 0).rgb;
        present += flux;
    }
    vec3 irradiance = present > 0.0 ? sum * (total / present) : vec3(0.0);
    imageStore(set_buffers, target, vec4(irradiance * frame.irradiance_scale, centre.w));
}
