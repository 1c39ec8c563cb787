// The reflection of surfaces: glTF 2.0's metallic-roughness model, a Lambertian and a GGX lobe with height-correlated Smith
// masking, Schlick's Fresnel and compensation for multiple scattering. Twin, with the equations: src/bsdf.rs.

#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "pi.glsl"

// Surfaces smoother than this reflect as perfect mirrors.
const float MIRROR_ROUGHNESS = 0.03;
// Least cosine between shading normal and eye; normals that face away are seen at a grazing angle.
const float GRAZING = 1e-4;

struct Bsdf {
    vec3 base;       // reflectance of the dielectric's Lambertian lobe under nothing, and of the metal at normal incidence
    float metallic;  // the metal's share
    vec3 f0;         // reflectance of the dielectric's GGX lobe at normal incidence
    float f90;       // the same at grazing incidence
    float roughness; // perceptual; its square is GGX's alpha
};

// A BSDF seen from one side, with what does not depend on the direction of the light.
struct Reflection {
    vec3 normal;
    vec3 to_eye;
    float cosine;    // between the two
    vec3 diffuse;    // directional albedo of the Lambertian lobe: what it makes of irradiance, times pi
    vec3 reflected;  // directional albedo of the GGX lobe
    vec3 f0;         // reflectances of the microfacets at normal and grazing incidence, times what multiple
    vec3 f90;        // scattering adds
    float alpha;
    bool mirror;
};

// A direction that light comes from; density: 1/sr, 0 where nothing is reflected, -1 for a perfect mirror's.
struct Sampled { vec3 direction; float density; };

// Whether it has a GGX lobe.
bool reflects(Bsdf bsdf) { return bsdf.metallic > 0.0 || bsdf.f90 > 0.0 || bsdf.f0 != vec3(0.0); }

float schlick(float cosine) {
    float c = clamp(1.0 - cosine, 0.0, 1.0);
    return c * c * c * c * c;
}

// Albedo of GGX microfacets by single scattering of uniform light, for Fresnel reflectance 1 and for (1 - c)^5: polynomials
// fitted to the integrals.
vec2 single_scattering(float cosine, float r) {
    float alpha = r * r;
    float t = cosine / (cosine + 0.5 * alpha);
    float white = -3.7046;
    white = white * t + 8.9347 + r * 1.1073;
    white = white * t - 7.0895 + r * (1.4425 + r * -4.7184);
    white = white * t + 2.3485 + r * (-4.302 + r * (8.3688 + r * -1.3877));
    white = white * t - 0.4763 + r * (1.2122 + r * (0.4362 + r * (-6.4368 + r * 3.245)));
    white = white * t + 0.99802 + r * (0.37004 + r * (-2.7373 + r * (6.6617 + r * (-6.5214 + r * 2.22))));
    float s = sqrt(cosine + alpha);
    float root = 4.9426;
    root = root * s - 9.3604 + r * -12.035;
    root = root * s + 5.5349 + r * (40.672 + r * -39.527);
    root = root * s - 2.0491 + r * (-31.082 + r * (-13.404 + r * 111.7));
    root = root * s + 0.012093 + r * (6.6914 + r * (37.516 + r * (-56.569 + r * -77.934)));
    root = root * s + 1.0028 + r * (-0.17455 + r * (-7.136 + r * (-6.6293 + r * (33.98 + r * 14.382))));
    white = clamp(white, 0.0, 1.0);
    root = clamp(root, 0.0, 1.0);
    return vec2(white, white * root * root * root * root * root);
}

Reflection prepare_bsdf(Bsdf bsdf, vec3 normal, vec3 to_eye) {
    Reflection r;
    r.cosine = dot(normal, to_eye);
    r.normal = r.cosine < GRAZING ? normalize(normal + to_eye * (GRAZING - r.cosine)) : normal;
    r.cosine = max(r.cosine, GRAZING);
    r.to_eye = to_eye;
    r.alpha = bsdf.roughness * bsdf.roughness;
    r.mirror = bsdf.roughness < MIRROR_ROUGHNESS;
    vec2 once = r.mirror ? vec2(1.0, schlick(r.cosine)) : single_scattering(r.cosine, bsdf.roughness);
    // Dielectric and metal each get back what is scattered more than once.
    float again = 1.0 / once.x - 1.0;
    vec3 dielectric = 1.0 + bsdf.f0 * again;
    vec3 dielectric_f0 = bsdf.f0 * dielectric;
    vec3 dielectric_f90 = bsdf.f90 * dielectric;
    vec3 metal = 1.0 + bsdf.base * again;
    r.f0 = mix(dielectric_f0, bsdf.base * metal, bsdf.metallic);
    r.f90 = mix(dielectric_f90, metal, bsdf.metallic);
    vec3 over = dielectric_f0 * (once.x - once.y) + dielectric_f90 * once.y;
    r.reflected = min(r.f0 * (once.x - once.y) + r.f90 * once.y, vec3(1.0));
    r.diffuse = bsdf.base * ((1.0 - bsdf.metallic) * (1.0 - min(max(over.r, max(over.g, over.b)), 1.0)));
    return r;
}

