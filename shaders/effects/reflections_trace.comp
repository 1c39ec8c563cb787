#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Radiance that the GGX lobe of each pixel mirrors: one path by the visible normals of GGX, which goes on from glossy hits. Out: radiance over
// the lobe's directional albedo; a: how wide a blur is of use; at most one hit of each path that the estimator is to light; and for
// the denoiser what is seen and where it was in the last frame: in smooth surfaces the mirror image of the hit, elsewhere the surface.
// A thin surface before it is sampled in its place or, by chance, beside it; its irradiance is that of a hit.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "bsdf.glsl"
#include "rounded.glsl"
#include "tracer.glsl"
#include "hit.glsl"
#include "next_thin_surface.glsl"
#include "noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
#include "surface.glsl"
#include "lights.glsl"
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 6) uniform utexture2D gbuffer_surface;
#include "unshadowed.glsl"
#include "shading_point.glsl"
#include "light_sampling.glsl"
#include "environment.glsl"
#include "visible_surface.glsl"
#include "hit_record.glsl"
// Irradiance by the estimator, W/m^2.
layout(set = 0, binding = 7) uniform texture2D irradiance;
layout(set = 0, binding = 12, rgba16f) uniform readonly image2D reprojected;
layout(set = 0, binding = 13, rgba16f) uniform writeonly image2D reflection;
layout(set = 0, binding = 14, rgba32ui) uniform writeonly uimage2D hit_place;
layout(set = 0, binding = 15, rgba16f) uniform writeonly image2D hit_weight;
// The surface that is seen in the reflection, as the G-buffer has it, and as denoisers keep it.
layout(set = 0, binding = 16, r32f) uniform writeonly image2D image_depth;
layout(set = 0, binding = 17, rgba16f) uniform writeonly image2D image_normal;
layout(set = 0, binding = 35, rgba16ui) uniform readonly uimage2D last_image_surface;
layout(set = 0, binding = 36, rgba16ui) uniform writeonly uimage2D image_surface;
layout(set = 0, binding = 37, rgba16f) uniform writeonly image2D image_reprojected;
layout(set = 0, binding = 41, r32ui) uniform readonly uimage2D last_image_instance;
layout(set = 0, binding = 42, r32ui) uniform writeonly uimage2D image_instance;

// Images of thin_surfaces.comp.
layout(set = 0, binding = 38, rgba16f) uniform readonly image2D thin_mirrored;
layout(set = 0, binding = 39, rgba16f) uniform readonly image2D thin_transmittance;

// The environment by roughness: see split_sum.glsl.
layout(set = 0, binding = 40, rgba16f) uniform readonly image2D prefiltered_environment;
#define READS_PREFILTERED
#include "split_sum.glsl"

// Glossy surfaces that a path follows, at most.
layout(constant_id = 2) const uint DEPTH = 2u;
// 1: hits mirror the environment alone, by the split sum.
layout(constant_id = 4) const uint SPLIT_SUM = 0u;

// Twin: TracePush in src/effects/reflections.rs.
layout(push_constant) uniform Push {
    float spread; // of a pixel, over a distance of 1
    uint has_history;
    uint has_environment; // 0: what lies behind all surfaces is only seen, it sends no light
    uint sees_screen;     // 0: hits on the screen are left to the estimator, too
    float near;           // view depth of the first thin surface
} push;

// Dimensions of the random numbers that a hit takes; the first ones are those of soft shadows.
const uint FIRST_DIMENSION = 4u;
const uint DIMENSIONS = 4u;
const uint INVISIBLE_DIMENSION = 40u;
// Roughness up to which a surface shows a mirror image, and up to which what a flat one shows moves as a mirror image does; how much
// neighbouring normals of a flat one differ.
const float IMAGE_ROUGHNESS = 0.05;
const float MOVING_ROUGHNESS = 0.25;
const float FLAT = 0.999;
// Share of the depth of a mirror image, by which it may differ from where it is expected.
const float IMAGE_ROUNDING = 0.01;
// Pixels that a blur reaches at most, and those that one of noisy light at a sharp mirror image does.
const float WIDEST = 30.0;
const float IMAGE_BLUR = 3.0;
// Tangent of the half angle that most of the lobe lies in, over alpha: GGX has long tails.
const float LOBE_WIDTH = 4.0;
// No instance plus one: indices have at most 24 bits, by Vulkan's limit.
const uint NO_INSTANCE = 0xffffffffu;
// Relative difference of depths up to which a blurred mirror's surface is found again, where its image was.
const float MIRROR_TOLERANCE = 0.1;

