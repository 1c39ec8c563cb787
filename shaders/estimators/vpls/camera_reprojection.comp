#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// The sum of all set buffers, each looked up by the camera that rendered it, in the nearest texel; one whose position lies beyond the
// cut-off is missing (algorithm 4 of Tonna 2019). Objects that move are not followed. Out: irradiance; a: how many sets were found.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "rounded.glsl"
#include "scene_set.glsl"
#define VPLS_BINDING 3
#include "vpls.glsl"
#include "representative.glsl"
#include "same_surface.glsl"
#define SET_BUFFERS_BINDING 5
#include "set_buffers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D irradiance;
#include "surface.glsl"

// Irradiance of a set at the point, W/m^2; false where the set's surface lies beyond the cut-off.
bool found_in(uint set, vec3 position, vec3 normal, out vec3 found) {
    found = vec3(0.0);
    SetParameters parameters = set_at(set);
    // The last instance is the world itself.
    vec3 p = to_view(set, ObjectPoint(sets.instance_count - 1u, position, normal)).position;
    vec2 size = vec2(sets.size);
    vec2 tangents = parameters.tan_y * vec2(size.x / size.y, 1.0);
    ivec2 texel = ivec2(floor((p.xy / (p.z * tangents) * 0.5 + 0.5) * size));
    bool inside = p.z > 0.0 && all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(sets.size)));
    if (parameters.scale <= 0.0 || !inside) return false;
    vec4 stored = unpack_texel(imageLoad(set_buffers, ivec3(texel, parameters.layer)));
    vec2 ray = ((vec2(texel) + 0.5) / size * 2.0 - 1.0) * tangents;
    found = stored.rgb * parameters.scale;
    return stored.a > 0.0 && distance(stored.a * vec3(ray, 1.0), p) <= vpl.position_cutoff * p.z;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    Surface surface = surface_at(pixel);
    vec4 sum = vec4(0.0);
    float flux = 0.0;
    for (uint set = 0u; set < sets.set_count && surface.depth > 0.0; set++) {
        vec3 found;
        if (!found_in(set, surface.position, surface.geometric, found)) continue;
        sum += vec4(found, 1.0);
        flux += set_at(set).flux;
    }
    if (sets.scale_missing == 1u && flux > 0.0) sum.rgb *= sets.total_flux / flux;
    imageStore(irradiance, pixel, storable(sum));
}