vec3 fresnel(Reflection r, float cosine) { return r.f0 + (r.f90 - r.f0) * schlick(cosine); }

// GGX's distribution of normals, 1/sr. The cross product keeps it exact where a smooth surface is bright.
float ggx_distribution(vec3 normal, vec3 half_way, float alpha) {
    float squared = alpha * alpha;
    float cosine = dot(normal, half_way);
    vec3 across = cross(normal, half_way);
    float sum = squared * cosine * cosine + dot(across, across);
    return squared / max(PI * sum * sum, 1.17549435e-38);
}

float lengthened(float cosine, float alpha) {
    float squared = alpha * alpha;
    return sqrt(squared + (1.0 - squared) * cosine * cosine);
}

// The GGX lobe for light from the unit vector `to_light`, 1/sr; 0 for a perfect mirror.
vec3 reflected_towards_eye(Reflection r, vec3 to_light) {
    float cosine = dot(r.normal, to_light);
    if (r.mirror || cosine <= 0.0) return vec3(0.0);
    vec3 half_way = normalize(r.to_eye + to_light);
    float visibility = 0.5 / (cosine * lengthened(r.cosine, r.alpha) + r.cosine * lengthened(cosine, r.alpha));
    return fresnel(r, dot(r.to_eye, half_way)) * (ggx_distribution(r.normal, half_way, r.alpha) * visibility);
}

// Density of `sample_reflected`, 1/sr; 0 for a perfect mirror.
float reflected_density(Reflection r, vec3 direction) {
    if (r.mirror || dot(r.normal, direction) <= 0.0) return 0.0;
    vec3 half_way = normalize(r.to_eye + direction);
    float masking = 0.5 / (r.cosine + lengthened(r.cosine, r.alpha));
    return ggx_distribution(r.normal, half_way, r.alpha) * masking;
}

// Tangent, bitangent and normal. Twin: `Frame::around` in src/sampling.rs.
mat3 frame_around(vec3 normal) {
    const vec3 TANGENT = vec3(-0.8, 0.0, 0.6);
    vec3 sum = vec3(-0.48, -0.6, -0.64) + normal;
    float squared = dot(sum, sum);
    vec3 x = squared > 1e-10 ? TANGENT - sum * (2.0 * dot(TANGENT, sum) / squared) : TANGENT;
    x = normalize(x - normal * dot(x, normal));
    return mat3(x, cross(normal, x), normal);
}

// A direction about +z with the density cosine/pi.
vec3 cosine_hemisphere(vec2 u) {
    float angle = 2.0 * PI * u.x;
    return vec3(sqrt(u.y) * vec2(cos(angle), sin(angle)), sqrt(max(1.0 - u.y, 0.0)));
}

// Samples the GGX lobe by its visible normals.
Sampled sample_reflected(Reflection r, vec2 u) {
    if (r.mirror) return Sampled(reflect(-r.to_eye, r.normal), -1.0);
    mat3 axes = frame_around(r.normal);
    vec3 x = axes[0], y = axes[1];
    vec3 stretched = normalize(vec3(r.alpha * dot(x, r.to_eye), r.alpha * dot(y, r.to_eye), r.cosine));
    float z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    float angle = 2.0 * PI * u.x;
    vec3 cap = vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(angle), sin(angle)), z) + stretched;
    vec3 local = normalize(vec3(r.alpha * cap.xy, max(cap.z, 0.0)));
    vec3 direction = reflect(-r.to_eye, x * local.x + y * local.y + r.normal * local.z);
    return Sampled(direction, reflected_density(r, direction));
}

#endif
