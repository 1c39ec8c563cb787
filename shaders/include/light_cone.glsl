// The directions from which a light with an extent shines on a point: a cone about the direction to its centre. Twin, with the
// equations: src/scene/light_cone.rs.

struct LightCone {
    vec3 axis;           // unit, to the centre
    float one_minus_cos; // of the half angle
    float distance;      // to the centre; FAR for a directional light
    float radius;        // of a sphere; 0 without one
};

LightCone cone_to_sphere(vec3 axis, float distance, float radius) {
    float sine = min(radius / distance, 1.0);
    return LightCone(axis, sine * sine / (1.0 + sqrt(1.0 - sine * sine)), distance, radius);
}

LightCone cone_to_disc(vec3 axis, float half_angle) {
    float sine = sin(0.5 * half_angle);
    return LightCone(axis, min(2.0 * sine * sine, 1.0), FAR, 0.0);
}

// Sine of the half angle.
float sine_of(LightCone cone) { return sqrt(cone.one_minus_cos * (2.0 - cone.one_minus_cos)); }

// Irradiance across a sampled direction over its density, relative to that across the axis of a light without extent.
float gain_of(LightCone cone) { return 2.0 / (2.0 - cone.one_minus_cos); }

// A unit direction, uniform in the cone; `reach`: along it to the light's near surface.
vec3 sample_cone(LightCone cone, vec2 u, out float reach) {
    reach = cone.distance;
    if (cone.one_minus_cos == 0.0) return cone.axis;
    float one_minus_cos = u.x * cone.one_minus_cos;
    float across = sqrt(one_minus_cos * (2.0 - one_minus_cos));
    float angle = 2.0 * PI * u.y;
    vec3 x = normalize(abs(cone.axis.x) > 0.7 ? cross(cone.axis, vec3(0.0, 1.0, 0.0)) : cross(cone.axis, vec3(1.0, 0.0, 0.0)));
    vec3 y = cross(cone.axis, x);
    float d = cone.distance;
    float r = cone.radius;
    if (r > 0.0) {
        float half_chord = sqrt(max(r * r - d * d * one_minus_cos * (2.0 - one_minus_cos), 0.0));
        reach = d <= r ? 0.0 : (d + r) * (d - r) / (d * (1.0 - one_minus_cos) + half_chord);
    }
    return (x * cos(angle) + y * sin(angle)) * across + cone.axis * (1.0 - one_minus_cos);
}
