// The set buffers, and the lookup of a surface in them. Needs frame.glsl, scene_set.glsl, vpls.glsl, same_surface.glsl
// and representative.glsl.
// Define SET_BUFFERS_BINDING before including: it and the next are taken; and SET_BUFFERS_WRITTEN where the pass writes them, too.
// Twins: SetParameters, SetPush in
// src/estimators/vpls/set_buffers.rs.

#ifdef SET_BUFFERS_WRITTEN
layout(set = 0, binding = SET_BUFFERS_BINDING, rgba16ui) uniform uimage2DArray set_buffers;
#else
layout(set = 0, binding = SET_BUFFERS_BINDING, rgba16ui) uniform readonly uimage2DArray set_buffers;
#endif
// For each set its SetParameters, then three rows for each instance: from object space to the space of the set's camera.
layout(set = 0, binding = SET_BUFFERS_BINDING + 1) uniform utextureBuffer set_views;

struct SetPush {
    uvec2 size;         // of the pictures of the sets, pixels
    uint set_step;      // pixels from one texel to the next
    uint instance_count;
    uint set_count;     // sets in all
    uint shown_set;     // of vpl_view.comp
    uint scale_missing; // 1: sets that saw the surface make up for those that did not
    float total_flux;   // luminous, of all sets
    uint view;          // of vpl_view.comp
    uint frame;         // of vpl_view.comp: number of this frame
    uint rendered_step; // of vpl_view.comp: pixels from one texel of the set that this frame renders to the next
    uint fill_mode;     // of irradiance_upsampling.comp: 0: fills all pixels; 1: leaves those that no set saw; 2: fills those alone
};
layout(push_constant) uniform Push { SetPush data; } push;
SetPush sets = push.data;

struct SetParameters {
    float scale; // irradiance over what the set buffer holds; 0: it was not rendered yet
    float flux;  // luminous, of the set
    float tan_y; // tangent of half the vertical field of view of the camera that rendered it
    uvec2 offset; // of the representative
    int layer;    // of the set buffers
    uint frame;   // that rendered it, the low 16 bits
};

int first_row(uint set) { return int(set * (3u * sets.instance_count + 1u)); }

SetParameters set_at(uint set) {
    uvec4 texel = texelFetch(set_views, first_row(set));
    vec3 floats = uintBitsToFloat(texel.xyz);
    uvec2 offset = uvec2(texel.w & 1u, texel.w >> 1 & 1u);
    return SetParameters(floats.x, floats.y, floats.z, offset, int(texel.w >> 2 & 0x3fffu), texel.w >> 16);
}

// A point of an instance's surface in its object space; the normal of any length.
struct ObjectPoint {
    uint instance;
    vec3 position;
    vec3 normal;
};

ObjectPoint to_object(uint instance, vec3 p, vec3 n) {
    InstanceData now = instances.data[instance];
    vec3 p_os = transform_point(now.world_to_object, p);
    return ObjectPoint(instance, p_os, transform_point(now.world_to_object, p + n) - p_os);
}

// The point as the camera that rendered a set saw it: x to the right, y down, z along the view, world units.
struct ViewPoint {
    vec3 position;
    vec3 normal;
};

ViewPoint to_view(uint set, ObjectPoint point) {
    int first = first_row(set) + 1 + int(3u * point.instance);
    ViewPoint view;
    for (int row = 0; row < 3; row++) {
        vec4 to_view = uintBitsToFloat(texelFetch(set_views, first + row));
        view.position[row] = dot(to_view, vec4(point.position, 1.0));
        view.normal[row] = dot(to_view.xyz, point.normal);
    }
    view.normal = normalize(view.normal);
    return view;
}

