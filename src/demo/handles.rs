//! Manipulation handles: arrows to move the selection, rings to rotate it, and light markers.
//!
//! In: the session and the pointer. Out: the handle under the pointer, and the selected entry after a drag.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui};
use glam::{Mat4, Quat, Vec2, Vec3, Vec3Swizzles, Vec4Swizzles};

use super::session::{Selected, Session};
use crate::bvh::Ray;
use crate::formats::{AxisAngle, InstanceEntry, LightEntry, RotationEntry};
use crate::scene::LightKind;

/// Length of arrows and radius of rings, as a fraction of the picture's height at the pivot.
const REACH: f32 = 0.18;
/// Pick distance, points.
const GRIP: f32 = 9.0;
/// Segments of a ring.
const RING: usize = 40;
const COLOURS: [Color32; 3] =
    [Color32::from_rgb(240, 80, 80), Color32::from_rgb(90, 210, 90), Color32::from_rgb(90, 140, 255)];
const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

/// Mode of the handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Mode {
    #[default]
    Move,
    Turn,
}

/// A drag of a handle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HandleDrag {
    mode: Mode,
    axis: Vec3,
    pivot: Vec3,
    /// Position along the axis, or angle about it, at the start of the drag.
    start: f32,
    original: Entry,
}

/// A document entry, as at the start of the drag.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Entry {
    Instance(usize, InstanceEntry),
    Light(usize, LightEntry),
}

/// Projection from world space to window points.
pub(super) struct Projector {
    view_projection: Mat4,
    viewport: Rect,
}

impl Projector {
    /// For a picture in `viewport`, points.
    pub fn new(session: &Session, viewport: Rect) -> Self {
        Self { view_projection: session.view_projection(), viewport }
    }

    /// Projects a point; none behind the camera.
    pub fn point(&self, world: Vec3) -> Option<Pos2> {
        let clip = self.view_projection * world.extend(1.0);
        let at = clip.xy() / clip.w * 0.5 + 0.5;
        let place = egui::vec2(at.x, at.y) * self.viewport.size();
        (clip.w > 1e-6 && at.is_finite()).then(|| self.viewport.min + place)
    }
}

/// Polyline of one axis' handle, world space.
fn lines(mode: Mode, pivot: Vec3, axis: Vec3, reach: f32) -> Vec<Vec3> {
    match mode {
        Mode::Move => vec![pivot, pivot + axis * reach],
        Mode::Turn => {
            let side = axis.yzx() * reach;
            let corner = |i: usize| {
                let angle = i as f32 / RING as f32 * std::f32::consts::TAU;
                pivot + Quat::from_axis_angle(axis, angle) * side
            };
            (0..=RING).map(corner).collect()
        }
    }
}

/// Length of handles at `pivot`, scene units.
fn reach(session: &Session, pivot: Vec3) -> f32 {
    let camera = &session.pose.camera;
    let depth = (pivot - camera.eye).dot(camera.forward()).max(camera.near);
    REACH * 2.0 * depth * (0.5 * camera.vertical_fov).tan()
}

/// Draws light markers, and the bounding box, handles and name of the selection.
pub(super) fn paint(ui: &Ui, session: &Session, viewport: Rect, mode: Mode) {
    let projector = Projector::new(session, viewport);
    let painter = ui.painter().with_clip_rect(viewport);
    for light in 0..session.document.lights().len() {
        let selected = session.selected == Some(Selected::Light(light));
        if let Some(at) = mark(session, &projector, light) {
            painter.circle(at, 5.0, light_colour(session, light), Stroke::new(1.5, edge(selected)));
        }
    }
    let Some(selected) = session.selected else { return };
    paint_box(&painter, session, &projector, selected);
    let Some(pivot) = session.place_of(selected) else { return };
    paint_name(&painter, &session.name_of(selected), projector.point(pivot));
    let reach = reach(session, pivot);
    for (axis, colour) in AXES.into_iter().zip(COLOURS) {
        let points: Option<Vec<Pos2>> =
            lines(mode, pivot, axis, reach).into_iter().map(|point| projector.point(point)).collect();
        let Some(points) = points else { continue };
        if mode == Mode::Move
            && let [from, to] = points[..]
        {
            painter.arrow(from, to - from, Stroke::new(2.5, colour));
        } else {
            painter.line(points, Stroke::new(2.0, colour));
        }
    }
}

