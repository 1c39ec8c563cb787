//! The CPU twin of `shaders/include/tracer_software.glsl`: the same steps on the same buffers.

use bytemuck::cast_slice;
use exr::prelude::f16;
use glam::{UVec2, UVec4, Vec2, Vec3, Vec4};
use glowworm::bvh::{Ray, gpu::GpuBvh, thin_surfaces::THIN_SURFACE};

const NONE: u32 = u32::MAX;
const STACK_SIZE: usize = 40;
const SLAB_PADDING: f32 = 1.0 / 524288.0;
const SMALLEST_DIRECTION: f32 = 8.6736174e-19;

/// The shader's `TracerHit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracerHit {
    pub t: f32,
    pub instance: u32,
    pub triangle: u32,
    pub material: u32,
    pub barycentrics: Vec2,
}

/// The hit that a query looks for, as in the shader.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Closest,
    Any,
    ClosestThinSurface,
}

/// The buffers as the shader sees them.
pub struct Tracer<'a> {
    nodes: &'a [UVec4],
    triangles: &'a [UVec4],
    instances: &'a [UVec4],
    triangle_uvs: &'a [UVec4],
    masks: &'a [UVec4],
    mask_texels: &'a [u32],
    groups: [UVec2; 2],
}

#[derive(Clone, Copy)]
struct TracerRay {
    origin: Vec3,
    inverse: Vec3,
    octant: u32,
    main_axis: usize,
    shear: Vec3,
}

/// The shader's stack size; an overflow panics.
#[derive(Default)]
struct Stack(Vec<UVec2>);

impl Stack {
    fn push(&mut self, group: UVec2) {
        assert!(self.0.len() < STACK_SIZE);
        self.0.push(group);
    }

    fn pop(&mut self) -> UVec2 {
        self.0.pop().expect("never empty when something is left")
    }
}

impl<'a> Tracer<'a> {
    pub fn new(layout: &'a GpuBvh) -> Self {
        Self {
            nodes: cast_slice(&layout.nodes),
            triangles: cast_slice(&layout.triangles),
            instances: cast_slice(&layout.instances),
            triangle_uvs: cast_slice(&layout.alpha.triangle_uvs),
            masks: cast_slice(&layout.alpha.masks),
            mask_texels: &layout.alpha.mask_texels,
            groups: [layout.roots.static_group, layout.roots.dynamic_group]
                .map(|group| UVec2::new(group.first, group.bits)),
        }
    }

    /// Whether anything opaque lies on the segment; calls `thin surface` with each thin surface that was met until then.
    pub fn trace_any(&self, ray: &Ray, mut thin_surface: impl FnMut(TracerHit)) -> bool {
        self.traverse(ray, Wanted::Any, &mut thin_surface).instance != NONE
    }

    pub fn trace_closest(&self, ray: &Ray) -> Option<TracerHit> {
        let hit = self.traverse(ray, Wanted::Closest, &mut |_| {});
        (hit.instance != NONE).then_some(hit)
    }

    pub fn trace_thin_surface(&self, ray: &Ray) -> Option<TracerHit> {
        let hit = self.traverse(ray, Wanted::ClosestThinSurface, &mut |_| {});
        (hit.instance != NONE).then_some(hit)
    }

