// A list of square tiles of the picture, and how many workgroups it takes to go through it.

// Pixels across a tile. Twin: `TILE` in src/passes/direct_shading.rs.
const uint PICTURE_TILE = 8u;

// Workgroups in a row of the dispatch, a tile each: devices need not do with more than 65,535 in one.
const uint LIST_ROW = 64u;

// The first three are what an indirect dispatch reads.
struct TileList {
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint count; // of tiles
};
