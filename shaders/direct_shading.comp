#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Direct light of point, spot and directional lights: diffuse and normalised Blinn-Phong specular
// reflection, shadow maps filtered over 3x3 texels; what surfaces emit; the background.
#include "frame.glsl"
#include "gbuffer.glsl"
#include "scene.glsl"
#include "lights.glsl"
#include "direct.glsl"
#include "picture_tiles.glsl"

// A workgroup has a tile of the picture, or as many of a list as a thread may have pixels.
layout(local_size_x = PICTURE_TILE, local_size_y = PICTURE_TILE) in;

// Whether only rows of the tiles of a list are lit, or all.
layout(constant_id = 0) const bool LISTED = false;
// Whether there is but one light, and but one shadow tile. CPU drivers load at once, not lane by lane, what all threads need
// before they part.
layout(constant_id = 1) const bool ONE_LIGHT = false;
layout(constant_id = 2) const bool ONE_TILE = false;

// Most pixels that a thread has of a list, one below the other in a tile, whose rows they divide. Twin: `TILES_PER_GROUP` in
// changed_tiles.comp.
layout(constant_id = 3) const uint ROWS = 1u;

layout(set = 0, binding = 1, r32f) uniform readonly image2D gbuffer_depth;
layout(set = 0, binding = 2, rgba16f) uniform readonly image2D gbuffer_normal;
layout(set = 0, binding = 3, rgba16f) uniform readonly image2D gbuffer_albedo;
layout(set = 0, binding = 5) uniform utexture2D gbuffer_instance;
layout(set = 0, binding = 6) uniform texture2D shadow_atlas;
layout(set = 0, binding = 7, std430) readonly buffer LightBlock { LightData data[]; } lights;
layout(set = 0, binding = 8, std430) readonly buffer TileBlock { ShadowTile data[]; } shadow_tiles;
layout(set = 0, binding = 9, std430) readonly buffer MaterialBlock { MaterialData data[]; } materials;
layout(set = 0, binding = 10, rgba32f) uniform image2D direct;
layout(set = 0, binding = 4, std430) readonly buffer ListBlock { TileList data; uint tiles[]; } tile_list;
layout(set = 0, binding = 11, std430) readonly buffer InstanceBlock { InstanceData data[]; } instances;

LightData only_light;
ShadowTile only_tile;

LightData light_at(uint index) {
    if (ONE_LIGHT) return only_light;
    return lights.data[index];
}

ShadowTile tile_at(uint index) {
    if (ONE_TILE) return only_tile;
    return shadow_tiles.data[index];
}

// Mean of the bilinear comparisons at the corners of a texel: a tent over 3x3 texels.
float filtered_visibility(vec4 rectangle, vec3 coordinates) {
    vec2 texel = coordinates.xy * rectangle.z;
    vec2 base = floor(texel);
    vec2 part = texel - base;
    vec3 wx = vec3(1.0 - part.x, 1.0, part.x);
    vec3 wy = vec3(1.0 - part.y, 1.0, part.y);
    ivec2 first = ivec2(rectangle.xy);
    ivec2 last = first + int(rectangle.z) - 1;
    float lit = 0.0;
    for (int y = 0; y < 3; y++) {
        for (int x = 0; x < 3; x++) {
            ivec2 at = clamp(first + ivec2(base) + ivec2(x - 1, y - 1), first, last);
            float nearest = texelFetch(shadow_atlas, at, 0).r;
            lit += coordinates.z >= nearest ? wx[x] * wy[y] : 0.0;
        }
    }
    return lit / 4.0;
}

// Tile coordinates of a receiver, moved along its normal by about the size of the filter there, so
// that a lit surface does not shadow itself.
bool tile_coordinates(ShadowTile tile, vec3 p, vec3 n, float cosine, out vec3 coordinates) {
    vec4 clip = tile.view_projection * vec4(p, 1.0);
    float texel = tile.texel.x * (tile.texel.y == 1.0 ? clip.w : 1.0);
    float sine = sqrt(max(0.0, 1.0 - cosine * cosine));
    clip += tile.view_projection * vec4(n * texel * (0.5 + 1.5 * sine), 0.0);
    coordinates = clip.xyz / clip.w;
    coordinates.xy = coordinates.xy * 0.5 + 0.5;
    float guard = 2.0 / tile.rectangle.z;
    return clip.w > 0.0 && all(greaterThan(coordinates.xy, vec2(guard))) && all(lessThan(coordinates.xy, vec2(1.0 - guard)));
}

uint cube_face(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= a.y && a.x >= a.z) return d.x >= 0.0 ? 0u : 1u;
    if (a.y >= a.z) return d.y >= 0.0 ? 2u : 3u;
    return d.z >= 0.0 ? 4u : 5u;
}