fn edge(selected: bool) -> Color32 {
    if selected { Color32::from_rgb(255, 200, 0) } else { Color32::from_black_alpha(160) }
}

/// Window position of the marker of a light without a surface.
fn mark(session: &Session, projector: &Projector, light: usize) -> Option<Pos2> {
    let known = session.pose.lights.get(session.document.scene_light(light)?)?;
    let has_place = matches!(known.kind, LightKind::Point { .. } | LightKind::Spot { .. });
    // The headlamp is at the camera itself.
    (has_place && session.headlamp != Some(light)).then(|| projector.point(known.position)).flatten()
}

fn light_colour(session: &Session, light: usize) -> Color32 {
    let power = session.document.lights().nth(light).and_then(|light| light.intensity.or(light.irradiance));
    let power = Vec3::from_array(power.unwrap_or([1.0; 3]));
    let [r, g, b] = (power / power.max_element().max(1e-9)).to_array().map(crate::scene::linear_to_srgb);
    Color32::from_rgb(r, g, b)
}

/// Writes the name of the selection below its pivot.
fn paint_name(painter: &Painter, name: &str, pivot: Option<Pos2>) {
    let Some(pivot) = pivot else { return };
    let text = painter.layout_no_wrap(name.to_owned(), FontId::proportional(13.0), edge(true));
    let place = Align2::CENTER_TOP.anchor_size(pivot + egui::vec2(0.0, 10.0), text.size());
    painter.rect_filled(place.expand(2.0), 2.0, Color32::from_black_alpha(160));
    painter.galley(place.min, text, edge(true));
}

/// Draws the bounding box of an instance or of an area light's surface.
fn paint_box(painter: &Painter, session: &Session, projector: &Projector, selected: Selected) {
    let instance = match selected {
        Selected::Instance(index) => Some(index),
        Selected::Light(index) => session.document.light_instance(index),
    };
    let Some(instance) = instance else { return };
    let (Some(known), Some(transform)) =
        (session.scene.instances.get(instance), session.pose.instances.get(instance))
    else {
        return;
    };
    let (low, high) = session.scene.meshes[known.mesh].bounds();
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { low[axis] } else { high[axis] };
        projector.point(transform.transform_point3(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))))
    };
    for (from, bit) in (0..8).flat_map(|i| (0..3).map(move |bit| (i, bit))) {
        if from >> bit & 1 == 0
            && let (Some(a), Some(b)) = (corner(from), corner(from | 1 << bit))
        {
            painter.line_segment([a, b], Stroke::new(1.0, edge(true)));
        }
    }
}

impl Session {
    /// The entry whose surface is at a position of the picture; none for what surrounds the camera, so that no click moves a building.
    pub fn selected_at(&self, at: Vec2) -> Option<Selected> {
        let instance =
            self.pick(at).map(|picked| picked.instance).filter(|instance| !self.surrounds(*instance))?;
        if instance < self.document.instances().len() {
            return Some(Selected::Instance(instance));
        }
        let mut lights = 0..self.document.lights().len();
        lights.find(|&light| self.document.light_instance(light) == Some(instance)).map(Selected::Light)
    }

    /// Whether the camera is inside of an instance's bounds.
    fn surrounds(&self, instance: usize) -> bool {
        let (Some(known), Some(transform)) =
            (self.scene.instances.get(instance), self.pose.instances.get(instance))
        else {
            return false;
        };
        let mesh = &self.scene.meshes[known.mesh];
        let (low, high) = mesh.bounds();
        let eye = transform.inverse().transform_point3(self.pose.camera.eye);
        eye.cmpge(low).all() && eye.cmple(high).all()
    }
}

