//! glTF 2.0 models, parsed by the crate `gltf`.
//!
//! In: a `.gltf` or `.glb` with its buffers and images. Out: a scene with its meshes, materials, node tree, animation,
//! cameras and lights; or, as a model of a scene file, one mesh of all that it shows at rest.
//!
//! Units: metres. Candela and lux are divided by 683 lm/W, emission is taken as W/m^2/sr.

mod accessor;
mod attributes;
mod buffers;
#[cfg(feature = "draco")]
mod draco;
mod extensions;
mod materials;
mod meshes;
#[cfg(feature = "meshopt")]
mod meshopt;
mod motion;
mod nodes;
mod repair;
mod shape;
mod source;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use ::gltf::camera::Projection;
use ::gltf::khr_lights_punctual::Kind;
use glam::{Affine3A, Vec3};

use self::materials::Materials;
use self::meshes::{baked, mesh_of};
use self::motion::Motions;
use self::nodes::{Placed, Tree};
use self::shape::Shape;
use self::source::Source;
use super::error::SceneError;
use super::{default_view, obj};
use crate::scene::{Animation, Camera, CameraOverride, Instance, Light, LightKind, Mesh, Scene, SpotFalloff};
use crate::untrusted;

/// Luminous efficacy by which photometric units become radiometric ones, lm/W.
const EFFICACY: f32 = 683.0;

/// Least difference of a spot's cones, radians.
const LEAST_FALLOFF: f32 = 1e-3;

/// Whether a file name is that of a glTF file.
pub(crate) fn is_gltf(file: &Path) -> bool {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    matches!(extension.as_deref(), Some("gltf" | "glb"))
}

/// Loads a file as a scene, with its own camera and lights, or made-up ones where it has none, and the animation of this name or
/// index, or its first one.
pub(crate) fn load(
    file: &Path,
    animation: Option<&str>,
    seen_by: &CameraOverride,
) -> Result<Scene, SceneError> {
    guarded(file, || load_unguarded(file, animation, seen_by))
}

/// Adds all that a file shows at rest as one mesh; returns its index.
pub(crate) fn add_model(file: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
    guarded(file, || add_model_unguarded(file, scene))
}

/// Reads a model by the crate `gltf`, whose panic is an error of the file.
fn guarded<T>(file: &Path, read: impl FnOnce() -> Result<T, SceneError>) -> Result<T, SceneError> {
    let invalid = |why| SceneError::invalid(file, None, format!("{why}; export or download it again"));
    untrusted::guarded(read).map_err(invalid)?
}

fn load_unguarded(
    file: &Path,
    animation: Option<&str>,
    seen_by: &CameraOverride,
) -> Result<Scene, SceneError> {
    let mut scene = Scene::new(&obj::stem(file));
    // As the specification has it.
    scene.metres_per_unit = Some(1.0);
    let mut file = File::open(file, &mut scene)?;
    let animations = file.source.document.animations();
    let name = |of: ::gltf::Animation<'_>| of.name().map_or_else(|| of.index().to_string(), str::to_owned);
    scene.files.animations = animations.map(name).collect();
    scene.files.cameras = file.source.document.cameras().len();
    let motions = Motions::read(&mut file.source, animation)?;
    let placed = std::mem::take(&mut file.placed);
    let moving = motions.moving(&file.tree);
    if file.source.document.skins().flat_map(|skin| skin.joints()).any(|joint| moving[joint.index()]) {
        file.source.not_shown.insert("animation of skins".to_owned());
    }
    let mut camera = None;
    for (place, animation) in placed.iter().zip(motions.animate(&file.tree, &placed)) {
        file.add_instance(&mut scene, place, animation.clone())?;
        file.add_light(&mut scene, place, animation.clone())?;
        if let Some(found) = file.camera(place)? {
            if camera.is_none() {
                camera = Some((found, animation));
            } else {
                file.source.not_shown.insert("cameras but the first".to_owned());
            }
        }
    }
    file.finish(&mut scene)?;
    scene.anchor_meshes();
    for instance in 0..scene.instances.len() {
        scene.add_area_light(instance);
    }
    let placed_camera = camera.map(|(found, animation)| {
        scene.camera_animation = animation;
        found
    });
    default_view::add_default_camera_and_light(&mut scene, placed_camera, seen_by)
        .map_err(|why| file.source.error(why))?;
    Ok(scene)
}

