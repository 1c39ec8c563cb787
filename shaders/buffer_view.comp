#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Shows one of the images that a frame goes through instead of the picture. In: those images and which one.
// Out: display. Light is shown as the picture is, with its exposure; everything else as plain display values.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "lights.glsl"
#include "packed_irradiance.glsl"
#include "scene.glsl"
#define DRAWN_SETS_BINDING 11
#include "drawn_sets.glsl"
#include "tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 4, std430) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 0, binding = 5) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 7, rgba32f) uniform readonly image2D direct;
layout(set = 0, binding = 8, rgba32f) uniform readonly image2D irradiance;
layout(set = 0, binding = 9) uniform utextureBuffer class_irradiance;
layout(set = 0, binding = 10, rgba16f) uniform readonly image2DArray set_buffers;
layout(set = 0, binding = 12) uniform utextureBuffer view_history; // see seen_by
layout(set = 0, binding = 13, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
layout(set = 0, binding = 14) uniform texture2D shadow_atlas;
layout(set = 0, binding = 15, std430) readonly buffer TileBlock { ShadowTile data[]; } shadow_tiles;
layout(set = 0, binding = 16, std430) readonly buffer ExposureBlock { float factor; } exposure;
layout(set = 0, binding = 17, rgba8) uniform writeonly image2D display;

// Twin: Push in src/passes/buffer_view.rs.
layout(push_constant) uniform Push {
    vec4 low;            // xyz: lower corner of the scene's bounds; w: nearest depth of anything
    vec4 extent;         // xyz: upper corner less the lower; w: farthest depth of anything
    uvec2 set_size;      // of the set buffers, texels
    uint view;           // one of those below
    uint set_count;      // sets in all
    uint set_drawn;      // 1: the set to show has been drawn
    uint instance_count;
    uint tile_size;      // texels across a shadow map
    uint tile_count;     // shadow maps
    uint tile_columns;   // of them in a row
    float unfiltered;    // what the irradiance of one class and set stands for
    uint one_vpl;        // 1: irradiance is that of one VPL, and so is the picture; a: its visibility
    uint first_texel;    // of what is known of that set
} push;

#include "reprojection.glsl"

// Twin: BufferView in src/passes/buffer_view.rs.
const uint COMBINED = 0u;
const uint DIRECT = 1u;
const uint INDIRECT = 2u;
const uint IRRADIANCE = 3u;
const uint UNFILTERED = 4u;
const uint SET_BUFFER = 6u;
const uint SET_REPROJECTED = 7u;
const uint SET_COUNT = 8u;
const uint VPL_VISIBILITY = 9u;
const uint SHADOW_MAPS = 10u;
const uint POSITION = 11u;
const uint DEPTH = 12u;
const uint NORMAL = 13u;
const uint GEOMETRIC_NORMAL = 14u;
const uint ALBEDO = 15u;
const uint SPECULAR = 16u;
const uint SHININESS = 17u;
const uint INSTANCE = 18u;
const uint MATERIAL_ID = 19u;
const uint MOTION = 20u;

const vec3 MISSING = vec3(1.0, 0.0, 1.0);
const vec3 NOTHING = vec3(0.0);
// Movement in pixels that is shown at full strength.
const float FULL_MOTION = 16.0;

// A white surface under an irradiance.
vec3 lit(vec3 e) { return shown(e / PI * exposure.factor); }

// Neighbouring numbers get colours far apart: their hues go on by the golden ratio.
vec3 number_colour(uint number) {
    float hue = fract(float(number) * 0.618034);
    return 0.55 + 0.45 * cos(2.0 * PI * (vec3(hue) + vec3(0.0, 1.0, 2.0) / 3.0));
}

// From black over blue and green to yellow.
vec3 share_colour(float share) {
    vec3 low = mix(vec3(0.0, 0.0, 0.05), vec3(0.15, 0.2, 0.75), clamp(share * 3.0, 0.0, 1.0));
    vec3 middle = mix(low, vec3(0.1, 0.65, 0.45), clamp(share * 3.0 - 1.0, 0.0, 1.0));
    return mix(middle, vec3(1.0, 0.92, 0.2), clamp(share * 3.0 - 2.0, 0.0, 1.0));
}

// What is used of the atlas as large as it fits, in the middle; nearer is lighter.
vec3 shadow_maps(ivec2 pixel) {
    uint rows = (push.tile_count + push.tile_columns - 1u) / push.tile_columns;
    vec2 atlas = vec2(push.tile_columns, rows) * float(push.tile_size);
    vec2 size = vec2(frame.size);
    float scale = max(atlas.x / size.x, atlas.y / size.y);
    ivec2 at = ivec2(floor((vec2(pixel) + 0.5 - 0.5 * size) * scale + 0.5 * atlas));
    if (push.tile_count == 0u || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(atlas)))) return vec3(0.1);
    uint tile = uint(at.y) / push.tile_size * push.tile_columns + uint(at.x) / push.tile_size;
    if (tile >= push.tile_count) return vec3(0.1);
    float depth = texelFetch(shadow_atlas, at, 0).r;
    if (shadow_tiles.data[tile].texel.y != 1.0) return vec3(depth);
    // Reversed and infinite: near / distance, with near a ten-thousandth of the scene's radius.
    return vec3(depth > 0.0 ? 1.0 - 1e-4 / (2.0 * depth) : 0.0);
}

