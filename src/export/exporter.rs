//! An export in progress, shared by the exporters of lights, materials and shapes.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;
use indexmap::IndexSet;
use serde::Serialize;

use crate::scene::{Light, LightKind, Pose, Scene};

/// Settings of the exported picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportSettings {
    /// Frame of the animation, for the report.
    pub frame: u64,
    /// Time, seconds.
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
    /// Time, seconds.
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
    /// Commit of the program, see [`crate::report::COMMIT`].
    pub commit: &'static str,
}

/// The report of the export, within its folder.
pub(super) const REPORT_FILE: &str = "glowworm-export.json";

/// The scene itself, within the folder.
pub const SCENE_FILE: &str = "scene.xml";

/// The plugin that makes materials exact which Mitsuba does not have; it renders the scene when run by itself.
pub const PLUGIN_FILE: &str = "glowworm_bsdf.py";

/// The materials that Mitsuba does not have, for Mitsuba alone and for [`PLUGIN_FILE`].
pub(super) const MATERIAL_FILES: [(&str, Reader); 2] =
    [("materials.xml", Reader::Plain), ("materials-glowworm.xml", Reader::Exact)];

/// Every file that may be in the folder itself.
pub(super) const OWN_FILES: [&str; 5] =
    [SCENE_FILE, REPORT_FILE, PLUGIN_FILE, MATERIAL_FILES[0].0, MATERIAL_FILES[1].0];

/// The program that a BSDF is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reader {
    /// Mitsuba with glowworm_bsdf.py.
    Exact,
    /// Mitsuba alone.
    Plain,
}

/// The triangles of one material, in one file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// The mesh, or for an emissive surface the instance.
    pub(super) owner: Owner,
    /// Index of the material.
    pub(super) material: u32,
}

/// The owner of the triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Owner {
    /// A mesh, in object space.
    Mesh(usize),
    /// An instance, in world space, offset backwards by this many steps; flat unless `smooth`.
    Instance { index: usize, steps: u32, smooth: bool },
}

/// The content of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
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
pub(super) struct Export<'a> {
    pub(super) scene: &'a Scene,
    pub(super) pose: &'a Pose,
    pub(super) settings: &'a ExportSettings,
    /// Whether `hide_emitters` hides portals and the spheres of point lights.
    pub(super) hides_emitters: bool,
    pub(super) files: BTreeMap<String, Content>,
    /// Images of textures; the index is the number in the file's name.
    pub(super) images: Vec<Content>,
    pub(super) used_materials: BTreeSet<u32>,
    /// Materials of meshes whose vertices have colours.
    pub(super) coloured: BTreeSet<u32>,
    /// Meshes exported as shape groups.
    pub(super) groups: BTreeSet<usize>,
    pub(super) shapes: usize,
    pub(super) triangles: usize,
    pub(super) lights: LightCounts,
    /// Differences from the scene, a sentence each.
    pub(super) remarks: IndexSet<&'static str>,
}

impl<'a> Export<'a> {
    pub(super) fn new(scene: &'a Scene, pose: &'a Pose, settings: &'a ExportSettings) -> Self {
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
            remarks: IndexSet::new(),
            shapes: 0,
            triangles: 0,
            lights: LightCounts::default(),
        }
    }

    /// Adds a file to write.
    pub(super) fn add_file(&mut self, name: &str, content: Content) {
        self.files.insert(name.to_owned(), content);
    }
}

/// A name that is valid in XML and as a file name: kind, index, and the valid part of `name`.
pub(super) fn named(kind: &str, index: usize, name: &str) -> String {
    const LONGEST: usize = 40;
    let stem = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let safe = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    let safe: String = safe.take(LONGEST).collect();
    if safe.is_empty() { format!("{kind}-{index}") } else { format!("{kind}-{index}-{safe}") }
}
