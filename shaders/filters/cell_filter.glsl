// Variants of the filters of cells. Twin: Variant in src/filters/cells.rs.

// The first and the last vertex of a path whose irradiance goes to its cell.
layout(constant_id = 0) const uint FIRST = 0u;
layout(constant_id = 1) const uint LAST = 0u;
// Layers of the vertices of a path; 0: only the irradiance of the visible surface is available.
layout(constant_id = 2) const uint VERTICES = 0u;
// Whether light goes by cells only over at least their width, and levels are dithered.
layout(constant_id = 3) const bool CACHE = false;
// Whether paths of earlier frames go on, in two layers behind those of this frame.
layout(constant_id = 4) const bool CONTINUES = false;
