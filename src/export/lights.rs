//! Point, spot and directional lights and the environment as Mitsuba's emitters.
//!
//! In: the lights of the pose. Out: an `<emitter>` for each point and directional light; several for a spot
//! (see [`super::spot`]). Area lights are shapes. The environment is a `constant` or an `envmap`.
//!
//! A light with an extent becomes a `null` shape that emits. A sphere of radius r at the distance d sends the irradiance
//! pi L (r/d)^2 across the direction to its centre, so for a point light L = I / (pi r^2): exactly what
//! [`crate::scene::LightCone`] samples. For a directional light of half angle theta it is a disc of radius d tan theta at
//! a large distance d, with L = E / (pi sin^2 theta).

use std::f32::consts::PI;
use std::io::{self, Write};

use glam::{Affine3A, Mat3, Vec3};

use super::exporter::{Content, Export, named};
use super::materials::write_environment;
use super::remarks;
use super::spot::{Ramp, ramps};
use super::xml::Element;
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
                    emitters.push(self.point(light, id, *intensity));
                }
                LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => {
                    self.lights.spot += 1;
                    self.remarks.insert(remarks::SPOT_FALLOFF);
                    if light.radius > 0.0 {
                        self.remarks.insert(remarks::SPOT_RADIUS);
                    }
                    let ramps = ramps(*inner_angle, *outer_angle, *falloff);
                    emitters.extend(spot(light, &id, *intensity, ramps));
                }
                LightKind::Directional { irradiance } => {
                    self.lights.directional += 1;
                    emitters.push(self.directional(light, id, *irradiance));
                }
                LightKind::Area { instance, .. } => {
                    let seen = self.scene.instances[*instance].visible;
                    *(if seen { &mut self.lights.area } else { &mut self.lights.portal }) += 1;
                }
            }
        }
        emitters
    }

    fn point(&mut self, light: &Light, id: String, intensity: Vec3) -> Element {
        if light.radius == 0.0 {
            return Element::plugin("emitter", "point")
                .attribute("id", id)
                .coordinates("point", "position", light.position)
                .rgb("intensity", intensity);
        }
        self.remarks.extend([remarks::MIRRORED_LIGHTS, remarks::WITHIN_SPHERES]);
        let sphere = Element::plugin("shape", "sphere")
            .attribute("id", id)
            .coordinates("point", "center", light.position)
            .float("radius", light.radius);
        shining(sphere, intensity / (PI * light.radius * light.radius))
    }

    fn directional(&mut self, light: &Light, id: String, irradiance: Vec3) -> Element {
        if light.half_angle == 0.0 {
            return Element::plugin("emitter", "directional")
                .attribute("id", id)
                .coordinates("vector", "direction", light.direction)
                .rgb("irradiance", irradiance);
        }
        self.remarks.extend([remarks::MIRRORED_LIGHTS, remarks::FAR_DISCS]);
        let bounds = self.scene.bounding_sphere(self.pose);
        let distance = FAR * bounds.radius;
        let (sine, cosine) = light.half_angle.min(WIDEST).sin_cos();
        let (x, y) = light.direction.any_orthonormal_pair();
        let axes = Mat3::from_cols(x, y, light.direction) * (distance * sine / cosine);
        let place = Affine3A::from_mat3_translation(axes, bounds.center - light.direction * distance);
        let disc = Element::plugin("shape", "disk").attribute("id", id).placed(&place);
        shining(disc, irradiance / (PI * sine * sine))
    }

    /// The emitter of the environment, if there is one.
    pub(super) fn environment(&mut self) -> Option<Element> {
        let environment = self.scene.environment.as_ref()?;
        if self.hides_emitters {
            self.remarks.insert(remarks::HIDDEN_ENVIRONMENT);
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

/// Distance of the disc of a directional light, in radii of the scene: seen from all of it in about the same direction.
const FAR: f32 = 1e4;

/// Largest half angle, radians: a plane that fills the hemisphere has no end.
const WIDEST: f32 = 1.55;

/// A shape as an emitter that rays pass through, as through a portal.
fn shining(shape: Element, radiance: Vec3) -> Element {
    shape
        .child(Element::plugin("bsdf", "null"))
        .child(Element::plugin("emitter", "area").rgb("radiance", radiance))
}

/// The map of the environment, within the folder.
const ENVIRONMENT_FILE: &str = "textures/environment.exr";

/// The Mitsuba spots whose sum is one spot light; together they have the sampling weight of one light.
fn spot(light: &Light, id: &str, intensity: Vec3, ramps: Vec<Ramp>) -> Vec<Element> {
    let (x, y) = light.direction.any_orthonormal_pair();
    let place = Affine3A::from_mat3_translation(Mat3::from_cols(x, y, light.direction), light.position);
    ramps
        .into_iter()
        .enumerate()
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