float visibility(LightData light, vec3 p, vec3 n, vec3 to_light) {
    float cosine = max(dot(n, to_light), 0.0);
    vec3 coordinates;
    bool cube = light.tile_count == 6u;
    uint first = light.first_tile + (cube ? cube_face(p - light.position.xyz) : 0u);
    uint end = cube ? first + 1u : first + light.tile_count;
    // Of a spot or the sun, the first tile that has the receiver. A cube has no outside; what the offset moves beyond its
    // face is looked up at the face's edge.
    bool inside = false;
    uint i = first;
    if (first < end) {
        do {
            inside = tile_coordinates(tile_at(i), p, n, cosine, coordinates) || cube;
        } while (!inside && ++i < end);
    }
    // Beyond all cascades: the sun shines there unless we knew better. Outside a spot's tile nothing is lit.
    if (!inside) return light.kind == LIGHT_DIRECTIONAL ? 1.0 : 0.0;
    return filtered_visibility(tile_at(i).rectangle, clamp(coordinates, vec3(0.0), vec3(1.0)));
}

// Irradiance across the direction to the light, without shadow.
vec3 arriving(LightData light, vec3 p, out vec3 to_light) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        to_light = -light.direction.xyz;
        return light.power.rgb;
    }
    vec3 d = light.position.xyz - p;
    float squared = max(dot(d, d), 1e-30);
    to_light = d * inversesqrt(squared);
    float falloff = 1.0;
    if (light.kind == LIGHT_SPOT) {
        falloff = smoothstep(light.direction.w, light.position.w, dot(-to_light, light.direction.xyz));
    }
    return light.power.rgb * falloff / squared;
}

struct Surface {
    vec3 position;
    vec3 shading;
    vec3 geometric;
    vec3 albedo;
    vec4 specular; // rgb: Ks; w: Ns
    vec3 to_eye;
};

// What a light sends to the eye by way of the surface.
vec3 reflected(LightData light, Surface surface) {
    vec3 to_light;
    vec3 irradiance = arriving(light, surface.position, to_light);
    float cosine = dot(surface.shading, to_light);
    if (cosine <= 0.0 || dot(surface.geometric, to_light) <= 0.0 || irradiance == vec3(0.0)) return vec3(0.0);
    irradiance *= cosine * visibility(light, surface.position, surface.geometric, to_light);
    float half_cosine = max(dot(surface.shading, normalize(to_light + surface.to_eye)), 0.0);
    vec4 specular = surface.specular;
    vec3 reflectance = surface.albedo / PI
        + specular.rgb * (specular.w + 8.0) / (8.0 * PI) * pow(half_cosine, specular.w);
    return reflectance * irradiance;
}

vec3 radiance_of(uvec2 id, ivec2 pixel) {
    vec4 normals = imageLoad(gbuffer_normal, pixel);
    Surface surface;
    surface.position = position_at(pixel, imageLoad(gbuffer_depth, pixel).r);
    surface.shading = octahedral_decode(normals.xy);
    surface.geometric = octahedral_decode(normals.zw);
    surface.albedo = imageLoad(gbuffer_albedo, pixel).rgb;
    surface.specular = materials.data[id.y & MATERIAL].specular;
    surface.to_eye = normalize(frame.eye.xyz - surface.position);

    vec3 radiance = vec3(0.0);
    if ((id.y & FRONT_FACING) != 0u) {
        radiance = materials.data[id.y & MATERIAL].emission.rgb * instances.data[id.x - 1u].emission.rgb;
    }
    if (frame.light_count > 0u) {
        // Asks at its end whether to go on: see tracer_find.
        uint i = 0u;
        do {
            radiance += reflected(light_at(i), surface);
        } while (++i < frame.light_count);
    }
    return radiance;
}

void light(ivec2 pixel) {
    if (any(greaterThanEqual(pixel, ivec2(frame.size)))) return;
    uvec2 id = texelFetch(gbuffer_instance, pixel, 0).xy;
    vec4 result = vec4(frame.background.rgb, NOTHING);
    if (id.x != 0u) result = vec4(radiance_of(id, pixel), (id.y & MAY_MOVE) != 0u ? MOVER : STATIC);
    // What a list holds is mostly as it was, and to write costs CPU drivers more than to compare.
    if (LISTED && result == imageLoad(direct, pixel)) return;
    imageStore(direct, pixel, result);
}

void light_listed() {
    // The first of the thread's rows, counted from the workgroup's.
    uint first_row = gl_LocalInvocationID.y * ROWS;
    uint place = group_in_list() * ROWS + first_row / PICTURE_TILE;
    if (place >= tile_list.data.count) return;
    uint packed = tile_list.tiles[place];
    uvec2 first = tile_of(packed) * PICTURE_TILE + uvec2(gl_LocalInvocationID.x, first_row % PICTURE_TILE);
    uint rows = rows_of(packed) >> (first_row % PICTURE_TILE) & ((1u << ROWS) - 1u);
    if (rows == 0u) return;
    do {
        light(ivec2(first + uvec2(0u, findLSB(rows))));
        rows &= rows - 1u;
    } while (rows != 0u);
}

void main() {
    if (ONE_LIGHT) only_light = lights.data[0];
    if (ONE_TILE) only_tile = shadow_tiles.data[0];
    if (LISTED) {
        light_listed();
    } else {
        light(ivec2(gl_GlobalInvocationID.xy));
    }
}
