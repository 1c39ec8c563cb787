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
#include "vpls.glsl"
#include "interleave.glsl"
#define VPL_SET_BINDING 3
#include "vpl_set.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 2) uniform utextureBuffer class_irradiance;
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2DArray set_buffers;

layout(push_constant) uniform Push {
    uint first_texel; // of the VPLs
    float total_flux; // of all classes
    uint layer;       // of the set buffers, for this set
} push;

const float MIN_NORMAL_COSINE = 0.9;
// Share of the flux that the window has to bring; else pixels farther away are asked as well.
const float MIN_PRESENT = 0.25;

// What a pixel must agree with to count, in scaled depths: plane distance is depth * dot(slope, (x, y, 1)) - offset, since
// positions are linear in pixel coordinates and depth.
struct Surface {
    vec3 shading;
    vec3 slope;
    float offset;
    float tolerance;
};

Surface surface_at(ivec2 pixel, float depth) {
    vec4 normals = texelFetch(gbuffer_normal, pixel, 0);
    vec3 geometric = octahedral_decode(normals.zw);
    vec2 step = 2.0 / vec2(frame.size);
    vec3 slope = vec3(dot(geometric, frame.ray_x.xyz) * step.x, dot(geometric, frame.ray_y.xyz) * step.y, 0.0);
    slope.z = dot(geometric, frame.ray.xyz - frame.ray_x.xyz - frame.ray_y.xyz) + 0.5 * (slope.x + slope.y);
    float offset = depth * dot(slope, vec3(pixel, 1.0));
    return Surface(octahedral_decode(normals.xy), slope, offset, 0.25 * frame.position_cutoff * depth);
}

// Pixels outside of the picture, which one that is smaller than the window has, lie on no surface.
uvec4 texel_at(ivec2 at) {
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(frame.size)));
    return inside ? texelFetch(class_irradiance, at.y * int(frame.size.x) + at.x) : uvec4(0u);
}

// Luminous flux of a pixel's class.
float flux_at(ivec2 at) { return vpl_class(push.first_texel, class_of(uvec2(at))).flux; }

// The window is centred on its pixel: for even n it is one pixel wider, and both its ends, which are of the same
// class, count for half. Off-centre by half a pixel, it would move steep gradients.
const bool EVEN = INTERLEAVE % 2u == 0u;
const int WIDTH = int(EVEN ? INTERLEAVE + 1u : INTERLEAVE);

float weight_at(int place) { return EVEN && (place == 0 || place == WIDTH - 1) ? 0.5 : 1.0; }

// First pixel of a window: moved inside at the borders, it still holds every class once.
ivec2 corner_of(ivec2 pixel) { return clamp(pixel - WIDTH / 2, ivec2(0), max(ivec2(frame.size) - WIDTH, ivec2(0))); }

// Four pixels, one below the other, of which each thread takes care: most of a texel's cost is to load and unpack it,
// and one lies in the windows of several. Everything is by pixel in the components of vectors.
const int ROWS = 4;

struct Centres {
    vec4 shading_x, shading_y, shading_z;
    vec4 slope_x, slope_y, slope_z;
    vec4 offset, tolerance;
    vec4 depth; // 0 where no surface is
    ivec4 corner_y;
};

Centres centres_at(ivec2 first) {
    Centres centres;
    for (int row = 0; row < ROWS; row++) {
        ivec2 pixel = first + ivec2(0, row);
        float depth = unpack_depth(texel_at(pixel).a);
        Surface surface = surface_at(min(pixel, ivec2(frame.size) - 1), depth);
        centres.shading_x[row] = surface.shading.x;
        centres.shading_y[row] = surface.shading.y;
        centres.shading_z[row] = surface.shading.z;
        centres.slope_x[row] = surface.slope.x;
        centres.slope_y[row] = surface.slope.y;
        centres.slope_z[row] = surface.slope.z;
        centres.offset[row] = surface.offset;
        centres.tolerance[row] = surface.tolerance;
        centres.depth[row] = depth;
        centres.corner_y[row] = corner_of(pixel).y;
    }
    return centres;
}

// One for each of the centres that the texel lies on the surface of.
bvec4 same_surfaces(Centres centres, uint packed, ivec2 at) {
    vec3 normal = unpack_normal(packed);
    float depth = unpack_depth(packed);
    vec4 slope = centres.slope_x * float(at.x) + centres.slope_y * float(at.y) + centres.slope_z;
    vec4 distance = depth * slope - centres.offset;
    vec4 cosine = normal.x * centres.shading_x + normal.y * centres.shading_y + normal.z * centres.shading_z;
    bvec4 near = lessThanEqual(abs(distance), centres.tolerance);
    bvec4 alike = greaterThanEqual(cosine, vec4(MIN_NORMAL_COSINE * length(normal)));
    return bvec4(uvec4(near) & uvec4(alike) & uint(is_surface(packed)));
}

// Words of a bit for each pixel of a window.
const uint WORDS = uint(WIDTH * WIDTH + 31) / 32u;

struct Sums {
    vec4 red, green, blue;
    vec4 present; // luminous flux of the classes that were found, each as often as it was
};

