// A vertex of a path: see path_vertices.glsl.

struct PathVertex {
    vec3 position;
    vec3 normal;  // of the triangle, on the side of the path
    vec3 light;   // irradiance by lights, emission and environment, W/m^2
    vec3 next;    // of the irradiance of the next vertex; 0: the path ends here
    uint state;   // VERTEX_ABSENT, VERTEX_UNLIT or VERTEX_LIT
};

const uint VERTEX_ABSENT = 0u;
// A vertex that was found, but not lit.
const uint VERTEX_UNLIT = 1u;
const uint VERTEX_LIT = 2u;
