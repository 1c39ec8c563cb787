//! Area lights as shaders sample them: of each its bounds and power, and its emissive triangles in the world.
//!
//! In: where everything stands. Out: two buffers, for shaders/include/unshadowed.glsl and light_sampling.glsl.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec2, Vec3, Vec4};

use super::to_u32;
use crate::bvh::gpu::halves;
use crate::scene::{AreaTriangle, BoundingSphere, LightKind, Pose, Scene, luminance};
use crate::vulkan::{Frame, Upload, VulkanError};

/// A light; `AreaLightData` in shaders/include/unshadowed.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct AreaLightData {
    /// xyz: of its bounds; w: their radius.
    pub centre: Vec4,
    /// xyz: mean normal, shorter than 1 where the light is not flat.
    pub facing: Vec4,
    /// rgb: radiance times area, the sum of its emitters, W/sr.
    pub power: Vec4,
    /// Index of its first emitter.
    pub first: u32,
    /// Number of its emitters.
    pub count: u32,
    /// Whether rays can hit it.
    pub is_visible: u32,
    /// Area of its emitters.
    pub area: f32,
}

/// A triangle; `Emitter` in shaders/include/light_sampling.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Emitter {
    /// xyz: world position; w: share of the light's flux of the emitters up to this one.
    pub corner: Vec4,
    /// xyz: to the second corner; w: density of points, 1/area.
    pub edge_u: Vec4,
    /// xyz: to the third corner; w: 1 if rays hit it; they pass thin surfaces.
    pub edge_v: Vec4,
    /// rgb: radiance; w: index of its alpha mask plus one, as bits.
    pub radiance: Vec4,
    /// Coordinates on the mask of the first and the second corner.
    pub uvs: Vec4,
    /// xy: third corner; zw: alphas of the corners, half floats as bits.
    pub uv: Vec4,
}

/// Inputs of the tables.
#[derive(PartialEq)]
struct Key {
    lights: Vec<(usize, Vec<AreaTriangle>, Affine3A)>,
}

/// The tables of a pose.
#[derive(Default)]
pub struct AreaLights {
    lights: Vec<AreaLightData>,
    emitters: Vec<Emitter>,
    /// The index of each instance's light plus one, or 0.
    of_instance: Vec<u32>,
    key: Option<Key>,
}

/// The tables on the device.
pub struct UploadedAreaLights {
    /// [`AreaLightData`].
    pub lights: Upload,
    /// [`Emitter`].
    pub emitters: Upload,
}

impl AreaLights {
    /// Brings the tables up to date.
    pub fn update(&mut self, scene: &Scene, pose: &Pose) {
        let lights = pose.lights.iter().filter_map(|light| match &light.kind {
            LightKind::Area { instance, triangles } => {
                Some((*instance, triangles.clone(), *pose.instances.get(*instance)?))
            }
            _ => None,
        });
        let key = Key { lights: lights.collect() };
        if self.key.as_ref() == Some(&key) {
            return;
        }
        (self.lights, self.emitters) = (Vec::new(), Vec::new());
        self.of_instance = vec![0; scene.instances.len()];
        for (instance, triangles, transform) in &key.lights {
            self.add(scene, *instance, triangles, transform);
        }
        self.key = Some(key);
    }

    /// How many lights there are that emit anything.
    pub fn count(&self) -> u32 {
        to_u32(self.lights.len())
    }

    /// Index of the light that an instance is, plus one; 0: none.
    pub fn of_instance(&self, instance: usize) -> u32 {
        self.of_instance.get(instance).copied().unwrap_or(0)
    }

    /// Uploads the tables. An empty one has one entry.
    pub fn upload(&self, frame: &mut Frame<'_>) -> Result<UploadedAreaLights, VulkanError> {
        let none = (&[AreaLightData::default()][..], &[Emitter::default()][..]);
        let (lights, emitters) =
            if self.lights.is_empty() { none } else { (&self.lights[..], &self.emitters[..]) };
        Ok(UploadedAreaLights { lights: frame.upload(lights)?, emitters: frame.upload(emitters)? })
    }

