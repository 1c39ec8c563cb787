// n, known when a pipeline is made: loops over a window unroll, and divisions by it, slow on CPU devices,
// become cheap.
layout(constant_id = 0) const uint INTERLEAVE = 4u;

// Class of a pixel within its n x n tile.
uint class_of(uvec2 pixel) { return pixel.x % INTERLEAVE + pixel.y % INTERLEAVE * INTERLEAVE; }
