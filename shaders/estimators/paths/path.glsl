// Irradiance by one path: at each vertex one light and one scattered ray estimate the light that arrives, weighted by the power heuristic
// (Kajiya 1986; Veach 1997, section 9.2). Twin, with the equations: src/reference/path.rs. Needs light_sampling.glsl,
// environment_sampling.glsl, hit.glsl, noise.glsl, path_vertices.glsl, `PathPush push`, `STORES_VERTICES`, `store_vertex` and `store_last_vertex`.

// Surfaces that scatter light before it arrives, at most.
layout(constant_id = 2) const uint BOUNCES = 2u;

// Dimensions of the random numbers at a vertex: direction; light and lobe; point of the light.
const uint DIMENSIONS = 3u;
// Blue noise for the first surface alone: further bounces would scramble it.
vec2 path_noise(ivec2 pixel, uint frame_index, uint dimension, uint bounce) {
    return bounce == 0u ? noise_of(pixel, frame_index, dimension) : white_noise_of(pixel, frame_index, dimension + bounce * DIMENSIONS);
}

// Angle by which a diffuse bounce widens a ray cone, radians: small, so that textures keep their detail where surfaces are near.
const float DIFFUSE_SPREAD = 0.1;

uint environment_light() { return frame.light_count + frame.area_light_count; }

// Estimates the unoccluded luminance that a light sends to where a path came from.
float light_weight(uint index, ShadingPoint at) {
    if (index != environment_light()) return luminance(unshadowed_radiance(index, at));
    return push.environment * luminance(at.diffuse + (at.is_glossy ? at.reflection.reflected : vec3(0.0)));
}

// One of the lights from `first` on; the environment comes last.
Reservoir choose_path_light(ShadingPoint at, uint first, float pick) {
    Reservoir reservoir = new_reservoir(pick);
    uint end = environment_light() + (push.environment > 0.0 ? 1u : 0u);
    for (uint i = first; i < end; i++) update(reservoir, i, light_weight(i, at));
    return reservoir;
}

// MIS weight of a sample with density `own` where the other technique has density `other` (Veach 1997, section 9.2).
float power_heuristic(float own, float other) { return 1.0 / (1.0 + (other / own) * (other / own)); }

// The probability of the GGX lobe in `sample_bsdf`.
float reflected_share(ShadingPoint at) {
    if (!at.is_glossy) return 0.0;
    vec3 r = at.reflection.reflected, d = at.diffuse;
    float reflected = max(r.x, max(r.y, r.z));
    return reflected > 0.0 ? reflected / (reflected + max(d.x, max(d.y, d.z))) : 0.0;
}

// Density of `sample_bsdf`, 1/sr, without the directions of perfect mirrors.
float bsdf_density(ShadingPoint at, vec3 direction, float share) {
    float diffuse = max(dot(at.surface.shading, direction), 0.0) / PI;
    return share > 0.0 ? mix(diffuse, reflected_density(at.reflection, direction), share) : diffuse;
}

// A scattered ray.
struct Scattered {
    vec3 direction;
    vec3 weight;   // BSDF times cosine over density; 0: nothing is reflected
    float density; // 1/sr; 0: no light sampling finds this direction
    float spread;  // what it widens a ray cone by
    bool mirrors;  // of a perfect mirror, to which lights send nothing
};

Scattered sample_bsdf(ShadingPoint at, float pick, vec2 u) {
    float share = reflected_share(at);
    Scattered result;
    result.mirrors = false;
    if (pick < share) {
        Sampled sampled = sample_reflected(at.reflection, u);
        result.direction = sampled.direction;
        result.spread = at.reflection.alpha;
        if (sampled.density < 0.0) {
            result.weight = fresnel(at.reflection, dot(at.reflection.normal, sampled.direction)) / share;
            result.density = 0.0;
            result.mirrors = true;
            return result;
        }
    } else {
        vec3 local = cosine_hemisphere(u);
        result.direction = frame_around(at.surface.shading) * local;
        result.spread = DIFFUSE_SPREAD;
    }
    result.density = bsdf_density(at, result.direction, share);
    float cosine = dot(at.surface.shading, result.direction);
    bool is_valid = cosine > 0.0 && result.density > 0.0;
    result.weight = is_valid ? bsdf_of(at, result.direction, 1.0) * (cosine / result.density) : vec3(0.0);
    return result;
}

// Radiance that the surface reflects to where the path came from of one light, by a shadow ray; weighted by MIS.
vec3 next_event_estimation(ShadingPoint at, Reservoir reservoir, vec2 u, inout uint rays) {
    if (!(reservoir.weight > 0.0)) return vec3(0.0);
    float probability = reservoir.weight / reservoir.sum;
    LightSample light;
    if (reservoir.selected == environment_light()) {
        light.to_light = sample_environment(u, light.density);
        light.irradiance = light.density > 0.0 ? environment_radiance(light.to_light, false) / light.density : vec3(0.0);
        light.reach = FAR;
    } else {
        light = sample_light(reservoir.selected, at, u);
    }
    float cosine = dot(at.surface.shading, light.to_light);
    if (cosine <= 0.0 || dot(at.surface.geometric, light.to_light) <= 0.0 || light.irradiance == vec3(0.0)) return vec3(0.0);
    vec3 radiance = bsdf_of(at, light.to_light, 1.0) * light.irradiance * (cosine / probability);
    if (light.density > 0.0) {
        float other = bsdf_density(at, light.to_light, reflected_share(at));
        radiance *= power_heuristic(light.density * probability, other);
    }
    if (radiance == vec3(0.0)) return radiance;
    rays++;
    return radiance * sample_transmittance(light, at.surface);
}

