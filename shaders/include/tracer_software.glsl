// Rays through the two-level BVH in plain buffers: no extension, no bindless, no subgroups.
//
// In: the arrays of src/bvh/gpu.rs. Out: what is wanted of the open segment
// t_min < t < t_max, t in units of the direction, which may have any length. Compressed wide BVH after
// Ylitie et al. 2017, triangle test after Woop et al. 2013; tests/bvh_support/twin.rs is the CPU twin.

#ifndef TRACER_SOFTWARE_GLSL
#define TRACER_SOFTWARE_GLSL

// Both levels' greatest depth, and what entering an instance leaves behind.
const int TRACER_STACK_SIZE = 40;
// Nodes at most before the triangles of those threads that have met some: of the threads that run in step, few wait long, and
// few tests of triangles find none that has any (after Aila and Laine 2009).
const uint TRACER_NODES = 3u;
// Relative padding of the slab test: covers the rounding of the quantised boxes and of the test.
const float TRACER_SLAB_PADDING = 1.0 / 524288.0;
// A direction component below this share of the largest counts as this much.
const float TRACER_SMALLEST_DIRECTION = 8.6736174e-19;

// A ray in world or object space, prepared for boxes and triangles.
struct TracerRay {
    vec3 origin;
    vec3 inverse;
    // Orders the children: bits 0 to 2 are set where the direction is positive, in each byte.
    uint octant;
    // The axis of the largest direction component, and the shear that makes the ray run along it.
    int main_axis;
    vec3 shear;
};

// Turns the axes so that the main one comes last.
vec3 tracer_turn(vec3 v, int main_axis) {
    return main_axis == 0 ? v.yzx : (main_axis == 1 ? v.zxy : v);
}

TracerRay tracer_prepare(vec3 origin, vec3 direction) {
    TracerRay ray;
    ray.origin = origin;
    vec3 size = abs(direction);
    float largest = max(max(size.x, size.y), size.z);
    bvec3 negative = lessThan(direction, vec3(0.0));
    uvec3 positive = mix(uvec3(0x04040404u, 0x02020202u, 0x01010101u), uvec3(0u), negative);
    ray.octant = positive.x | positive.y | positive.z;
    ray.main_axis = size.x > size.y && size.x > size.z ? 0 : (size.y > size.z ? 1 : 2);
    vec3 turned = tracer_turn(direction, ray.main_axis);
    ray.shear = vec3(turned.xy, 1.0) / turned.z;
    size = max(size, vec3(largest * TRACER_SMALLEST_DIRECTION));
    ray.inverse = mix(vec3(1.0), vec3(-1.0), negative) / size;
    return ray;
}

vec4 tracer_unpack_bytes(uint bytes) {
    return vec4(ivec4(uvec4(bytes, bytes >> 8, bytes >> 16, bytes >> 24) & 0xffu));
}

// Bits of those of four children that are met, spread by visiting order or primitive.
uint tracer_spread(bvec4 met, uint meta, uint octant) {
    uint inner = ((meta & (meta << 1)) & 0x10101010u) >> 4;
    uint shifts = (meta ^ (octant & (inner * 0xffu))) & 0x1f1f1f1fu;
    uint bits = (meta >> 5) & 0x07070707u;
    uvec4 spread = (uvec4(bits, bits >> 8, bits >> 16, bits >> 24) & 7u)
        << (uvec4(shifts, shifts >> 8, shifts >> 16, shifts >> 24) & 31u);
    spread = mix(uvec4(0u), spread, met);
    return (spread.x | spread.y) | (spread.z | spread.w);
}

