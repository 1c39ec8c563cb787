#version 460
#extension GL_GOOGLE_include_directive : require
// G-buffer, texels: view depth, normals, diffuse albedo towards the eye, roughness, instance, base colour, metallic, emission and
// motion of the nearest surface; all else follows from these.
#include "frame.glsl"
#include "scene_set.glsl"
#include "gbuffer.glsl"
#include "gbuffer_draw.glsl"
#include "footprint.glsl"
#include "mask.glsl"
#include "bsdf.glsl"
#include "shading_normal.glsl"

layout(location = 0) in vec3 position_ws;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 uvs;
layout(location = 3) in vec3 clip_then;
layout(location = 4) in vec4 tangent;
layout(location = 5) in vec4 colour;
layout(location = 6) in float extent;

layout(set = 2, binding = 0) uniform sampler2D base_texture;
layout(set = 2, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 2, binding = 2) uniform sampler2D emission_texture;
layout(set = 2, binding = 3) uniform sampler2D normal_texture;
MaterialData material = materials.data[push.material];

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_albedo;
layout(location = 3) out uvec2 out_instance;
layout(location = 4) out uvec2 out_surface;
layout(location = 5) out vec2 out_motion;

// Albedo of irradiance: the base colour where a surface has no other lobe, which spares it the rest.
vec3 diffuse_albedo(Bsdf bsdf, vec3 normal, vec3 to_eye) {
    return reflects(bsdf) ? prepare_bsdf(bsdf, normal, to_eye).diffuse : bsdf.base;
}

vec2 coordinates(TextureUse use) { return DETAILED ? coordinates_of(use, uvs) : uvs.xy; }

// A material's texture. Coordinates are transformed by what a buffer holds, which helper invocations may read as 0, so its footprint
// follows from the gradients of those of the vertices.
vec4 sampled(sampler2D image, TextureUse use, Gradients gradients) {
    vec2 right = DETAILED ? change_of(use, gradients.right) : gradients.right.xy;
    vec2 down = DETAILED ? change_of(use, gradients.down) : gradients.down.xy;
    Taps taps = taps_of(use, right, down, vec2(textureSize(image, 0)));
    vec2 start = coordinates(use) - taps.axis * (0.5 * taps.count);
    vec4 sum = vec4(0.0);
    for (float tap = 0.5; tap < taps.count; tap++) sum += textureLod(image, start + taps.axis * tap, taps.lod);
    return sum / taps.count;
}

// The shading normal on the side that is seen, which `geometric` is on.
vec3 shading_normal(vec3 geometric, vec3 texel) {
    vec3 shading = normalize(normal);
    if (!DETAILED) return dot(shading, geometric) < 0.0 ? -shading : shading;
    InstanceData instance = instances.data[push.instance];
    vec3 vertex_normal = normalize(transform_normal(instance.world_to_object, shading));
    if (material.normal_texture.image == 0u || tangent.w == 0.0) {
        return dot(vertex_normal, geometric) < 0.0 ? -vertex_normal : vertex_normal;
    }
    vec3 mapped = mapped_normal(shading, tangent, texel, material.normal_scale);
    return seen_normal(vertex_normal, normalize(transform_normal(instance.world_to_object, mapped)), geometric);
}

// How far the surface has moved in the picture since the last frame, in pixels.
vec2 motion() {
    if ((push.flags & MOVED) == 0u) return vec2(0.0);
    return gl_FragCoord.xy + frame.jitter - (clip_then.xy / clip_then.z * 0.5 + 0.5) * vec2(frame.size);
}

// View depth of the triangle's plane, moved along the normal by the rounding error of its corners, so that rays do not meet the triangle
// again. Twins: `surface_of` in shaders/include/hit.glsl, `ray_offset` in src/scene/world_surface.rs.
float lifted_depth(vec3 geometric) {
    float depth = 1.0 / gl_FragCoord.w;
    float cosine = abs(dot(geometric, pixel_ray(gl_FragCoord.xy - 0.5)));
    return depth - min(CORNER_ROUNDING * extent / max(cosine, 1e-3), 0.01 * depth);
}

void main() {
    // Taken before any branch and discard: derivatives need the whole quad.
    vec3 geometric = cross(dFdx(position_ws), dFdy(position_ws));
    Gradients gradients = Gradients(frame.footprint * dFdx(uvs), frame.footprint * dFdy(uvs));
    Bsdf bsdf = Bsdf(material.base.rgb * sampled(base_texture, material.base_texture, gradients).rgb, material.base.w, material.reflectance.rgb,
        material.reflectance.w, material.emission.w);
    vec3 emission = material.emission.rgb;
    vec3 texel = vec3(0.5, 0.5, 1.0);
    if (material.metallic_roughness_texture.image > 0u) {
        vec2 data = sampled(metallic_roughness_texture, material.metallic_roughness_texture, gradients).gb;
        bsdf.roughness *= data.x;
        bsdf.metallic *= data.y;
    }
    if (material.emission_texture.image > 0u) {
        emission *= sampled(emission_texture, material.emission_texture, gradients).rgb;
    }
    if (DETAILED) {
        bsdf.base *= colour.rgb;
        if ((material.flags & UNLIT) != 0u) emission *= colour.rgb;
        if (material.normal_texture.image > 0u) {
            texel = sampled(normal_texture, material.normal_texture, gradients).rgb;
        }
    }
    float alpha = DETAILED ? colour.a : 1.0;
    if (MASKED && !mask_opaque(material.mask - 1u, coordinates(material.base_texture), alpha)) discard;

    // Turn both normals to the side that is seen.
    vec3 to_eye = frame.eye.xyz - position_ws;
    float area = dot(geometric, geometric);
    bool front = gl_FrontFacing != ((push.flags & FLIPS_WINDING) != 0u);
    geometric = area > 0.0 ? geometric * inversesqrt(area) : normalize(to_eye);
    if (dot(geometric, to_eye) < 0.0) geometric = -geometric;
    vec3 shading = shading_normal(geometric, texel);

    out_depth = lifted_depth(geometric);
    out_normal = vec4(octahedral_encode(shading), octahedral_encode(geometric));
    out_albedo = vec4(diffuse_albedo(bsdf, shading, normalize(to_eye)), bsdf.roughness);
    out_instance = uvec2(push.instance + 1u, push.material | (front ? FRONT_FACING : 0u));
    if (emission != vec3(0.0)) {
        emission = emits_on(material, front) ? emission * instances.data[push.instance].emission.rgb : vec3(0.0);
    }
    out_surface = uvec2(pack_base(bsdf.base, bsdf.metallic), pack_emission(emission));
    out_motion = motion();
}
