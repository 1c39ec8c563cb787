//! Emissive triangles of an instance as an area light.
//!
//! In: the materials of its mesh. Out: triangles with a radiance, times the share of them that is there; those whose textures vary in
//! pieces, so that light is sampled where they emit.

use glam::{Vec2, Vec3};

use super::contents::{Pose, Scene};
use super::light::{AreaTriangle, Light, LightKind, luminance};
use super::material::Material;
use super::mesh::{Mesh, SurfacePoint};
use super::texture_use::TextureUse;
use crate::sampling;

/// Points of a piece at which textures are read.
const POINTS: u32 = 16;

/// Most pieces of an instance, unless it has more triangles.
const MOST_PIECES: usize = 4096;

/// Most splits of a triangle into four: 32 pieces along each edge.
const MOST_SPLITS: u32 = 5;

/// Splits where only vertices make the difference: 8 pieces along each edge.
const VERTEX_SPLITS: u32 = 3;

/// Pieces that differ by less than this share of the brightest are one.
const LEAST_CONTRAST: f32 = 0.05;

/// An emissive side of a triangle.
struct EmissiveSide<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    material: &'a Material,
    triangle: u32,
    front: bool,
}

impl EmissiveSide<'_> {
    /// Appends the pieces of the part between `corners`, split at most `splits` times.
    fn split(&self, corners: [Vec2; 3], splits: u32, pieces: &mut Vec<AreaTriangle>) {
        if splits == 0 {
            pieces.push(self.piece(corners));
            return;
        }
        let first = pieces.len();
        let [a, b, c] = corners;
        let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]] {
            self.split(part, splits - 1, pieces);
        }
        let parts = &pieces[first..];
        let mean = parts.iter().map(|part| part.radiance).sum::<Vec3>() / 4.0;
        let brightest = parts.iter().map(|part| part.radiance.max_element()).fold(0.0, f32::max);
        let is_uniform =
            |part: &AreaTriangle| (part.radiance - mean).abs().max_element() <= LEAST_CONTRAST * brightest;
        if parts.len() == 4 && parts.iter().all(is_uniform) {
            pieces.truncate(first);
            pieces.push(AreaTriangle { radiance: mean, ..self.piece_at(corners) });
        }
    }

    fn piece_at(&self, corners: [Vec2; 3]) -> AreaTriangle {
        AreaTriangle { triangle: self.triangle, front: self.front, corners, radiance: Vec3::ZERO }
    }

    fn piece(&self, corners: [Vec2; 3]) -> AreaTriangle {
        let piece = self.piece_at(corners);
        let radiance = |point| {
            let at = SurfacePoint { triangle: self.triangle, barycentrics: piece.barycentrics(point) };
            self.material.covered_emission_at(self.scene, self.mesh.interpolate(at).attributes)
        };
        if !self.material.emission_varies(self.mesh) {
            return AreaTriangle { radiance: radiance(Vec2::ZERO), ..piece };
        }
        let sum: Vec3 = sampling::triangle_points(POINTS).map(radiance).sum();
        AreaTriangle { radiance: sum / POINTS as f32, ..piece }
    }

    /// Splits after which a piece is about as large as a texel, at most `most`.
    fn splits(&self, most: u32) -> u32 {
        let of_texture = |texture: TextureUse| {
            let size = self.scene.textures[texture.texture].size().as_vec2();
            let place = |barycentrics| {
                let at = SurfacePoint { triangle: self.triangle, barycentrics };
                texture.coordinates(self.mesh.interpolate(at).attributes.uvs) * size
            };
            let [a, b, c] = AreaTriangle::WHOLE.map(place);
            let texels = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if texels.is_finite() { (texels.max(1.0).log2().ceil() as u32 + 1).min(most) } else { 0 }
        };
        let by_vertices = if self.material.emission_varies(self.mesh) { VERTEX_SPLITS.min(most) } else { 0 };
        self.material.emitting_textures().map(of_texture).max().unwrap_or(by_vertices)
    }
}

impl Scene {
    /// Adds an area light for instance `instance`, with its name, if any of its triangles is emissive.
    pub fn add_area_light(&mut self, instance: usize) {
        let triangles = self.emissive_triangles(instance);
        if triangles.is_empty() {
            return;
        }
        self.lights.push(Light {
            name: self.instances[instance].name.clone(),
            kind: LightKind::Area { instance, triangles },
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            radius: 0.0,
            half_angle: 0.0,
            animation: None,
        });
    }

    fn emissive_triangles(&self, instance: usize) -> Vec<AreaTriangle> {
        let mesh = &*self.meshes[self.instances[instance].mesh];
        let emissive = || {
            let materials =
                mesh.triangle_materials.iter().map(|&material| &self.materials[material as usize]);
            (0..).zip(materials).filter(|(_, material)| material.is_emissive())
        };
        let varying = emissive().filter(|(_, material)| material.emission_varies(mesh)).count();
        let most = (MOST_PIECES / varying.max(1)).max(1).ilog(4).min(MOST_SPLITS);
        let mut pieces = Vec::new();
        for (triangle, material) in emissive() {
            for front in [true, false].into_iter().filter(|&front| material.emits_on(front)) {
                let side = EmissiveSide { scene: self, mesh, material, triangle, front };
                side.split(AreaTriangle::WHOLE, side.splits(most), &mut pieces);
            }
        }
        pieces.retain(|piece| piece.radiance != Vec3::ZERO);
        pieces
    }

    /// Factor on the emission of each instance's materials, since a pose may change area lights or take them away:
    /// radiance now over the radiance that the scene states.
    pub fn emission_factors(&self, pose: &Pose) -> Vec<Vec3> {
        let (rest, now) = (self.brightest_emissions(&self.lights), self.brightest_emissions(&pose.lights));
        let factor = |(rest, now): (Option<Vec3>, Option<Vec3>)| match (rest, now) {
            (Some(rest), Some(now)) if rest != now => {
                let factor = now / rest;
                Vec3::select(factor.is_finite_mask(), factor, Vec3::ZERO)
            }
            (Some(_), None) => Vec3::ZERO,
            _ => Vec3::ONE,
        };
        rest.into_iter().zip(now).map(factor).collect()
    }

    /// The brightest piece of each instance's area light.
    fn brightest_emissions(&self, lights: &[Light]) -> Vec<Option<Vec3>> {
        let mut brightest = vec![None; self.instances.len()];
        for light in lights {
            let LightKind::Area { instance, triangles } = &light.kind else { continue };
            let radiances = triangles.iter().map(|triangle| triangle.radiance);
            brightest[*instance] = radiances.max_by(|a, b| luminance(*a).total_cmp(&luminance(*b)));
        }
        brightest
    }
}
