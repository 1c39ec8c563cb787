//! What is said about an export: how to render it, and where the picture is not quite glowworm's.

use glam::Vec3;

use super::{Export, Specular};
use crate::scene::{Light, LightKind};

/// Scenes of a smaller radius than this suffer from how far Mitsuba moves rays off surfaces.
pub(super) const SMALL_RADIUS: f32 = 0.1;

/// Something of the scene that Mitsuba cannot have exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Remark {
    /// The scene is small.
    RaysStartFarOff,
    /// Shading normals that look away from the camera.
    NormalsTurn,
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
            Self::RaysStartFarOff => {
                "Mitsuba moves rays off surfaces by 9e-5 units and more, which loses shadows in a scene as small \
                 as this; scale it up."
            }
            Self::NormalsTurn => {
                "Where a smooth surface is seen so flatly that its shading normal looks away, Mitsuba turns that \
                 normal over; glowworm does not."
            }
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
        inexact.extend(self.remark_highlights());
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

    /// Materials in use whose highlights (Ks, Ns) glowworm shows.
    pub(super) fn highlights(&self) -> usize {
        let has_no_area = |light: &Light| !matches!(light.kind, LightKind::Area { .. });
        if self.scene.lights.iter().any(has_no_area) { self.shiny_materials() } else { 0 }
    }

    fn shiny_materials(&self) -> usize {
        let specular = |&&material: &&u32| self.scene.materials[material as usize].specular;
        self.used_materials.iter().filter(|material| specular(material) != Vec3::ZERO).count()
    }

    /// What became of the highlights, unless that changes nothing.
    fn remark_highlights(&self) -> Option<String> {
        let only = "glowworm's reflect light straight from point, spot and directional lights on the visible \
                    surface alone";
        match self.settings.specular {
            Specular::Omit if self.highlights() > 0 => {
                let of = materials(self.highlights());
                Some(format!("The highlights of {of} are left out: {only}, to which no BSDF can be limited."))
            }
            Specular::Convert if self.shiny_materials() > 0 => {
                let of = materials(self.shiny_materials());
                let dimmed = match self.dimmed_highlights {
                    0 => String::new(),
                    dimmed => format!(
                        " Those of {} are weaker than they were, since with the diffuse part they would \
                         reflect more light than arrives.",
                        materials(dimmed)
                    ),
                };
                Some(format!(
                    "The highlights of {of} are rough conductors (Beckmann, alpha^2 = 2 / (Ns + 2)), which \
                     reflect all light; {only}.{dimmed}"
                ))
            }
            _ => None,
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
