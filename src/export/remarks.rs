//! Remarks of an export: how to render it, and how the picture differs from glowworm's.

use glam::Vec3;

use super::{Export, Specular};

/// In scenes of a smaller radius Mitsuba's ray offsets lose shadows.
pub(super) const SMALL_RADIUS: f32 = 0.1;

/// A feature of the scene that Mitsuba does not reproduce exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Remark {
    /// The ray offset is large relative to a small scene.
    RayOffset,
    /// Shading normals that face away from the camera are flipped.
    FlippedNormals,
    /// The falloff of spot lights is piecewise linear.
    SpotFalloff,
    /// Emissive surfaces lose smooth shading.
    FlatEmitters,
    /// Emissive surfaces that the camera sees as copies show no reflected light.
    EmittersWithoutReflection,
    /// Masked parts of emissive surfaces emit.
    MaskedEmission,
}

impl Remark {
    fn text(self) -> &'static str {
        match self {
            Self::RayOffset => {
                "Mitsuba offsets rays from surfaces by 9e-5 units and more, which loses shadows in a scene this small; \
                 scale it up."
            }
            Self::FlippedNormals => {
                "Where the shading normal of a smooth surface faces away from the camera at grazing angles, Mitsuba \
                 flips that normal; glowworm does not."
            }
            Self::SpotFalloff => {
                "The falloff of a spot light is a sum of Mitsuba's spots, within 0.1 % of its intensity."
            }
            Self::FlatEmitters => "Emissive surfaces are shaded flat: reflected light shows their triangles.",
            Self::EmittersWithoutReflection => {
                "The camera sees emissive surfaces without the light that they reflect: it sees a copy of them, since \
                 hide_emitters hides them with the portals."
            }
            Self::MaskedEmission => {
                "In Mitsuba, parts of emissive surfaces that an alpha mask hides emit nevertheless."
            }
        }
    }
}

impl Export<'_> {
    /// Every difference, a sentence each.
    pub(super) fn inexact(&self) -> Vec<String> {
        let mut inexact: Vec<String> = self.remarks.iter().map(|remark| remark.text().to_owned()).collect();
        inexact.extend(self.remark_highlights());
        let background = self.scene.background;
        if self.scene.environment.is_some() {
            inexact.push("The environment is left out.".to_owned());
        } else if background != Vec3::ZERO {
            inexact.push(format!(
                "The background ({} {} {}) lights nothing in glowworm, so it is not an emitter here: add it, \
                 times 1 - alpha, to the picture.",
                background.x, background.y, background.z
            ));
        }
        inexact
    }

    /// Number of used materials with a GGX lobe.
    pub(super) fn highlights(&self) -> usize {
        let reflects =
            |&&material: &&u32| self.scene.materials[material as usize].mean_bsdf(self.scene).reflects();
        self.used_materials.iter().filter(reflects).count()
    }

    /// The remark on GGX lobes, if there are any.
    fn remark_highlights(&self) -> Option<String> {
        let of = materials(self.highlights());
        match self.settings.specular {
            _ if self.highlights() == 0 => None,
            Specular::Omit => Some(format!("What the GGX lobes of {of} reflect is omitted.")),
            Specular::Convert => Some(format!(
                "The GGX lobes of {of} are rough conductors beside a diffuse part: the mean reflectance is the same, but \
                 not that at each angle."
            )),
        }
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

fn materials(count: usize) -> String {
    if count == 1 { "1 material".to_owned() } else { format!("{count} materials") }
}
