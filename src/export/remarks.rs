//! Remarks of an export: how to render it, and how the picture differs from glowworm's.

use std::collections::BTreeSet;

use glam::Vec3;

use super::exporter::{Export, PLUGIN_FILE};

/// In scenes of a smaller radius Mitsuba's ray offsets lose shadows.
pub(super) const SMALL_RADIUS: f32 = 0.1;

// Features of the scene that Mitsuba does not reproduce exactly, a sentence each.
pub(super) const RAY_OFFSET: &str = "Mitsuba offsets rays from surfaces by 9e-5 units and more, which loses shadows in a scene this small; \
     scale it up.";
pub(super) const ANCHOR: &str = "The scene is far from the origin, where floats are coarse: places here are relative to its middle, as glowworm renders it.";
pub(super) const FLIPPED_NORMALS: &str = "Where the shading normal of a smooth surface faces away from the camera at grazing angles, Mitsuba flips \
     that normal; glowworm does not.";
pub(super) const SPOT_FALLOFF: &str =
    "The falloff of a spot light is a sum of Mitsuba's spots, within 0.1 % of its intensity.";
pub(super) const SPOT_RADIUS: &str = "Spot lights with a radius are points here, so their shadows are hard.";
pub(super) const MIRRORED_LIGHTS: &str = "Lights with a radius or an angle are spheres and discs, which perfect mirrors show; in glowworm these do \
     not.";
pub(super) const WITHIN_SPHERES: &str =
    "Surfaces within the sphere of a point light get nothing of its light, but in glowworm all of it.";
pub(super) const FAR_DISCS: &str = "A directional light with an angle is a far disc, of 89 degrees at most; a camera whose far plane is \
     beyond shows it.";
pub(super) const SMOOTH_EMITTERS: &str =
    "What smooth surfaces emit follows their smooth normals in Mitsuba, their triangles in glowworm.";
pub(super) const EMITTERS_WITHOUT_REFLECTION: &str = "The camera sees emissive surfaces without the light that they reflect: it sees a copy of them, since \
     hide_emitters hides them with the portals and the spheres of lights.";
pub(super) const MASKED_EMISSION: &str =
    "In Mitsuba, parts of emissive surfaces that alpha hides emit nevertheless.";
pub(super) const ONE_SIDED_EMISSION: &str =
    "Surfaces that emit on both sides emit from their front alone in Mitsuba.";
pub(super) const BACKS: &str =
    "The camera sees the backs of single-sided surfaces, which glowworm's passes as if they were not there.";
pub(super) const CUT_TEXELS: &str = "Alpha masks cut out whole texels; in glowworm they are interpolated.";
pub(super) const HIDDEN_ENVIRONMENT: &str = "The camera does not see the environment, since hide_emitters hides it with the portals and the spheres \
     of lights.";
pub(super) const WRAP_MODES: &str =
    "Textures go on beyond their borders alike on both axes, as on the first.";
pub(super) const COORDINATES: &str =
    "Textures of one material with different coordinates have those of its first texture.";
pub(super) const VERTEX_ALPHA: &str = "The alpha of vertices is left out.";

impl Export<'_> {
    /// Every difference, a sentence each.
    pub(super) fn inexact(&self) -> Vec<String> {
        let mut inexact: Vec<String> = self.remarks.iter().map(|&remark| remark.to_owned()).collect();
        inexact.extend(self.remark_special());
        let background = self.background();
        if background != Vec3::ZERO {
            inexact.push(format!(
                "The background ({} {} {}) lights nothing in glowworm, so it is not an emitter here: add it, \
                 times 1 - alpha, to the picture.",
                background.x, background.y, background.z
            ));
        }
        inexact
    }

    /// The radiance that camera rays see beyond the scene and that is not an emitter.
    pub(super) fn background(&self) -> Vec3 {
        if self.scene.environment.is_some() { Vec3::ZERO } else { self.scene.background }
    }

    /// Used materials that Mitsuba does not have.
    pub(super) fn special_materials(&self) -> BTreeSet<u32> {
        self.used_materials.iter().copied().filter(|&material| self.is_special(material)).collect()
    }

    /// The remark on materials that Mitsuba does not have, if there are any.
    fn remark_special(&self) -> Option<String> {
        let of = match self.special_materials().len() {
            0 => return None,
            1 => "1 material".to_owned(),
            count => format!("{count} materials"),
        };
        Some(format!(
            "Mitsuba's own materials only come near {of}, which reflect by glTF's model or are thin surfaces. For the same \
             picture render with python {PLUGIN_FILE}, which brings that model."
        ))
    }

    /// The head of the file.
    pub(super) fn head(&self) -> Vec<String> {
        let settings = self.settings;
        let unfit = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
        let name = self.scene.name.replace(unfit, " ");
        let mut head = vec![
            format!(
                "{name}, frame {} ({} s), by glowworm export. Linear radiance, W/m^2/sr.",
                settings.frame, settings.time
            ),
            "Render it with: mitsuba scene.xml (or mitsuba -m llvm_ad_rgb -D spp=1024 -o picture.exr scene.xml)"
                .to_owned(),
        ];
        head.extend(self.inexact().into_iter().map(|difference| format!("Not exact: {difference}")));
        head
    }
}
