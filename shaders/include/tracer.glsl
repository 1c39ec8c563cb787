// The tracer that shaders use: trace_transmittance, trace_closest and trace_thin_surface, at the end. Whichever it is, it offers
//   bool tracer_find(
//       vec3 origin, vec3 direction, float t_min, float t_max, uint wanted, out TracerHit hit, out vec3 transmittance)
// which finds what is wanted of the segment t_min < t < t_max, t in units of the direction, which may have any length; where
// any hit is wanted and there is none, `transmittance` is what the thin surfaces on the segment let pass.
//
// The build compiles what includes this file twice, once with TRACER_HARDWARE.

#ifndef TRACER_GLSL
#define TRACER_GLSL

#include "scene_set.glsl"
#include "bilinear.glsl"
#include "bsdf.glsl"
#include "has_thin_surfaces.glsl"
#include "mask.glsl"
#include "wrap.glsl"

const uint TRACER_NONE = 0xffffffffu;
// In `masked`: the triangle is one of a thin surface, and the rest is its index.
const uint TRACER_THIN = 0x80000000u;

// The hit that a query looks for on a segment. Thin surfaces count as absent unless it looks for one.
const uint TRACER_CLOSEST = 0u;
const uint TRACER_ANY = 1u;
const uint TRACER_CLOSEST_THIN = 2u;

// The closest surface along a ray.
struct TracerHit {
    float t;
    // Index into the scene's instances.
    uint instance;
    // Index into the mesh's triangles.
    uint triangle;
    uint material;
    // Index into bvh_triangles.
    uint place;
    // Weights of the triangle's second and third corner.
    vec2 barycentrics;
};

// Whether the triangle's alpha mask leaves the surface there; masked is 1 + index of the triangle's coordinates.
bool tracer_is_opaque(uint masked, vec2 barycentrics) {
    uvec4 first_two = bvh_triangle_uvs.words[(masked - 1u) * 2u];
    uvec4 third = bvh_triangle_uvs.words[(masked - 1u) * 2u + 1u];
    float first = 1.0 - barycentrics.x - barycentrics.y;
    precise vec2 uv = uintBitsToFloat(first_two.xy) * first + uintBitsToFloat(first_two.zw) * barycentrics.x
        + uintBitsToFloat(third.xy) * barycentrics.y;
    vec2 two = unpackHalf2x16(third.w);
    vec3 alphas = vec3(unpackHalf2x16(third.z).y, two);
    precise float alpha = alphas.x + (alphas.y - alphas.x) * barycentrics.x + (alphas.z - alphas.x) * barycentrics.y;
    return mask_opaque(third.z & 0xffffu, uv, alpha);
}

bool tracer_is_thin(uint masked) { return HAS_THIN_SURFACES && (masked & TRACER_THIN) != 0u; }

// A point of a thin surface. Twin: `ThinSurface` in src/scene/material.rs.
struct ThinPoint {
    float coverage; // the share of the surface that is there
    vec3 passed;    // what that part lets pass of the light that its coat does not reflect
};

// `colour`: that of texture and vertices.
ThinPoint thin_point(uint material, vec4 colour) {
    GpuThinSurface thin = bvh_thin_surfaces.data[material];
    float coverage = (thin.modes & THIN_BLENDS) != 0u ? thin.passed.w * colour.a : 1.0;
    return ThinPoint(coverage, thin.passed.rgb * colour.rgb);
}

// Transmittance of the thin surface where its coat reflects this share at most.
vec3 transmittance_of(ThinPoint thin, vec3 reflected) {
    float most = max(reflected.r, max(reflected.g, reflected.b));
    return (1.0 - thin.coverage) + thin.passed * (thin.coverage * (1.0 - most));
}

