#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Sums the n x n classes around each pixel, from pixels whose normals agree and whose positions lie
// near the centre's plane, scaled up by what the missing classes would have brought (the discontinuity
// buffer of Wald et al. 2002). That share is taken over all temporal sets, so that it does not depend on
// how the VPLs of a class are dealt to sets. Out: the set buffer, irradiance and view depth.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "class_pixel.glsl"
#include "interleave.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 2) uniform utexture2D class_irradiance;
layout(set = 0, binding = 3, std430) readonly buffer FluxBlock { float data[]; } class_flux;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2DArray set_buffers;

layout(push_constant) uniform Push {
    float total_flux; // of all classes
    uint layer;       // of the set buffers, for this set
} push;

const float MIN_NORMAL_COSINE = 0.9;
// Share of the flux that the window has to bring; else pixels farther away are asked as well.
const float MIN_PRESENT = 0.25;

struct Sum {
    vec3 irradiance;
    float present; // luminous flux of the classes that were found, each as often as it was
};

// What a pixel must agree with to count, in scaled depths: plane distance is depth * dot(slope, (x, y, 1)) - offset, since
// positions are linear in pixel coordinates and depth.
struct Surface {
    vec3 shading;
    vec3 slope;
    float offset;
    float tolerance;
};

Surface surface_at(ivec2 pixel, float depth, vec3 shading, vec3 geometric) {
    vec2 step = 2.0 / vec2(frame.size);
    vec3 slope = vec3(dot(geometric, frame.ray_x.xyz) * step.x, dot(geometric, frame.ray_y.xyz) * step.y, 0.0);
    slope.z = dot(geometric, frame.ray.xyz - frame.ray_x.xyz - frame.ray_y.xyz) + 0.5 * (slope.x + slope.y);
    float offset = depth * dot(slope, vec3(pixel, 1.0));
    return Surface(shading, slope, offset, 0.25 * frame.position_cutoff * depth);
}

// other: normal and depth.
bool same_surface(Surface centre, vec4 other, ivec2 at) {
    float distance = other.w * dot(centre.slope, vec3(at, 1.0)) - centre.offset;
    return other.w > 0.0 && abs(distance) <= centre.tolerance && dot(other.xyz, centre.shading) >= MIN_NORMAL_COSINE;
}

vec4 unpack_surface(uint surface) { return vec4(normalize(unpack_normal(surface)), unpack_depth(surface)); }

// Luminous flux of a pixel's class.
float flux_at(ivec2 at) { return class_flux.data[class_of(uvec2(at))]; }

// The window is centred on its pixel: for even n it is one pixel wider, and both its ends, which are of the same
// class, count for half. Off-centre by half a pixel, it would move steep gradients.
const bool EVEN = INTERLEAVE % 2u == 0u;
const uint WIDTH = EVEN ? INTERLEAVE + 1u : INTERLEAVE;

float weight_at(uint place) {
    uint x = place % WIDTH;
    uint y = place / WIDTH;
    float across = EVEN && (x == 0u || x == INTERLEAVE) ? 0.5 : 1.0;
    return EVEN && (y == 0u || y == INTERLEAVE) ? 0.5 * across : across;
}

// Pixels of the windows of a workgroup, loaded once for all of them.
const uint GROUP = 8u;
const uint TILE = GROUP + WIDTH - 1u;
shared vec4 tile_surface[TILE * TILE]; // xyz: normal; w: depth
shared vec4 tile_irradiance[TILE * TILE];

// First pixel of a window: moved inside at the borders, it still holds every class once.
ivec2 corner_of(ivec2 pixel) {
    const int width = int(WIDTH);
    return clamp(pixel - width / 2, ivec2(0), max(ivec2(frame.size) - width, ivec2(0)));
}