    fn traverse(&self, world: &Ray, wanted: Wanted, thin_surface: &mut dyn FnMut(TracerHit)) -> TracerHit {
        let (instance, triangle, material, barycentrics) = (NONE, NONE, 0, Vec2::ZERO);
        let mut hit = TracerHit { t: world.t_max, instance, triangle, material, barycentrics };
        let mut stack = Stack::default();
        let [mut group, moving] = self.groups;
        if moving.y != 0 {
            stack.push(moving);
        }
        let mut primitives = UVec2::ZERO;
        let mut ray = prepare(world.origin, world.direction);
        let mut instance = NONE;
        let mut base = 0;

        while primitives.y != 0 || group.y != 0 || !stack.0.is_empty() {
            if instance != NONE && primitives.y == 0 && group.y == 0 && stack.0.len() == base {
                // Leave the instance.
                ray = prepare(world.origin, world.direction);
                instance = NONE;
                base = 0;
            }
            if instance == NONE {
                if group.y == 0 && primitives.y == 0 {
                    group = stack.pop();
                }
                if group.y <= 0x00ff_ffff && group.y != 0 {
                    (primitives, group.y) = (group, 0);
                }
                if primitives.y != 0 {
                    // Enter one instance, and push the others and this level's nodes.
                    let first = 31 - primitives.y.leading_zeros();
                    primitives.y &= !(1 << first);
                    for later in [primitives, group] {
                        if later.y != 0 {
                            stack.push(later);
                        }
                    }
                    let root;
                    (ray, root, instance) = self.enter(primitives.x + first, world);
                    base = stack.0.len();
                    group = UVec2::new(root, 0x8000_0000);
                    primitives = UVec2::ZERO;
                }
            }

            while primitives.y == 0 && (group.y != 0 || stack.0.len() != base) {
                // Pop the stack.
                if group.y == 0 {
                    group = stack.pop();
                }
                primitives = group;
                if group.y > 0x00ff_ffff {
                    // Take the nearest child of the group, and push the rest.
                    let first = 31 - group.y.leading_zeros();
                    let slot = (first - 24) ^ (ray.octant & 7);
                    let node = (group.x + (group.y & !(u32::MAX << slot)).count_ones()) as usize * 5;
                    group.y &= !(1 << first);
                    if group.y > 0x00ff_ffff {
                        stack.push(group);
                    }

                    // Intersect its children.
                    let (head, links) = (self.nodes[node], self.nodes[node + 1]);
                    let hits = self.child_hits(node, &ray, world.t_min, hit.t);
                    let inner = if hits > 0x00ff_ffff { hits & 0xff00_0000 | head.w >> 24 } else { 0 };
                    group = UVec2::new(links.x, inner);
                    primitives = UVec2::new(links.y, hits & 0x00ff_ffff);
                } else {
                    group.y = 0;
                }
                while instance != NONE && primitives.y != 0 {
                    let first = 31 - primitives.y.leading_zeros();
                    primitives.y &= !(1 << first);
                    let triangle = primitives.x + first;
                    let met = self.test_triangle(triangle, instance, &ray, world.t_min, &hit);
                    let stops = |met: &TracerHit| self.stops(wanted, triangle, &ray, *met, thin_surface);
                    if let Some(met) = met.filter(stops) {
                        hit = met;
                        if wanted == Wanted::Any {
                            return hit;
                        }
                    }
                }
            }
        }
        hit
    }

    /// Whether the triangle is one of those that are wanted, where it was met; calls `thin surface` with thin surfaces on the way.
    fn stops(
        &self,
        wanted: Wanted,
        triangle: u32,
        ray: &TracerRay,
        met: TracerHit,
        thin_surface: &mut dyn FnMut(TracerHit),
    ) -> bool {
        let masked = self.triangles[triangle as usize * 3 + 1].w;
        if masked & THIN_SURFACE == 0 {
            return wanted != Wanted::ClosestThinSurface
                && (masked == 0 || self.is_opaque(masked, met.barycentrics));
        }
        let counts = wanted != Wanted::Closest && self.owns_edges(triangle, ray);
        if counts && wanted == Wanted::Any {
            thin_surface(met);
        }
        counts && wanted == Wanted::ClosestThinSurface
    }

