//! Integrator, camera, film and sampler.

use glam::Vec3;

use super::exporter::Export;
use super::xml::{Element, numbers};

impl Export<'_> {
    /// The parameters that `mitsuba -D name=value` changes.
    pub(super) fn defaults(&self) -> [Element; 2] {
        let default =
            |name, value: String| Element::new("default").attribute("name", name).attribute("value", value);
        [default("spp", self.settings.spp.to_string()), default("max_depth", self.max_depth().to_string())]
    }

    /// Mitsuba's `max_depth`: edges of the longest light path, from the light to the camera, which is bounces + 2.
    /// -1: no limit.
    pub(super) fn max_depth(&self) -> i64 {
        self.settings.bounces.map_or(-1, |bounces| i64::from(bounces) + 2)
    }

    /// `path`; or `volpath` with portals, lights with an extent, masks or thin surfaces, which does not count passing through
    /// them as a bounce.
    pub(super) fn integrator_name(&self) -> &'static str {
        let used = |&material: &u32| {
            let material = &self.scene.materials[material as usize];
            material.alpha_mask.is_some() || material.is_thin_surface()
        };
        let has_discs = self.pose.lights.iter().any(|light| light.half_angle > 0.0);
        if self.hides_emitters || has_discs || self.used_materials.iter().any(used) {
            "volpath"
        } else {
            "path"
        }
    }

    pub(super) fn integrator(&self) -> Element {
        // Russian roulette only without a bounce limit.
        let roulette = if self.settings.bounces.is_some() { i32::MAX } else { 5 };
        let integrator = Element::plugin("integrator", self.integrator_name())
            .integer("max_depth", "$max_depth")
            .integer("rr_depth", roulette);
        if self.hides_emitters { integrator.boolean("hide_emitters", true) } else { integrator }
    }

    pub(super) fn sensor(&self) -> Element {
        let camera = &self.pose.camera;
        let place = Element::new("lookat")
            .attribute("origin", numbers(&camera.eye.to_array()))
            .attribute("target", numbers(&camera.target.to_array()))
            .attribute("up", numbers(&camera.up.to_array()));
        // Alpha is needed to add the background.
        let has_background = self.background() != Vec3::ZERO;
        let film = Element::plugin("film", "hdrfilm")
            .integer("width", self.settings.size[0])
            .integer("height", self.settings.size[1])
            .string("pixel_format", if has_background { "rgba" } else { "rgb" })
            .string("component_format", "float32")
            .child(Element::plugin("rfilter", "box"));
        let bounds = self.scene.bounding_sphere(self.pose);
        let far = camera.far.min(1.01 * (camera.eye.distance(bounds.center) + bounds.radius));
        Element::plugin("sensor", "perspective")
            .string("fov_axis", "y")
            .float("fov", camera.vertical_fov.to_degrees())
            .float("near_clip", camera.near)
            .float("far_clip", far)
            .child(Element::new("transform").attribute("name", "to_world").child(place))
            .child(Element::plugin("sampler", "multijitter").integer("sample_count", "$spp"))
            .child(film)
    }
}
