// Looking a surface up in what a set has drawn. Needs frame.glsl, set_parameters.glsl, `set_buffers`,
// `instance_history` and `push.set_size`, the size of the set buffers.

// Texel coordinates this close to a texel's centre take that texel alone, as in a view that stands still.
const float CENTRED = 0.01;

vec3 from_rows(uint first, vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(
        dot(instance_history.rows[first], h), dot(instance_history.rows[first + 1u], h),
        dot(instance_history.rows[first + 2u], h));
}

// Irradiance of a set at world position p (of that time) with normal n; false where it was not seen.
bool look_up(SetParameters parameters, vec3 p, vec3 n, out vec3 found) {
    vec3 v = p - parameters.eye.xyz;
    float depth = dot(v, parameters.ray.xyz);
    if (depth <= 0.0) return false;
    vec2 size = vec2(push.set_size);
    vec2 ndc = vec2(dot(v, parameters.ray_x.xyz) * parameters.ray_x.w, dot(v, parameters.ray_y.xyz) * parameters.ray_y.w) / depth;
    vec2 texel = (ndc * 0.5 + 0.5) * size - 0.5;
    vec2 base = floor(texel);
    vec2 part = texel - base;
    bool centred = all(lessThan(abs(part - round(part)), vec2(CENTRED)));
    if (centred) {
        base += round(part);
        part = vec2(0.0);
    }
    // Neighbouring texels of a surface seen at a grazing angle are farther apart than the cut-off.
    float cosine = abs(dot(n, v)) * inversesqrt(dot(v, v));
    float footprint = depth * 2.0 / size.y * inversesqrt(parameters.ray_y.w) / max(cosine, 0.05);
    float near = 0.25 * frame.position_cutoff * depth;
    float cutoff = max(4.0 * near, 1.5 * footprint);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    int taps = centred ? 1 : 4;
    int i = 0;
    do {
        ivec2 corner = ivec2(i & 1, i >> 1);
        float weight = (corner.x == 1 ? part.x : 1.0 - part.x) * (corner.y == 1 ? part.y : 1.0 - part.y);
        ivec2 at = ivec2(base) + corner;
        bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.set_size)));
        vec4 stored = inside ? imageLoad(set_buffers, ivec3(at, int(parameters.layer))) : vec4(0.0);
        // The surface that was drawn there, from its depth.
        vec2 at_ndc = (vec2(at) + 0.5) / size * 2.0 - 1.0;
        vec3 ray = parameters.ray.xyz + at_ndc.x * parameters.ray_x.xyz + at_ndc.y * parameters.ray_y.xyz;
        vec3 offset = ray * (stored.w / frame.depth_scale) - v;
        bool same = stored.w > 0.0 && dot(offset, offset) <= cutoff * cutoff && abs(dot(offset, n)) <= near;
        sum += same ? weight * stored.rgb : vec3(0.0);
        weights += same ? weight : 0.0;
    } while (++i < taps);
    found = sum / max(weights, 1e-6) * parameters.eye.w;
    return weights > 0.0;
}
