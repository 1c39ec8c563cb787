//! Reads the files of a frame, in each layout, into the inputs of a denoiser.

use std::collections::BTreeMap;
use std::f32::consts::PI;
use std::path::Path;

use glam::{Affine3A, Vec2, Vec3};

use super::files::{self, FrameState, RGBA};
use super::{DatasetError, DatasetFrames};
use crate::gpu_scene::geometry::octahedral;
use crate::output::Picture;
use crate::renderer::DenoiserFrame;

/// The limit of the shaders where all surfaces mirror, and where none does: see shaders/include/reflection_weight.glsl.
const ALL_MIRROR: f32 = 2.0;
const NONE_MIRRORS: f32 = -1.0;

type Images = BTreeMap<&'static str, Vec<[f32; 4]>>;

impl DatasetFrames {
    /// The renderer's own inputs.
    pub(super) fn live(&self, frame: u32) -> Result<DenoiserFrame, DatasetError> {
        let state = self.state(frame)?;
        let (path, picture) = self.picture("live", frame)?;
        let mut images = Images::new();
        for (name, _) in DenoiserFrame::CHANNELS {
            let image = image_of(&picture, name).ok_or_else(|| lacks(&path, name))?;
            images.insert(name, image);
        }
        let more = [DenoiserFrame::REFLECTION].into_iter().chain(DenoiserFrame::THIN_SURFACES);
        images.extend(more.filter_map(|name| Some((name, image_of(&picture, name)?))));
        if let Some(limit) = state.reflection_limit {
            return self.checked(frame, &path, frame_of(state, limit, images));
        }
        let path = files::path_of(&self.folder, "frame", frame, "json");
        Err(DatasetError::of(
            &path,
            "has no reflection_limit; write the data set anew with glowworm render --dataset",
        ))
    }

    /// Indirect light as the signal; the GGX lobe's reflection is added as if it were mirrored with an albedo of 1.
    pub(super) fn parts(&self, frame: u32) -> Result<DenoiserFrame, DatasetError> {
        let state = self.state(frame)?;
        let rgb = |name: &str| self.rgb(name, frame);
        let instance = rgb("instance")?;
        let (diffuse, roughness) = (rgb("diffuse")?, rgb("roughness")?);
        let albedo = diffuse.iter().zip(&roughness).map(|(&[r, g, b], roughness)| [r, g, b, roughness[0]]);
        let covered: Vec<bool> = instance.iter().map(|id| id[0] >= 0.0).collect();
        let motion = rgb("motion")?.into_iter();
        let [width, height] = self.size.map(|side| side as f32);
        let depth = rgb("world_position")?.into_iter().map(|position| view_depth(&state, position.into()));
        let images = Images::from([
            ("gbuffer_depth", masked(depth.map(|depth| [depth, 0.0, 0.0, 0.0]), &covered)),
            ("gbuffer_normal", rgb("shading_normal")?.into_iter().map(packed_normals).collect()),
            ("gbuffer_albedo", albedo.collect()),
            ("gbuffer_instance", instance.iter().map(|id| [id[0] + 1.0, 0.0, 0.0, 0.0]).collect()),
            ("gbuffer_motion", motion.map(|[x, y, _]| [x * width, y * height, 0.0, 0.0]).collect()),
            ("noisy", rgb("indirect")?.into_iter().map(opaque).collect()),
            ("direct", metered(rgb("direct")?, &covered)),
            ("specular_albedo", vec![[1.0; 4]; covered.len()]),
            (DenoiserFrame::REFLECTION, rgb("reflected")?.into_iter().map(opaque).collect()),
        ]);
        let path = files::path_of(&self.folder, "instance", frame, "exr");
        self.checked(frame, &path, frame_of(state, ALL_MIRROR, images))
    }

    /// All light as the signal, on one instance. Points stand still, so their motion is the camera's.
    pub(super) fn bmfr(&self, frame: u32) -> Result<DenoiserFrame, DatasetError> {
        let rgb = |name: &str| self.rgb(name, frame);
        let (colour, albedo) = (rgb("color")?, rgb("albedo")?);
        let (normals, positions) = (rgb("shading_normal")?, rgb("world_position")?);
        let covered: Vec<bool> = normals.iter().map(|normal| *normal != [0.0; 3]).collect();
        let state = self.bmfr_state(frame)?;
        let depth = positions.iter().map(|&position| view_depth(&state, position.into()));
        let by_albedo = || colour.iter().zip(&albedo).map(|(c, a)| [0, 1, 2].map(|i| c[i] * a[i]));
        // Pixels without a surface hold no signal, and show no denoiser's output.
        let uncovered: Vec<bool> = covered.iter().map(|covered| !covered).collect();
        let background: Vec<[f32; 4]> = masked(by_albedo().map(opaque), &uncovered);
        let images = Images::from([
            ("gbuffer_depth", masked(depth.map(|depth| [depth, 0.0, 0.0, 0.0]), &covered)),
            ("gbuffer_normal", normals.iter().copied().map(packed_normals).collect()),
            ("gbuffer_albedo", masked(albedo.iter().copied().map(opaque), &covered)),
            (
                "gbuffer_instance",
                covered.iter().map(|&covered| [f32::from(u8::from(covered)), 0.0, 0.0, 0.0]).collect(),
            ),
            ("gbuffer_motion", masked(self.camera_motion(frame, &positions).into_iter(), &covered)),
            // Radiance over the albedo is irradiance over pi.
            ("noisy", masked(colour.iter().map(|colour| opaque(colour.map(|c| c * PI))), &covered)),
            ("direct", metered(background.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(), &covered)),
            ("specular_albedo", vec![[0.0; 4]; covered.len()]),
        ]);
        Ok(frame_of(state, NONE_MIRRORS, images))
    }

