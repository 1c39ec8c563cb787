// Light from everywhere around the scene. Needs frame.glsl. Define ENVIRONMENT_BINDING before including.

// Equirectangular, from the top left; its middle lies towards -z, its right half towards +x. One texel where there is no map.
layout(set = 0, binding = ENVIRONMENT_BINDING) uniform texture2D environment_map;

// Radiance from a direction of any length, bilinear; it repeats to the sides. Twin: Environment::radiance in src/scene/environment.rs.
vec3 environment_radiance(vec3 direction) {
    vec3 d = normalize(direction);
    float turn = frame.background.w;
    vec2 xz = vec2(cos(turn) * d.x - sin(turn) * d.z, sin(turn) * d.x + cos(turn) * d.z);
    // Towards a pole any azimuth will do.
    float azimuth = dot(xz, xz) > 0.0 ? atan(xz.x, -xz.y) : 0.0;
    vec2 uv = vec2(azimuth / (2.0 * PI) + 0.5, atan(length(xz), d.y) / PI);
    ivec2 size = textureSize(environment_map, 0);
    vec2 at = uv * vec2(size) - 0.5;
    ivec2 low = ivec2(floor(at));
    vec2 part = at - vec2(low);
    ivec2 x = (low.x + ivec2(0, 1) + size.x) % size.x;
    ivec2 y = clamp(low.y + ivec2(0, 1), 0, size.y - 1);
    vec3 top = mix(texelFetch(environment_map, ivec2(x.x, y.x), 0).rgb, texelFetch(environment_map, ivec2(x.y, y.x), 0).rgb, part.x);
    vec3 bottom = mix(texelFetch(environment_map, ivec2(x.x, y.y), 0).rgb, texelFetch(environment_map, ivec2(x.y, y.y), 0).rgb, part.x);
    return frame.background.rgb * mix(top, bottom, part.y);
}
