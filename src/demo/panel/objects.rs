//! Lights and instances: select, edit, add, delete.

use egui::{ComboBox, DragValue, Slider, Ui};
use glam::Vec3;

use super::shown::Shown;
use super::tree;
use super::widgets::{FIELD, Output, power};
use crate::demo::action::{AppAction, EditAction, HandleMode, NewObject, Selected};
use crate::demo::selection::label;
use crate::demo::session::Session;
use crate::demo::transform::carry;
use crate::formats::{
    AnimationEntry, AxisAngle, InstanceEntry, LightEntry, Primitive, RotationEntry, ScaleEntry, SpinEntry,
};
use crate::scene::LightType;

const KINDS: [LightType; 4] = [LightType::Point, LightType::Spot, LightType::Directional, LightType::Area];

pub(super) fn draw(ui: &mut Ui, searched: &mut String, shown: &Shown<'_>, out: &mut Output) {
    let Some(session) = shown.session() else { return };
    out.text_field(ui, "search", searched, ("search by name", FIELD));
    tree::draw(ui, session, shown.view.inspector.material, searched, out);
    ui.horizontal_wrapped(|ui| {
        ui.label("add");
        for kind in KINDS {
            let button = ui.small_button(label(kind)).on_hover_text("A new light in view of the camera");
            out.click(ui, &format!("add {}", label(kind)), &button, EditAction::AddLight(kind));
        }
    });
    add_object(ui, session, out);
    let Some(selected) = session.selected else {
        ui.small("Click an object or a light in the picture to select it.");
        return;
    };
    ui.horizontal_wrapped(|ui| {
        for mode in HandleMode::ALL {
            let label =
                ui.selectable_label(shown.view.handles == mode, mode.label()).on_hover_text("T: the next");
            out.click(ui, mode.label(), &label, EditAction::Handles(Some(mode)));
        }
        out.button(ui, "copy", "Ctrl+D", EditAction::Duplicate);
        out.button(ui, "delete", "Del", EditAction::Delete);
    });
    match selected {
        Selected::Light(index) => {
            if let Some(entry) = session.document.lights().nth(index) {
                light(ui, session, (index, entry), out);
            }
        }
        Selected::Instance(index) => {
            if let Some(entry) = session.document.instances().nth(index) {
                instance(ui, session, index, entry, out);
            }
        }
    }
}

/// Shapes, models that are in the scene, and files.
fn add_object(ui: &mut Ui, session: &Session, out: &mut Output) {
    let combo = ComboBox::from_id_salt("add object").selected_text("add an object").width(150.0);
    let menu = combo.show_ui(ui, |ui| {
        let shapes = Primitive::ALL.map(|shape| (shape.label(), NewObject::Shape(shape)));
        let models = session.document.models().map(|model| (model, NewObject::Model(model.to_owned())));
        for (name, object) in shapes.into_iter().chain(models) {
            let label = ui.selectable_label(false, name);
            out.click(ui, &format!("add {name}"), &label, EditAction::AddObject(object));
        }
        out.on_click(&ui.selectable_label(false, "model from a file …"), AppAction::AskModel);
    });
    out.place(ui, "add an object", &menu.response);
}

fn light(ui: &mut Ui, session: &Session, (index, entry): (usize, &LightEntry), out: &mut Output) {
    let mut light = entry.clone();
    let speed = 2e-3 * session.radius;
    if let Some(name) = &mut light.name {
        out.text_field(ui, "light name", name, ("", FIELD));
    }
    if session.headlamp == Some(index) {
        // The document has where it was when it was attached.
        let mut now = light.clone();
        carry(&mut now, &session.pose.camera);
        ui.add_enabled_ui(false, |ui| place_of_light(ui, &mut now, speed));
    } else {
        place_of_light(ui, &mut light, speed);
    }
    for (what, unit, value) in [
        ("intensity", "W/sr", light.intensity.as_mut()),
        ("irradiance", "W/m²", light.irradiance.as_mut()),
        ("radiance", "W/m²/sr", light.radiance.as_mut()),
    ] {
        // An area light must stay emissive.
        let least = if light.kind == LightType::Area { 1e-3 } else { 0.0 };
        power(ui, what, unit, value, least);
    }
    if light.kind == LightType::Spot {
        cone(ui, &mut light);
    }
    extent(ui, &mut light, session.radius, out);
    let mut headlamp = session.headlamp == Some(index);
    let can_go = light.kind != LightType::Area;
    let check = ui.add_enabled(can_go, egui::Checkbox::new(&mut headlamp, "attached to the camera (H)"));
    if check.changed() {
        out.push(EditAction::ToggleHeadlamp);
    }
    if light.instance.is_none() {
        spin(ui, &mut light.animation);
    }
    if light != *entry {
        out.push(EditAction::EditLight(index, Box::new(light)));
    }
}

fn place_of_light(ui: &mut Ui, light: &mut LightEntry, speed: f32) {
    vector(ui, "position", light.position.as_mut(), speed);
    vector(ui, "direction", light.direction.as_mut(), 0.01);
    if let Some(polygon) = &mut light.polygon {
        quad(ui, polygon, speed);
    }
}