// A path with what it has gathered, over the directional albedo of the visible surface's lobe.
struct Path {
    vec3 radiance;
    vec3 throughput;
    HitRecord record;
    float record_weight; // of all hits that could have been the record
};

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(frame.size))); }

Path new_path() {
    return Path(vec3(0.0), vec3(1.0), HitRecord(vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0), 0.0);
}

// Irradiance of a surface that is on the screen; false where none of it is.
bool seen_irradiance(HitSurface hit, uint instance, out vec3 result) {
    vec4 clip = frame.view_projection * vec4(hit.position, 1.0);
    ivec2 pixel = ivec2(floor((clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.size)));
    if (push.sees_screen == 0u || clip.w <= 0.0 || !inside(pixel) || texelFetch(gbuffer_instance, pixel, 0).x != instance + 1u) return false;
    Surface at = surface_at(pixel);
    float footprint = at.depth * push.spread;
    bool same = abs(dot(at.position - hit.position, hit.geometric)) < 2.0 * footprint + ray_offset(hit.position)
        && distance(at.position, hit.position) < 4.0 * footprint / max(abs(dot(hit.geometric, normalize(hit.position - frame.eye.xyz))), 0.1)
        && dot(at.shading, hit.shading) > 0.9;
    result = texelFetch(irradiance, pixel, 0).rgb;
    return same;
}

// Lights a hit: emission, one light, and irradiance, which is known or left to the estimator.
void shade(inout Path path, HitSurface hit, ShadingPoint at, uint instance, vec3 albedo, vec4 random) {
    path.radiance += path.throughput * hit.emission;
    ChosenLight chosen = choose_light(at, random.x);
    if (chosen.probability > 0.0) {
        path.radiance += path.throughput * sampled_radiance(at, chosen, sample_light(chosen.index, at, random.zw));
    }
    vec3 weight = path.throughput * albedo / PI;
    vec3 known;
    if (seen_irradiance(hit, instance, known)) {
        path.radiance += weight * known;
        return;
    }
    float luma = luminance(weight);
    if (!(luma > 0.0)) return;
    path.record_weight += luma;
    if (random.y * path.record_weight < luma) {
        path.record = HitRecord(hit.position, at.surface.shading, at.surface.geometric, weight / luma, 0.0);
    }
}

// Radiance that the GGX lobe reflects of one of the lights from `first` on that rays do not meet.
vec3 invisible_light(ShadingPoint at, uint first, ivec2 pixel, uint dimension) {
    // Without these, visible ones send nothing.
    at.diffuse = vec3(0.0);
    at.gloss_of_areas = 0.0;
    ChosenLight chosen = choose_light(at, noise(pixel, dimension).x, first, frame.light_count + frame.area_light_count - first);
    if (chosen.probability == 0.0) return vec3(0.0);
    return sampled_radiance(at, chosen, sample_light(chosen.index, at, noise(pixel, dimension + 1u)));
}

// The first hit of a path, or the environment.
struct FirstHit {
    bool met;
    uint instance;
    float distance;
    vec3 position;
    vec3 shading; // unit normals on the side that was hit
    vec3 geometric;
};