vec3 set_buffer(ivec2 pixel) {
    if (push.set_drawn == 0u) return MISSING;
    SetParameters set = set_at(push.first_texel, 0u);
    ivec2 at = ivec2((vec2(pixel) + 0.5) / vec2(frame.size) * vec2(push.set_size));
    vec4 stored = imageLoad(set_buffers, ivec3(at, int(set.layer)));
    return lit(stored.rgb * set.scale * float(push.set_count));
}

// What the set knows of the surface of this pixel; what it does not know is marked.
vec3 set_reprojected(InObject surface) {
    if (push.set_drawn == 0u) return MISSING;
    SetParameters set = set_at(push.first_texel, 0u);
    vec3 found;
    return look_up(set, seen_by(set, surface), found) ? lit(found * float(push.set_count)) : MISSING;
}

// How far the surface has moved in the picture since the last frame, in pixels.
vec2 motion(ivec2 pixel, vec3 p, uint instance) {
    InstanceData data = instances.data[instance];
    vec3 p_then = transform_point(data.previous_object_to_world, transform_point(data.world_to_object, p));
    vec3 clip = (frame.previous_view_projection * vec4(p_then, 1.0)).xyw;
    return vec2(pixel) + 0.5 - (clip.xy / clip.z * 0.5 + 0.5) * vec2(frame.size);
}

// Views of things that are there where no surface is, too.
bool whole_picture(ivec2 pixel, out vec3 colour) {
    colour = NOTHING;
    switch (push.view) {
        case SHADOW_MAPS: colour = shadow_maps(pixel); return true;
        case SET_BUFFER: colour = set_buffer(pixel); return true;
        case DIRECT: colour = shown(imageLoad(direct, pixel).rgb * exposure.factor); return true;
        default: return false;
    }
}

vec3 light_view(ivec2 pixel) {
    vec3 e = imageLoad(irradiance, pixel).rgb;
    vec3 albedo = imageLoad(gbuffer_albedo, pixel).rgb;
    switch (push.view) {
        case UNFILTERED: return lit(unpack_irradiance(texelFetch(class_irradiance, texel_of(pixel)).rg) * push.unfiltered);
        case IRRADIANCE: return lit(e);
        default: return shown(albedo / PI * e * exposure.factor);
    }
}

vec3 surface_view(ivec2 pixel, float depth, uvec2 id) {
    vec3 position = position_at(pixel, depth);
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    vec4 specular = materials.data[id.y & MATERIAL].specular;
    vec3 geometric = octahedral_decode(normals.zw);
    vec4 light = imageLoad(irradiance, pixel);
    switch (push.view) {
        case SET_REPROJECTED: return set_reprojected(in_object(id.x - 1u, position, geometric));
        case SET_COUNT: return share_colour(abs(light.a) / float(push.set_count));
        case VPL_VISIBILITY: return vec3(push.one_vpl == 1u ? light.a : 0.0);
        case POSITION: return (position - push.low.xyz) / push.extent.xyz;
        case DEPTH: return vec3((push.extent.w - depth) / (push.extent.w - push.low.w));
        case NORMAL: return octahedral_decode(normals.xy) * 0.5 + 0.5;
        case GEOMETRIC_NORMAL: return geometric * 0.5 + 0.5;
        case ALBEDO: return srgb(imageLoad(gbuffer_albedo, pixel).rgb);
        case SPECULAR: return srgb(specular.rgb);
        case SHININESS: return vec3(log2(specular.a + 1.0) / 10.0);
        case INSTANCE: return number_colour(id.x - 1u);
        case MATERIAL_ID: return number_colour(id.y & MATERIAL);
        case MOTION:
            vec2 pixels = motion(pixel, position, id.x - 1u);
            // The root shows slow movement, too.
            return vec3(0.5 + 0.5 * sign(pixels) * sqrt(abs(pixels) / FULL_MOTION), 0.5);
        default: return light_view(pixel);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    vec3 colour;
    if (!whole_picture(pixel, colour) && id.x > 0u) {
        colour = surface_view(pixel, imageLoad(gbuffer_depth, pixel).r, id);
    }
    imageStore(display, pixel, vec4(clamp(colour, 0.0, 1.0), 1.0));
}
