//! The material at the inspector's point or chosen in the tree, with its sliders.

use egui::{ScrollArea, Slider, Ui, Window};

use super::shown::Shown;
use super::widgets::{Output, power};
use crate::demo::action::EditAction;
use crate::demo::session::Session;
use crate::formats::MaterialEdit;
use crate::scene::{Alpha, Material};

/// Most that the slopes of a normal map are multiplied by.
const NORMAL_SCALE: f32 = 4.0;

pub(super) fn draw(ui: &Ui, shown: &Shown<'_>, out: &mut Output) {
    let (Some(session), Some(index)) = (shown.session(), shown.view.inspector.material) else { return };
    let Some(material) = session.scene.materials.get(index) else { return };
    let viewport = shown.picture_area(ui.ctx());
    let window = Window::new("Material").fixed_pos(viewport.min + egui::vec2(8.0, 8.0)).resizable(false);
    let height = viewport.height() * 0.5;
    let content = |ui: &mut Ui| {
        ui.strong(if material.name.is_empty() { "(no name)" } else { &material.name });
        let files = session.read.materials();
        let own = files.get(index);
        let Some(file) = own.or_else(|| files.iter().find(|file| file.name == material.name)) else {
            ui.label("A light: edit it under Lights and objects.");
            return;
        };
        // A surface that an entry of [[lights]] makes emit has its radiance from there.
        let edit = edited(ui, session, file, own.is_some(), out);
        out.extend(edit.map(|edit| EditAction::EditMaterial(Box::new(edit))));
    };
    window.show(ui.ctx(), |ui| ScrollArea::vertical().max_height(height).show(ui, content));
}

/// The widgets; returns another edit, if there is one.
fn edited(
    ui: &mut Ui,
    session: &Session,
    file: &Material,
    own_emission: bool,
    out: &mut Output,
) -> Option<MaterialEdit> {
    let mut now = file.clone();
    let edit = session.document.material_edit(&file.name);
    if let Some(edit) = edit {
        edit.apply(&mut now);
    }
    let before = now.clone();
    let mut base = now.base_colour.to_array();
    ui.horizontal(|ui| {
        if ui.color_edit_button_rgb(&mut base).changed() {
            now.base_colour = base.map(|channel| channel.clamp(0.0, 1.0)).into();
        }
        ui.label("base colour");
    });
    let is_blended = file.alpha == Alpha::Blend;
    for (name, value, most, is_there) in [
        ("metallic", &mut now.metallic, 1.0, true),
        ("roughness", &mut now.roughness, 1.0, true),
        ("opacity", &mut now.opacity, 1.0, is_blended),
        ("transmission", &mut now.transmission, 1.0, file.is_thin_surface()),
        ("normal scale", &mut now.normal_scale, NORMAL_SCALE, file.normal_texture.is_some()),
    ] {
        if is_there {
            out.slider(ui, name, Slider::new(value, 0.0..=most).text(name));
        }
    }
    if own_emission {
        let mut emission = now.emission.to_array();
        power(ui, "emission", "W/m²/sr", Some(&mut emission), 0.0);
        now.emission = emission.into();
    }
    let reset = ui.add_enabled(edit.is_some(), egui::Button::new("Reset to the file's"));
    out.place(ui, "reset material", &reset);
    if reset.clicked() {
        return Some(MaterialEdit { name: file.name.clone(), ..MaterialEdit::default() });
    }
    (now != before).then(|| MaterialEdit::between(file, &now))
}