// `first_light`: of those whose light on the visible surface no other pass adds.
Path trace_path(ivec2 pixel, Path path, ShadingPoint visible, uint first_light, out FirstHit first) {
    first = FirstHit(false, 0u, 1e4 * frame.eye.w, vec3(0.0), vec3(0.0), vec3(0.0));
    ShadingPoint at = visible;
    RayCone cone = RayCone(push.spread * at.surface.depth, push.spread);
    for (uint depth = 0u; depth < DEPTH && path.throughput != vec3(0.0); depth++) {
        uint dimension = FIRST_DIMENSION + depth * DIMENSIONS;
        if (depth == 0u) path.throughput /= max(at.reflection.reflected, vec3(1e-4));
        path.radiance += path.throughput * invisible_light(at, first_light, pixel, INVISIBLE_DIMENSION + 2u * depth);
        first_light = frame.direct_lights;
        Sampled sampled = sample_reflected(at.reflection, noise(pixel, dimension));
        float cosine = dot(at.reflection.normal, sampled.direction);
        if (sampled.density == 0.0 || cosine <= 0.0) break;
        vec3 through = sampled.density < 0.0 ? fresnel(at.reflection, cosine)
            : reflected_towards_eye(at.reflection, sampled.direction) * (cosine / sampled.density);
        path.throughput *= through;
        // A ray that the shading normal sends below the triangle is mirrored by it: no energy is lost.
        float below = min(dot(at.surface.geometric, sampled.direction), 0.0);
        sampled.direction -= 2.0 * below * at.surface.geometric;
        cone.spread += at.reflection.alpha;

        vec3 origin = ray_origin(at.surface);
        TracerHit hit;
        bool met = trace_closest(origin, sampled.direction, 0.0, FAR, hit);
        if (HAS_THIN_SURFACES) path.throughput *= trace_transmittance(origin, sampled.direction, 0.0, met ? just_before(hit.t) : FAR);
        if (!met) {
            // Perfect mirrors see suns, other lobes get their light directly.
            if (push.has_environment == 1u) path.radiance += path.throughput * environment_radiance(sampled.direction, sampled.density < 0.0);
            break;
        }
        HitSurface surface = surface_of(hit, sampled.direction, cone);
        cone.width += cone.spread * hit.t;
        if (depth == 0u) first = FirstHit(true, hit.instance, hit.t, surface.position, surface.shading, surface.geometric);
        at.surface = Surface(surface.position, surface.shading, surface.geometric, hit.t, 0.0);
        at.is_glossy = reflects(surface.bsdf);
        at.reflection = prepare_bsdf(surface.bsdf, surface.shading, -sampled.direction);
        at.diffuse = at.reflection.diffuse;
        bool goes_on = SPLIT_SUM == 0u && at.is_glossy && depth + 1u < DEPTH && reflection_weight(surface.bsdf.roughness) > 0.5;
        // Area lights that the path goes on to meet count there.
        at.gloss_of_areas = goes_on ? 0.0 : 1.0;
        vec3 albedo = at.diffuse;
        if (SPLIT_SUM == 1u && at.is_glossy) {
            if (push.has_environment == 1u) path.radiance += path.throughput * split_sum(at.reflection, surface.bsdf.roughness);
        } else if (at.is_glossy && !goes_on) {
            albedo += at.reflection.reflected;
        }
        vec2 picks = noise(pixel, dimension + 1u);
        shade(path, surface, at, hit.instance, albedo, vec4(picks, noise(pixel, dimension + 2u)));
        if (!goes_on) break;
    }
    path.record.weight *= path.record_weight;
    path.record.random = noise(pixel, 3u).x;
    return path;
}

// Whether the surface is flat around the pixel.
bool is_flat(ivec2 pixel, vec3 normal) {
    for (int i = 0; i < 4; i++) {
        ivec2 at = pixel + ivec2(i / 2 == 0 ? i * 2 - 1 : 0, i / 2 == 1 ? i * 2 - 5 : 0) * 2;
        if (!inside(at) || texelFetch(gbuffer_instance, at, 0).x != texelFetch(gbuffer_instance, pixel, 0).x) continue;
        if (dot(octahedral_decode(imageLoad(gbuffer_normal, at).xy), normal) < FLAT) return false;
    }
    return true;
}

