// Radiance that each light sends from a surface to the eye, unoccluded: exact for lights without extent, smooth estimates for others,
// area lights among them, and never 0 where they send anything (for the ratio estimator of Heitz et al. 2018). Needs frame.glsl,
// bsdf.glsl, surface.glsl, lights.glsl and scene_set.glsl.
#include "light_cone.glsl"

// A surface with its BSDF, as the eye, or what a ray comes from, sees it.
struct ShadingPoint {
    Surface surface;
    vec3 diffuse;          // directional albedo of the Lambertian lobe
    bool is_glossy;        // has a GGX lobe
    Reflection reflection; // of that
    float gloss_of_areas;  // share of the GGX lobe's light of area lights that counts here: rays along the lobe do not meet it
};

// The BSDF of both lobes, 1/sr, without the cosine; `gloss`: share of the GGX lobe.
vec3 bsdf_of(ShadingPoint point, vec3 to_light, float gloss) {
    vec3 bsdf = point.diffuse / PI;
    if (point.is_glossy && gloss > 0.0) bsdf += gloss * reflected_towards_eye(point.reflection, to_light);
    return bsdf;
}

// The mean cosine above the horizon of a light about a direction with this cosine, whose half angle has this sine.
float cosine_above(float cosine, float sine) {
    if (cosine >= sine) return cosine;
    return cosine <= -sine ? 0.0 : (cosine + sine) * (cosine + sine) / (4.0 * sine);
}

// About what irradiance from the directions of a light becomes: the BSDF at its centre times the mean cosine above the horizon, exact
// without extent and 0 only where the whole light is below the horizon. A wide light makes a wide highlight: a disc of the sine s has
// the variance s^2/4 along each axis, which adds to GGX's alpha^2. `inside`: how far the surface lies from the border of the light's
// bounds towards their centre, 0 to 1; there light may come from anywhere.
vec3 lobe_response(ShadingPoint point, vec3 to_light, float sine, float inside, float gloss) {
    float above = max(cosine_above(dot(point.surface.shading, to_light), sine), 0.25 * inside);
    if (above <= 0.0 || (inside == 0.0 && dot(point.surface.geometric, to_light) <= -sine)) return vec3(0.0);
    if (sine > 0.0) {
        point.reflection.alpha = min(sqrt(point.reflection.alpha * point.reflection.alpha + 0.25 * sine * sine), 1.0);
        to_light = normalize(to_light + point.surface.shading * max(0.5 * sine - dot(point.surface.shading, to_light), 0.0));
    }
    return bsdf_of(point, to_light, gloss) * above;
}

LightCone cone_of(LightData light, vec3 p) {
    if (light.kind == LIGHT_DIRECTIONAL) return cone_to_disc(-light.direction.xyz, light.half_angle);
    vec3 d = light.position.xyz - p;
    float distance = max(length(d), 1e-15);
    return cone_to_sphere(d / distance, distance, light.radius);
}

// Share of the GGX lobe's light of an area light that counts.
float gloss_of(AreaLightData light, ShadingPoint point) { return light.is_visible == 0u ? 1.0 : point.gloss_of_areas; }

// About what a light sends to the eye, unoccluded: positive wherever it sends anything.
vec3 unshadowed_radiance(uint index, ShadingPoint point) {
    vec3 p = point.surface.position;
    if (index < frame.light_count) {
        vec3 to_light;
        vec3 irradiance = unshadowed(lights.data[index], p, to_light);
        return irradiance * lobe_response(point, to_light, sine_of(cone_of(lights.data[index], p)), 0.0, 1.0);
    }
    AreaLightData light = area_lights.data[index - frame.light_count];
    vec3 d = light.centre.xyz - p;
    float radius = light.centre.w;
    float distance = max(length(d), 1e-15);
    vec3 to_light = d / distance;
    float sine = min(radius / distance, 1.0);
    float inside = max(1.0 - distance / radius, 0.0);
    // A flat light sends by the cosine, a closed one the same everywhere: a quarter of its area faces any point.
    float flatness = length(light.facing.xyz);
    float cosine = flatness > 0.0 ? -dot(light.facing.xyz, to_light) / flatness : 0.0;
    float facing = mix(0.25, cosine_above(cosine, sine), flatness);
    float spread = max(facing, 0.02) / (distance * distance + radius * radius);
    return light.power.rgb * spread * lobe_response(point, to_light, sine, inside, gloss_of(light, point));
}
