#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Thin surfaces between the eye and what a pixel sees, from front to back: with T what the thin surfaces before one let pass, c its share
// that is there, and its BSDF's directional albedos, each adds
//   T c (emission + BSDF of punctual lights) as light,   T c (diffuse + specular albedo) as albedo under irradiance.
// Out: both sums, and what all thin surfaces let pass of the light behind. Irradiance is that of the surface behind; before the open sky
// it is the environment's mean, and that light is in the first sum. Where reflection rays are traced, they and the estimator light all of
// the albedo of the first surface instead.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "rounded.glsl"
#include "tracer.glsl"
#include "hit.glsl"
#include "next_thin_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
#include "light_transmittance.glsl"
layout(set = 0, binding = 4, rgba16f) uniform writeonly image2D thin_light;
layout(set = 0, binding = 5, rgba16f) uniform writeonly image2D thin_albedo;
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D thin_transmittance;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D thin_mirrored;

// Twin: ThinSurfacesPush in src/passes/thin_surfaces.rs.
layout(push_constant) uniform Push {
    vec3 ambient; // irradiance where there is nothing behind, W/m^2
    float spread; // of a pixel, over a distance of 1
    float near;   // view depth of the first and last thin surface
    float far;
} push;

// Thin surfaces that are seen one behind the other, at most.
const int MOST_THIN_SURFACES = 256;

// The radiance of punctual lights by both lobes towards the eye.
vec3 punctual_radiance(Surface at, Reflection reflection, bool is_glossy) {
    vec3 radiance = vec3(0.0);
    for (uint i = 0u; i < frame.light_count; i++) {
        LightData light = lights.data[i];
        vec3 to_light;
        vec3 irradiance = unshadowed_irradiance(light, at, to_light);
        if (irradiance == vec3(0.0)) continue;
        vec3 bsdf = reflection.diffuse / PI;
        if (is_glossy) bsdf += reflected_towards_eye(reflection, to_light);
        radiance += bsdf * irradiance * light_transmittance(light, at, to_light);
    }
    return radiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    float depth = imageLoad(gbuffer_depth, pixel).r;
    // One long along the view: t is view depth.
    vec3 direction = pixel_ray(vec2(pixel));
    vec3 to_eye = -normalize(direction);
    float start = push.near;
    float end = depth > 0.0 ? depth : push.far;

    vec3 light = vec3(0.0);
    vec3 albedo = vec3(0.0);
    vec3 mirrored = vec3(0.0);
    vec3 transmittance = vec3(1.0);
    TracerHit hit;
    HitSurface met;
    for (int shown = 0; shown < MOST_THIN_SURFACES && transmittance != vec3(0.0); shown++) {
        if (!next_thin_surface(direction, start, end, push.spread, hit, met)) break;
        Reflection reflection = prepare_bsdf(met.bsdf, met.shading, to_eye);
        ThinPoint thin = thin_point(hit.material, met.colour);
        vec3 weight = transmittance * thin.coverage;
        Surface at = Surface(met.position, met.shading, met.geometric, hit.t, 0.0);
        light += weight * (met.emission + punctual_radiance(at, reflection, reflects(met.bsdf)));
        vec3 by_irradiance = weight * (reflection.diffuse + reflection.reflected);
        if (shown == 0 && frame.reflection_limit >= 0.0) mirrored = by_irradiance;
        else albedo += by_irradiance;
        transmittance *= transmittance_of(thin, reflection.reflected);
    }
    if (depth == 0.0) {
        light += albedo / PI * push.ambient;
        albedo = vec3(0.0);
    }
    imageStore(thin_light, pixel, storable(vec4(light, 0.0)));
    imageStore(thin_albedo, pixel, vec4(albedo, 0.0));
    imageStore(thin_transmittance, pixel, vec4(transmittance, 0.0));
    imageStore(thin_mirrored, pixel, rounded(vec4(mirrored, 0.0)));
}