// Irradiance of a set, and its history length, where its camera saw the point, bilinear among the texels on its surface, which
// leaves its plane by at most `slope`, see slope.glsl; false where it did not.
bool look_up(uint set, ObjectPoint surface, float slope, out vec4 found) {
    SetParameters parameters = set_at(set);
    ViewPoint point = to_view(set, surface);
    vec3 p = point.position;
    vec2 size = vec2(sets.size);
    vec2 tangents = parameters.tan_y * vec2(size.x / size.y, 1.0);
    vec2 pixel = (p.xy / (p.z * tangents) * 0.5 + 0.5) * size - 0.5;
    vec2 at = (pixel - vec2(parameters.offset)) / float(sets.set_step);
    // Rounding must not ask a second texel in a stationary view.
    at = mix(at, round(at), lessThan(abs(at - round(at)), vec2(0.005)));
    vec2 base = floor(at);
    vec2 part = at - base;
    // Neighbouring texels of a surface seen at a grazing angle are farther apart than the cut-off.
    float cosine = abs(dot(point.normal, p)) * inversesqrt(dot(p, p));
    float footprint = p.z * 2.0 / size.y * parameters.tan_y * float(sets.set_step) / max(cosine, 0.05);
    float cutoff = max(vpl.position_cutoff * p.z, 1.5 * footprint);

    // Read the four texels around, all at once: left and right above, left and right below.
    ivec2 last = ivec2(set_extent(sets.size, sets.set_step)) - 1;
    ivec2 low = clamp(ivec2(base), ivec2(0), last);
    ivec2 high = clamp(ivec2(base) + 1, ivec2(0), last);
    vec2 low_weight = mix(vec2(0.0), 1.0 - part, equal(vec2(low), base));
    vec2 high_weight = mix(vec2(0.0), part, equal(vec2(high), base + 1.0));
    vec4 weight = vec4(low_weight.x, high_weight.x, low_weight.x, high_weight.x)
        * vec4(low_weight.yy, high_weight.yy);
    int layer = parameters.layer;
    uvec4 texels[4] = uvec4[](
        imageLoad(set_buffers, ivec3(low, layer)),
        imageLoad(set_buffers, ivec3(high.x, low.y, layer)),
        imageLoad(set_buffers, ivec3(low.x, high.y, layer)),
        imageLoad(set_buffers, ivec3(high, layer)));
    vec4 stored[4] = vec4[](unpack_texel(texels[0]), unpack_texel(texels[1]), unpack_texel(texels[2]), unpack_texel(texels[3]));
    vec4 lengths = vec4(history_length_of(texels[0]), history_length_of(texels[1]), history_length_of(texels[2]), history_length_of(texels[3]));

    // Keep those whose surfaces, from their depths, are the point's.
    vec4 depths = vec4(stored[0].a, stored[1].a, stored[2].a, stored[3].a);
    vec2 low_pixel = vec2(representative(low, sets.set_step, parameters.offset, sets.size));
    vec2 high_pixel = vec2(representative(high, sets.set_step, parameters.offset, sets.size));
    vec2 low_ray = ((low_pixel + 0.5) / size * 2.0 - 1.0) * tangents;
    vec2 high_ray = ((high_pixel + 0.5) / size * 2.0 - 1.0) * tangents;
    vec4 x = depths * vec4(low_ray.x, high_ray.x, low_ray.x, high_ray.x) - p.x;
    vec4 y = depths * vec4(low_ray.yy, high_ray.yy) - p.y;
    vec4 z = depths - p.z;
    vec4 from_plane = abs(x * point.normal.x + y * point.normal.y + z * point.normal.z);
    vec4 distances = sqrt(x * x + y * y + z * z);
    vec4 near = ROUNDING * p.z + slope * distances * distances;
    bvec4 same = bvec4(uvec4(lessThanEqual(from_plane, near)) & uvec4(greaterThan(depths, vec4(0.0)))
        & uvec4(lessThanEqual(distances, vec4(cutoff))));
    weight = mix(vec4(0.0), weight, same);
    float weights = weight.x + weight.y + weight.z + weight.w;
    vec3 irradiance = weight.x * stored[0].rgb + weight.y * stored[1].rgb + weight.z * stored[2].rgb + weight.w * stored[3].rgb;
    found = vec4(irradiance * parameters.scale, dot(weight, lengths)) / max(weights, 1e-6);
    return parameters.scale > 0.0 && p.z > 0.0 && weights > 0.0;
}

// Where a set may have seen a surface: at its place now, as light stays with the place when an object turns; else where the object was.
// `first`: 1 for what is static, which was nowhere else.
struct SeenPlaces { ObjectPoint now; ObjectPoint moved; uint first; };

SeenPlaces places_of(uint instance, vec3 p, vec3 n) {
    // The last rows of a set are those of the world.
    ObjectPoint now = ObjectPoint(sets.instance_count - 1u, p, n);
    return SeenPlaces(now, to_object(instance, p, n), instances.data[instance].is_dynamic == 1u ? 0u : 1u);
}

bool look_up(uint set, SeenPlaces places, float slope, out vec4 found) {
    bool seen = false;
    for (uint place = places.first; place < 2u && !seen; place++) {
        ObjectPoint point = places.now;
        if (place == 1u) point = places.moved;
        seen = look_up(set, point, slope, found);
    }
    return seen;
}

// The sum of all sets at the surface that a pixel sees (algorithm 4 of Tonna 2019). Sets that have not seen it, or that were rendered
// before much has changed, are made up for by the others, in proportion to flux. a: how many sets saw it. Out: the variance of the
// sum's luminance, as the sets differ.
vec4 sum_of_sets(uint instance, vec3 position, vec3 normal, float slope, out float variance) {
    SeenPlaces places = places_of(instance, position, normal);
    bool scaled = sets.scale_missing == 1u;
    vec4 sum = vec4(0.0);
    float flux = 0.0;
    float weights = 0.0;
    vec3 moments = vec3(0.0); // of the weights, the luminance, its square
    for (uint set = 0u; set < sets.set_count; set++) {
        vec4 found;
        if (!look_up(set, places, slope, found)) continue;
        vec3 irradiance = found.rgb;
        float weight = scaled ? set_weight(set) : 1.0;
        float light = luminance(irradiance);
        sum += vec4(weight * irradiance, 1.0);
        flux += weight * set_at(set).flux;
        weights += weight;
        moments += weight * vec3(weight, light, light * light);
    }
    if (weights <= 0.0) {
        variance = 0.0;
        return sum;
    }
    // As many sets of one weight would be as uncertain. A single one does not tell how uncertain it is.
    float effective = weights * weights / moments.x;
    float mean = moments.y / weights;
    float spread = max(moments.z / weights - mean * mean, 0.0) / max(effective - 1.0, 1e-3);
    float count = float(sets.set_count);
    variance = count * count * (effective > 1.5 ? spread : mean * mean);
    bool missing = sum.a < count || weights < sum.a;
    if (missing && scaled && flux > 0.0) sum.rgb *= sets.total_flux / flux;
    return sum;
}
