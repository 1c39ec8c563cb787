//! Exports a scene at one time for Mitsuba 3: `scene.xml`, meshes as PLY, textures as PNG.
//!
//! In: a scene, a time, and picture settings. Out: a folder that Mitsuba 3 (tested with 3.9) renders to the same
//! radiance: the same geometry, materials, lights, units, camera and bounce limit. [`ExportReport::inexact`] and the
//! head of `scene.xml` list the differences. Materials that Mitsuba does not have are written twice: as its nearest ones,
//! which `scene.xml` includes, and for [`PLUGIN_FILE`], which is in the folder and makes them exact.
//!
//! Numbers in the XML are 32-bit floats that round-trip.

mod folder;
mod lights;
mod materials;
mod ply;
mod remarks;
mod shapes;
mod spot;
mod view;
mod xml;

pub use folder::{ExportError, ExportFolder};

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use glam::Vec3;
use serde::Serialize;

use crate::report::COMMIT;
use crate::scene::{Light, LightKind, Pose, Scene};
use folder::REPORT_FILE;
use materials::Reader;
use remarks::{Remark, SMALL_RADIUS};
use shapes::Part;
use xml::Element;

/// Settings of the exported picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportSettings {
    /// Frame of the animation, for the report.
    pub frame: u64,
    /// Its time, seconds.
    pub time: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Bounce limit: scattering events between a light and the visible surface; none: no limit.
    pub bounces: Option<u32>,
    /// Default samples a pixel.
    pub spp: u32,
}

/// Number of lights by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LightCounts {
    /// Point lights.
    pub point: usize,
    /// Spot lights; each becomes several of Mitsuba's.
    pub spot: usize,
    /// Directional lights.
    pub directional: usize,
    /// Visible emissive instances.
    pub area: usize,
    /// Invisible emissive instances.
    pub portal: usize,
}

impl LightCounts {
    /// The total.
    pub fn total(&self) -> usize {
        self.point + self.spot + self.directional + self.area + self.portal
    }
}

/// The report of an export.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportReport {
    /// Name of the scene.
    pub scene: String,
    /// `mitsuba`.
    pub format: &'static str,
    /// Frame of the animation.
    pub frame: u64,
    /// Its time, seconds.
    pub time: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples of each pixel.
    pub spp: u32,
    /// Mitsuba's integrator.
    pub integrator: &'static str,
    /// Its `max_depth`; -1: no limit.
    pub max_depth: i64,
    /// Number of materials that need [`PLUGIN_FILE`] to be the same in Mitsuba.
    pub special: usize,
    /// Background radiance, to be added times 1 - alpha.
    pub background: [f32; 3],
    /// Shapes of the Mitsuba scene: meshes of one material, and instances of shape groups.
    pub shapes: usize,
    /// Triangles of all instances.
    pub triangles: usize,
    /// BSDFs.
    pub materials: usize,
    /// Images, including alpha masks.
    pub textures: usize,
    /// Lights of the scene.
    pub lights: LightCounts,
    /// Differences between Mitsuba's picture and glowworm's, a sentence each.
    pub inexact: Vec<String>,
    /// Every file, relative to the folder.
    pub files: Vec<String>,
    /// Commit of the program, see [`COMMIT`].
    pub commit: &'static str,
}

/// The content of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Mesh(Part),
    /// A texture times a colour.
    Texture {
        texture: usize,
        tint: Vec3,
    },
    /// A channel of a texture times a factor.
    Channel {
        texture: usize,
        channel: usize,
        factor: f32,
    },
    /// A texture times radiance.
    Emission {
        texture: usize,
        factor: Vec3,
    },
    Mask(usize),
    /// The environment's map.
    Environment,
}

/// An export in progress.
struct Export<'a> {
    scene: &'a Scene,
    pose: &'a Pose,
    settings: &'a ExportSettings,
    /// Whether `hide_emitters` hides portals and the spheres of point lights.
    hides_emitters: bool,
    files: BTreeMap<String, Content>,
    /// Images of textures; the index is the number in the file's name.
    images: Vec<Content>,
    used_materials: BTreeSet<u32>,
    /// Materials of meshes whose vertices have colours.
    coloured: BTreeSet<u32>,
    /// Meshes exported as shape groups.
    groups: BTreeSet<usize>,
    shapes: usize,
    triangles: usize,
    lights: LightCounts,
    remarks: BTreeSet<Remark>,
}

/// Exports `scene` at the time of `settings` to `folder`.
///
/// # Errors
/// If a file cannot be written; names it. An earlier export in the folder is unchanged then.
pub fn export_mitsuba(
    scene: &Scene,
    settings: &ExportSettings,
    folder: &ExportFolder,
) -> Result<ExportReport, ExportError> {
    let pose = scene.pose(settings.time);
    let mut export = Export::new(scene, &pose, settings);
    let documents = export.documents();
    let report = export.report();
    let mut staging = folder.begin()?;
    for (name, content) in &export.files {
        staging.write(name, |output| export.write_file(content, output))?;
    }
    for (name, document) in &documents {
        staging.write(name, |output| document.write(output))?;
    }
    if report.special > 0 {
        staging.write(PLUGIN_FILE, |output| output.write_all(PLUGIN))?;
    }
    staging.complete(&report)?;
    Ok(report)
}

/// The scene itself, within the folder.
pub const SCENE_FILE: &str = "scene.xml";

/// What makes materials exact that Mitsuba does not have; renders the scene when run by itself.
pub const PLUGIN_FILE: &str = "glowworm_bsdf.py";

