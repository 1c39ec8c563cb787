// Directions in proportion to the luminance of the environment's map without its suns, nearly. Needs environment.glsl. Twin: EnvironmentMap::sample and
// density in src/scene/environment.rs.

// Below 1, for what u leaves within a bin.
const float BELOW_ONE = 1.0 - exp2(-24.0);

// The integral of the distribution, in units of the map's texels; 0 without a map, or where it is black.
float environment_integral() {
    uint last = uint(environment_distribution.cumulative.length()) - 1u;
    return last > 0u ? environment_distribution.cumulative[last] : 0.0;
}

// A bin by inversion of `count` cumulative values, and u within it.
uint environment_bin(uint first, uint count, inout float u) {
    uint low = 0u;
    uint high = count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (environment_distribution.cumulative[first + middle] <= u) low = middle + 1u;
        else high = middle;
    }
    float before = low > 0u ? environment_distribution.cumulative[first + low - 1u] : 0.0;
    float share = environment_distribution.cumulative[first + low] - before;
    u = clamp((u - before) / max(share, 1e-30), 0.0, BELOW_ONE);
    return low;
}

// u in proportion to a linear function from `ends.x` to `ends.y`.
float sample_linear(vec2 ends, float u) {
    float most = max(ends.x, ends.y);
    if (most <= 0.0) return u;
    ends /= most;
    float root = sqrt(max(ends.x * ends.x + (ends.y * ends.y - ends.x * ends.x) * u, 0.0));
    return ends.x + root > 0.0 ? min(u * (ends.x + ends.y) / (ends.x + root), BELOW_ONE) : 0.0;
}

// Upper and lower edge of a row of cells, which lie between the centres of four texels.
vec2 environment_row(int row, int height) { return clamp((float(row) + vec2(-0.5, 0.5)) / float(height), 0.0, 1.0); }

// Density of `sample_environment` over solid angle, 1/sr, at the place `uv` of the map.
float environment_density_at(vec2 uv) {
    int height = textureSize(sky_map, 0).y;
    int row = clamp(int(uv.y * float(height) + 0.5), 0, height);
    vec2 edges = environment_row(row, height);
    float greatest_sine = sin(PI * clamp(0.5, edges.x, edges.y));
    float area = 2.0 * PI * PI * sin(PI * uv.y) * environment_integral();
    return area > 0.0 ? luminance(textureLod(sky_map, uv, 0.0).rgb) * greatest_sine / area : 0.0;
}

float environment_density(vec3 direction) { return environment_density_at(environment_place(direction)); }

// A direction, and its density over solid angle, 1/sr; 0: there is none.
vec3 sample_environment(vec2 u, out float density) {
    ivec2 size = textureSize(sky_map, 0);
    int row = int(environment_bin(0u, uint(size.y) + 1u, u.y));
    int column = int(environment_bin(uint(size.y) + 1u + uint(row * size.x), uint(size.x), u.x));
    ivec2 columns = ivec2(column, (column + 1) % size.x);
    ivec2 rows = ivec2(max(row - 1, 0), min(row, size.y - 1));
    vec2 above, below;
    for (int i = 0; i < 2; i++) {
        above[i] = luminance(texelFetch(sky_map, ivec2(columns[i], rows.x), 0).rgb);
        below[i] = luminance(texelFetch(sky_map, ivec2(columns[i], rows.y), 0).rgb);
    }
    float down = sample_linear(vec2(above.x + above.y, below.x + below.y), u.y);
    float across = sample_linear(mix(above, below, down), u.x);
    vec2 edges = environment_row(row, size.y);
    vec2 uv = vec2(fract((float(column) + 0.5 + across) / float(size.x)), mix(edges.x, edges.y, down));
    density = environment_density_at(uv);
    float azimuth = 2.0 * PI * (uv.x - 0.5);
    float sine = sin(PI * uv.y);
    vec3 unturned = vec3(sine * sin(azimuth), cos(PI * uv.y), -sine * cos(azimuth));
    float turn = frame.background.w;
    return vec3(cos(turn) * unturned.x + sin(turn) * unturned.z, unturned.y, cos(turn) * unturned.z - sin(turn) * unturned.x);
}
