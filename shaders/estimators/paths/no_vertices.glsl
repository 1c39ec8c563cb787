// For path.glsl: stores no vertices.
#include "path_vertex.glsl"
const bool STORES_VERTICES = false;

void store_vertex(uint bounce, PathVertex vertex) {}
void store_last_vertex(bool goes_on, Surface surface) {}
