#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Brings every set buffer into the current view and adds them up (algorithm 4 of Tonna 2019). A pixel
// follows its surface back to where it was when the set was drawn: by its instance's transform of that
// time, then by that time's camera. Sets that have not seen the surface are made up for by the others,
// in proportion to flux. Where nothing has moved since the last frame, its sum goes on: less what the set that
// was drawn again was before, plus what it is now.
// Out: irradiance; a: how many sets saw the surface, negative where it may move.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene.glsl"

layout(local_size_x = 64, local_size_y = 1) in;

#define DRAWN_SETS_BINDING 5
#include "drawn_sets.glsl"

// Whether anything that is seen may have moved since a set was drawn, or the camera. CPU drivers spend time on what no
// pixel needs too.
layout(constant_id = 0) const bool MOVES = true;
// Whether every set has seen every surface that is seen now, where it is.
layout(constant_id = 1) const bool STEADY = false;

// Pixels of a thread, one below the other, `row_step` apart.
layout(constant_id = 2) const uint ROWS = 1u;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 4, rgba16f) uniform readonly image2DArray set_buffers;
layout(set = 0, binding = 6, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
// Rows that lead from object space to what the camera of each layer saw: see seen_by.
layout(set = 0, binding = 7) uniform utextureBuffer view_history;
layout(set = 0, binding = 8, rgba32f) uniform image2D irradiance;

struct Push {
    uvec2 first;          // pixel
    uvec2 end;            // behind the last
    uvec2 anew_first;     // pixel that may show another surface than in the last frame though neither may move
    uvec2 anew_end;       // behind the last
    uvec2 set_size;       // of the set buffers, texels
    uint row_step;        // from one row of pixels to the next
    uint running;         // 1: the last frame's sums hold where nothing has changed
    uint refresh;         // which of REFRESHED rows of pixels is summed up anew
    uint instance_count;
    uint scale_missing;
    float total_flux;
    uint set_count;       // sets in all
    uint drawn_count;     // sets that have been drawn at all
    uint same_view_count; // those of them, at the beginning, that the current camera drew
    uint first_texel;     // of the list of sets
    uint layer_before;    // of the set that was drawn again, before
    uint layer_now;       // and now
    float scale_before;   // what its irradiance is multiplied by, before
    float scale_now;      // and now
};
// Loaded before threads part, as `frame` is.
layout(push_constant) uniform PushBlock { Push data; } pushed;
Push push = pushed.data;

#include "reprojection.glsl"

// Frames after which every sum has been made anew, so that rounding does not pile up. Twin: `REFRESHED` in
// src/passes/indirect_reprojection.rs.
const uint REFRESHED = 1024u;

// Most that the set buffers' depths, half floats, are off.
const float ROUNDING = 1.0 / 2048.0;

// Whether a texel that a set has drawn from the same view shows what is now at this depth.
bool sees(vec4 stored, float depth) {
    return abs(stored.w / frame.depth_scale - depth) <= max(0.25 * frame.position_cutoff, ROUNDING) * depth;
}

// Goes on with the sum of the last frame where every set is in it and neither what is seen may move nor what was seen then;
// tells whether it did.
bool goes_on(ivec2 pixel, vec4 last, inout vec4 sum) {
    if (MOVES && (texelFetch(gbuffer_instance, pixel, 0).y & MAY_MOVE) != 0u) return false;
    vec4 before = imageLoad(set_buffers, ivec3(pixel, int(push.layer_before)));
    vec4 now = imageLoad(set_buffers, ivec3(pixel, int(push.layer_now)));
    if (last.a != float(push.set_count)) return false;
    vec3 was = before.rgb * push.scale_before;
    vec3 is = now.rgb * push.scale_now;
    vec3 rest = last.rgb - was;
    // What is left of a difference of equal numbers is not light.
    rest = mix(vec3(0.0), rest, greaterThan(rest, 1e-5 * last.rgb));
    // What has not changed must not be rounded either: then the picture stands still.
    sum = vec4(mix(rest + is, last.rgb, equal(was, is)), last.a);
    return true;
}

// What the sets bring together.
struct Sum {
    vec3 irradiance;
    float flux; // luminous, of the sets that saw the surface
    uint count; // of those
};

// What stands still under a camera that stands still is where it was, unless something else hid it.
void add_same_views(inout Sum sum, ivec2 pixel, float depth, uint sets) {
    if (sets == 0u) return;
    // Here and below, loops ask at their end whether to go on: see tracer_find.
    uint i = 0u;
    do {
        SetParameters set = set_at(push.first_texel, i);
        vec4 stored = imageLoad(set_buffers, ivec3(pixel, int(set.layer)));
        bool same = sees(stored, depth);
        sum.irradiance += same ? stored.rgb * set.scale : vec3(0.0);
        sum.flux += same ? set.flux : 0.0;
        sum.count += same ? 1u : 0u;
    } while (++i < sets);
}

// What each of the sets from `first` on saw where the surface was when it drew.
void add_other_views(inout Sum sum, InObject surface, uint first) {
    if (first >= push.drawn_count) return;
    uint i = first;
    do {
        SetParameters set = set_at(push.first_texel, i);
        vec3 found;
        if (look_up(set, seen_by(set, surface), found)) {
            sum.irradiance += found;
            sum.flux += set.flux;
            sum.count++;
        }
    } while (++i < push.drawn_count);
}

// The sum of all sets.
vec4 sum_of_all(ivec2 pixel) {
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    if (id.x == 0u) return vec4(0.0);
    float depth = imageLoad(gbuffer_depth, pixel).r;
    bool may_move = MOVES && (id.y & MAY_MOVE) != 0u;
    uint same_view_count = may_move ? 0u : push.same_view_count;
    Sum sum = Sum(vec3(0.0), 0.0, 0u);
    add_same_views(sum, pixel, depth, same_view_count);
    if (MOVES) {
        vec3 n = octahedral_decode(imageLoad(gbuffer_normal, pixel).zw);
        add_other_views(sum, in_object(id.x - 1u, position_at(pixel, depth), n), same_view_count);
    }
    if (push.scale_missing == 1u && sum.flux > 0.0 && sum.count < push.set_count) {
        sum.irradiance *= push.total_flux / sum.flux;
    }
    float count = float(sum.count);
    return vec4(sum.irradiance, may_move ? -count : count);
}

// The pixel's sum of this frame, gone on with or made anew.
void bring_together(uvec2 place) {
    ivec2 pixel = ivec2(place);
    bool anew = all(greaterThanEqual(place, push.anew_first)) && all(lessThan(place, push.anew_end));
    bool running = STEADY || (push.running == 1u && !anew && place.y % REFRESHED != push.refresh);
    vec4 last = imageLoad(irradiance, pixel);
    vec4 sum = last;
    if (running) running = goes_on(pixel, last, sum);
    if (!STEADY && !running) sum = sum_of_all(pixel);
    // To write costs CPU drivers more than to compare.
    if (sum != last) imageStore(irradiance, pixel, sum);
}

void main() {
    uvec2 place = push.first + gl_GlobalInvocationID.xy * uvec2(1u, ROWS * push.row_step);
    uint end = min(place.y + ROWS * push.row_step, push.end.y);
    if (place.x >= push.end.x || place.y >= end) return;
    do {
        bring_together(place);
        place.y += push.row_step;
    } while (place.y < end);
}