// Bits 24 to 31: inner children that the ray meets, by visiting order; bits 0 to 23: primitives.
uint tracer_child_hits(uint node, uvec4 head, uvec2 meta, TracerRay ray, float t_min, float t_max) {
    // Bring the ray into the node's grid; the padding moves each near plane nearer and far plane farther.
    uvec3 exponents = uvec3(head.w, head.w >> 8, head.w >> 16) & 0xffu;
    vec3 cell = uintBitsToFloat(exponents << 23);
    vec3 to_node = uintBitsToFloat(head.xyz) - ray.origin;
    vec3 apart = abs(to_node);
    float reach = max(max(apart.x, apart.y), apart.z) + 255.0 * max(max(cell.x, cell.y), cell.z);
    vec3 padding = (TRACER_SLAB_PADDING * reach) * abs(ray.inverse);
    vec3 cell_step = cell * ray.inverse;
    vec3 start = to_node * ray.inverse;
    vec3 near = start - padding;
    vec3 far = start + padding;

    // Test four children at a time.
    uvec4 planes_x = texelFetch(bvh_nodes, int(node + 2u));
    uvec4 planes_y = texelFetch(bvh_nodes, int(node + 3u));
    uvec4 planes_z = texelFetch(bvh_nodes, int(node + 4u));
    planes_x = ray.inverse.x < 0.0 ? planes_x.zwxy : planes_x;
    planes_y = ray.inverse.y < 0.0 ? planes_y.zwxy : planes_y;
    planes_z = ray.inverse.z < 0.0 ? planes_z.zwxy : planes_z;
    uint hits = 0u;
    for (int part = 0; part < 2; ++part) {
        vec4 enter = max(
            max(tracer_unpack_bytes(planes_x[part]) * cell_step.x + near.x,
                tracer_unpack_bytes(planes_y[part]) * cell_step.y + near.y),
            max(tracer_unpack_bytes(planes_z[part]) * cell_step.z + near.z, vec4(t_min)));
        vec4 leave = min(
            min(tracer_unpack_bytes(planes_x[part + 2]) * cell_step.x + far.x,
                tracer_unpack_bytes(planes_y[part + 2]) * cell_step.y + far.y),
            min(tracer_unpack_bytes(planes_z[part + 2]) * cell_step.z + far.z, vec4(t_max)));
        hits |= tracer_spread(lessThanEqual(enter, leave), meta[part], ray.octant);
    }
    return hits;
}

// The triangle in the frame of the ray, which runs along z there, and its three edge functions.
struct TracerCrossing { mat3 corners; vec3 edges; };

TracerCrossing tracer_cross(uvec4 word_a, uvec4 word_b, uvec4 word_c, TracerRay ray) {
    vec3 a = tracer_turn(uintBitsToFloat(word_a.xyz) - ray.origin, ray.main_axis);
    vec3 b = tracer_turn(uintBitsToFloat(word_b.xyz) - ray.origin, ray.main_axis);
    vec3 c = tracer_turn(uintBitsToFloat(word_c.xyz) - ray.origin, ray.main_axis);
    precise vec2 a2 = a.xy - ray.shear.xy * a.z;
    precise vec2 b2 = b.xy - ray.shear.xy * b.z;
    precise vec2 c2 = c.xy - ray.shear.xy * c.z;
    precise float u = c2.x * b2.y - c2.y * b2.x;
    precise float v = a2.x * c2.y - a2.y * c2.x;
    precise float w = b2.x * a2.y - b2.y * a2.x;
    return TracerCrossing(mat3(vec3(a2, a.z), vec3(b2, b.z), vec3(c2, c.z)), vec3(u, v, w));
}

// Whether the ray meets the triangle nearer than the hit, or as near with lower indices, alpha mask or not; hit.t is the
// upper bound of t, and hit.instance is TRACER_NONE before the first hit.
bool tracer_test_triangle(
    uint triangle, uint instance, TracerRay ray, float t_min, TracerHit hit, out TracerHit met, out uint masked
) {
    // Evaluate the three edge functions; inclusive edges, either winding.
    uvec4 word_a = texelFetch(bvh_triangles, int(triangle * 3u));
    uvec4 word_b = texelFetch(bvh_triangles, int(triangle * 3u + 1u));
    uvec4 word_c = texelFetch(bvh_triangles, int(triangle * 3u + 2u));
    TracerCrossing crossing = tracer_cross(word_a, word_b, word_c, ray);
    precise float u = crossing.edges.x;
    precise float v = crossing.edges.y;
    precise float w = crossing.edges.z;
    precise float det = u + v + w;
    bool inside = det != 0.0 && !(min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0);

    // Interpolate the distance along the main axis.
    precise float scale = 1.0 / det;
    precise float t = (u * crossing.corners[0].z + v * crossing.corners[1].z + w * crossing.corners[2].z) * scale * ray.shear.z;
    precise vec2 barycentrics = vec2(v, w) * scale;
    bool lower = hit.instance != TRACER_NONE
        && (instance < hit.instance || (instance == hit.instance && word_a.w < hit.triangle));
    bool nearer = t < hit.t || (t == hit.t && lower);
    met = TracerHit(t, instance, word_a.w, word_c.w, triangle, barycentrics);
    masked = word_b.w;
    return inside && t > t_min && nearer;
}

