//! Remarks of an export: how to render it, and how the picture differs from glowworm's.

use std::collections::BTreeSet;

use glam::Vec3;

use super::{Export, PLUGIN_FILE};

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
    /// Spot lights have no radius.
    SpotRadius,
    /// Mirrors show the spheres and discs of point and directional lights.
    MirroredLights,
    /// Within its sphere a point light shines on nothing.
    WithinSpheres,
    /// The disc of a directional light is at some distance.
    FarDiscs,
    /// Emissive surfaces are taken to emit from the side of their smooth normals.
    SmoothEmitters,
    /// Emissive surfaces that the camera sees as copies show no reflected light.
    EmittersWithoutReflection,
    /// Masked parts of emissive surfaces emit.
    MaskedEmission,
    /// The camera does not see the environment.
    HiddenEnvironment,
    /// A texture has one wrap mode.
    WrapModes,
    /// A surface has one set of texture coordinates.
    Coordinates,
    /// Alpha of vertices is lost.
    VertexAlpha,
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
            Self::SpotRadius => "Spot lights with a radius are points here, so their shadows are hard.",
            Self::MirroredLights => {
                "Lights with a radius or an angle are spheres and discs, which perfect mirrors show; in glowworm these do \
                 not."
            }
            Self::WithinSpheres => {
                "Surfaces within the sphere of a point light get nothing of its light, but in glowworm all of it."
            }
            Self::FarDiscs => {
                "A directional light with an angle is a far disc, of 89 degrees at most; a camera whose far plane is \
                 beyond shows it."
            }
            Self::SmoothEmitters => {
                "What smooth surfaces emit follows their smooth normals in Mitsuba, their triangles in glowworm."
            }
            Self::EmittersWithoutReflection => {
                "The camera sees emissive surfaces without the light that they reflect: it sees a copy of them, since \
                 hide_emitters hides them with the portals and the spheres of lights."
            }
            Self::MaskedEmission => {
                "In Mitsuba, parts of emissive surfaces that an alpha mask hides emit nevertheless."
            }
            Self::WrapModes => "Textures go on beyond their borders alike on both axes, as on the first.",
            Self::Coordinates => {
                "Textures of one material with different coordinates have those of its first texture."
            }
            Self::VertexAlpha => "The alpha of vertices is left out.",
            Self::HiddenEnvironment => {
                "The camera does not see the environment, since hide_emitters hides it with the portals and the spheres \
                 of lights."
            }
        }
    }
}

impl Export<'_> {
    /// Every difference, a sentence each.
    pub(super) fn inexact(&self) -> Vec<String> {
        let mut inexact: Vec<String> = self.remarks.iter().map(|remark| remark.text().to_owned()).collect();
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

    /// What camera rays see beyond the scene that is not an emitter.
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
