#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shows what the VPLs' passes have made instead of the picture. Out: display. Light is shown as the picture is, with its
// exposure; everything else as plain display values.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene_set.glsl"
#include "tone_map.glsl"
#include "false_colour.glsl"
#define VPLS_BINDING 4
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#define SET_BUFFERS_BINDING 6
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 9, rgba32f) uniform readonly image2D sampled_irradiance;
layout(set = 0, binding = 10, rgba16f) uniform readonly image2D irradiance;
layout(set = 0, binding = 11, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 12, rgba8) uniform writeonly image2D display;
#include "surface.glsl"
#include "slope.glsl"

// Twin: VIEWS in src/estimators/vpls/view.rs.
const uint UNFILTERED = 0u;
const uint FILTERED = 1u;
const uint SET_BUFFER = 2u;
const uint SET_REPROJECTED = 3u;
const uint SET_COUNT = 4u;
const uint STALENESS = 5u;
const uint VPL_VISIBILITY = 6u;
const uint VPL_USEFULNESS = 7u;

const vec3 MISSING = vec3(1.0, 0.0, 1.0);

// A white surface under an irradiance.
vec3 lit(vec3 e) { return shown(e / PI * exposure.factor); }

// Shows the set as it was rendered, by the camera of that time.
vec3 set_buffer(ivec2 pixel) {
    SetParameters parameters = set_at(sets.shown_set);
    ivec2 texel = ivec2((vec2(pixel) + 0.5) / vec2(frame.size) * vec2(set_extent(sets.size, sets.set_step)));
    vec4 stored = unpack_texel(imageLoad(set_buffers, ivec3(texel, parameters.layer)));
    return parameters.scale > 0.0 ? lit(stored.rgb * parameters.scale * float(sets.set_count)) : MISSING;
}

// Shows the irradiance that the set's texel has sampled, before the filter.
vec3 unfiltered(ivec2 pixel) {
    vec3 sampled = imageLoad(sampled_irradiance, pixel / int(sets.rendered_step)).rgb;
    return lit(sampled / vpl.irradiance_scale * float(sets.set_count));
}

// Irradiance of the set at this pixel's surface, tone-mapped; marked where the set has none.
vec3 set_reprojected(ivec2 pixel, uint instance) {
    Surface surface = surface_at(pixel);
    SeenPlaces places = places_of(instance, surface.position, surface.geometric);
    vec4 found;
    return look_up(sets.shown_set, places, slope_at(pixel, surface), found) ? lit(found.rgb * float(sets.set_count)) : MISSING;
}

// How old the light of this pixel is, on average over the sets by their weights: of each turn that a set is the mean of, the frames since.
vec3 staleness(ivec2 pixel, uint instance) {
    Surface surface = surface_at(pixel);
    SeenPlaces places = places_of(instance, surface.position, surface.geometric);
    float slope = slope_at(pixel, surface);
    float ages = 0.0;
    float weights = 0.0;
    for (uint set = 0u; set < sets.set_count; set++) {
        vec4 found;
        if (!look_up(set, places, slope, found)) continue;
        float since = float((sets.frame - set_at(set).frame) & 0xffffu);
        float turns_before = max(found.a - 1.0, 0.0);
        ages += set_weight(set) * (since + 0.5 * turns_before * float(sets.set_count));
        weights += set_weight(set);
    }
    return weights > 0.0 ? share_colour(ages / weights / float(sets.set_count)) : MISSING;
}

vec3 surface_view(ivec2 pixel, uint instance) {
    switch (sets.view) {
        case UNFILTERED: return unfiltered(pixel);
        case SET_REPROJECTED: return set_reprojected(pixel, instance);
        case SET_COUNT: return share_colour(imageLoad(irradiance, pixel).a / float(sets.set_count));
        case STALENESS: return staleness(pixel, instance);
        case VPL_USEFULNESS: return 0.3 * lit(imageLoad(irradiance, pixel).rgb);
        default: return vec3(imageLoad(irradiance, pixel).a);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uint id = texelFetch(gbuffer_instance, pixel, 0).x;
    vec3 colour = vec3(0.0);
    if (sets.view == FILTERED || sets.view == SET_BUFFER) {
        colour = set_buffer(pixel);
    } else if (id > 0u) {
        colour = surface_view(pixel, id - 1u);
    }
    imageStore(display, pixel, vec4(clamp(colour, 0.0, 1.0), 1.0));
}
