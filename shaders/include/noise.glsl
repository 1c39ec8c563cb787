// Random numbers of rays. Needs frame.glsl and scene_set.glsl. Table: src/gpu_scene/noise.rs. Twin: tests/device/noise.rs.

// 1: white noise; otherwise blue.
layout(constant_id = 1) const uint WHITE_NOISE = 0u;

const uint NOISE_SIDE = 64u;
const uint NOISE_FRAMES = 32u;

#include "pcg.glsl"

vec2 unit_of(uvec2 bits) { return vec2(bits >> 8u) * exp2(-24.0); }

// Two independent numbers from 0 to 1 for a pixel: others for each dimension and each frame of the sequence.
vec2 white_noise_of(ivec2 pixel, uint frame_index, uint dimension) {
    uvec3 bits = pcg3d(uvec3(uvec2(pixel) + (dimension / 64u << 16u), frame_index * 64u + dimension % 64u));
    return unit_of(pcg3d(bits ^ uvec3(frame.seed)).xy);
}

// A channel of the table, 0 to 255.
uint blue_byte(ivec2 pixel, uvec2 place, uint frame_index, uint channel) {
    uvec2 texel = (uvec2(pixel) + place) % NOISE_SIDE;
    uint index = (frame_index % NOISE_FRAMES * NOISE_SIDE + texel.y) * NOISE_SIDE + texel.x;
    return blue_noise.words[index / 2u] >> (index % 2u * 16u + channel * 8u) & 255u;
}

// Two such numbers that are blue noise over pixels and frames.
vec2 noise_of(ivec2 pixel, uint frame_index, uint dimension) {
    vec2 white = white_noise_of(pixel, frame_index, dimension);
    if (WHITE_NOISE == 1u) return white;
    // Each dimension and each cycle of the table looks elsewhere in it, for each of the two numbers: pairs of texels of their own, so
    // that the mean over many cycles is not one over those pairs that stand in the table.
    uvec2 place = pcg3d(uvec3(dimension, frame_index / NOISE_FRAMES, frame.seed)).xy;
    vec2 both = vec2(blue_byte(pixel, place >> 8u, frame_index, 0u), blue_byte(pixel, place >> 20u, frame_index, 1u));
    // White noise fills the gaps between 256 values: rarer events would never be sampled.
    return min((both + white) / 256.0, 1.0 - exp2(-24.0));
}

// The numbers of this frame.
vec2 noise(ivec2 pixel, uint dimension) { return noise_of(pixel, frame.noise_frame, dimension); }
