// Shrinkage (James and Stein 1961): an estimate is blended with that of the surfaces around it, the more the larger its variance is
// beside the square of their difference. Thin and disoccluded surfaces, of which few sets have samples, are neither black nor white then.

// So few sets may be alike by chance, all black as well as all bright.
const float FEW_SETS = 3.0;

// rgb: irradiance; a: how many sets saw it.
bool may_be_black_by_chance(vec4 irradiance) { return irradiance.a <= FEW_SETS && irradiance.rgb == vec3(0.0); }

// Weight of a neighbour, by the cosine between their normals and how many texels it is away.
float neighbour_weight(float cosine, vec3 d) { return (max(cosine, 0.0) + 0.05) / (1.0 + dot(d, d)); }

// The irradiance shrunk to the weighted sum of its neighbours'.
vec3 shrunk(vec3 irradiance, float variance, vec4 neighbours) {
    vec3 around = neighbours.rgb / neighbours.a;
    float difference = luminance(irradiance - around);
    return mix(irradiance, around, min(variance / max(difference * difference, 1e-12), 1.0));
}
