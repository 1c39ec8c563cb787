// A list of tiles of the picture, and how many workgroups it takes to go through it.

// Workgroups in a row of the dispatch: devices need not do with more than 65,535 in one.
const uint LIST_ROW = 32768u;

// The first three are what an indirect dispatch reads; `count` and they are 0 before the first tile.
struct TileList {
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint count; // of tiles
};

// Number of a workgroup of that dispatch.
uint group_in_list() { return gl_WorkGroupID.y * LIST_ROW + gl_WorkGroupID.x; }

// A tile in a list: its column and row. Divisions of its number would be slow on CPU devices.
uint pack_tile(uvec2 tile) { return tile.x | tile.y << 16; }
uvec2 unpack_tile(uint packed) { return uvec2(packed & 0xffffu, packed >> 16); }

// Makes room in a list for one more tile; tells its place. per_group: tiles that a workgroup takes care of.
#define ADD_TILE(list, per_group, place) \
    uint place = atomicAdd(list.count, 1u); \
    atomicMax(list.groups_x, min(place / (per_group) + 1u, LIST_ROW)); \
    atomicMax(list.groups_y, place / (per_group) / LIST_ROW + 1u); \
    list.groups_z = 1u
