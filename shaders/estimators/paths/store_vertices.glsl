// For path.glsl: stores the first STORED_VERTICES vertices of a path in layers from `first_layer` on. Needs path_vertices.glsl.
const bool STORES_VERTICES = STORED_VERTICES > 0u;

// The first layer of the path.
uint first_layer;
// Vertices of it that are stored so far.
uint stored;

void write_vertex(uint layer, PathVertex vertex) {
    ivec3 place = ivec3(gl_GlobalInvocationID.xy, first_layer + layer);
    imageStore(path_places, place, pack_place(vertex));
    imageStore(path_lights, place, uvec4(pack_light(vertex), 0u, 0u));
}

void store_vertex(uint bounce, PathVertex vertex) {
    if (bounce >= STORED_VERTICES) return;
    write_vertex(bounce, vertex);
    stored = bounce + 1u;
}

// The vertex after the last one that was lit, if the path met any.
void store_last_vertex(bool goes_on, Surface surface) {
    if (stored >= STORED_VERTICES) return;
    vec3 none = vec3(0.0);
    write_vertex(stored, PathVertex(surface.position, surface.geometric, none, none, goes_on ? VERTEX_UNLIT : VERTEX_ABSENT));
}