/// The light whose marker is at a window position.
pub(super) fn light_at(session: &Session, viewport: Rect, at: Pos2) -> Option<Selected> {
    let projector = Projector::new(session, viewport);
    let distance = |light: usize| mark(session, &projector, light).map(|mark| mark.distance(at));
    let near = (0..session.document.lights().len()).filter_map(|light| Some((distance(light)?, light)));
    let nearest = near.filter(|(distance, _)| *distance < GRIP).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, light)| Selected::Light(light))
}

impl HandleDrag {
    /// Starts a drag at a window position, if there is a handle.
    pub fn begin(session: &Session, mode: Mode, viewport: Rect, at: Pos2) -> Option<Self> {
        let selected = session.selected?;
        let pivot = session.place_of(selected)?;
        let projector = Projector::new(session, viewport);
        let reach = reach(session, pivot);
        let distance = |axis: Vec3| {
            let points: Vec<Pos2> = lines(mode, pivot, axis, reach)
                .into_iter()
                .filter_map(|point| projector.point(point))
                .collect();
            points.windows(2).map(|ends| distance_to(at, ends[0], ends[1])).fold(f32::INFINITY, f32::min)
        };
        let nearest = AXES.into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        let original = match selected {
            Selected::Instance(index) => {
                Entry::Instance(index, session.document.instances().nth(index)?.clone())
            }
            Selected::Light(index) => Entry::Light(index, session.document.lights().nth(index)?.clone()),
        };
        let drag = Self { mode, axis: nearest, pivot, start: 0.0, original };
        let share = (at - viewport.min) / viewport.size();
        let ray = session.ray(Vec2::new(share.x, share.y));
        let start = drag.place(&ray).filter(|_| distance(nearest) < GRIP)?;
        Some(Self { start, ..drag })
    }

    /// Position along the axis closest to a ray, or the angle at which the ray hits the ring's plane.
    fn place(&self, ray: &Ray) -> Option<f32> {
        let direction = ray.direction.normalize();
        let along = direction.dot(self.axis);
        match self.mode {
            Mode::Move => {
                let off = ray.origin - self.pivot;
                let square = 1.0 - along * along;
                (square > 1e-4).then(|| (off.dot(self.axis) - off.dot(direction) * along) / square)
            }
            Mode::Turn => {
                let t = (self.pivot - ray.origin).dot(self.axis) / along;
                let at = ray.origin + direction * t - self.pivot;
                let (x, y) = (at.dot(self.axis.yzx()), at.dot(self.axis.cross(self.axis.yzx())));
                (along.abs() > 1e-3 && at.length_squared() > 0.0).then(|| y.atan2(x))
            }
        }
    }

    /// The entry dragged to this ray.
    pub fn dragged(&self, ray: &Ray) -> Option<Entry> {
        let way = self.place(ray)? - self.start;
        Some(match (&self.original, self.mode) {
            (Entry::Instance(index, entry), Mode::Move) => {
                Entry::Instance(*index, moved_instance(entry, self.axis * way))
            }
            (Entry::Instance(index, entry), Mode::Turn) => {
                Entry::Instance(*index, turned_instance(entry, self.axis, way))
            }
            (Entry::Light(index, entry), Mode::Move) => {
                Entry::Light(*index, moved_light(entry, self.axis * way))
            }
            (Entry::Light(index, entry), Mode::Turn) => {
                Entry::Light(*index, turned_light(entry, Quat::from_axis_angle(self.axis, way)))
            }
        })
    }
}

fn distance_to(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let (line, off) = (to - from, at - from);
    let t = if line.length_sq() > 0.0 { (off.dot(line) / line.length_sq()).clamp(0.0, 1.0) } else { 0.0 };
    (off - line * t).length()
}

fn plus(place: [f32; 3], way: Vec3) -> [f32; 3] {
    (Vec3::from_array(place) + way).to_array()
}

/// An instance translated by `way`.
pub(super) fn moved_instance(entry: &InstanceEntry, way: Vec3) -> InstanceEntry {
    InstanceEntry { translation: Some(plus(entry.translation.unwrap_or_default(), way)), ..entry.clone() }
}

