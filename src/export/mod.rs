//! Exports a scene at one time for Mitsuba 3: `scene.xml`, meshes as PLY, textures as PNG.
//!
//! In: a scene, a time, and picture settings. Out: a folder that Mitsuba 3 (tested with 3.9) renders to the same
//! radiance: the same geometry, materials, lights, units, camera and bounce limit. [`ExportReport::inexact`] and the
//! head of `scene.xml` list the differences. Materials that Mitsuba does not have are written twice: as its nearest ones,
//! which `scene.xml` includes, and for [`PLUGIN_FILE`], which is in the folder and makes them exact.
//!
//! Numbers in the XML are 32-bit floats that round-trip.

mod exporter;
mod folder;
mod lights;
mod materials;
mod ply;
mod remarks;
mod shapes;
mod spot;
mod view;
mod xml;

pub use exporter::{ExportReport, ExportSettings, LightCounts, PLUGIN_FILE, SCENE_FILE};
pub use folder::{ExportError, ExportFolder};

use std::io::{self, Write};

use glam::Vec3;

use crate::report::COMMIT;
use crate::scene::Scene;
use exporter::{Content, Export, MATERIAL_FILES, OWN_FILES, REPORT_FILE, Reader};
use xml::Element;

const PLUGIN: &[u8] = include_bytes!("glowworm_bsdf.py");

/// Exports `scene` at the time of `settings` to `folder`.
///
/// # Errors
/// If a file cannot be written; names it. An earlier export in the folder is unchanged then.
pub fn export_mitsuba(
    scene: &Scene,
    settings: &ExportSettings,
    folder: &ExportFolder,
) -> Result<ExportReport, ExportError> {
    let (pose, anchor) = (scene.pose(settings.time), scene.anchor());
    let pose = pose.about(anchor);
    let mut export = Export::new(scene, &pose, settings);
    if anchor != Vec3::ZERO {
        export.remarks.insert(remarks::ANCHOR);
    }
    let documents = export.documents();
    let report = export.report();
    folder.replace(|staging| {
        for (name, content) in &export.files {
            staging.write(name, |output| export.write_file(content, output))?;
        }
        for (name, document) in &documents {
            staging.write(name, |output| document.write(output))?;
        }
        if report.special > 0 {
            staging.write(PLUGIN_FILE, |output| output.write_all(PLUGIN))?;
        }
        staging.write(REPORT_FILE, |output| {
            serde_json::to_writer_pretty(&mut *output, &report)?;
            writeln!(output)
        })
    })?;
    Ok(report)
}

impl Export<'_> {
    /// The documents with their names: `scene.xml`, and materials that Mitsuba does not have.
    fn documents(&mut self) -> Vec<(&'static str, Element)> {
        if self.scene.bounding_sphere(self.pose).radius < remarks::SMALL_RADIUS {
            self.remarks.insert(remarks::RAY_OFFSET);
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
