// Counts of cells, behind those of rays in one buffer. Twin: COUNTERS and KEPT in src/filters/cells.rs and RAY_COUNTERS in src/estimators/ray_counters.rs.
layout(set = 0, binding = 8, std430) buffer RayCounterBlock { uvec2 rays[32]; uint cells[32]; } ray_counters;

const uint CELLS_OCCUPIED = 0u;
const uint CELLS_DROPPED = 1u;
const uint CELLS_EVICTED = 2u;

// Kept paths of 1 vertex, and so on.
const uint PATHS_KEPT = 8u;

void count_cells(uint counter, uint count) { atomicAdd(ray_counters.cells[counter], count); }
