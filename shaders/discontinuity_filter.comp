#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Sums the n x n classes around each pixel, from pixels whose normals agree and whose positions lie
// near the centre's plane, scaled up by what the missing classes would have brought (the discontinuity
// buffer of Wald et al. 2002). That share is taken over all temporal sets, so that it does not depend on
// how the VPLs of a class are dealt to sets. Out: the set buffer, irradiance and view depth.
#include "frame.glsl"
#include "gbuffer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_position;
layout(set = 0, binding = 2) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 3) uniform texture2D class_irradiance;
layout(set = 0, binding = 4, std430) readonly buffer FluxBlock { float data[]; } class_flux;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2DArray set_buffers;

const float MIN_NORMAL_COSINE = 0.9;
// Share of the flux that the n x n window has to bring; else a window three times as wide is tried.
const float MIN_PRESENT = 0.25;

struct Sum {
    vec3 irradiance;
    float present; // luminous flux of the classes that were found, each as often as it was
};

// Adds up the pixels of a square window that lie on the centre's surface.
Sum window_sum(ivec2 corner, int width, ivec2 size, vec4 centre, vec3 shading, vec3 geometric) {
    int n = int(frame.interleave);
    float tolerance = 0.25 * frame.position_cutoff * centre.w;
    Sum sum = Sum(vec3(0.0), 0.0);
    // Classes are counted along, since dividing is slow.
    ivec2 start = corner % n;
    int row_class = start.y;
    for (int y = corner.y; y < min(corner.y + width, size.y); y++) {
        int column_class = start.x;
        for (int x = corner.x; x < min(corner.x + width, size.x); x++) {
            int pixel_class = row_class * n + column_class;
            column_class = column_class + 1 == n ? 0 : column_class + 1;
            vec4 other = texelFetch(gbuffer_position, ivec2(x, y), 0);
            if (other.w <= 0.0 || abs(dot(geometric, other.xyz - centre.xyz)) > tolerance) continue;
            vec3 normal = octahedral_decode(texelFetch(gbuffer_normal, ivec2(x, y), 0).xy);
            if (dot(normal, shading) < MIN_NORMAL_COSINE) continue;
            sum.irradiance += texelFetch(class_irradiance, ivec2(x, y), 0).rgb;
            sum.present += class_flux.data[pixel_class];
        }
        row_class = row_class + 1 == n ? 0 : row_class + 1;
    }
    return sum;
}

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
    int n = int(frame.interleave);
    float total = 0.0;
    for (int k = 0; k < n * n; k++) total += class_flux.data[k];

    // Moved inside at the borders, the window still holds every class once.
    ivec2 corner = clamp(pixel - (n - 1) / 2, ivec2(0), max(size - n, ivec2(0)));
    Sum sum = window_sum(corner, n, size, centre, shading, geometric);
    // On thin and curved things few classes lie on the surface: without more of them it would be speckled.
    if (n > 1 && sum.present < MIN_PRESENT * total) {
        corner = clamp(pixel - (3 * n - 1) / 2, ivec2(0), max(size - 3 * n, ivec2(0)));
        sum = window_sum(corner, 3 * n, size, centre, shading, geometric);
    }
    vec3 irradiance = sum.present > 0.0 ? sum.irradiance * (total / sum.present) : vec3(0.0);
    imageStore(set_buffers, target, vec4(irradiance * frame.irradiance_scale, centre.w));
}
