//! Delta lights and the environment as Mitsuba's emitters.
//!
//! In: the lights of the pose. Out: an `<emitter>` for each point and directional light; several for a spot
//! (see [`super::spot`]). Area lights are shapes. The environment is a `constant` or an `envmap`.

use std::io::{self, Write};

use glam::{Affine3A, Mat3, Vec3};

use super::materials::write_environment;
use super::spot::ramps;
use super::xml::Element;
use super::{Content, Export, Remark, named};
use crate::scene::{Light, LightKind};

impl Export<'_> {
    /// The emitters of all lights but area lights; counts all lights.
    pub(super) fn emitters(&mut self) -> Vec<Element> {
        let mut emitters = Vec::new();
        for (index, light) in self.pose.lights.iter().enumerate() {
            let id = named("light", index, &light.name);
            match &light.kind {
                LightKind::Point { intensity } => {
                    self.lights.point += 1;
                    emitters.push(
                        Element::plugin("emitter", "point")
                            .attribute("id", id)
                            .coordinates("point", "position", light.position)
                            .rgb("intensity", *intensity),
                    );
                }
                LightKind::Spot { intensity, inner_angle, outer_angle } => {
                    self.lights.spot += 1;
                    self.remarks.insert(Remark::SpotFalloff);
                    emitters.extend(spot(light, &id, *intensity, [*inner_angle, *outer_angle]));
                }
                LightKind::Directional { irradiance } => {
                    self.lights.directional += 1;
                    emitters.push(
                        Element::plugin("emitter", "directional")
                            .attribute("id", id)
                            .coordinates("vector", "direction", light.direction)
                            .rgb("irradiance", *irradiance),
                    );
                }
                LightKind::Area { instance, .. } => {
                    let seen = self.scene.instances[*instance].visible;
                    *(if seen { &mut self.lights.area } else { &mut self.lights.portal }) += 1;
                }
            }
        }
        emitters
    }

    /// The emitter of the environment, if there is one.
    pub(super) fn environment(&mut self) -> Option<Element> {
        let environment = self.scene.environment.as_ref()?;
        if self.has_portals {
            self.remarks.insert(Remark::HiddenEnvironment);
        }
        if environment.map.is_none() {
            return Some(Element::plugin("emitter", "constant").rgb("radiance", environment.radiance));
        }
        self.add_file(ENVIRONMENT_FILE, Content::Environment);
        // The middle of Mitsuba's maps lies towards +z, that of glowworm's towards -z.
        let turn = Affine3A::from_rotation_y(environment.rotation + std::f32::consts::PI);
        Some(Element::plugin("emitter", "envmap").string("filename", ENVIRONMENT_FILE).placed(&turn))
    }

    pub(super) fn write_environment(&self, output: &mut dyn Write) -> io::Result<()> {
        let environment = self.scene.environment.as_ref();
        let found =
            environment.and_then(|environment| Some((environment.map.as_deref()?, environment.radiance)));
        let (map, factor) = found.ok_or_else(|| io::Error::other("no environment map"))?;
        write_environment(map, factor, output)
    }
}

/// The map of the environment, within the folder.
const ENVIRONMENT_FILE: &str = "textures/environment.exr";

/// The Mitsuba spots whose sum is one spot light; together they have the sampling weight of one light.
fn spot(light: &Light, id: &str, intensity: Vec3, [inner, outer]: [f32; 2]) -> Vec<Element> {
    let (x, y) = light.direction.any_orthonormal_pair();
    let place = Affine3A::from_mat3_translation(Mat3::from_cols(x, y, light.direction), light.position);
    let ramps = ramps(inner, outer).into_iter().enumerate();
    ramps
        .map(|(index, ramp)| {
            Element::plugin("emitter", "spot")
                .attribute("id", format!("{id}-{index}"))
                .placed(&place)
                .rgb("intensity", intensity * ramp.share as f32)
                .float("beam_width", ramp.beam.to_degrees() as f32)
                .float("cutoff_angle", ramp.cutoff.to_degrees() as f32)
                .float("sampling_weight", ramp.share as f32)
        })
        .collect()
}
