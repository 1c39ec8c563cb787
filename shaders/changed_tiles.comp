#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Which tiles of the picture have to be lit again: those that may show other surfaces than in the last frame, and those
// whose surfaces lie where shadow maps have changed.
#include "frame.glsl"
#include "lights.glsl"
#include "picture_tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, std430) readonly buffer TileBlock { ShadowTile data[]; } shadow_tiles;
// First texel that has changed in each shadow tile, counted from the tile's, and that behind the last.
layout(set = 0, binding = 3, std430) readonly buffer PartBlock { uvec4 data[]; } changed_parts;
layout(set = 0, binding = 4, std430) buffer ListBlock { TileList data; uint tiles[]; } tile_list;

layout(push_constant) uniform Push {
    uvec2 changed_first; // pixel that may show another surface
    uvec2 changed_end;   // behind the last
    uint shadow_tile_count;
    uint pad0;
} push;

// Texels that a lookup may be away from where its surface is: how far receivers are moved, and the filter.
const float REACH = 5.0;

// Least and greatest view depth of a tile's surfaces; the least is greater where there are none.
vec2 depths_of(uvec2 first, uvec2 end) {
    vec2 depths = vec2(1e38, 0.0);
    for (uint y = first.y; y < end.y; y++) {
        for (uint x = first.x; x < end.x; x++) {
            float depth = imageLoad(gbuffer_depth, ivec2(x, y)).r;
            if (depth > 0.0) depths = vec2(min(depths.x, depth), max(depths.y, depth));
        }
    }
    return depths;
}

// A corner of what a tile of the picture sees between two depths.
vec3 corner_at(uvec2 first, uvec2 end, vec2 depths, uint corner) {
    vec2 at = vec2((corner & 1u) == 0u ? first.x : end.x, (corner & 2u) == 0u ? first.y : end.y);
    vec2 ndc = at * (2.0 / vec2(frame.size)) - 1.0;
    float depth = (corner & 4u) == 0u ? depths.x : depths.y;
    return frame.eye.xyz + depth * (frame.ray.xyz + ndc.x * frame.ray_x.xyz + ndc.y * frame.ray_y.xyz);
}

// Whether something in that part of the world may be looked up in the changed part of a shadow tile.
bool looks_up(uvec2 first, uvec2 end, vec2 depths, ShadowTile tile, vec4 part) {
    vec2 low = vec2(1e38);
    vec2 high = vec2(-1e38);
    uint behind = 0u;
    for (uint corner = 0u; corner < 8u; corner++) {
        vec4 clip = tile.view_projection * vec4(corner_at(first, end, depths, corner), 1.0);
        if (clip.w <= 0.0) {
            behind++;
        } else {
            vec2 texel = (clip.xy / clip.w * 0.5 + 0.5) * tile.rectangle.z;
            low = min(low, texel);
            high = max(high, texel);
        }
    }
    if (behind > 0u) return behind < 8u;
    bool touched = all(lessThan(low, part.zw + REACH)) && all(greaterThan(high, part.xy - REACH));
    // Beyond a spot's cone there is no light for a shadow to take away.
    vec2 middle = vec2(0.5 * tile.rectangle.z);
    bool lit = tile.texel.z == 0.0 || distance(middle, clamp(middle, low, high)) < tile.texel.z;
    return touched && lit;
}

bool shadows_changed(uvec2 first, uvec2 end) {
    vec2 depths = depths_of(first, end);
    bool changed = false;
    for (uint i = 0u; i < push.shadow_tile_count && depths.x <= depths.y; i++) {
        uvec4 part = changed_parts.data[i];
        if (all(lessThan(part.xy, part.zw))) {
            changed = changed || looks_up(first, end, depths, shadow_tiles.data[i], vec4(part));
        }
    }
    return changed;
}

void main() {
    uvec2 tiles = (frame.size + PICTURE_TILE - 1u) / PICTURE_TILE;
    uint index = gl_GlobalInvocationID.x;
    if (index >= tiles.x * tiles.y) return;
    uvec2 tile = uvec2(index % tiles.x, index / tiles.x);
    uvec2 first = tile * PICTURE_TILE;
    uvec2 end = min(first + PICTURE_TILE, frame.size);
    bool seen = all(lessThan(first, push.changed_end)) && all(greaterThan(end, push.changed_first));
    if (!seen && !shadows_changed(first, end)) return;
    ADD_TILE(tile_list.data, 1u, place);
    tile_list.tiles[place] = pack_tile(tile);
}
