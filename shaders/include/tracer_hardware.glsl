// Rays through the device's acceleration structures, by ray queries (GL_EXT_ray_query).
//
// In: a top level over the placed meshes and the tables of src/bvh/hardware.rs. Out: as in tracer.glsl; of surfaces
// at the same t, any may be the closest, and whether the ends of the segment count is the device's affair.

#ifndef TRACER_HARDWARE_GLSL
#define TRACER_HARDWARE_GLSL

// Where a triangle lies in bvh_triangles. An instance's record offset is its mesh.
uint tracer_triangle(int mesh, int run, int primitive) {
    return bvh_runs.first_triangles[mesh * 2 + run] + uint(primitive);
}

bool tracer_find(
    vec3 origin, vec3 direction, float t_min, float t_max, uint wanted, out TracerHit hit, out vec3 transmittance
) {
    hit = TracerHit(t_max, TRACER_NONE, TRACER_NONE, 0u, 0u, vec2(0.0));
    transmittance = vec3(1.0);
    uint flags = wanted == TRACER_ANY ? gl_RayFlagsTerminateOnFirstHitEXT
        : (wanted == TRACER_CLOSEST_THIN ? gl_RayFlagsCullOpaqueEXT : gl_RayFlagsNoneEXT);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, bvh_top_level, flags, 0xffu, origin, t_min, direction, t_max);
    while (rayQueryProceedEXT(query)) {
        // Only triangles with an alpha mask and thin surfaces ask.
        uint triangle = tracer_triangle(
            int(rayQueryGetIntersectionInstanceShaderBindingTableRecordOffsetEXT(query, false)),
            rayQueryGetIntersectionGeometryIndexEXT(query, false),
            rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        uint masked = texelFetch(bvh_triangles, int(triangle * 3u + 1u)).w;
        vec2 barycentrics = rayQueryGetIntersectionBarycentricsEXT(query, false);
        bool is_wanted = wanted == TRACER_CLOSEST_THIN;
        if (!tracer_is_thin(masked)) {
            is_wanted = !is_wanted && tracer_is_opaque(masked, barycentrics);
        } else if (wanted == TRACER_ANY) {
            mat3 world_to_object = transpose(mat3(rayQueryGetIntersectionWorldToObjectEXT(query, false)));
            transmittance *= tracer_transmittance(triangle, barycentrics, world_to_object, direction);
            is_wanted = transmittance == vec3(0.0);
        }
        if (is_wanted) rayQueryConfirmIntersectionEXT(query);
    }
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) {
        return false;
    }
    uint triangle = tracer_triangle(
        int(rayQueryGetIntersectionInstanceShaderBindingTableRecordOffsetEXT(query, true)),
        rayQueryGetIntersectionGeometryIndexEXT(query, true),
        rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    hit.t = rayQueryGetIntersectionTEXT(query, true);
    hit.instance = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true));
    hit.triangle = texelFetch(bvh_triangles, int(triangle * 3u)).w;
    hit.material = texelFetch(bvh_triangles, int(triangle * 3u + 2u)).w;
    hit.place = triangle;
    hit.barycentrics = rayQueryGetIntersectionBarycentricsEXT(query, true);
    return true;
}

#endif