// The surface that is seen in the reflection.
struct MirrorImage {
    vec3 position; // of the mirror image
    float depth;
    vec3 shading;
    vec3 geometric;
    uint instance; // plus one
};

MirrorImage image_of(Surface mirror, FirstHit hit) {
    vec3 along = mirror.position - frame.eye.xyz;
    float stretch = 1.0 + hit.distance / length(along);
    MirrorImage image = MirrorImage(frame.eye.xyz + along * stretch, mirror.depth * stretch, -normalize(along), -normalize(along), NO_INSTANCE);
    if (hit.met) {
        image.shading = reflect(hit.shading, mirror.shading);
        image.geometric = reflect(hit.geometric, mirror.shading);
        image.instance = hit.instance + 1u;
    }
    return image;
}

VisibleSurface last_surface_at(ivec2 texel) { return unpack_surface(imageLoad(last_image_surface, texel)); }
uint last_instance_at(ivec2 texel) { return imageLoad(last_image_instance, texel).x; }
#define REPROJECTION_TESTS 3
#include "reprojected_surface.glsl"

// Where the mirror image was in the last frame, and which texels showed it there, or if it is blurred, its mirror: as `reprojected`.
vec4 image_then(ivec2 pixel, Surface mirror, MirrorImage image, FirstHit hit, bool is_sharp, MirrorImage shown) {
    vec3 then = image.position;
    if (hit.met) {
        InstanceData data = instances.data[hit.instance];
        vec3 hit_then = transform_point(data.previous_object_to_world, transform_point(data.world_to_object, hit.position));
        then += reflect(hit_then - hit.position, mirror.shading);
    }
    vec4 clip = frame.previous_view_projection * vec4(then, 1.0);
    if (clip.w <= 0.0 || push.has_history == 0u) return vec4(0.0);
    vec2 motion = vec2(pixel) + 0.5 + frame.jitter - (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.size);
    ExpectedSurface expected = ExpectedSurface(VisibleSurface(mirror.depth, shown.shading), shown.instance, MIRROR_TOLERANCE * mirror.depth);
    if (is_sharp) {
        expected.surface.depth = clip.w;
        expected.tolerance = clip.w * depth_tolerance(IMAGE_ROUNDING, image.geometric, image.position, push.spread);
    }
    vec2 masks = showing_texels(expected, vec2(pixel) - motion);
    return vec4(motion, masks);
}

// How wide a blur is of use, as a share of the widest: the width of the lobe, and a little where light at the hit is noisy.
float blur_of(Surface mirror, float alpha, FirstHit hit, bool noisy_light) {
    float seen_from = distance(mirror.position, frame.eye.xyz);
    float lobe = LOBE_WIDTH * alpha * hit.distance / ((hit.distance + seen_from) * push.spread);
    return clamp(max(lobe, noisy_light ? IMAGE_BLUR : 0.0) / WIDEST, 0.0, 1.0);
}

// The surface where a reflection path begins, as the denoiser sees it.
struct ReflectingSurface {
    ShadingPoint at;
    float roughness;
    uint instance;
    bool mirrors;
};