const PLUGIN: &[u8] = include_bytes!("glowworm_bsdf.py");

/// The materials that Mitsuba does not have, for Mitsuba alone and for [`PLUGIN_FILE`].
const MATERIAL_FILES: [(&str, Reader); 2] =
    [("materials.xml", Reader::Plain), ("materials-glowworm.xml", Reader::Exact)];

/// Every file that may be in the folder itself.
const OWN_FILES: [&str; 5] = [SCENE_FILE, REPORT_FILE, PLUGIN_FILE, MATERIAL_FILES[0].0, MATERIAL_FILES[1].0];

impl<'a> Export<'a> {
    fn new(scene: &'a Scene, pose: &'a Pose, settings: &'a ExportSettings) -> Self {
        let is_hidden = |light: &Light| match light.kind {
            LightKind::Area { instance, .. } => !scene.instances[instance].visible,
            LightKind::Point { .. } => light.radius > 0.0,
            _ => false,
        };
        Self {
            scene,
            pose,
            settings,
            hides_emitters: pose.lights.iter().any(is_hidden),
            files: BTreeMap::new(),
            images: Vec::new(),
            used_materials: BTreeSet::new(),
            coloured: scene
                .meshes
                .iter()
                .filter(|mesh| !mesh.colours.is_empty())
                .flat_map(|mesh| mesh.triangle_materials.iter().copied())
                .collect(),
            groups: BTreeSet::new(),
            remarks: BTreeSet::new(),
            shapes: 0,
            triangles: 0,
            lights: LightCounts::default(),
        }
    }

    /// The documents with their names: `scene.xml`, and materials that Mitsuba does not have.
    fn documents(&mut self) -> Vec<(&'static str, Element)> {
        if self.scene.bounding_sphere(self.pose).radius < SMALL_RADIUS {
            self.remarks.insert(Remark::RayOffset);
        }
        let shapes = self.shapes();
        let mut emitters = self.emitters();
        emitters.extend(self.environment());
        let special = self.special_materials();
        let plain: Vec<u32> = self.used_materials.difference(&special).copied().collect();
        let bsdfs: Vec<Element> = plain.into_iter().map(|index| self.bsdf(index, Reader::Plain)).collect();
        let remarks = self.head();
        let scene = |remarks: &[String]| {
            let scene = Element::new("scene").attribute("version", "3.0.0");
            remarks.iter().fold(scene, |scene, remark| scene.comment(remark))
        };
        let mut documents = Vec::new();
        let mut include = None;
        if !special.is_empty() {
            for (name, reader) in MATERIAL_FILES {
                let bsdfs: Vec<Element> = special.iter().map(|&index| self.bsdf(index, reader)).collect();
                documents.push((name, scene(&[]).children(bsdfs)));
            }
            let default = Element::new("default").attribute("name", "materials");
            include = Some([
                default.attribute("value", MATERIAL_FILES[0].0),
                Element::new("include").attribute("filename", "$materials"),
            ]);
        }
        let document = scene(&remarks)
            .children(self.defaults())
            .child(self.integrator())
            .child(self.sensor())
            .children(include.into_iter().flatten())
            .children(bsdfs)
            .children(emitters)
            .children(shapes);
        documents.push((SCENE_FILE, document));
        documents
    }

    /// Adds a file to write.
    fn add_file(&mut self, name: &str, content: Content) {
        self.files.insert(name.to_owned(), content);
    }

    fn write_file(&self, content: &Content, output: &mut dyn Write) -> io::Result<()> {
        match *content {
            Content::Mesh(part) => part.mesh(self).write(output),
            Content::Texture { texture, tint } => {
                materials::write_texture(&self.scene.textures[texture], tint, output)
            }
            Content::Channel { texture, channel, factor } => {
                materials::write_channel(&self.scene.textures[texture], channel, factor, output)
            }
            Content::Emission { texture, factor } => {
                materials::write_emission(&self.scene.textures[texture], factor, output)
            }
            Content::Mask(mask) => materials::write_mask(&self.scene.alpha_masks[mask], output),
            Content::Environment => self.write_environment(output),
        }
    }

    fn report(&self) -> ExportReport {
        let is_image = |content: &&Content| !matches!(content, Content::Mesh(_));
        let special = self.special_materials().len();
        let own = if special > 0 { &OWN_FILES[..] } else { &OWN_FILES[..2] };
        ExportReport {
            scene: self.scene.name.clone(),
            format: "mitsuba",
            frame: self.settings.frame,
            time: self.settings.time,
            size: self.settings.size,
            spp: self.settings.spp,
            integrator: self.integrator_name(),
            max_depth: self.max_depth(),
            special,
            background: self.background().to_array(),
            shapes: self.shapes,
            triangles: self.triangles,
            materials: self.used_materials.len(),
            textures: self.files.values().filter(is_image).count(),
            lights: self.lights,
            inexact: self.inexact(),
            files: own.iter().map(|&name| name.to_owned()).chain(self.files.keys().cloned()).collect(),
            commit: COMMIT,
        }
    }
}

/// A name that is valid in XML and as a file name: kind, index, and the valid part of `name`.
fn named(kind: &str, index: usize, name: &str) -> String {
    const LONGEST: usize = 40;
    let stem = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let safe = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let safe: String = safe.take(LONGEST).collect();
    if safe.is_empty() { format!("{kind}-{index}") } else { format!("{kind}-{index}-{safe}") }
}