    fn add(&mut self, scene: &Scene, instance: usize, triangles: &[AreaTriangle], transform: &Affine3A) {
        let mesh = &scene.meshes[scene.instances[instance].mesh];
        let visible = scene.instances[instance].visible;
        let flips_winding = transform.matrix3.determinant() < 0.0;
        let first = self.emitters.len();
        let (mut flux, mut area, mut facing, mut power) = (0.0, 0.0, Vec3::ZERO, Vec3::ZERO);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for triangle in triangles {
            let material = &scene.materials[mesh.triangle_materials[triangle.triangle as usize] as usize];
            let corners = triangle.interpolate(mesh.triangle_positions(triangle.triangle));
            let mut corners = corners.map(|at| transform.transform_point3(at));
            let mut uvs = triangle.interpolate(mesh.mask_coordinates(triangle.triangle, material));
            let mut alphas = triangle.interpolate(mesh.alphas(triangle.triangle));
            // Mirroring flips the winding but not the front side.
            if flips_winding == triangle.front {
                corners.swap(1, 2);
                uvs.swap(1, 2);
                alphas.swap(1, 2);
            }
            let [a, u, v] = [corners[0], corners[1] - corners[0], corners[2] - corners[0]];
            let doubled = u.cross(v);
            let own = 0.5 * doubled.length();
            flux += f64::from(own) * f64::from(luminance(triangle.radiance).max(0.0));
            area += own;
            facing += 0.5 * doubled;
            power += own * triangle.radiance;
            for corner in corners {
                (low, high) = (low.min(corner), high.max(corner));
            }
            let mask = material.alpha_mask.map_or(0, |mask| to_u32(mask) + 1);
            let [first, second, third]: [Vec2; 3] = uvs;
            let [first_two, last] = halves(Vec3::from(alphas).extend(0.0));
            self.emitters.push(Emitter {
                // The running sum for now.
                corner: a.extend(flux as f32),
                edge_u: u.extend(own),
                edge_v: v.extend(f32::from(visible && !material.is_thin_surface())),
                radiance: triangle.radiance.extend(f32::from_bits(mask)),
                uvs: Vec4::new(first.x, first.y, second.x, second.y),
                uv: Vec4::new(third.x, third.y, f32::from_bits(first_two), f32::from_bits(last)),
            });
        }
        if !(flux > 0.0 && flux.is_finite()) {
            self.emitters.truncate(first);
            return;
        }
        // The density must match the rounded distribution.
        let mut before = 0.0;
        for emitter in &mut self.emitters[first..] {
            let (up_to, own) = ((f64::from(emitter.corner.w) / flux).min(1.0) as f32, emitter.edge_u.w);
            emitter.edge_u.w = (up_to - before) / own.max(f32::MIN_POSITIVE);
            emitter.corner.w = up_to;
            before = up_to;
        }
        let bounds = BoundingSphere::around((low, high));
        self.of_instance[instance] = to_u32(self.lights.len()) + 1;
        self.lights.push(AreaLightData {
            centre: bounds.center.extend(bounds.radius),
            facing: (facing / area).extend(0.0),
            power: power.extend(0.0),
            first: to_u32(first),
            count: to_u32(self.emitters.len() - first),
            is_visible: u32::from(self.emitters[first..].iter().any(|emitter| emitter.edge_v.w > 0.0)),
            area,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_scene::structs::tests::same_layout;
    use crate::vulkan::shaders;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        let shader = shaders::SOFT_SHADOWS_TRACE_COMP.software;
        same_layout!(shader, AreaLightData, centre, facing, power, first, count, is_visible, area);
        same_layout!(shader, Emitter, corner, edge_u, edge_v, radiance, uvs, uv);
    }
}