    fn child_hits(&self, node: usize, ray: &TracerRay, t_min: f32, t_max: f32) -> u32 {
        let (head, links) = (self.nodes[node], self.nodes[node + 1]);
        let exponent = |byte: u32| f32::from_bits((head.w >> (8 * byte) & 0xff) << 23);
        let cell = Vec3::new(exponent(0), exponent(1), exponent(2));
        let to_node = floats(head).truncate() - ray.origin;
        let reach = to_node.abs().max_element() + 255.0 * cell.max_element();
        let padding = (SLAB_PADDING * reach) * ray.inverse.abs();
        let step = cell * ray.inverse;
        let start = to_node * ray.inverse;
        let (near, far) = (start - padding, start + padding);
        let planes = [0, 1, 2].map(|axis| {
            let words = self.nodes[node + 2 + axis];
            if ray.inverse[axis] < 0.0 { UVec4::new(words.z, words.w, words.x, words.y) } else { words }
        });
        let mut hits = 0;
        for part in 0..2 {
            let plane = |axis: usize, part: usize, start: Vec3| {
                unpack_bytes(planes[axis][part]) * step[axis] + start[axis]
            };
            let enter = plane(0, part, near)
                .max(plane(1, part, near))
                .max(plane(2, part, near).max(Vec4::splat(t_min)));
            let leave = plane(0, part + 2, far)
                .min(plane(1, part + 2, far))
                .min(plane(2, part + 2, far).min(Vec4::splat(t_max)));
            hits |= spread(enter.cmple(leave).bitmask(), links[2 + part], ray.octant);
        }
        hits
    }

    fn enter(&self, placed: u32, world: &Ray) -> (TracerRay, u32, u32) {
        let words = &self.instances[placed as usize * 4..][..4];
        let (row_x, row_y, row_z) = (floats(words[0]), floats(words[1]), floats(words[2]));
        let column = |i: usize| Vec3::new(row_x[i], row_y[i], row_z[i]);
        let linear = |v: Vec3| column(0) * v.x + column(1) * v.y + column(2) * v.z;
        let ray = prepare(linear(world.origin) + column(3), linear(world.direction));
        (ray, words[3].x, words[3].y)
    }

    /// The corners in the frame of the ray, and the edge functions.
    fn cross(&self, triangle: u32, ray: &TracerRay) -> ([Vec3; 3], Vec3) {
        let words = &self.triangles[triangle as usize * 3..][..3];
        let corners = [0, 1, 2].map(|i| {
            let corner = turn(floats(words[i]).truncate() - ray.origin, ray.main_axis);
            (corner.truncate() - ray.shear.truncate() * corner.z).extend(corner.z)
        });
        let [a, b, c] = corners;
        let edges = Vec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        (corners, edges)
    }

    fn owns_edges(&self, triangle: u32, ray: &TracerRay) -> bool {
        let (corners, edges) = self.cross(triangle, ray);
        let winding = edges.element_sum().signum();
        (0..3).all(|i| {
            let along = (corners[(i + 2) % 3] - corners[(i + 1) % 3]) * winding;
            edges[i] != 0.0 || along.y > 0.0 || (along.y == 0.0 && along.x >= 0.0)
        })
    }

    fn test_triangle(
        &self,
        triangle: u32,
        instance: u32,
        ray: &TracerRay,
        t_min: f32,
        hit: &TracerHit,
    ) -> Option<TracerHit> {
        let words = &self.triangles[triangle as usize * 3..][..3];
        let ([a, b, c], Vec3 { x: u, y: v, z: w }) = self.cross(triangle, ray);
        let det = u + v + w;
        let outside = u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0;
        if outside || det == 0.0 {
            return None;
        }
        let scale = 1.0 / det;
        let t = (u * a.z + v * b.z + w * c.z) * scale * ray.shear.z;
        let barycentrics = Vec2::new(v, w) * scale;
        let id = words[0].w;
        let lower = hit.instance != NONE && (instance, id) < (hit.instance, hit.triangle);
        let accepted = t > t_min && (t < hit.t || t == hit.t && lower);
        accepted.then(|| TracerHit { t, instance, triangle: id, material: words[2].w, barycentrics })
    }

