// The vertices of the paths of a frame, as the path tracer leaves them to filters: layer k holds the k-th, of the last layer light alone is
// not known. The irradiance of a vertex is its own light plus `next` times that of the next one, an unbiased estimate. Needs gbuffer.glsl;
// define PATH_VERTICES_BINDING, the first of two, and PATH_VERTICES_ACCESS before.
#include "path_vertex.glsl"

layout(set = 0, binding = PATH_VERTICES_BINDING, rgba32ui) uniform PATH_VERTICES_ACCESS uimage2DArray path_places;
layout(set = 0, binding = PATH_VERTICES_BINDING + 1, rg32ui) uniform PATH_VERTICES_ACCESS uimage2DArray path_lights;

// A normal of two times 15 bits, below the state.
uvec4 pack_place(PathVertex vertex) {
    uvec2 normal = uvec2((octahedral_encode(vertex.normal) * 0.5 + 0.5) * 32767.0 + 0.5);
    return uvec4(floatBitsToUint(vertex.position), normal.x | normal.y << 15 | vertex.state << 30);
}

uvec2 pack_light(PathVertex vertex) { return uvec2(pack_emission(vertex.light), pack_emission(vertex.next)); }

PathVertex unpack_vertex(uvec4 place, uvec2 light) {
    vec2 normal = vec2(place.w & 32767u, place.w >> 15 & 32767u) * (2.0 / 32767.0) - 1.0;
    return PathVertex(uintBitsToFloat(place.xyz), octahedral_decode(normal), unpack_emission(light.x), unpack_emission(light.y), place.w >> 30);
}
