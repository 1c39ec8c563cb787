// For path.glsl: leaves the first LEFT_VERTICES vertices of a path in layers from `first_layer` on. Needs path_vertices.glsl.
const bool LEAVES_VERTICES = LEFT_VERTICES > 0u;

// The first layer of the path.
uint first_layer;
// Vertices that are left of it so far.
uint left;

void store_vertex(uint layer, PathVertex vertex) {
    ivec3 place = ivec3(gl_GlobalInvocationID.xy, first_layer + layer);
    imageStore(path_places, place, pack_place(vertex));
    imageStore(path_lights, place, uvec4(pack_light(vertex), 0u, 0u));
}

void leave_vertex(uint bounce, PathVertex vertex) {
    if (bounce >= LEFT_VERTICES) return;
    store_vertex(bounce, vertex);
    left = bounce + 1u;
}

// The vertex after the last one that was lit, if the path met any.
void leave_end(bool goes_on, Surface surface) {
    if (left >= LEFT_VERTICES) return;
    vec3 none = vec3(0.0);
    store_vertex(left, PathVertex(surface.position, surface.geometric, none, none, goes_on ? VERTEX_UNLIT : VERTEX_ABSENT));
}
