#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
// The discontinuity filter where all windows lie on one surface: then every class is found, and windows share the sums of
// their rows. Out: as of discontinuity_filter.comp.
#include "frame.glsl"
#include "packed_surface.glsl"
#include "packed_irradiance.glsl"
#include "interleave.glsl"
#include "window.glsl"
#include "tile_list.glsl"
#include "filter_tiles.glsl"

layout(local_size_x = GROUP_THREADS) in;

layout(set = 0, binding = 1) uniform utextureBuffer class_irradiance;
layout(set = 0, binding = 2) uniform utextureBuffer packed_surfaces;
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2DArray set_buffers;
layout(set = 0, binding = 4, std430) readonly buffer ListBlock { TileList list; uint tiles[]; } filter_tiles;

layout(push_constant) uniform Push {
    uint layer; // of the set buffers, for this set
} push;

void store(ivec2 pixel, vec3 irradiance) {
    float depth = unpack_depth(texelFetch(packed_surfaces, texel_of(pixel)).r);
    imageStore(set_buffers, ivec3(pixel, int(push.layer)), vec4(irradiance * frame.irradiance_scale, depth));
}

void main() {
    uint thread = group_in_list() * GROUP_THREADS + gl_LocalInvocationID.x;
    uint place = thread / WHOLE_THREADS;
    if (place >= filter_tiles.list.count) return;
    ivec2 first = corner_of_tile(filter_tiles.tiles[place]);
    first.x += int(thread % WHOLE_THREADS) * WHOLE_COLUMNS;
    int corner = texel_of(first - WIDTH / 2);
    vec3 sums[WHOLE_COLUMNS][TILE.y];
    [[unroll]] for (int y = 0; y < WIDTH + TILE.y - 1; y++) {
        // A row of the windows of pixels side by side.
        vec3 of_row[WHOLE_COLUMNS];
        [[unroll]] for (int column = 0; column < WIDTH + WHOLE_COLUMNS - 1; column++) {
            int texel = corner + y * int(frame.size.x) + column;
            vec3 of_class = unpack_irradiance(texelFetch(class_irradiance, texel).rg);
            [[unroll]] for (int strip = 0; strip < WHOLE_COLUMNS; strip++) {
                if (column == strip) of_row[strip] = vec3(0.0);
                if (column >= strip && column < strip + WIDTH) of_row[strip] += weight_at(column - strip) * of_class;
            }
        }
        // The windows that it lies in; where it is their last row, they are done.
        [[unroll]] for (int row = 0; row < TILE.y; row++) {
            [[unroll]] for (int strip = 0; strip < WHOLE_COLUMNS; strip++) {
                if (y == row) sums[strip][row] = vec3(0.0);
                if (y >= row && y < row + WIDTH) sums[strip][row] += weight_at(y - row) * of_row[strip];
                if (y == row + WIDTH - 1) store(first + ivec2(strip, row), sums[strip][row]);
            }
        }
    }
}
