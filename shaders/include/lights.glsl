// Point, spot and directional lights. Twin: LightData in src/passes/structs.rs. Needs frame.glsl and surface.glsl.

const uint LIGHT_POINT = 0u;
const uint LIGHT_SPOT = 1u;
const uint LIGHT_DIRECTIONAL = 2u;

struct LightData {
    vec4 position;  // xyz: world position; w: cosine of the spot's inner angle
    vec4 direction; // xyz: direction in which light travels; w: cosine of the spot's outer angle
    vec4 power;     // rgb: intensity in W/sr, or irradiance in W/m^2
    uint kind;
    uint pad0;
    uint pad1;
    uint pad2;
};

// Irradiance on a plane across the direction to the light, were nothing between.
vec3 unshadowed(LightData light, vec3 p, out vec3 to_light) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        to_light = -light.direction.xyz;
        return light.power.rgb;
    }
    vec3 d = light.position.xyz - p;
    float squared = max(dot(d, d), 1e-30);
    to_light = d * inversesqrt(squared);
    float falloff = 1.0;
    if (light.kind == LIGHT_SPOT) {
        falloff = smoothstep(light.direction.w, light.position.w, dot(-to_light, light.direction.xyz));
    }
    return light.power.rgb * falloff / squared;
}

// The same on the surface: 0 where it faces away.
vec3 unshadowed_irradiance(LightData light, Surface surface, out vec3 to_light) {
    vec3 irradiance = unshadowed(light, surface.position, to_light);
    float cosine = dot(surface.shading, to_light);
    bool faces = cosine > 0.0 && dot(surface.geometric, to_light) > 0.0;
    return faces ? irradiance * cosine : vec3(0.0);
}

// Lights whose visibility one texel of a layer of `direct_shadows` holds, a bit each.
const uint LIGHTS_PER_LAYER = 32u;