    fn bmfr_state(&self, frame: u32) -> Result<FrameState, DatasetError> {
        let found = self.matrices.as_ref().map(|matrices| (matrices, matrices.eye_and_rays(frame as usize)));
        let Some((matrices, Some((eye, rays)))) = found else {
            let path = self.folder.join(super::MATRICES_FILE);
            return Err(DatasetError::of(
                &path,
                format!("camera_matrices[{frame}] is not that of a perspective camera"),
            ));
        };
        let view_projection = matrices.matrices[frame as usize];
        let (size, instances) = (self.size(), vec![Affine3A::IDENTITY]);
        Ok(FrameState { size, eye, rays, view_projection, instances, reflection_limit: None })
    }

    /// Motion from where each point was seen in the last frame to its pixel, pixels.
    fn camera_motion(&self, frame: u32, positions: &[[f32; 3]]) -> Vec<[f32; 4]> {
        let (Some(matrices), Some(last)) = (&self.matrices, frame.checked_sub(1)) else {
            return vec![[0.0; 4]; positions.len()];
        };
        let size = Vec2::from(self.size.map(|side| side as f32));
        let of = |(index, position): (usize, &[f32; 3])| {
            let pixel = Vec2::new((index % self.size[0]) as f32, (index / self.size[0]) as f32);
            let then = matrices.pixel(last as usize, frame as usize, size, Vec3::from(*position));
            (pixel - then).extend(0.0).extend(0.0).to_array()
        };
        positions.iter().enumerate().map(of).collect()
    }

    /// Fails if a pixel shows an instance that does not stand anywhere.
    fn checked(&self, frame: u32, path: &Path, given: DenoiserFrame) -> Result<DenoiserFrame, DatasetError> {
        let count = given.instances.len();
        let stands = |id: &f32| (0.0..=count as f32).contains(id) && id.fract() == 0.0;
        let ids = given.images["gbuffer_instance"].iter().map(|texel| texel[0]);
        match ids.into_iter().find(|id| !stands(id)) {
            None => Ok(given),
            Some(id) => Err(DatasetError::of(
                path,
                format!(
                    "shows instance {}, but frame{frame}.json has {count}; write the data set anew",
                    id - 1.0
                ),
            )),
        }
    }
}

fn frame_of(state: FrameState, reflection_limit: f32, images: Images) -> DenoiserFrame {
    let FrameState { size, eye, rays, view_projection, instances, .. } = state;
    DenoiserFrame { size, eye, rays, view_projection, instances, reflection_limit, images }
}

fn lacks(path: &Path, name: &str) -> DatasetError {
    let channels = RGBA[..files::channels_of(name)].join(", ");
    let what_to_do = "write the data set anew with glowworm render --dataset";
    DatasetError::of(path, format!("has no layer {name} with channels {channels}; {what_to_do}"))
}

/// A layer of the renderer's images, if it is there with all its channels.
fn image_of(picture: &Picture, name: &str) -> Option<Vec<[f32; 4]>> {
    let layer = picture.layers.iter().find(|layer| layer.name == name)?;
    let channel = |letter: &&str| {
        let (_, values) = layer.channels.iter().find(|(known, _)| known == letter)?;
        (values.len() == picture.width * picture.height).then_some(values)
    };
    let channels = RGBA[..files::channels_of(name)].iter().map(channel).collect::<Option<Vec<_>>>()?;
    let texel = |at: usize| std::array::from_fn(|index| channels.get(index).map_or(0.0, |values| values[at]));
    Some((0..picture.width * picture.height).map(texel).collect())
}

fn view_depth(state: &FrameState, position: Vec3) -> f32 {
    (state.view_projection * position.extend(1.0)).w
}

/// The shading normal, which stands for the geometric one, too.
fn packed_normals(normal: [f32; 3]) -> [f32; 4] {
    let [x, y] = octahedral(normal.into()).to_array();
    [x, y, x, y]
}

fn opaque([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 1.0]
}

/// Texels where `shown`, and 0 elsewhere.
fn masked(texels: impl Iterator<Item = [f32; 4]>, shown: &[bool]) -> Vec<[f32; 4]> {
    texels.zip(shown).map(|(texel, shown)| if *shown { texel } else { [0.0; 4] }).collect()
}

/// Radiance, which counts for automatic exposure where a surface is seen.
fn metered(radiance: Vec<[f32; 3]>, covered: &[bool]) -> Vec<[f32; 4]> {
    let weight = |covered: bool| f32::from(u8::from(covered));
    radiance.into_iter().zip(covered).map(|([r, g, b], covered)| [r, g, b, weight(*covered)]).collect()
}