// Adds up the pixels of the windows that lie on the centres' surfaces; those of one window hold every class once.
Sums window_sums(Centres centres, int corner_x) {
    Sums sums = Sums(vec4(0.0), vec4(0.0), vec4(0.0), vec4(push.total_flux));
    // Those of a window that are not on the surface.
    uvec4 missing[3] = uvec4[3](uvec4(0u), uvec4(0u), uvec4(0u));
    for (int row = 0; row < WIDTH + ROWS - 1; row++) {
        int y = centres.corner_y[0] + row;
        ivec4 places = y - centres.corner_y;
        bvec4 ends = bvec4(uvec4(equal(places, ivec4(0))) | uvec4(equal(places, ivec4(WIDTH - 1))));
        bvec4 inside = lessThan(uvec4(places), uvec4(WIDTH));
        vec4 weights = mix(vec4(0.0), EVEN ? mix(vec4(1.0), vec4(0.5), ends) : vec4(1.0), inside);
        for (int column = 0; column < WIDTH; column++) {
            ivec2 at = ivec2(corner_x + column, y);
            uvec4 texel = texel_at(at);
            bvec4 same = same_surfaces(centres, texel.a, at);
            vec4 share = weight_at(column) * mix(vec4(0.0), weights, same);
            vec3 irradiance = uintBitsToFloat(texel.rgb);
            sums.red += share * irradiance.r;
            sums.green += share * irradiance.g;
            sums.blue += share * irradiance.b;
            uvec4 bits = uvec4(places * WIDTH + column);
            uvec4 lacks = uvec4(inside) & uvec4(not(same));
            for (uint word = 0u; word < WORDS; word++) {
                missing[word] |= (lacks & uvec4(equal(bits / 32u, uvec4(word)))) << (bits % 32u);
            }
        }
    }
    // Take off what the classes of those would have brought.
    for (int row = 0; row < ROWS; row++) {
        for (uint word = 0u; word < WORDS; word++) {
            for (uint bits = missing[word][row]; bits != 0u; bits &= bits - 1u) {
                int place = int(word * 32u) + findLSB(bits);
                ivec2 within = ivec2(place % WIDTH, place / WIDTH);
                float flux = flux_at(ivec2(corner_x, centres.corner_y[row]) + within);
                sums.present[row] -= weight_at(within.x) * weight_at(within.y) * flux;
            }
        }
    }
    return sums;
}

// Adds pixels farther away, one of each class again: every STEP-th, with no factor in common with n.
const int STEP = INTERLEAVE % 3u != 0u ? 3 : INTERLEAVE == 6u ? 5 : 2;

void add_farther(inout Sums sums, Centres centres, ivec2 first, int row) {
    ivec2 corner = first + ivec2(0, row) - (int(INTERLEAVE - 1u) * STEP) / 2;
    for (uint place = 0u; place < INTERLEAVE * INTERLEAVE; place++) {
        ivec2 at = corner + ivec2(place % INTERLEAVE, place / INTERLEAVE) * STEP;
        uvec4 texel = texel_at(at);
        bool same = same_surfaces(centres, texel.a, at)[row];
        vec3 irradiance = same ? uintBitsToFloat(texel.rgb) : vec3(0.0);
        sums.red[row] += irradiance.r;
        sums.green[row] += irradiance.g;
        sums.blue[row] += irradiance.b;
        sums.present[row] += same ? flux_at(at) : 0.0;
    }
}

void main() {
    ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
    if (any(greaterThanEqual(first, ivec2(frame.size)))) return;
    Centres centres = centres_at(first);
    Sums sums = window_sums(centres, corner_of(first).x);
    // What is left of a difference of equal numbers is not light.
    bvec4 nothing = lessThan(sums.present, vec4(1e-5 * push.total_flux));
    sums.red = mix(sums.red, vec4(0.0), nothing);
    sums.green = mix(sums.green, vec4(0.0), nothing);
    sums.blue = mix(sums.blue, vec4(0.0), nothing);
    sums.present = mix(sums.present, vec4(0.0), nothing);
    // On thin and curved things few classes lie on the surface: without more of them it would be speckled.
    uint few = 0u;
    for (int row = 0; row < ROWS; row++) {
        bool lacks = centres.depth[row] > 0.0 && sums.present[row] < MIN_PRESENT * push.total_flux;
        few |= lacks ? 1u << row : 0u;
    }
    for (; few != 0u; few &= few - 1u) add_farther(sums, centres, first, findLSB(few));
    for (int row = 0; row < ROWS; row++) {
        ivec2 pixel = first + ivec2(0, row);
        if (pixel.y >= int(frame.size.y)) break;
        vec3 irradiance = vec3(sums.red[row], sums.green[row], sums.blue[row]);
        float scale = sums.present[row] > 0.0 ? push.total_flux / sums.present[row] * frame.irradiance_scale : 0.0;
        float depth = centres.depth[row];
        imageStore(set_buffers, ivec3(pixel, int(push.layer)), depth > 0.0 ? vec4(irradiance * scale, depth) : vec4(0.0));
    }
}
