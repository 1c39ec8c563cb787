#version 460
#extension GL_GOOGLE_include_directive : require
// G-buffer, texels: view depth, normals, diffuse albedo towards the eye, roughness, instance, base colour, metallic and emission of the nearest
// surface; all else follows from these.
#include "frame.glsl"
#include "scene.glsl"
#include "gbuffer.glsl"
#define MASK_BINDING 3
#include "mask.glsl"
#include "bsdf.glsl"

layout(location = 0) in vec3 position_ws;
layout(location = 1) in vec3 normal_ws;
layout(location = 2) in vec2 surface_uv;

layout(set = 0, binding = 1, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;
layout(set = 0, binding = 2, std430) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 1, binding = 0) uniform sampler2D base_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D emission_texture;

// Whether the material has an alpha mask. What cannot be discarded is compared by depth before it is shaded.
layout(constant_id = 0) const bool MASKED = false;

layout(push_constant) uniform Push { uint instance; uint material; } push;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_albedo;
layout(location = 3) out uvec2 out_instance;
layout(location = 4) out uvec2 out_surface;

// What irradiance becomes: a surface that reflects nothing else is spared the rest.
vec3 diffuse_albedo(Bsdf bsdf, vec3 normal, vec3 to_eye) {
    return reflects(bsdf) ? seen(bsdf, normal, to_eye).diffuse : bsdf.base;
}

void main() {
    // Taken before any discard: derivatives and mip level need the whole quad.
    vec3 geometric = cross(dFdx(position_ws), dFdy(position_ws));
    MaterialData material = materials.data[push.material];
    Bsdf bsdf = Bsdf(material.base.rgb * texture(base_texture, surface_uv).rgb, material.base.w,
        material.reflectance.rgb, material.reflectance.w, material.emission.w);
    vec3 emission = material.emission.rgb;
    if ((material.maps & MAP_METALLIC_ROUGHNESS) != 0u) {
        vec2 texel = texture(metallic_roughness_texture, surface_uv).gb;
        bsdf.roughness *= texel.x;
        bsdf.metallic *= texel.y;
    }
    if ((material.maps & MAP_EMISSION) != 0u) emission *= texture(emission_texture, surface_uv).rgb;
    if (MASKED && !mask_opaque(material.mask, surface_uv)) discard;

    // Turn both normals to the side that is seen: surfaces are two-sided.
    vec3 to_eye = frame.eye.xyz - position_ws;
    float area = dot(geometric, geometric);
    vec3 shading = normalize(normal_ws);
    geometric = area > 0.0 ? geometric * inversesqrt(area) : shading;
    if (dot(geometric, to_eye) < 0.0) geometric = -geometric;
    if (dot(shading, geometric) < 0.0) shading = -shading;

    bool front = gl_FrontFacing != (instances.data[push.instance].mirrored == 1u);
    out_depth = 1.0 / gl_FragCoord.w;
    out_normal = vec4(octahedral_encode(shading), octahedral_encode(geometric));
    out_albedo = vec4(diffuse_albedo(bsdf, shading, normalize(to_eye)), bsdf.roughness);
    out_instance = uvec2(push.instance + 1u, push.material | (front ? FRONT_FACING : 0u));
    vec3 emitted = front ? emission * instances.data[push.instance].emission.rgb : vec3(0.0);
    out_surface = uvec2(pack_base(bsdf.base, bsdf.metallic), pack_emission(emitted));
}