// The first thin surface of a pixel, and the path that begins there, as a share of its albedo; the rest is for irradiance.
bool thin_surface_at(ivec2 pixel, out ReflectingSurface reflector, out Path path) {
    path = new_path();
    vec3 direction = pixel_ray(vec2(pixel));
    float start = push.near;
    TracerHit hit;
    HitSurface met;
    if (!next_thin_surface(direction, start, FAR, push.spread, hit, met)) return false;
    Reflection reflection = prepare_bsdf(met.bsdf, met.shading, -normalize(direction));
    reflector.at = ShadingPoint(Surface(met.position, met.shading, met.geometric, hit.t, 0.0), reflection.diffuse, reflects(met.bsdf), reflection, 0.0);
    reflector.roughness = met.bsdf.roughness;
    reflector.instance = hit.instance + 1u;
    reflector.mirrors = true;
    vec3 all = max(reflection.diffuse + reflection.reflected, vec3(1e-6));
    path.throughput = reflection.reflected * reflection_weight(met.bsdf.roughness) / all;
    vec3 weight = (vec3(1.0) - path.throughput) / PI;
    path.record_weight = luminance(weight);
    path.record = HitRecord(met.position, met.shading, met.geometric, weight / max(path.record_weight, 1e-6), 0.0);
    return true;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    ReflectingSurface reflector;
    reflector.at.surface = surface_at(pixel);
    reflector.roughness = imageLoad(gbuffer_albedo, pixel).a;
    reflector.instance = id.x;
    reflector.mirrors = id.x != 0u && reflection_weight(reflector.roughness) > 0.0;
    if (reflector.mirrors) {
        reflector.at = shading_point_at(pixel, id);
        reflector.mirrors = reflector.at.is_glossy;
    }
    vec4 then = imageLoad(reprojected, pixel);
    Path path = new_path();
    ShadingPoint begins = reflector.at;
    vec3 scale = vec3(1.0);
    uint first_light = frame.direct_lights;
    bool is_thin = false, is_traced = true;
    vec3 before = HAS_THIN_SURFACES ? imageLoad(thin_mirrored, pixel).rgb : vec3(0.0);
    ReflectingSurface thin;
    Path from_thin;
    if (before != vec3(0.0) && thin_surface_at(pixel, thin, from_thin)) {
        vec3 behind = vec3(0.0);
        if (reflector.mirrors) behind = reflector.at.reflection.reflected * reflection_weight(reflector.roughness) * imageLoad(thin_transmittance, pixel).rgb;
        float share = luminance(before) / luminance(before + behind);
        bool begins_before = noise(pixel, 3u).y < share;
        scale = (begins_before ? before / share : behind / (1.0 - share)) / max(before + behind, vec3(1e-6));
        if (begins_before) {
            path = from_thin;
            begins = thin.at;
            first_light = max(first_light, frame.light_count);
        }
        is_thin = share >= 0.5;
        is_traced = is_thin == begins_before;
        if (is_thin) reflector = thin;
    }

    vec4 result = vec4(0.0);
    Surface surface = reflector.at.surface;
    MirrorImage image = MirrorImage(surface.position, surface.depth, surface.shading, surface.geometric, reflector.instance);
    if (reflector.mirrors) {
        FirstHit first;
        path = trace_path(pixel, path, begins, first_light, first);
        path.record.weight *= scale;
        // The reflection by another surface than the visible one says nothing of the image in it.
        if (!is_traced) first = FirstHit(false, 0u, 0.0, vec3(0.0), vec3(0.0), vec3(0.0));
        float blur = blur_of(surface, reflector.at.reflection.alpha, first, path.record.weight != vec3(0.0));
        result = vec4(min(path.radiance * scale, MOST_HALF), blur);
        bool is_sharp = reflector.roughness < IMAGE_ROUGHNESS && is_traced;
        MirrorImage mirrored = image_of(surface, first);
        bool moves = reflector.roughness < MOVING_ROUGHNESS && (is_thin || is_flat(pixel, surface.shading));
        MirrorImage moving = image;
        if (is_sharp) image = mirrored;
        if (moves) moving = mirrored;
        else first.met = false;
        if (moves || is_thin) then = image_then(pixel, surface, moving, first, is_sharp, image);
    }
    imageStore(reflection, pixel, rounded(result));
    imageStore(hit_place, pixel, pack_place(path.record));
    imageStore(hit_weight, pixel, pack_weight(path.record));
    // Where nothing is mirrored there is nothing to denoise.
    float depth = reflector.mirrors ? image.depth : 0.0;
    imageStore(image_depth, pixel, vec4(depth));
    imageStore(image_normal, pixel, vec4(octahedral_encode(image.shading), octahedral_encode(image.geometric)));
    VisibleSurface packed = VisibleSurface(depth, image.shading);
    imageStore(image_surface, pixel, reflector.mirrors ? pack_surface(packed) : uvec4(0u));
    imageStore(image_instance, pixel, uvec4(image.instance));
    imageStore(image_reprojected, pixel, then);
}
