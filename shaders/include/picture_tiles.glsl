// Square tiles of the picture.
#include "tile_list.glsl"

// Pixels across a tile. Twin: `TILE` in src/passes/direct_shading.rs.
const uint PICTURE_TILE = 8u;
