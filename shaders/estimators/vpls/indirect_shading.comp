#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The discontinuity filter (Wald et al. 2002): adds up the n x n classes around each texel of the set buffer, from the pixels
// that lie on its surface, and divides by the share of the flux that these classes have. The share is taken over all temporal
// sets, so that it does not depend on how the VPLs of a class are dealt to sets.
// Out: the layer of the set, rgb: scaled irradiance; a: scaled view depth, negative where too few classes were found.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "interleave.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#define VPL_CLASSES_BINDING 5
#include "vpl_classes.glsl"
#include "representative.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 6, rgba32f) uniform readonly image2D class_irradiance;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2DArray set_buffers;
#include "surface.glsl"

layout(constant_id = 1) const uint SET_STEP = 2u; // pixels from one texel of the set buffers to the next

// The window is centred on its pixel: for even n it is one pixel wider than n, and both its ends, which are of the same
// class, count for half. Off-centre by half a pixel, it would move steep gradients.
const bool EVEN = INTERLEAVE % 2u == 0u;
const int WIDTH = int(EVEN ? INTERLEAVE + 1u : INTERLEAVE);
const float MIN_NORMAL_COSINE = 0.9;
// Share of the flux below which a window is sparse.
const float SPARSE = 0.27;

float weight_at(int place) { return EVEN && (place == 0 || place == WIDTH - 1) ? 0.5 : 1.0; }

// First pixel of a window: moved inside at the picture's borders, where it still holds every class.
ivec2 window_of(ivec2 pixel) { return clamp(pixel - WIDTH / 2, ivec2(0), max(ivec2(frame.size) - WIDTH, ivec2(0))); }

// The pixels of all windows of a workgroup.
const int SIDE = 7 * int(SET_STEP) + WIDTH;
shared uvec2 tile_irradiance[SIDE * SIDE]; // half floats
shared uint tile_normal[SIDE * SIDE];
shared float tile_depth[SIDE * SIDE];
shared float class_flux[CLASSES];

void load_tile(ivec2 first) {
    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 64) {
        ivec2 pixel = first + ivec2(i % SIDE, i / SIDE);
        bool inside = all(lessThan(pixel, ivec2(frame.size)));
        ivec2 read = min(pixel, ivec2(frame.size) - 1);
        vec4 irradiance = min(imageLoad(class_irradiance, read), MAX_STORED);
        tile_irradiance[i] = uvec2(packHalf2x16(irradiance.rg), packHalf2x16(irradiance.ba));
        tile_normal[i] = packSnorm4x8(vec4(octahedral_decode(imageLoad(gbuffer_normal, read).xy), 0.0));
        tile_depth[i] = inside ? imageLoad(gbuffer_depth, read).r : 0.0;
    }
    for (uint i = gl_LocalInvocationIndex; i < CLASSES; i += 64u) class_flux[i] = vpl_classes.data[vpl.first_class + i].flux;
}

// Sum over the window; a: luminous flux of the classes that were found.
vec4 filtered(Surface centre, ivec2 window, ivec2 tile) {
    vec4 sum = vec4(0.0);
    float near = 0.25 * vpl.position_cutoff * centre.depth;
    // Distance from the centre's plane is linear in pixel coordinates and depth.
    vec3 origin = pixel_ray(vec2(window));
    vec2 step = 2.0 / vec2(frame.size);
    vec3 slope = vec3(dot(centre.geometric, frame.ray_x.xyz) * step.x, dot(centre.geometric, frame.ray_y.xyz) * step.y,
        dot(centre.geometric, origin));
    float offset = dot(centre.geometric, centre.position - frame.eye.xyz);
    for (int y = 0; y < WIDTH; y++) {
        for (int x = 0; x < WIDTH; x++) {
            ivec2 pixel = window + ivec2(x, y);
            int i = (pixel.y - tile.y) * SIDE + pixel.x - tile.x;
            float depth = tile_depth[i];
            float from_plane = abs(depth * dot(slope, vec3(x, y, 1.0)) - offset);
            bool same = depth > 0.0 && from_plane <= near
                && dot(unpackSnorm4x8(tile_normal[i]).xyz, centre.shading) >= MIN_NORMAL_COSINE;
            float weight = same ? weight_at(x) * weight_at(y) : 0.0;
            vec3 irradiance = vec3(unpackHalf2x16(tile_irradiance[i].x), unpackHalf2x16(tile_irradiance[i].y).x);
            sum += weight * vec4(irradiance, class_flux[class_of(uvec2(pixel))]);
        }
    }
    return sum;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 first = ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy);
    ivec2 tile = window_of(representative(first, SET_STEP, vpl.representative, frame.size));
    load_tile(tile);
    barrier();
    if (any(greaterThanEqual(uvec2(texel), set_extent(frame.size, SET_STEP)))) return;
    ivec2 pixel = representative(texel, SET_STEP, vpl.representative, frame.size);
    Surface centre = surface_at(pixel);
    vec4 stored = vec4(0.0);
    if (centre.depth > 0.0) {
        vec4 sum = filtered(centre, window_of(pixel), tile);
        bool sparse = sum.a < SPARSE * vpl.total_flux;
        if (sum.a > 0.0) stored.rgb = min(sum.rgb * (vpl.total_flux / sum.a), MAX_STORED);
        stored.a = centre.depth * vpl.depth_scale * (sparse ? -1.0 : 1.0);
    }
    imageStore(set_buffers, ivec3(texel, vpl.layer), stored);
}
