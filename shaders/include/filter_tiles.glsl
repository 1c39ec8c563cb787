// The tiles of the picture that the discontinuity filter goes through. Needs frame.glsl, window.glsl and tile_list.glsl.

// Columns of pixels of a thread, for the same reason as ROWS.
const int COLUMNS = 2;

// Pixels of a tile. Twin: `TILE` in src/passes/indirect_shading.rs.
const ivec2 TILE = ivec2(8, 2 * ROWS);

// Threads of a tile, side by side and in all.
const int THREADS_ACROSS = TILE.x / COLUMNS;
const int TILE_THREADS = THREADS_ACROSS * TILE.y / ROWS;

// The same where all windows lie on one surface: what is asked of a texel is less, so it pays to share it among more.
const int WHOLE_COLUMNS = 4;
const int WHOLE_THREADS = TILE.x / WHOLE_COLUMNS;

// Threads of a workgroup.
const int GROUP_THREADS = 64;

// Tiles side by side.
int tile_columns() { return (int(frame.size.x) + TILE.x - 1) / TILE.x; }
int tile_rows() { return (int(frame.size.y) + TILE.y - 1) / TILE.y; }

// First pixel of a tile in a list.
ivec2 corner_of_tile(uint packed) { return ivec2(unpack_tile(packed)) * TILE; }