fn turned_instance(entry: &InstanceEntry, axis: Vec3, angle: f32) -> InstanceEntry {
    let now = match entry.rotation {
        None => Quat::IDENTITY,
        Some(RotationEntry::Euler(degrees)) => {
            let [x, y, z] = degrees.map(f32::to_radians);
            Quat::from_euler(glam::EulerRot::XYZEx, x, y, z)
        }
        Some(RotationEntry::AxisAngle(turn)) => Quat::from_axis_angle(
            Vec3::from_array(turn.axis).normalize_or(Vec3::Y),
            turn.degrees.to_radians(),
        ),
    };
    let (axis, angle) = (Quat::from_axis_angle(axis, angle) * now).normalize().to_axis_angle();
    let turn = AxisAngle { axis: axis.to_array(), degrees: angle.to_degrees() };
    InstanceEntry { rotation: Some(RotationEntry::AxisAngle(turn)), ..entry.clone() }
}

/// A light translated by `way`.
pub(super) fn moved_light(entry: &LightEntry, way: Vec3) -> LightEntry {
    LightEntry {
        position: entry.position.map(|position| plus(position, way)),
        polygon: entry.polygon.map(|polygon| polygon.map(|corner| plus(corner, way))),
        ..entry.clone()
    }
}

fn turned_light(entry: &LightEntry, turn: Quat) -> LightEntry {
    let about_middle = |polygon: [[f32; 3]; 4]| {
        let middle = polygon.into_iter().map(Vec3::from_array).sum::<Vec3>() / 4.0;
        polygon.map(|corner| (middle + turn * (Vec3::from_array(corner) - middle)).to_array())
    };
    LightEntry {
        direction: entry.direction.map(|direction| (turn * Vec3::from_array(direction)).to_array()),
        polygon: entry.polygon.map(about_middle),
        ..entry.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LightType;

    fn drag(mode: Mode, axis: Vec3) -> HandleDrag {
        let light = LightEntry {
            position: Some([1.0, 2.0, 3.0]),
            direction: Some([1.0, 0.0, 0.0]),
            ..LightEntry::of(LightType::Spot)
        };
        let pivot = Vec3::new(1.0, 2.0, 3.0);
        HandleDrag { mode, axis, pivot, start: 0.0, original: Entry::Light(0, light) }
    }

    fn ray_to(target: Vec3) -> Ray {
        let origin = Vec3::new(0.5, 9.0, 20.0);
        Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY }
    }

    #[test]
    fn a_light_goes_where_its_arrow_is_dragged() {
        let drag = drag(Mode::Move, Vec3::X);
        let Some(Entry::Light(_, light)) = drag.dragged(&ray_to(Vec3::new(4.0, 2.0, 3.0))) else { panic!() };
        let position = Vec3::from_array(light.position.unwrap());
        assert!(position.distance(Vec3::new(4.0, 2.0, 3.0)) < 1e-3, "{position}");
    }

    #[test]
    fn a_light_turns_with_its_ring() {
        let mut drag = drag(Mode::Turn, Vec3::Y);
        drag.start = drag.place(&ray_to(drag.pivot + Vec3::X)).unwrap();
        let Some(Entry::Light(_, light)) = drag.dragged(&ray_to(drag.pivot + Vec3::NEG_Z)) else { panic!() };
        let direction = Vec3::from_array(light.direction.unwrap());
        assert!(direction.distance(Vec3::NEG_Z) < 1e-3, "{direction}");
    }

    #[test]
    fn turns_of_an_instance_add_up() {
        let text = "model = \"m\"\nrotation = [0, 90, 0]";
        let entry: InstanceEntry = toml::from_str(text).unwrap();
        let turned = turned_instance(&entry, Vec3::Y, 30f32.to_radians());
        let Some(RotationEntry::AxisAngle(turn)) = turned.rotation else { panic!() };
        assert!(Vec3::from_array(turn.axis).distance(Vec3::Y) < 1e-5 && (turn.degrees - 120.0).abs() < 1e-3);
    }
}
