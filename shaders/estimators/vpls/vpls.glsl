// VPLs, and what one emits. Needs frame.glsl. Define VPLS_BINDING before including: it and the next are taken.
// Twins: VplUniforms in src/estimators/vpls/vpl_buffer.rs, GpuVpl and GlossyLobe in src/estimators/vpls/manager/.
#include "bsdf.glsl"

// A box that an instance has swept. Twin: src/estimators/vpls/swept_bounds.rs.
struct SweptBox {
    vec3 low;
    float exists; // 1: there is a box
    vec3 high;
    float pad;
};
const uint MAX_SWEPT_BOXES = 8u;

struct VplUniforms {
    float geometry_bound;   // c, 1/m^2; 0: none
    float irradiance_scale; // images hold irradiance times this
    float position_cutoff;  // fraction of view depth
    uint first_vpl;         // of the set, in `vpls`
    uint vpl_count;         // of the set
    uint layer;             // of the set buffers, for the set
    uvec2 representative;   // see representative.glsl
    uint bounces;           // of a path, at most
    uint cycle;             // how often all sets have had their turn
    uint target;            // layer of the set buffers that its turn writes
    float longest_history;  // turns before this one that its buffer is the mean of, at most
    vec4 set_weights[16];   // of each temporal set: the less, the more has changed since it was rendered
    SweptBox swept[MAX_SWEPT_BOXES]; // since the set was last rendered; those that exist come first
};

// The GGX lobe of a VPL on a glossy surface, by which it emits a share of its flux; the Lambertian lobe emits the rest.
struct GlossyLobe {
    vec3 incident; // unit direction that the normal mirrors as the shading normal mirrors the light that arrived
    uint packed;   // unorm: the lobe's share of the flux in each channel, and its roughness; 0: no such lobe
};

struct GpuVpl {
    vec3 position;    // a ray offset above the surface; at infinity the unit direction towards it
    uint slot;
    vec3 normal;      // geometric, of the side that shines
    uint bounce;
    vec3 flux;        // phi, W; at infinity the irradiance across its direction, W/m^2
    uint at_infinity; // 1: a direction instead of a place
    GlossyLobe lobe;
};

layout(set = 0, binding = VPLS_BINDING, std140) uniform VplUniformBlock { VplUniforms data; } vpl_uniforms;
layout(set = 0, binding = VPLS_BINDING + 1, std430) readonly buffer VplBlock { GpuVpl data[]; } vpls;
VplUniforms vpl = vpl_uniforms.data;

float set_weight(uint set) { return vpl_uniforms.data.set_weights[set / 4u][set % 4u]; }

// Bound c of the geometry term of a VPL, 1/m^2; 0: none. That of a light's own VPLs is looser, as what it takes away may be lost:
// short rays do not see the portal of a window.
float bound_of(GpuVpl light) { return light.bounce == 0u ? 16.0 * vpl.geometry_bound : vpl.geometry_bound; }

// Intensity of a VPL in a unit direction over its flux, 1/sr.
vec3 emission_density(GpuVpl light, vec3 direction) {
    float cosine = dot(light.normal, direction);
    if (cosine <= 0.0) return vec3(0.0);
    vec3 diffuse = vec3(cosine / PI);
    if (light.lobe.packed == 0u) return diffuse;
    vec4 lobe = unpackUnorm4x8(light.lobe.packed);
    // Normalized: that of a surface that reflects all light.
    Reflection white = prepare_bsdf(Bsdf(vec3(0.0), 0.0, vec3(1.0), 1.0, lobe.a), light.normal, -light.lobe.incident);
    return mix(diffuse, reflected_towards_eye(white, direction) * cosine, lobe.rgb);
}

// Whether a ray crosses a box that an instance has swept, so that its occlusion may have changed.
bool crosses_swept_box(vec3 origin, vec4 ray) {
    vec3 inverse = 1.0 / ray.xyz;
    for (uint i = 0u; i < MAX_SWEPT_BOXES && vpl_uniforms.data.swept[i].exists > 0.0; i++) {
        vec3 a = (vpl_uniforms.data.swept[i].low - origin) * inverse;
        vec3 b = (vpl_uniforms.data.swept[i].high - origin) * inverse;
        vec3 near = min(a, b);
        vec3 far = max(a, b);
        if (max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, ray.w))) return true;
    }
    return false;
}

// The occlusion ray from a surface to the VPL: its direction and, in w, the t at which it ends.
vec4 ray_to(GpuVpl light, vec3 origin) {
    return light.at_infinity != 0u ? vec4(light.position, 1e30) : vec4(light.position - origin, 1.0);
}
