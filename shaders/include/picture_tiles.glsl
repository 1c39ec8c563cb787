// Square tiles of the picture.
#include "tile_list.glsl"

// Pixels across a tile. Twin: `TILE` in src/passes/direct_shading.rs.
const uint PICTURE_TILE = 8u;

// A tile in a list, with its rows as bits. Pictures are so small that twelve bits do for a column or row of tiles.
uint pack_rows(uvec2 tile, uint rows) { return tile.x | tile.y << 12 | rows << 24; }
uvec2 tile_of(uint packed) { return uvec2(packed & 0xfffu, packed >> 12 & 0xfffu); }
uint rows_of(uint packed) { return packed >> 24; }