fn add_model_unguarded(path: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
    let mut file = File::open(path, scene)?;
    let mut whole = Mesh { name: obj::stem(path), ..Mesh::default() };
    let document = Arc::clone(&file.source.document);
    for place in std::mem::take(&mut file.placed) {
        let node = place.in_document(&document);
        if node.camera().is_some() || node.light().is_some() {
            file.source.not_shown.insert("cameras and lights (the scene file's are)".to_owned());
        }
        let Some(mesh) = node.mesh() else { continue };
        let shape = Shape::of(&file.source, &file.tree, &node)?;
        if let Some(mesh) = mesh_of(&mut file.source, (&mesh, &shape), &file.materials, scene)? {
            let skinned = node.skin().is_some();
            whole.append(if skinned { mesh } else { baked(&mesh, &place.transform) });
        }
    }
    if file.source.document.animations().len() > 0 {
        file.source.not_shown.insert("animation (instances have their own)".to_owned());
    }
    whole.sort_by_material();
    if whole.triangles.is_empty() {
        return Err(file.empty());
    }
    file.warn(scene);
    scene.meshes.push(whole.into());
    Ok(scene.meshes.len() - 1)
}

/// A file being added to a scene.
struct File {
    source: Source,
    materials: Materials,
    tree: Tree,
    placed: Vec<Placed>,
    /// Scene index of each mesh of the file that is used, with the node that poses it; none if it has no triangles.
    meshes: HashMap<(usize, Option<usize>), Option<usize>>,
}

impl File {
    fn open(file: &Path, scene: &mut Scene) -> Result<Self, SceneError> {
        let mut source = Source::read(file)?;
        let names = source.document.extensions_used().map(str::to_owned);
        scene.files.extensions.extend(names);
        let (tree, placed) = nodes::read(&mut source)?;
        let materials = Materials::add(&mut source, scene)?;
        Ok(Self { source, materials, tree, placed, meshes: HashMap::new() })
    }

    fn name(&self, place: &Placed) -> String {
        place
            .in_document(&self.source.document)
            .name()
            .map_or_else(|| format!("node {}", place.node), str::to_owned)
    }

    fn add_instance(
        &mut self,
        scene: &mut Scene,
        place: &Placed,
        animation: Option<Animation>,
    ) -> Result<(), SceneError> {
        let document = Arc::clone(&self.source.document);
        let node = place.in_document(&document);
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let is_posed = node.skin().is_some() || node.weights().is_some();
        let key = (mesh.index(), is_posed.then_some(place.node));
        let known = self.meshes.get(&key).copied();
        let index = match known {
            Some(index) => index,
            None => {
                let shape = Shape::of(&self.source, &self.tree, &node)?;
                let made = mesh_of(&mut self.source, (&mesh, &shape), &self.materials, scene)?;
                let index = made.map(|made| {
                    scene.meshes.push(made.into());
                    scene.meshes.len() - 1
                });
                self.meshes.insert(key, index);
                index
            }
        };
        let Some(mut index) = index else { return Ok(()) };
        let (mut transform, mut animation) = (place.transform, animation);
        if node.skin().is_some() {
            (transform, animation) = (Affine3A::IDENTITY, None);
        }
        if transform.matrix3.determinant() < 0.0 && scene.is_emissive(index) {
            // Which side emits depends on the winding, so a mirrored light gets a mesh of its own.
            scene.meshes.push(baked(&scene.meshes[index], &transform).into());
            index = scene.meshes.len() - 1;
            transform = Affine3A::IDENTITY;
            if animation.take().is_some() {
                self.source.not_shown.insert("animation of mirrored surfaces that emit".to_owned());
            }
        }
        if animation.is_none() && place.is_nothing {
            self.source.not_shown.insert("meshes scaled to nothing".to_owned());
            return Ok(());
        }
        scene.instances.push(Instance {
            dynamic: animation.is_some(),
            animation,
            ..Instance::fixed(&self.name(place), index, transform)
        });
        Ok(())
    }

