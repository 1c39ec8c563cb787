// The surface that a ray has hit. Needs frame.glsl, scene.glsl and tracer.glsl. Define HIT_BINDING before including: it and the
// next are taken.

layout(set = 0, binding = HIT_BINDING, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
layout(set = 0, binding = HIT_BINDING + 1, std430) readonly buffer MaterialBlock { MaterialData data[]; } materials;

struct HitSurface {
    vec3 position;
    vec3 normal;   // geometric, on the side that was hit
    vec3 albedo;   // mean of the material's texture
    vec3 emission; // towards the ray's origin, W/m^2/sr
};

HitSurface surface_of(TracerHit hit, vec3 origin, vec3 direction) {
    vec3 a = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u)).xyz);
    vec3 b = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u + 1u)).xyz);
    vec3 c = uintBitsToFloat(texelFetch(bvh_triangles, int(hit.place * 3u + 2u)).xyz);
    InstanceData instance = instances.data[hit.instance];
    vec3 normal = normalize(transform_normal(instance.world_to_object, cross(b - a, c - a)));
    bool front = dot(normal, direction) < 0.0;
    MaterialData material = materials.data[hit.material];
    vec3 emission = front ? material.mean_emission.rgb * instance.emission.rgb : vec3(0.0);
    return HitSurface(origin + hit.t * direction, front ? normal : -normal, material.mean_albedo.rgb, emission);
}
