// Looking a surface up in what a set has drawn. Needs frame.glsl, drawn_sets.glsl, `set_buffers`, `view_history` and
// `push` with `set_size`, the size of the set buffers, and `instance_count`.

// Texel coordinates this close to a texel's centre take that texel alone, as in a view that stands still.
const float CENTRED = 0.01;

// A surface as the camera that drew a set saw it: x to the right, y down, z along the view, world units.
struct Seen {
    vec3 position;
    vec3 normal;
};

// Where the camera that drew a set saw a surface of an instance: position and normal in object space, the latter of any length.
Seen seen_by(SetParameters set, uint instance, vec3 p_os, vec3 n_os) {
    int first = int((set.layer * push.instance_count + instance) * 3u);
    Seen seen;
    for (int row = 0; row < 3; row++) {
        vec4 view = uintBitsToFloat(texelFetch(view_history, first + row));
        seen.position[row] = dot(view, vec4(p_os, 1.0));
        seen.normal[row] = dot(view.xyz, n_os);
    }
    seen.normal = normalize(seen.normal);
    return seen;
}

// Irradiance of a set where its camera saw the surface; false where it did not.
bool look_up(SetParameters set, Seen seen, out vec3 found) {
    vec3 p = seen.position;
    float depth = p.z;
    if (depth <= 0.0) return false;
    vec2 size = vec2(push.set_size);
    vec2 tangents = set.tan_y * vec2(size.x / size.y, 1.0);
    vec2 texel = (p.xy / (depth * tangents) * 0.5 + 0.5) * size - 0.5;
    vec2 base = floor(texel);
    vec2 part = texel - base;
    bool centred = all(lessThan(abs(part - round(part)), vec2(CENTRED)));
    if (centred) {
        base += round(part);
        part = vec2(0.0);
    }
    // Neighbouring texels of a surface seen at a grazing angle are farther apart than the cut-off.
    float cosine = abs(dot(seen.normal, p)) * inversesqrt(dot(p, p));
    float footprint = depth * 2.0 / size.y * set.tan_y / max(cosine, 0.05);
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
        vec4 stored = inside ? imageLoad(set_buffers, ivec3(at, int(set.layer))) : vec4(0.0);
        // The surface that was drawn there, from its depth.
        vec2 ndc = (vec2(at) + 0.5) / size * 2.0 - 1.0;
        vec3 offset = vec3(ndc * tangents, 1.0) * (stored.w / frame.depth_scale) - p;
        bool same = stored.w > 0.0 && dot(offset, offset) <= cutoff * cutoff && abs(dot(offset, seen.normal)) <= near;
        sum += same ? weight * stored.rgb : vec3(0.0);
        weights += same ? weight : 0.0;
    } while (++i < taps);
    found = sum / max(weights, 1e-6) * set.scale;
    return weights > 0.0;
}
