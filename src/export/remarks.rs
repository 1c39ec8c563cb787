//! What is said about an export: how to render it, and where the picture is not quite glowworm's.

use glam::Vec3;

use super::{Export, Specular};
use crate::scene::LightKind;

/// Something of the scene that Mitsuba cannot have exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Remark {
    /// The falloff of spots.
    SpotsArePolygons,
    /// Lamps that are shaded smoothly lose that.
    LampsAreFlat,
    /// Lamps that the camera sees by a copy do not show what they reflect.
    SeenLampsReflectNothing,
    /// Parts of lamps that are cut away emit.
    HolesShine,
}

impl Remark {
    fn text(self) -> &'static str {
        match self {
            Self::SpotsArePolygons => {
                "The falloff of a spot light is a sum of spots of Mitsuba, within 0.1 % of its intensity."
            }
            Self::LampsAreFlat => {
                "Surfaces that emit light are shaded flat: what they reflect shows their triangles."
            }
            Self::SeenLampsReflectNothing => {
                "The camera sees surfaces that emit light without what they reflect (a copy of them stands in, \
                 since hide_emitters hides them with the portals)."
            }
            Self::HolesShine => {
                "Parts of light-emitting surfaces that an alpha mask cuts away emit nevertheless."
            }
        }
    }
}

impl Export<'_> {
    /// Every difference, a sentence each.
    pub(super) fn inexact(&self) -> Vec<String> {
        let mut inexact: Vec<String> = self.remarks.iter().map(|remark| remark.text().to_owned()).collect();
        inexact.extend(self.highlights());
        let background = self.scene.background;
        if background != Vec3::ZERO {
            inexact.push(format!(
                "The background ({} {} {}) lights nothing in glowworm, so it is no emitter here: add it, times \
                 1 - alpha, to the picture.",
                background.x, background.y, background.z
            ));
        }
        inexact
    }

    /// What became of the highlights, unless that changes nothing.
    fn highlights(&self) -> Option<String> {
        let materials = &self.scene.materials;
        let shiny =
            self.used_materials.iter().filter(|&&m| materials[m as usize].specular != Vec3::ZERO).count();
        let makes_highlights = |kind: &LightKind| !matches!(kind, LightKind::Area { .. });
        let seen = self.scene.lights.iter().any(|light| makes_highlights(&light.kind));
        let only = "glowworm's reflect light straight from point, spot and directional lights on the visible \
                    surface alone";
        match self.settings.specular {
            Specular::Omit if shiny > 0 && seen => Some(format!(
                "The highlights of {shiny} materials are left out: {only}, to which no BSDF can be limited."
            )),
            Specular::Convert if shiny > 0 => {
                let dimmed = match self.dimmed_highlights {
                    0 => String::new(),
                    dimmed => format!(
                        " Those of {dimmed} materials are weaker than they were, since with the diffuse part \
                         they would reflect more light than arrives."
                    ),
                };
                Some(format!(
                    "The highlights of {shiny} materials are rough conductors (Beckmann, alpha^2 = 2 / (Ns + 2)), \
                     which reflect all light; {only}.{dimmed}"
                ))
            }
            _ => None,
        }
    }

    /// The head of the file.
    pub(super) fn head(&self) -> Vec<String> {
        let settings = self.settings;
        let name: String = self.scene.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
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
