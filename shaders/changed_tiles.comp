#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Which rows of which tiles of the picture have to be lit again: those that may show other surfaces than in the last frame, and
// those whose surfaces lie where shadow maps have changed.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "lights.glsl"
#include "direct.glsl"
#include "picture_tiles.glsl"

layout(local_size_x = 64) in;

// Tiles that a workgroup of direct_shading.comp takes. Twin: `ROWS` there.
layout(constant_id = 0) const uint TILES_PER_GROUP = 1u;

// Where a shadow tile has changed. Twin: `ChangedPart` in src/passes/structs.rs.
struct ChangedPart {
    uvec2 first;    // texel, counted from the tile's
    uvec2 end;      // behind the last
    float nearest;  // depth; what is nearer to the light is lit as it was
    float farthest; // what is farther away is too, but for where cells have changed
    uint first_row; // of the cells that tell
    uint pad0;
};

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, std430) readonly buffer TileBlock { ShadowTile data[]; } shadow_tiles;
layout(set = 0, binding = 3, std430) readonly buffer PartBlock { ChangedPart data[]; } changed_parts;
layout(set = 0, binding = 4, std430) buffer ListBlock { TileList data; uint tiles[]; } tile_list;
// Of each cell of a row, a bit: whether one within reach has changed.
layout(set = 0, binding = 5) uniform utextureBuffer changed_cells;
layout(set = 0, binding = 6) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 7, rgba32f) uniform readonly image2D direct;

layout(push_constant) uniform Push {
    uvec2 changed_first; // pixel that may show another surface
    uvec2 changed_end;   // behind the last
    uvec2 anew_first;    // pixel that may though neither may move
    uvec2 anew_end;
    uint shadow_tile_count;
    uint first_texel;    // of all cells
} push;

// Cells across a shadow tile. Twin: `CELLS` in src/passes/outlines.rs.
const uint CELLS = 128u;

// Texels that a lookup may be away from where its surface is. Twin: `REACH` in src/passes/direct_shadows.rs.
const float REACH = 5.0;

// Rows of cells that are looked at for a box; of a larger one, its surfaces are.
const uint MOST_ROWS = 8u;

bool is_within(uvec2 pixel, uvec2 first, uvec2 end) { return all(greaterThanEqual(pixel, first)) && all(lessThan(pixel, end)); }

// The pixels of a tile one by one; what lies beyond the picture's edges is the last within.
uvec2 pixel_of_tile(uvec2 corner, uint place) {
    return min(corner + uvec2(place % PICTURE_TILE, place / PICTURE_TILE), frame.size - 1u);
}

// Least and greatest view depth of a tile's surfaces; the least is greater where there are none.
vec2 depths_of(uvec2 corner) {
    vec2 depths = vec2(1e38, 0.0);
    // Here and below, loops ask at their end whether to go on: see tracer_find.
    uint place = 0u;
    do {
        float depth = imageLoad(gbuffer_depth, ivec2(pixel_of_tile(corner, place))).r;
        depths = vec2(min(depths.x, depth > 0.0 ? depth : 1e38), max(depths.y, depth));
    } while (++place < PICTURE_TILE * PICTURE_TILE);
    return depths;
}

// A corner of what a tile of the picture sees between two depths.
vec3 corner_at(uvec2 first, uvec2 end, vec2 depths, uint corner) {
    vec2 at = vec2((corner & 1u) == 0u ? first.x : end.x, (corner & 2u) == 0u ? first.y : end.y);
    vec2 ndc = at * (2.0 / vec2(frame.size)) - 1.0;
    float depth = (corner & 4u) == 0u ? depths.x : depths.y;
    return frame.eye.xyz + depth * (frame.ray.xyz + ndc.x * frame.ray_x.xyz + ndc.y * frame.ray_y.xyz);
}

// From clip space to texels of a shadow tile and depth.
vec3 texel_of_clip(ShadowTile tile, vec4 clip) {
    return vec3((clip.xy / clip.w * 0.5 + 0.5) * tile.rectangle.z, clip.z / clip.w);
}

// Cells with a bit before that of a column.
uvec4 cells_before(uint column) {
    uvec4 bits = uvec4(clamp(ivec4(column) - ivec4(0, 32, 64, 96), 0, 32));
    return mix((uvec4(1u) << min(bits, uvec4(31u))) - 1u, uvec4(0xffffffffu), equal(bits, uvec4(32u)));
}

uvec2 cell_at(ShadowTile tile, vec2 texel) {
    return uvec2(clamp(texel * (float(CELLS) / tile.rectangle.z), vec2(0.0), vec2(float(CELLS - 1u))));
}

