// For path.glsl: nothing is left of the vertices of a path.
#include "path_vertex.glsl"
const bool LEAVES_VERTICES = false;

void leave_vertex(uint bounce, PathVertex vertex) {}
void leave_end(bool goes_on, Surface surface) {}
