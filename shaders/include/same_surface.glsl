// Whether points belong to one surface.

const float MIN_NORMAL_COSINE = 0.9;
// Share of the view depth by which rounding may move a point off its plane.
const float ROUNDING = 1e-4;

// A point `d` away, with geometric normal n_d, from one with geometric normal n. Where the surface is flat it must lie in the
// plane; where it is curved it may leave the plane by as much as the normals differ.
bool same_surface(vec3 d, vec3 n, vec3 n_d, float depth) {
    return abs(dot(n, d)) <= ROUNDING * depth + length(cross(n, n_d)) * length(d);
}