    fn is_opaque(&self, masked: u32, barycentrics: Vec2) -> bool {
        let index = (masked as usize - 1) * 2;
        let (first_two, third) = (self.triangle_uvs[index], self.triangle_uvs[index + 1]);
        let first = 1.0 - barycentrics.x - barycentrics.y;
        let (uv01, uv2) = (floats(first_two), floats(third));
        let uv = Vec2::new(uv01.x, uv01.y) * first
            + Vec2::new(uv01.z, uv01.w) * barycentrics.x
            + Vec2::new(uv2.x, uv2.y) * barycentrics.y;
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        let [a, b, c] = [half(third.z >> 16), half(third.w), half(third.w >> 16)];
        let alpha = a + (b - a) * barycentrics.x + (c - a) * barycentrics.y;
        let mask = self.masks[(third.z & 0xffff) as usize];
        // All masks repeat.
        let size = UVec2::new(mask.y & 0xffff, mask.y >> 16);
        let nearest = mask.z & 64 != 0;
        let place = (uv - uv.floor()) * size.as_vec2();
        let at =
            if nearest { place.as_uvec2().as_vec2().min(size.as_vec2() - 1.0) + 1.0 } else { place + 0.5 };
        let (next, part) = (at.as_uvec2(), at.fract());
        let texel = |right: u32, down: u32| {
            let texel = (next + size + UVec2::new(right, down) - 1) % size;
            self.mask_texel(mask, texel.y * size.x + texel.x)
        };
        let row = |down: u32| texel(0, down) + (texel(1, down) - texel(0, down)) * part.x;
        (row(0) + (row(1) - row(0)) * part.y) * alpha >= f32::from_bits(mask.w)
    }

    fn mask_texel(&self, mask: UVec4, texel: u32) -> f32 {
        let [bits, most] = if mask.z & 128 != 0 { [16, 0xffff] } else { [8, 0xff] };
        let each = 32 / bits;
        let word = self.mask_texels[(mask.x + texel / each) as usize];
        (word >> (texel % each * bits) & most) as f32 / most as f32
    }
}

fn prepare(origin: Vec3, direction: Vec3) -> TracerRay {
    let size = direction.abs();
    let negative = direction.cmplt(Vec3::ZERO);
    let sign = Vec3::select(negative, Vec3::NEG_ONE, Vec3::ONE);
    let octants = [0x0404_0404, 0x0202_0202, 0x0101_0101];
    let main_axis = if size.x > size.y && size.x > size.z { 0 } else { 2 - usize::from(size.y > size.z) };
    let turned = turn(direction, main_axis);
    TracerRay {
        origin,
        inverse: sign / size.max(Vec3::splat(size.max_element() * SMALLEST_DIRECTION)),
        octant: (0..3).filter(|&i| !negative.test(i)).map(|i| octants[i]).sum(),
        main_axis,
        shear: turned.truncate().extend(1.0) / turned.z,
    }
}

fn turn(v: Vec3, main_axis: usize) -> Vec3 {
    Vec3::new(v[(main_axis + 1) % 3], v[(main_axis + 2) % 3], v[main_axis])
}

fn floats(words: UVec4) -> Vec4 {
    Vec4::from(words.to_array().map(f32::from_bits))
}

fn unpack_bytes(bytes: u32) -> Vec4 {
    Vec4::from(bytes.to_le_bytes().map(f32::from))
}

fn spread(met: u32, meta: u32, octant: u32) -> u32 {
    let inner = (meta & (meta << 1) & 0x1010_1010) >> 4;
    let shifts = (meta ^ (octant & (inner * 0xff))) & 0x1f1f_1f1f;
    let bits = (meta >> 5) & 0x0707_0707;
    let child = |i: usize| (bits >> (8 * i) & 7) << (shifts >> (8 * i) & 31);
    (0..4).filter(|&i| met >> i & 1 == 1).fold(0, |all, i| all | child(i))
}
