// The surface that a pixel sees, with its BSDF. Needs unshadowed.glsl and the G-buffer's images.
#include "reflection_weight.glsl"

ShadingPoint shading_point_at(ivec2 pixel, uvec2 id) {
    ShadingPoint at;
    at.surface = surface_at(pixel);
    MaterialData material = materials.data[id.y & MATERIAL];
    vec4 albedo_roughness = imageLoad(gbuffer_albedo, pixel);
    vec4 base = unpack_base(texelFetch(gbuffer_surface, pixel, 0).x);
    Bsdf bsdf = Bsdf(base.rgb, base.a, material.reflectance.rgb, material.reflectance.w, albedo_roughness.a);
    at.diffuse = albedo_roughness.rgb;
    at.is_glossy = reflects(bsdf);
    if (at.is_glossy) at.reflection = prepare_bsdf(bsdf, at.surface.shading, normalize(frame.eye.xyz - at.surface.position));
    // Reflection rays meet area lights.
    at.gloss_of_areas = 1.0 - reflection_weight(bsdf.roughness);
    return at;
}