// Whether a shadow may have come or gone between two points of a shadow tile: texels and depth.
bool changed_between(ShadowTile tile, ChangedPart part, vec3 low, vec3 high) {
    if (low.z > part.nearest) return false;
    bool touched = all(lessThan(low.xy - REACH, vec2(part.end))) && all(greaterThan(high.xy + REACH, vec2(part.first)));
    // Beyond a spot's cone there is no light for a shadow to take away.
    vec2 middle = vec2(0.5 * tile.rectangle.z);
    bool lit = tile.texel.z == 0.0 || distance(middle, clamp(middle, low.xy - REACH, high.xy + REACH)) < tile.texel.z;
    if (!touched || !lit) return false;
    if (high.z >= part.farthest) return true;
    uvec2 first = cell_at(tile, low.xy);
    uvec2 last = cell_at(tile, high.xy);
    if (last.y - first.y >= MOST_ROWS) return true;
    uvec4 columns = cells_before(last.x + 1u) & ~cells_before(first.x);
    int first_texel = int(push.first_texel + part.first_row);
    uvec4 changed = uvec4(0u);
    uint row = first.y;
    do {
        changed |= texelFetch(changed_cells, first_texel + int(row)) & columns;
    } while (++row <= last.y);
    return any(notEqual(changed, uvec4(0u)));
}

// Whether anything between two depths may be lit otherwise, as far as the box around it tells.
bool box_changed(uvec2 first, uvec2 end, vec2 depths, ShadowTile tile, ChangedPart part) {
    vec3 low = vec3(1e38);
    vec3 high = vec3(-1e38);
    uint behind = 0u;
    for (uint corner = 0u; corner < 8u; corner++) {
        vec4 clip = tile.view_projection * vec4(corner_at(first, end, depths, corner), 1.0);
        if (clip.w <= 0.0) {
            behind++;
        } else {
            vec3 texel = texel_of_clip(tile, clip);
            low = min(low, texel);
            high = max(high, texel);
        }
    }
    return behind > 0u ? behind < 8u : changed_between(tile, part, low, high);
}

// Rows of a tile, as bits, with a surface that may be lit otherwise.
uint rows_changed(uvec2 corner, ShadowTile tile, ChangedPart part) {
    uint rows = 0u;
    uint place = 0u;
    do {
        ivec2 pixel = ivec2(pixel_of_tile(corner, place));
        float depth = imageLoad(gbuffer_depth, pixel).r;
        vec4 clip = tile.view_projection * vec4(position_at(pixel, depth), 1.0);
        vec3 texel = texel_of_clip(tile, clip);
        bool changed = depth > 0.0 && clip.w > 0.0 && changed_between(tile, part, texel, texel);
        rows |= changed ? 1u << (place / PICTURE_TILE) : 0u;
    } while (++place < PICTURE_TILE * PICTURE_TILE);
    return rows;
}

// Rows of a tile with a pixel that may show another surface.
uint rows_with_others(uvec2 corner) {
    uint rows = 0u;
    uint place = 0u;
    do {
        uvec2 pixel = pixel_of_tile(corner, place);
        bool anew = is_within(pixel, push.anew_first, push.anew_end);
        uint now = texelFetch(gbuffer_instance, ivec2(pixel), 0).y;
        bool other = anew || (now & MAY_MOVE) != 0u || imageLoad(direct, ivec2(pixel)).a == MOVER;
        rows |= other && is_within(pixel, push.changed_first, push.changed_end) ? 1u << (place / PICTURE_TILE) : 0u;
    } while (++place < PICTURE_TILE * PICTURE_TILE);
    return rows;
}

void main() {
    uvec2 tiles = (frame.size + PICTURE_TILE - 1u) / PICTURE_TILE;
    uint index = gl_GlobalInvocationID.x;
    if (index >= tiles.x * tiles.y) return;
    uvec2 tile = uvec2(index % tiles.x, index / tiles.x);
    uvec2 first = tile * PICTURE_TILE;
    uvec2 end = min(first + PICTURE_TILE, frame.size);
    uint rows = 0u;
    if (all(lessThan(first, push.changed_end)) && all(greaterThan(end, push.changed_first))) rows = rows_with_others(first);
    vec2 depths = depths_of(first);
    for (uint i = 0u; i < push.shadow_tile_count && depths.x <= depths.y; i++) {
        ChangedPart part = changed_parts.data[i];
        if (any(greaterThanEqual(part.first, part.end))) continue;
        // At the edges of things the box is much larger than what is in it.
        ShadowTile shadow_tile = shadow_tiles.data[i];
        if (box_changed(first, end, depths, shadow_tile, part)) rows |= rows_changed(first, shadow_tile, part);
    }
    if (rows == 0u) return;
    ADD_TILE(tile_list.data, TILES_PER_GROUP, place);
    tile_list.tiles[place] = pack_rows(tile, rows);
}