// Whether rays on an edge of the triangle are its own: where two triangles of a thin surface share one, the thin surface counts once, for
// one of the two (raster's top-left rule).
bool tracer_owns_edges(uint triangle, TracerRay ray) {
    TracerCrossing crossing = tracer_cross(texelFetch(bvh_triangles, int(triangle * 3u)),
        texelFetch(bvh_triangles, int(triangle * 3u + 1u)), texelFetch(bvh_triangles, int(triangle * 3u + 2u)), ray);
    float winding = sign(crossing.edges.x + crossing.edges.y + crossing.edges.z);
    for (int i = 0; i < 3; i++) {
        vec2 along = (crossing.corners[(i + 2) % 3].xy - crossing.corners[(i + 1) % 3].xy) * winding;
        if (crossing.edges[i] == 0.0 && (along.y < 0.0 || (along.y == 0.0 && along.x < 0.0))) return false;
    }
    return true;
}

// A row of an instance's matrix from world to object.
vec4 tracer_row(uint placed, uint row) { return uintBitsToFloat(texelFetch(bvh_instances, int(placed * 4u + row))); }

// The ray in an instance's object space, not normalised, so that t stays the same; entered is (root
// of its mesh, index into the scene's instances).
TracerRay tracer_enter(uint placed, vec3 origin, vec3 direction, out uvec2 entered) {
    vec4 row_x = tracer_row(placed, 0u);
    vec4 row_y = tracer_row(placed, 1u);
    vec4 row_z = tracer_row(placed, 2u);
    entered = texelFetch(bvh_instances, int(placed * 4u + 3u)).xy;
    vec3 column_x = vec3(row_x.x, row_y.x, row_z.x);
    vec3 column_y = vec3(row_x.y, row_y.y, row_z.y);
    vec3 column_z = vec3(row_x.z, row_y.z, row_z.z);
    vec3 place = vec3(row_x.w, row_y.w, row_z.w);
    precise vec3 moved = column_x * origin.x + column_y * origin.y + column_z * origin.z + place;
    precise vec3 turned = column_x * direction.x + column_y * direction.y + column_z * direction.z;
    return tracer_prepare(moved, turned);
}