void load_tile(ivec2 origin) {
    ivec2 last = ivec2(frame.size) - 1;
    for (uint i = gl_LocalInvocationIndex; i < TILE * TILE; i += GROUP * GROUP) {
        ivec2 at = origin + ivec2(i % TILE, i / TILE);
        // Pictures smaller than the window lack its last pixels.
        uvec4 texel = all(lessThanEqual(at, last)) ? texelFetch(class_irradiance, at, 0) : uvec4(0u);
        tile_surface[i] = unpack_surface(texel.a);
        tile_irradiance[i] = vec4(uintBitsToFloat(texel.rgb), 0.0);
    }
}

// Adds up the pixels of the window that lie on the centre's surface; together they hold every class once.
Sum window_sum(ivec2 corner, ivec2 origin, Surface centre) {
    Sum sum = Sum(vec3(0.0), push.total_flux);
    uint first = uint(corner.y - origin.y) * TILE + uint(corner.x - origin.x);
    // One bit for each pixel of the window that is not on the surface.
    uint missing[3] = uint[3](0u, 0u, 0u);
    for (uint y = 0u; y < WIDTH; y++) {
        for (uint x = 0u; x < WIDTH; x++) {
            uint at = first + y * TILE + x;
            bool same = same_surface(centre, tile_surface[at], corner + ivec2(x, y));
            uint place = y * WIDTH + x;
            sum.irradiance += same ? weight_at(place) * tile_irradiance[at].rgb : vec3(0.0);
            missing[place / 32u] |= same ? 0u : 1u << (place % 32u);
        }
    }
    // Take off what the classes of those would have brought.
    for (uint word = 0u; word < (WIDTH * WIDTH + 31u) / 32u; word++) {
        for (uint bits = missing[word]; bits != 0u; bits &= bits - 1u) {
            uint place = word * 32u + uint(findLSB(bits));
            sum.present -= weight_at(place) * flux_at(corner + ivec2(place % WIDTH, place / WIDTH));
        }
    }
    // What is left of a difference of equal numbers is not light.
    if (sum.present < 1e-5 * push.total_flux) sum = Sum(vec3(0.0), 0.0);
    return sum;
}

// Adds pixels farther away, one of each class again: every STEP-th, with no factor in common with n.
const uint STEP = INTERLEAVE % 3u != 0u ? 3u : INTERLEAVE == 6u ? 5u : 2u;

void add_farther(inout Sum sum, ivec2 pixel, Surface centre) {
    ivec2 corner = pixel - int((INTERLEAVE - 1u) * STEP) / 2;
    for (uint y = 0u; y < INTERLEAVE; y++) {
        for (uint x = 0u; x < INTERLEAVE; x++) {
            ivec2 at = corner + ivec2(x, y) * int(STEP);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
            uvec4 other = texelFetch(class_irradiance, at, 0);
            if (!same_surface(centre, unpack_surface(other.a), at)) continue;
            sum.irradiance += uintBitsToFloat(other.rgb);
            sum.present += flux_at(at);
        }
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 origin = corner_of(ivec2(gl_WorkGroupID.xy * GROUP));
    load_tile(origin);
    barrier();
    if (any(greaterThanEqual(pixel, ivec2(frame.size)))) return;
    ivec3 target = ivec3(pixel, int(push.layer));
    uvec2 place = uvec2(pixel - origin);
    float depth = tile_surface[place.y * TILE + place.x].w;
    if (depth <= 0.0) {
        imageStore(set_buffers, target, vec4(0.0));
        return;
    }
    vec4 normals = texelFetch(gbuffer_normal, pixel, 0);
    Surface centre = surface_at(pixel, depth, octahedral_decode(normals.xy), octahedral_decode(normals.zw));
    Sum sum = window_sum(corner_of(pixel), origin, centre);
    // On thin and curved things few classes lie on the surface: without more of them it would be speckled.
    for (uint i = sum.present < MIN_PRESENT * push.total_flux ? 1u : 0u; i > 0u; i--) add_farther(sum, pixel, centre);
    vec3 irradiance = sum.present > 0.0 ? sum.irradiance * (push.total_flux / sum.present) : vec3(0.0);
    imageStore(set_buffers, target, vec4(irradiance * frame.irradiance_scale, depth));
}
