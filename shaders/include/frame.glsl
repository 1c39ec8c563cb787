// What every pass of a frame may want to know. Twin: FrameUniforms in src/passes/structs.rs.

struct FrameUniforms {
    mat4 view_projection;          // world to clip, reversed depth
    mat4 previous_view_projection; // the same, one frame ago
    vec4 eye;                      // xyz: world position; w: radius of the scene's bounding sphere
    vec4 background;               // rgb: radiance where no surface is; w: clamp c of the geometry term, 0: none
    vec4 ray;                      // xyz: view direction
    vec4 ray_x;                    // xyz: right times the tangent of half the horizontal field of view
    vec4 ray_y;                    // xyz: down times the tangent of half the vertical field of view
    uvec2 size;                    // of the picture, texels
    uint interleave;               // n
    uint light_count;              // lights with shadow maps
    float position_cutoff;         // fraction of view depth
    float irradiance_scale;        // set buffers hold irradiance times this
    float depth_scale;             // packed depths are view depths times this
    float roulette;                // one over the irradiance below which a VPL gets only some of its rays
};

layout(set = 0, binding = 0, std140) uniform FrameBlock { FrameUniforms data; } frame_uniforms;

// Loaded where a shader begins: once threads have parted, CPU drivers load even uniforms lane by lane.
FrameUniforms frame = frame_uniforms.data;

// World position of what a pixel sees at a view depth.
vec3 position_at(ivec2 pixel, float depth) {
    vec2 at = (vec2(pixel) + 0.5) * (2.0 / vec2(frame.size)) - 1.0;
    return frame.eye.xyz + depth * (frame.ray.xyz + at.x * frame.ray_x.xyz + at.y * frame.ray_y.xyz);
}

// Where buffers with a texel a pixel have that of `pixel`: row by row.
int texel_of(ivec2 pixel) { return pixel.y * int(frame.size.x) + pixel.x; }

const float PI = 3.14159265358979;

// How far ray ends are moved off their surfaces at world position p: far beyond the rounding of
// positions, far below anything that can be seen. Twin: `ray_offset` in src/vpl/.
float ray_offset(vec3 p) {
    vec3 a = abs(p);
    return 2e-5 * max(max(a.x, max(a.y, a.z)), 0.2 * frame.eye.w);
}

float luminance(vec3 rgb) { return dot(rgb, vec3(0.2126, 0.7152, 0.0722)); }