// Depth first through both levels; of several at the same t, the closest hit is that of the lowest instance, then
// triangle. What happens seldom, to enter and leave instances and to look at alpha masks, is kept out of the inner loop, and
// loops ask at their end whether to go on: drivers for CPUs spend time on both sides of every branch, and on the whole of a
// turn in which every thread leaves the loop at its beginning.
bool tracer_find(
    vec3 origin, vec3 direction, float t_min, float t_max, uint wanted, out TracerHit hit, out vec3 transmittance
) {
    hit = TracerHit(t_max, TRACER_NONE, TRACER_NONE, 0u, 0u, vec2(0.0));
    transmittance = vec3(1.0);
    uvec2 stack[TRACER_STACK_SIZE];
    int height = 0;
    // A group is (index of its first child, hit bits by visiting order << 24 | mask of inner children),
    // or, without any of the high eight bits, (index of the first primitive, bits of primitives).
    uvec2 group = bvh_roots.groups.xy;
    if (bvh_roots.groups.w != 0u) {
        stack[height++] = bvh_roots.groups.zw;
    }
    if (group.y == 0u && height == 0) {
        return false;
    }
    // Triangles or, outside of all instances, instances that are still to be met.
    uvec2 primitives = uvec2(0u);
    TracerRay ray = tracer_prepare(origin, direction);
    uint instance = TRACER_NONE;
    uint placed = 0u;
    // Height of the stack at which the instance, or everything, is done.
    int base = 0;

    do {
        if (instance != TRACER_NONE && primitives.y == 0u && group.y == 0u && height == base) {
            // Back out of the instance.
            ray = tracer_prepare(origin, direction);
            instance = TRACER_NONE;
            base = 0;
        }
        if (instance == TRACER_NONE) {
            if (group.y == 0u && primitives.y == 0u) {
                group = stack[--height];
            }
            if (group.y <= 0x00ffffffu && group.y != 0u) {
                primitives = group;
                group.y = 0u;
            }
            if (primitives.y != 0u) {
                // Enter one instance, and leave the others and this level's nodes for later.
                uint first = uint(findMSB(primitives.y));
                primitives.y &= ~(1u << first);
                if (primitives.y != 0u) {
                    stack[height++] = primitives;
                }
                if (group.y != 0u) {
                    stack[height++] = group;
                }
                uvec2 entered;
                placed = primitives.x + first;
                ray = tracer_enter(placed, origin, direction, entered);
                instance = entered.y;
                base = height;
                group = uvec2(entered.x, 0x80000000u);
                primitives = uvec2(0u);
            }
        }

        // Hit on a triangle with a mask, or of a thin surface.
        TracerHit met;
        uint masked = 0u;
        do {
            uint turns = 0u;
            do {
                if (primitives.y == 0u) {
                    // Go on with what was left for later.
                    if (group.y == 0u) {
                        group = stack[--height];
                    }
                    primitives = group;
                    if (group.y > 0x00ffffffu) {
                        // Take the nearest child of the group, and leave the rest for later.
                        uint first = uint(findMSB(group.y));
                        uint slot = (first - 24u) ^ (ray.octant & 7u);
                        uint node = (group.x + uint(bitCount(group.y & ~(0xffffffffu << slot)))) * 5u;
                        group.y &= ~(1u << first);
                        if (group.y > 0x00ffffffu) {
                            stack[height++] = group;
                        }

                        // Intersect its children.
                        uvec4 head = texelFetch(bvh_nodes, int(node));
                        uvec4 links = texelFetch(bvh_nodes, int(node + 1u));
                        uint hits = tracer_child_hits(node, head, links.zw, ray, t_min, hit.t);
                        group = uvec2(links.x, hits > 0x00ffffffu ? (hits & 0xff000000u) | (head.w >> 24) : 0u);
                        primitives = uvec2(links.y, hits & 0x00ffffffu);
                    } else {
                        group.y = 0u;
                    }
                }
            } while (primitives.y == 0u && (group.y != 0u || height != base) && ++turns < TRACER_NODES);
            if (instance != TRACER_NONE) {
                do {
                    if (primitives.y != 0u) {
                        uint first = uint(findMSB(primitives.y));
                        primitives.y &= ~(1u << first);
                        uint mask;
                        if (tracer_test_triangle(primitives.x + first, instance, ray, t_min, hit, met, mask)) {
                            masked = mask;
                            if (mask == 0u && wanted != TRACER_CLOSEST_THIN) {
                                hit = met;
                                if (wanted == TRACER_ANY) {
                                    primitives.y = 0u;
                                    group.y = 0u;
                                    height = 0;
                                    base = 0;
                                }
                            }
                        }
                    }
                } while (primitives.y != 0u && masked == 0u);
            }
        } while (masked == 0u && primitives.y == 0u && (group.y != 0u || height != base));

        if (tracer_is_thin(masked)) {
            if (wanted == TRACER_CLOSEST_THIN && tracer_owns_edges(met.place, ray)) {
                hit = met;
            }
            if (wanted == TRACER_ANY && tracer_owns_edges(met.place, ray)) {
                mat3 world_to_object =
                    mat3(tracer_row(placed, 0u).xyz, tracer_row(placed, 1u).xyz, tracer_row(placed, 2u).xyz);
                transmittance *= tracer_transmittance(met.place, met.barycentrics, world_to_object, direction);
                if (transmittance == vec3(0.0)) {
                    return true;
                }
            }
        } else if (masked != 0u && wanted != TRACER_CLOSEST_THIN && tracer_is_opaque(masked, met.barycentrics)) {
            hit = met;
            if (wanted == TRACER_ANY) {
                return true;
            }
        }
    } while (primitives.y != 0u || group.y != 0u || height != 0);
    return hit.instance != TRACER_NONE;
}

#endif