/// Centre and edge lengths of an area light.
fn quad(ui: &mut Ui, polygon: &mut [[f32; 3]; 4], speed: f32) {
    let corners = polygon.map(Vec3::from_array);
    let centre = corners.iter().sum::<Vec3>() / 4.0;
    let mut moved = centre.to_array();
    vector(ui, "position", Some(&mut moved), speed);
    // Along the first edge, and along what the second has across it.
    let along = (corners[1] - corners[0]).normalize_or(Vec3::X);
    let across = (corners[2] - corners[1]).reject_from(along).normalize_or(Vec3::Z);
    let size = [along, across].map(|axis| {
        let places = corners.map(|corner| corner.dot(axis));
        places.into_iter().fold(f32::NEG_INFINITY, f32::max)
            - places.into_iter().fold(f32::INFINITY, f32::min)
    });
    let mut sized = size;
    ui.horizontal(|ui| {
        ui.label("size");
        for side in &mut sized {
            ui.add(DragValue::new(side).range(0.01 * speed..=1e6).speed(speed).max_decimals(3));
        }
    });
    if (moved, sized) != (centre.to_array(), size) {
        *polygon = corners.map(|corner| {
            let off = corner - centre;
            let scaled = |axis: Vec3, i: usize| axis * (off.dot(axis) * (sized[i] / size[i].max(1e-9) - 1.0));
            (Vec3::from_array(moved) + off + scaled(along, 0) + scaled(across, 1)).to_array()
        });
    }
}

fn instance(ui: &mut Ui, session: &Session, index: usize, entry: &InstanceEntry, out: &mut Output) {
    let mut instance = entry.clone();
    let mut place = instance.translation.unwrap_or_default();
    vector(ui, "position", Some(&mut place), 2e-3 * session.radius);
    if Some(place) != instance.translation && place != [0.0; 3] {
        instance.translation = Some(place);
    }
    match &mut instance.rotation {
        Some(RotationEntry::AxisAngle(AxisAngle { axis, degrees })) => {
            vector(ui, "axis", Some(axis), 0.01);
            ui.horizontal(|ui| {
                ui.label("rotation");
                ui.add(DragValue::new(degrees).suffix("°"));
            });
        }
        Some(RotationEntry::Euler(degrees)) => vector(ui, "rotation", Some(degrees), 1.0),
        None => {
            let mut degrees = [0.0; 3];
            vector(ui, "rotation", Some(&mut degrees), 1.0);
            if degrees != [0.0; 3] {
                instance.rotation = Some(RotationEntry::Euler(degrees));
            }
        }
    }
    match &mut instance.scale {
        Some(ScaleEntry::PerAxis(scale)) => vector(ui, "scale", Some(scale), 0.01),
        scale => {
            let mut factor = if let Some(ScaleEntry::Uniform(factor)) = scale { *factor } else { 1.0 };
            ui.horizontal(|ui| {
                ui.label("scale");
                if ui.add(DragValue::new(&mut factor).range(1e-3..=1e3).speed(0.01)).changed() {
                    *scale = Some(ScaleEntry::Uniform(factor));
                }
            });
        }
    }
    spin(ui, &mut instance.animation);
    if instance != *entry {
        out.push(EditAction::EditInstance(index, Box::new(instance)));
    }
}

fn vector(ui: &mut Ui, name: &str, value: Option<&mut [f32; 3]>, speed: f32) {
    let Some(value) = value else { return };
    ui.label(name);
    ui.horizontal(|ui| {
        for part in value {
            ui.add(DragValue::new(part).speed(speed).max_decimals(3));
        }
    });
}

fn cone(ui: &mut Ui, light: &mut LightEntry) {
    let mut outer = light.outer_deg.unwrap_or(30.0);
    let mut inner = light.inner_deg.unwrap_or(0.8 * outer);
    ui.horizontal(|ui| {
        ui.label("cone");
        let inner_changed = ui.add(DragValue::new(&mut inner).range(0.0..=outer - 0.5).suffix("°")).changed();
        let outer_changed = ui.add(DragValue::new(&mut outer).range(1.0..=175.0).suffix("°")).changed();
        if inner_changed || outer_changed {
            light.outer_deg = Some(outer);
            light.inner_deg = Some(inner.min(outer - 0.5));
        }
    });
}

/// The extent of a light: the radius of a sphere, or the half angle of a disc; none has no key in a scene file.
fn extent(ui: &mut Ui, light: &mut LightEntry, scene_radius: f32, out: &mut Output) {
    let (name, unit, most, value) = match light.kind {
        LightType::Point | LightType::Spot => ("radius", "", 0.2 * scene_radius, &mut light.radius),
        LightType::Directional => ("angle", "°", 90.0, &mut light.angle_deg),
        LightType::Area => return,
    };
    let mut now = value.unwrap_or(0.0);
    let slider =
        Slider::new(&mut now, 0.0..=most).logarithmic(true).smallest_positive(1e-3 * f64::from(most));
    let slider = out.slider(ui, &format!("light {name}"), slider.suffix(unit).text(name));
    if slider.on_hover_text("Extent of what shines: larger makes softer shadows").changed() {
        *value = (now > 0.0).then_some(now);
    }
}

/// A constant rotation, about the vertical axis unless it has another.
fn spin(ui: &mut Ui, animation: &mut Option<AnimationEntry>) {
    let mut all = animation.clone().unwrap_or_default();
    let up = SpinEntry { axis: [0.0, 1.0, 0.0], degrees_per_second: 0.0, pivot: None };
    let mut spin = all.rotation.take().unwrap_or(up);
    ui.horizontal(|ui| {
        ui.label("spin");
        if ui.add(DragValue::new(&mut spin.degrees_per_second).suffix("°/s")).changed() {
            all.rotation = (spin.degrees_per_second != 0.0).then_some(spin);
            *animation = Some(all).filter(|all| !all.keyframes.is_empty() || all.rotation.is_some());
        }
    });
}