vec4 tracer_thin_texel(GpuThinSurface thin, uint texel) {
    if ((thin.modes & THIN_HALF) != 0u) {
        uint word = thin.first + 2u * texel;
        return unpack_halves(uvec2(bvh_thin_texels.words[word], bvh_thin_texels.words[word + 1u]));
    }
    uint format = (thin.modes & THIN_LINEAR) != 0u ? FORMAT_LINEAR : FORMAT_SRGB;
    return decoded(unpackUnorm4x8(bvh_thin_texels.words[thin.first + texel]), format);
}

// Transmittance of a triangle of a thin surface: its coat by the flat triangle and the mean of its textures. `world_to_object`: the rows.
vec3 tracer_transmittance(uint triangle, vec2 barycentrics, mat3 world_to_object, vec3 direction) {
    uvec4 a = texelFetch(bvh_triangles, int(triangle * 3u));
    uvec4 b = texelFetch(bvh_triangles, int(triangle * 3u + 1u));
    uvec4 c = texelFetch(bvh_triangles, int(triangle * 3u + 2u));
    GpuThinTriangle corners = bvh_thin_triangles.data[b.w & ~TRACER_THIN];
    GpuThinSurface thin = bvh_thin_surfaces.data[c.w];

    // Colour of vertices and texture.
    vec3 weights = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    vec4 colour = mat3x4(unpack_halves(corners.colours[0]), unpack_halves(corners.colours[1]),
        unpack_halves(corners.colours[2])) * weights;
    if (thin.size != 0u) {
        vec2 uv = mat3x2(corners.uvs[0], corners.uvs[1], corners.uvs[2]) * weights;
        Footprint at = footprint_at(wrapped(uv, thin.modes), uvec2(thin.size & 0xffffu, thin.size >> 16), thin.modes);
        colour *= interpolated(vec4[4](tracer_thin_texel(thin, at.texels.x), tracer_thin_texel(thin, at.texels.y),
            tracer_thin_texel(thin, at.texels.z), tracer_thin_texel(thin, at.texels.w)), at.part);
    }

    // Reflection of the coat.
    vec3 normal = cross(uintBitsToFloat(b.xyz) - uintBitsToFloat(a.xyz), uintBitsToFloat(c.xyz) - uintBitsToFloat(a.xyz));
    normal = normalize(world_to_object * normal);
    Bsdf coat = Bsdf(thin.base.rgb, thin.base.w, thin.reflectance.rgb, thin.reflectance.w, thin.roughness);
    vec3 to_eye = -normalize(direction);
    vec3 reflected = prepare_bsdf(coat, dot(normal, to_eye) < 0.0 ? -normal : normal, to_eye).reflected;
    return transmittance_of(thin_point(c.w, colour), reflected);
}

#ifdef TRACER_HARDWARE
#include "tracer_hardware.glsl"
#else
#include "tracer_software.glsl"
#endif

// The next smaller and greater t: a ray from or to a hit does not meet it again.
float just_before(float t) { return uintBitsToFloat(floatBitsToUint(t) - 1u); }
float just_behind(float t) { return uintBitsToFloat(floatBitsToUint(t) + 1u); }

// Transmittance of the segment: 0 where anything opaque lies on it, else the product over the thin surfaces there.
vec3 trace_transmittance(vec3 origin, vec3 direction, float t_min, float t_max) {
    TracerHit hit;
    vec3 transmittance;
    return tracer_find(origin, direction, t_min, t_max, TRACER_ANY, hit, transmittance) ? vec3(0.0) : transmittance;
}

// The closest hit on the segment behind any thin surfaces, whose tint is trace_transmittance up to there.
bool trace_closest(vec3 origin, vec3 direction, float t_min, float t_max, out TracerHit hit) {
    vec3 transmittance;
    return tracer_find(origin, direction, t_min, t_max, TRACER_CLOSEST, hit, transmittance);
}

// The closest thin surface on the segment, opaque surfaces before it or not.
bool trace_thin_surface(vec3 origin, vec3 direction, float t_min, float t_max, out TracerHit hit) {
    vec3 transmittance;
    return tracer_find(origin, direction, t_min, t_max, TRACER_CLOSEST_THIN, hit, transmittance);
}

#endif
