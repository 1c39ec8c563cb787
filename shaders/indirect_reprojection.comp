#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Brings every set buffer into the current view and adds them up (algorithm 4 of Tonna 2019). A pixel
// follows its surface back to where it was when the set was drawn: by its instance's transform of that
// time, then by that time's camera. Sets that have not seen the surface are made up for by the others,
// in proportion to flux.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const uint MAX_SETS = 64u;

// Camera and light of the frame that drew a set. Twin: SetParameters in src/passes/structs.rs.
struct SetParameters {
    vec4 eye;   // xyz: world position; w: 1 / irradiance scale
    vec4 ray;   // xyz: what the middle of the picture sees, 1 along the view axis; w: luminous flux of the set
    vec4 ray_x; // xyz: how that changes to the right edge; w: one over its squared length
    vec4 ray_y; // xyz: how it changes to the bottom edge; w: one over its squared length
    uint layer; // of the set buffers
    uint pad0;
    uint pad1;
    uint pad2;
};

layout(set = 0, binding = 1) uniform texture2D gbuffer_position;
layout(set = 0, binding = 2) uniform texture2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 4) uniform texture2DArray set_buffers;
layout(set = 0, binding = 5, std140) uniform SetBlock { SetParameters data[MAX_SETS]; } set_parameters;
layout(set = 0, binding = 6, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
layout(set = 0, binding = 7, std430) readonly buffer HistoryBlock { vec4 rows[]; } instance_history;
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D irradiance;

layout(push_constant) uniform Push {
    uint instance_count;
    uint scale_missing;
    float total_flux;
    uint drawn_count;     // sets that have been drawn at all
    uint same_view_count; // those of them, at the beginning, that the current camera drew
} push;

// Texel coordinates this close to a texel's centre take that texel alone, as in a view that stands still.
const float CENTRED = 0.01;

vec3 from_rows(uint first, vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(
        dot(instance_history.rows[first], h), dot(instance_history.rows[first + 1u], h),
        dot(instance_history.rows[first + 2u], h));
}

// Irradiance of a set at world position p (of that time) with normal n; false where it was not seen.
bool look_up(SetParameters parameters, vec3 p, vec3 n, out vec3 found) {
    vec3 v = p - parameters.eye.xyz;
    float depth = dot(v, parameters.ray.xyz);
    if (depth <= 0.0) return false;
    vec2 size = vec2(frame.size);
    vec2 ndc = vec2(dot(v, parameters.ray_x.xyz) * parameters.ray_x.w, dot(v, parameters.ray_y.xyz) * parameters.ray_y.w) / depth;
    vec2 texel = (ndc * 0.5 + 0.5) * size - 0.5;
    vec2 base = floor(texel);
    vec2 part = texel - base;
    bool centred = all(lessThan(abs(part - round(part)), vec2(CENTRED)));
    if (centred) {
        base += round(part);
        part = vec2(0.0);
    }
    int taps = centred ? 1 : 4;
    // Neighbouring texels of a surface seen at a grazing angle are farther apart than the cut-off.
    float cosine = abs(dot(n, v)) * inversesqrt(dot(v, v));
    float footprint = depth * 2.0 / size.y * inversesqrt(parameters.ray_y.w) / max(cosine, 0.05);
    float near = 0.25 * frame.position_cutoff * depth;
    float cutoff = max(4.0 * near, 1.5 * footprint);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < taps; i++) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        float weight = (corner.x == 1 ? part.x : 1.0 - part.x) * (corner.y == 1 ? part.y : 1.0 - part.y);
        ivec2 at = ivec2(base) + corner;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        vec4 stored = texelFetch(set_buffers, ivec3(at, int(parameters.layer)), 0);
        if (stored.w <= 0.0) continue;
        // The surface that was drawn there, from its depth.
        vec2 at_ndc = (vec2(at) + 0.5) / size * 2.0 - 1.0;
        vec3 ray = parameters.ray.xyz + at_ndc.x * parameters.ray_x.xyz + at_ndc.y * parameters.ray_y.xyz;
        vec3 offset = ray * (stored.w / frame.depth_scale) - v;
        if (dot(offset, offset) > cutoff * cutoff || abs(dot(offset, n)) > near) continue;
        sum += weight * stored.rgb;
        weights += weight;
    }
    found = sum / max(weights, 1e-6) * parameters.eye.w;
    return weights > 0.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, frame.size))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    if (id.x == 0u) {
        imageStore(irradiance, pixel, vec4(0.0));
        return;
    }
    vec4 position = texelFetch(gbuffer_position, pixel, 0);
    vec3 p = position.xyz;
    vec3 n = octahedral_decode(texelFetch(gbuffer_normal, pixel, 0).zw);

    vec3 sum = vec3(0.0);
    float present = 0.0;
    uint count = 0u;

    // What stands still under a camera that stands still is where it was, unless something else hid it.
    uint may_move = (id.y & MAY_MOVE) != 0u ? 1u : 0u;
    uint same_view_count = may_move == 1u ? 0u : push.same_view_count;
    for (uint i = 0u; i < same_view_count; i++) {
        SetParameters parameters = set_parameters.data[i];
        vec4 stored = texelFetch(set_buffers, ivec3(pixel, int(parameters.layer)), 0);
        bool same = abs(stored.w / frame.depth_scale - position.w) <= 0.25 * frame.position_cutoff * position.w;
        sum += same ? stored.rgb * parameters.eye.w : vec3(0.0);
        present += same ? parameters.ray.w : 0.0;
        count += same ? 1u : 0u;
    }

    // Loops of one turn, not branches: CPU drivers run both sides of a branch, but skip loops that no lane enters.
    vec3 p_os = p;
    vec3 tip_os = p + n;
    for (uint i = 0u; i < may_move; i++) {
        p_os = transform_point(instances.data[id.x - 1u].world_to_object, p);
        tip_os = transform_point(instances.data[id.x - 1u].world_to_object, p + n);
    }
    for (uint i = same_view_count; i < push.drawn_count; i++) {
        SetParameters parameters = set_parameters.data[i];
        vec3 p_then = p;
        vec3 n_then = n;
        for (uint moved = 0u; moved < may_move; moved++) {
            uint row = (parameters.layer * push.instance_count + id.x - 1u) * 3u;
            p_then = from_rows(row, p_os);
            n_then = normalize(from_rows(row, tip_os) - p_then);
        }
        vec3 found;
        if (!look_up(parameters, p_then, n_then, found)) continue;
        sum += found;
        present += parameters.ray.w;
        count++;
    }
    if (push.scale_missing == 1u && present > 0.0 && count < frame.sets) sum *= push.total_flux / present;
    imageStore(irradiance, pixel, vec4(sum, float(count)));
}
