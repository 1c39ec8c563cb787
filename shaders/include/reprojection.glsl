// Looking a surface up in what a set has drawn. Needs frame.glsl, scene.glsl, drawn_sets.glsl, `set_buffers`, `instances`,
// `view_history` and `push` with `set_size`, the size of the set buffers, and `instance_count`.

// Texel coordinates this close to a texel's centre take that texel alone, as in a view that stands still.
const float CENTRED = 0.01;

// A surface of an instance, in its object space; the normal of any length.
struct InObject {
    uint instance;
    vec3 position;
    vec3 normal;
};

// The surface of an instance at p, world space, where it is now.
InObject in_object(uint instance, vec3 p, vec3 n) {
    InstanceData now = instances.data[instance];
    vec3 p_os = transform_point(now.world_to_object, p);
    return InObject(instance, p_os, transform_point(now.world_to_object, p + n) - p_os);
}

// A surface as the camera that drew a set saw it: x to the right, y down, z along the view, world units.
struct Seen {
    vec3 position;
    vec3 normal;
};

// Where the camera that drew a set saw a surface.
Seen seen_by(SetParameters set, InObject surface) {
    int first = int((set.layer * push.instance_count + surface.instance) * 3u);
    Seen seen;
    for (int row = 0; row < 3; row++) {
        vec4 view = uintBitsToFloat(texelFetch(view_history, first + row));
        seen.position[row] = dot(view, vec4(surface.position, 1.0));
        seen.normal[row] = dot(view.xyz, surface.normal);
    }
    seen.normal *= inversesqrt(dot(seen.normal, seen.normal));
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
    if (all(lessThan(abs(part - round(part)), vec2(CENTRED)))) {
        base += round(part);
        part = vec2(0.0);
    }
    // Neighbouring texels of a surface seen at a grazing angle are farther apart than the cut-off.
    float cosine = abs(dot(seen.normal, p)) * inversesqrt(dot(p, p));
    float footprint = depth * 2.0 / size.y * set.tan_y / max(cosine, 0.05);
    float near = 0.25 * frame.position_cutoff * depth;
    float cutoff = max(4.0 * near, 1.5 * footprint);
    // The four texels around, all at once: left and right above, left and right below.
    ivec2 last = ivec2(push.set_size) - 1;
    ivec2 low = clamp(ivec2(base), ivec2(0), last);
    ivec2 high = clamp(ivec2(base) + 1, ivec2(0), last);
    vec2 low_weight = mix(vec2(0.0), 1.0 - part, equal(vec2(low), base));
    vec2 high_weight = mix(vec2(0.0), part, equal(vec2(high), base + 1.0));
    vec4 weight = vec4(low_weight.x, high_weight.x, low_weight.x, high_weight.x)
        * vec4(low_weight.yy, high_weight.yy);
    int layer = int(set.layer);
    vec4 stored[4] = vec4[](
        imageLoad(set_buffers, ivec3(low, layer)), imageLoad(set_buffers, ivec3(high.x, low.y, layer)),
        imageLoad(set_buffers, ivec3(low.x, high.y, layer)), imageLoad(set_buffers, ivec3(high, layer)));
    // The surfaces that were drawn there, from their depths.
    vec4 depths = vec4(stored[0].w, stored[1].w, stored[2].w, stored[3].w) / frame.depth_scale;
    vec2 ray_low = ((vec2(low) + 0.5) / size * 2.0 - 1.0) * tangents;
    vec2 ray_high = ((vec2(high) + 0.5) / size * 2.0 - 1.0) * tangents;
    vec4 x = depths * vec4(ray_low.x, ray_high.x, ray_low.x, ray_high.x) - p.x;
    vec4 y = depths * vec4(ray_low.yy, ray_high.yy) - p.y;
    vec4 z = depths - p.z;
    vec4 distance = abs(x * seen.normal.x + y * seen.normal.y + z * seen.normal.z);
    weight = mix(vec4(0.0), weight, lessThanEqual(distance, vec4(near)));
    weight = mix(vec4(0.0), weight, lessThanEqual(x * x + y * y + z * z, vec4(cutoff * cutoff)));
    weight = mix(vec4(0.0), weight, greaterThan(depths, vec4(0.0)));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; i++) sum += weight[i] > 0.0 ? weight[i] * stored[i].rgb : vec3(0.0);
    float weights = weight.x + weight.y + weight.z + weight.w;
    found = sum / max(weights, 1e-6) * set.scale;
    return weights > 0.0;
}
