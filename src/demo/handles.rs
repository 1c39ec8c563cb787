//! Manipulation handles: arrows to move the selection, rings to rotate it, bars to scale it, and light markers.
//!
//! In: the session and the pointer. Out: the handle under the pointer, and the selected entry after a drag.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui};
use glam::{Mat4, Quat, Vec2, Vec3, Vec3Swizzles, Vec4Swizzles};

use super::action::{Entry, HandleMode, Selected};
use super::keys::key_at;
use super::session::Session;
use super::transform::{
    moved_instance, moved_key, moved_light, rotated_instance, rotated_key, rotated_light, scaled_instance,
    scaled_light,
};
use crate::bvh::Ray;
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

/// A drag of a handle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HandleDrag {
    mode: HandleMode,
    axis: Vec3,
    pivot: Vec3,
    /// Length of the handle, scene units.
    reach: f32,
    /// Position along the axis, or angle about it, at the start of the drag.
    start: f32,
    original: Entry,
    /// The key that is moved or rotated in place of the whole motion.
    key: Option<usize>,
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
fn lines(mode: HandleMode, pivot: Vec3, axis: Vec3, reach: f32) -> Vec<Vec3> {
    match mode {
        HandleMode::Move | HandleMode::Scale => vec![pivot, pivot + axis * reach],
        HandleMode::Rotate => {
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
pub(super) fn paint(ui: &Ui, session: &Session, viewport: Rect, mode: HandleMode) {
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
        match (mode, &points[..]) {
            (HandleMode::Move, &[from, to]) => painter.arrow(from, to - from, Stroke::new(2.5, colour)),
            (HandleMode::Scale, &[from, to]) => {
                painter.line_segment([from, to], Stroke::new(2.0, Color32::LIGHT_GRAY));
                let end = Rect::from_center_size(to, egui::Vec2::splat(9.0));
                painter.rect_filled(end, 0.0, Color32::LIGHT_GRAY);
            }
            _ => {
                painter.line(points, Stroke::new(2.0, colour));
            }
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

/// The light whose marker is at a window position.
pub(super) fn light_at(session: &Session, viewport: Rect, at: Pos2) -> Option<Selected> {
    let projector = Projector::new(session, viewport);
    let distance = |light: usize| mark(session, &projector, light).map(|mark| mark.distance(at));
    let near = (0..session.document.lights().len()).filter_map(|light| Some((distance(light)?, light)));
    let nearest = near.filter(|(distance, _)| *distance < GRIP).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, light)| Selected::Light(light))
}

impl HandleDrag {
    /// Starts a drag at a window position, if there is a handle; of the key at `time`, if the clock stands there.
    pub fn begin(
        session: &Session,
        mode: HandleMode,
        time: Option<f64>,
        viewport: Rect,
        at: Pos2,
    ) -> Option<Self> {
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
        let mut original = session.entry(selected)?;
        let key =
            time.zip(original.animation().as_ref()).and_then(|(time, animation)| key_at(animation, time));
        let drag = Self { mode, axis: nearest, pivot, reach, start: 0.0, original, key };
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
            HandleMode::Move | HandleMode::Scale => {
                let off = ray.origin - self.pivot;
                let square = 1.0 - along * along;
                (square > 1e-4).then(|| (off.dot(self.axis) - off.dot(direction) * along) / square)
            }
            HandleMode::Rotate => {
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
        let mut dragged = self.original.clone();
        if way.abs() < f32::EPSILON {
            // A click is no edit.
            return Some(dragged);
        }
        let (offset, turn) = (self.axis * way, Quat::from_axis_angle(self.axis, way));
        // A handle's length outwards doubles the size, one inwards halves it.
        let factor = (way / self.reach).clamp(-8.0, 8.0).exp2();
        let keys = dragged.animation().as_mut().map(|animation| &mut animation.keyframes);
        let key = self.key.and_then(|index| keys?.get_mut(index));
        if let Some(key) = key.filter(|_| self.mode != HandleMode::Scale) {
            *key =
                if self.mode == HandleMode::Move { moved_key(key, offset) } else { rotated_key(key, turn) };
            return Some(dragged);
        }
        match (&mut dragged, self.mode) {
            (Entry::Instance(_, entry), HandleMode::Move) => *entry = moved_instance(entry, offset),
            (Entry::Instance(_, entry), HandleMode::Rotate) => *entry = rotated_instance(entry, turn),
            (Entry::Instance(_, entry), HandleMode::Scale) => *entry = scaled_instance(entry, factor),
            (Entry::Light(_, entry), HandleMode::Move) => *entry = moved_light(entry, offset),
            (Entry::Light(_, entry), HandleMode::Rotate) => *entry = rotated_light(entry, turn),
            (Entry::Light(_, entry), HandleMode::Scale) => *entry = scaled_light(entry, factor),
        }
        Some(dragged)
    }
}

fn distance_to(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let (line, off) = (to - from, at - from);
    let t = if line.length_sq() > 0.0 { (off.dot(line) / line.length_sq()).clamp(0.0, 1.0) } else { 0.0 };
    (off - line * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{InstanceEntry, LightEntry, ScaleEntry};
    use crate::scene::LightType;

    fn drag(mode: HandleMode, axis: Vec3) -> HandleDrag {
        let light = LightEntry {
            position: Some([1.0, 2.0, 3.0]),
            direction: Some([1.0, 0.0, 0.0]),
            ..LightEntry::of(LightType::Spot)
        };
        let pivot = Vec3::new(1.0, 2.0, 3.0);
        HandleDrag { mode, axis, pivot, reach: 2.0, start: 0.0, original: Entry::Light(0, light), key: None }
    }

    fn ray_to(target: Vec3) -> Ray {
        let origin = Vec3::new(0.5, 9.0, 20.0);
        Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY }
    }

    #[test]
    fn a_light_goes_where_its_arrow_is_dragged() {
        let drag = drag(HandleMode::Move, Vec3::X);
        let Some(Entry::Light(_, light)) = drag.dragged(&ray_to(Vec3::new(4.0, 2.0, 3.0))) else { panic!() };
        let position = Vec3::from_array(light.position.unwrap());
        assert!(position.distance(Vec3::new(4.0, 2.0, 3.0)) < 1e-3, "{position}");
    }

    #[test]
    fn a_light_turns_with_its_ring() {
        let mut drag = drag(HandleMode::Rotate, Vec3::Y);
        drag.start = drag.place(&ray_to(drag.pivot + Vec3::X)).unwrap();
        let Some(Entry::Light(_, light)) = drag.dragged(&ray_to(drag.pivot + Vec3::NEG_Z)) else { panic!() };
        let direction = Vec3::from_array(light.direction.unwrap());
        assert!(direction.distance(Vec3::NEG_Z) < 1e-3, "{direction}");
    }

    #[test]
    fn a_handle_s_length_outwards_doubles() {
        let scaled = |text: &str, way: f32| {
            let entry: InstanceEntry = toml::from_str(&format!("model = \"m\"\n{text}")).unwrap();
            let mut drag =
                HandleDrag { original: Entry::Instance(0, entry), ..drag(HandleMode::Scale, Vec3::X) };
            drag.start = drag.place(&ray_to(drag.pivot + Vec3::X)).unwrap();
            let target = drag.pivot + Vec3::X * (1.0 + way * drag.reach);
            match drag.dragged(&ray_to(target)) {
                Some(Entry::Instance(_, InstanceEntry { scale: Some(scale), .. })) => scale,
                other => panic!("{other:?}"),
            }
        };
        let ScaleEntry::Uniform(factor) = scaled("", 1.0) else { panic!() };
        assert!((factor - 2.0).abs() < 1e-3, "{factor}");
        let ScaleEntry::PerAxis(factors) = scaled("scale = [4, 2, 1]", -1.0) else { panic!() };
        assert!(Vec3::from(factors).distance(Vec3::new(2.0, 1.0, 0.5)) < 1e-3, "{factors:?}");
    }
}
