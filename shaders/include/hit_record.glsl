// A surface that a reflection ray has hit and that is to be lit by the estimator: a texel of each of two images a pixel. Needs
// gbuffer.glsl.

struct HitRecord {
    vec3 position;
    vec3 shading;   // unit normals on the side that was hit
    vec3 geometric;
    vec3 weight;    // of irradiance there in the reflection; 0: there is no such surface
    float random;   // from 0 to 1, for the estimator
};

uvec4 pack_place(HitRecord hit) {
    vec4 normals = vec4(octahedral_encode(hit.shading), octahedral_encode(hit.geometric));
    return uvec4(floatBitsToUint(hit.position), packSnorm4x8(normals));
}

vec4 pack_weight(HitRecord hit) { return vec4(min(hit.weight, 65504.0), hit.random); }

HitRecord unpack_hit(uvec4 place, vec4 weight) {
    vec4 normals = unpackSnorm4x8(place.w);
    return HitRecord(uintBitsToFloat(place.xyz), octahedral_decode(normals.xy), octahedral_decode(normals.zw), weight.rgb, weight.a);
}