// MIS weight of light found by a scattered ray from `at`; light sampling finds its direction on light `index` with `density`, 1/sr.
float mis_weight_bsdf(ShadingPoint at, Reservoir reservoir, uint index, float density, Scattered scattered) {
    if (scattered.density == 0.0) return 1.0;
    float probability = reservoir.sum > 0.0 ? light_weight(index, at) / reservoir.sum : 0.0;
    return power_heuristic(scattered.density, probability * density);
}

// MIS weight of emission that a scattered ray has hit; 0 for direct light, which other passes add.
float mis_weight_emission(ShadingPoint at, Reservoir reservoir, uint first, TracerHit hit, HitSurface surface, Scattered scattered) {
    uint light = instances.data[hit.instance].area_light;
    if (light == 0u) return 1.0;
    light += frame.light_count - 1u;
    if (light < first) return 0.0;
    AreaLightData data = area_lights.data[light - frame.light_count];
    float cosine = abs(dot(surface.geometric, scattered.direction));
    float density = hit.t * hit.t / (max(cosine, 1e-6) * data.area);
    return mis_weight_bsdf(at, reservoir, light, density, scattered);
}

// Follows a scattered ray from `at`: adds what it meets to the light that `at` sends back, and goes on to the surface that it meets, if
// there is one.
bool scatter(inout ShadingPoint at, Reservoir reservoir, uint first, inout Scattered scattered, inout RayCone cone, inout vec3 light, inout uint rays) {
    // A ray that the shading normal sends below the triangle is mirrored by it: no energy is lost. Light sampling cannot find it.
    float below = dot(at.surface.geometric, scattered.direction);
    if (below <= 0.0) {
        scattered.direction -= 2.0 * below * at.surface.geometric;
        scattered.density = 0.0;
    }
    cone.spread += scattered.spread;
    vec3 origin = ray_origin(at.surface);
    TracerHit hit;
    rays++;
    bool met = trace_closest(origin, scattered.direction, 0.0, FAR, hit);
    if (HAS_THIN_SURFACES) scattered.weight *= trace_transmittance(origin, scattered.direction, 0.0, met ? just_before(hit.t) : FAR);
    if (!met) {
        if (push.has_environment == 0u) return false;
        float share = 1.0;
        if (push.environment > 0.0) {
            float density = environment_density(scattered.direction);
            share = mis_weight_bsdf(at, reservoir, environment_light(), density, scattered);
        }
        light += scattered.weight * share * environment_radiance(scattered.direction, scattered.mirrors);
        return false;
    }
    HitSurface found = surface_of(hit, scattered.direction, cone);
    if (found.emission != vec3(0.0)) {
        light += scattered.weight * found.emission * mis_weight_emission(at, reservoir, first, hit, found, scattered);
    }
    cone.width += cone.spread * hit.t;
    at.surface = Surface(found.position, found.shading, found.geometric, hit.t, 0.0);
    at.is_glossy = reflects(found.bsdf);
    at.reflection = prepare_bsdf(found.bsdf, found.shading, -scattered.direction);
    at.diffuse = at.reflection.diffuse;
    return true;
}

// Light over the albedo that reflected it; 0 where that is 0.
vec3 demodulate(vec3 light, vec3 albedo) { return mix(light / max(albedo, vec3(1e-6)), vec3(0.0), lessThan(albedo, vec3(1e-6))); }

// Irradiance of a surface, W/m^2, by the lights from `first` on (those before are lit by other passes), and by all that other surfaces
// scatter. `place`: of the path's random numbers, those of `pixel` in the frame `frame_index`, from the dimension `dimension` on.
// `store_vertex` is told of each vertex: irradiance is what would, on a white surface of its albedo, be the light that it sends back.
vec3 path_irradiance(Surface surface, RayCone cone, uint first, ivec2 pixel, uint frame_index, uint dimension, inout uint rays) {
    vec3 radiance = vec3(0.0);
    vec3 throughput = vec3(PI);
    // The radiance of a white diffuse surface is the irradiance over pi.
    ShadingPoint at;
    at.surface = surface;
    at.diffuse = vec3(1.0);
    at.is_glossy = false;
    at.gloss_of_areas = 1.0;
    vec3 albedo = vec3(1.0);
    bool goes_on = true;
    for (uint bounce = 0u; bounce <= BOUNCES && goes_on; bounce++) {
        vec2 picks = path_noise(pixel, frame_index, dimension + 1u, bounce);
        Reservoir reservoir = choose_path_light(at, first, picks.x);
        vec3 light = next_event_estimation(at, reservoir, path_noise(pixel, frame_index, dimension + 2u, bounce), rays);
        vec3 next = vec3(0.0), last_albedo = albedo, weight = vec3(0.0);
        Surface lit = at.surface;

        // The last ray finds emission alone, and the place whose light filters may know.
        goes_on = bounce < BOUNCES || frame.area_light_count > 0u || push.has_environment == 1u || STORES_VERTICES;
        if (goes_on) {
            Scattered scattered = sample_bsdf(at, picks.y, path_noise(pixel, frame_index, dimension, bounce));
            goes_on = scattered.weight != vec3(0.0) && scatter(at, reservoir, first, scattered, cone, light, rays);
            if (goes_on) {
                weight = scattered.weight;
                albedo = at.diffuse + (at.is_glossy ? at.reflection.reflected : vec3(0.0));
                next = demodulate(weight * albedo, last_albedo);
            }
        }
        radiance += throughput * light;
        throughput *= weight;
        store_vertex(bounce, PathVertex(lit.position, lit.geometric, demodulate(PI * light, last_albedo), next, VERTEX_LIT));
        first = 0u;
    }
    store_last_vertex(goes_on, at.surface);
    return radiance;
}