    /// Adds the light of a node (KHR_lights_punctual).
    fn add_light(
        &mut self,
        scene: &mut Scene,
        place: &Placed,
        animation: Option<Animation>,
    ) -> Result<(), SceneError> {
        let name = self.name(place);
        let document = Arc::clone(&self.source.document);
        let Some(light) = place.in_document(&document).light() else { return Ok(()) };
        let power = Vec3::from_array(light.color()) * (light.intensity() / EFFICACY);
        if !power.is_finite() || power.min_element() < 0.0 {
            return Err(self
                .source
                .error(format!("light \"{name}\": colour times intensity must be finite and not negative")));
        }
        let kind = match light.kind() {
            Kind::Directional => LightKind::Directional { irradiance: power },
            Kind::Point => LightKind::Point { intensity: power },
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let outer_angle = outer_cone_angle.clamp(2.0 * LEAST_FALLOFF, std::f32::consts::FRAC_PI_2);
                let inner_angle = inner_cone_angle.clamp(0.0, outer_angle - LEAST_FALLOFF);
                LightKind::Spot { intensity: power, inner_angle, outer_angle, falloff: SpotFalloff::Square }
            }
        };
        if light.range().is_some() {
            self.source.not_shown.insert("ranges of lights".to_owned());
        }
        scene.lights.push(Light {
            name,
            kind,
            position: place.transform.translation.into(),
            direction: place.transform.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z),
            radius: 0.0,
            half_angle: 0.0,
            animation,
        });
        Ok(())
    }

    /// The perspective camera of a node.
    fn camera(&mut self, place: &Placed) -> Result<Option<Camera>, SceneError> {
        let document = Arc::clone(&self.source.document);
        let Some(camera) = place.in_document(&document).camera() else { return Ok(None) };
        let Projection::Perspective(lens) = camera.projection() else {
            self.source.not_shown.insert("orthographic cameras".to_owned());
            return Ok(None);
        };
        let axis = |v: Vec3, or: Vec3| place.transform.transform_vector3(v).normalize_or(or);
        let (forward, up) = (axis(Vec3::NEG_Z, Vec3::NEG_Z), axis(Vec3::Y, Vec3::Y));
        let eye = Vec3::from(place.transform.translation);
        let near = lens.znear();
        let far = lens.zfar().filter(|far| *far > near).unwrap_or(f32::INFINITY);
        let degrees = lens.yfov().to_degrees();
        let is_usable = (0.01..=170.0).contains(&degrees) && near > 0.0 && near.is_finite();
        if !is_usable || forward.cross(up).length() < 1e-4 {
            return Err(self.source.error(format!(
                "camera {}: needs a field of view from 0.01 to 170 degrees and a near plane above 0; export it again",
                camera.index()
            )));
        }
        let target = eye + forward;
        Ok(Some(Camera { up, vertical_fov: lens.yfov(), near, far, ..Camera::looking(eye, target) }))
    }

    fn finish(&self, scene: &mut Scene) -> Result<(), SceneError> {
        if scene.instances.is_empty() {
            return Err(self.empty());
        }
        self.warn(scene);
        Ok(())
    }

    /// The error about a file that shows nothing, with what it leaves out.
    fn empty(&self) -> SceneError {
        let names: Vec<&str> = self.source.not_shown.iter().map(String::as_str).collect();
        let left_out =
            if names.is_empty() { String::new() } else { format!(" (not shown: {})", names.join(", ")) };
        self.source.error(format!("has no triangles{left_out}; export a model with meshes in its scene"))
    }

    /// Names what is in the file and is not shown.
    fn warn(&self, scene: &mut Scene) {
        let names: Vec<&str> = self.source.not_shown.iter().map(String::as_str).collect();
        if !names.is_empty() {
            scene.warnings.push(format!("{}: not shown: {}", self.source.file.display(), names.join(", ")));
        }
    }
}
