//! The tree of what is in the scene: lights; models with their instances; the materials of each instance.

use egui::collapsing_header::CollapsingState;
use egui::{Button, Id, RichText, ScrollArea, Ui};

use super::widgets::Output;
use crate::demo::action::{Action, EditAction, Selected, ViewAction};
use crate::demo::session::Session;
use crate::scene::Mesh;

/// Height of the tree, points.
const HEIGHT: f32 = 150.0;

/// The subject of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum What {
    Group,
    Entry(Selected),
    Material(usize),
}

/// A node with all below it.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    name: String,
    what: What,
    children: Vec<Node>,
    /// Whether it is open until it is closed by hand.
    is_open: bool,
}

/// The nodes that are shown as chosen.
struct Chosen {
    selected: Option<What>,
    /// Whether that differs from the last frame.
    is_new: bool,
    material: Option<What>,
}

pub(super) fn draw(
    ui: &mut Ui,
    session: &Session,
    material: Option<usize>,
    searched: &str,
    out: &mut Output,
) {
    let selected = session.selected.map(What::Entry);
    let known = Id::new("selected entry");
    let is_new = ui.data(|data| data.get_temp(known)) != Some(selected);
    ui.data_mut(|data| data.insert_temp(known, selected));
    let searched = searched.trim().to_lowercase();
    let mut nodes = nodes(session);
    if !searched.is_empty() {
        nodes.retain_mut(|node| node.search(&searched, selected));
    }
    let chosen = Chosen { selected, is_new, material: material.map(What::Material) };
    let area = ScrollArea::vertical().id_salt("objects").max_height(HEIGHT).auto_shrink([false, true]);
    area.show(ui, |ui| {
        // A branch is open at once, so that what is selected in it can be scrolled to.
        ui.style_mut().animation_time = 0.0;
        for node in &nodes {
            node.draw(ui, Id::new(&searched), &chosen, out);
        }
    });
}

/// The whole tree. A model of several instances is a branch of its own.
fn nodes(session: &Session) -> Vec<Node> {
    let (document, scene) = (&session.document, &session.scene);
    let entry = |this: Selected, children| {
        let what = What::Entry(this);
        Node { name: session.name_of(this), what, children, is_open: false }
    };
    let group = |name: &str, children| Node {
        name: name.to_owned(),
        what: What::Group,
        children,
        is_open: name == LIGHTS,
    };
    let material = |index: usize| {
        let name = scene.materials.get(index).map_or("", |material| &material.name);
        let name = if name.is_empty() { "(no name)" } else { name }.to_owned();
        Node { name, what: What::Material(index), children: Vec::new(), is_open: false }
    };
    let lights = (0..document.lights().len()).map(|index| entry(Selected::Light(index), Vec::new()));
    let mut nodes = vec![group(LIGHTS, lights.collect())];
    for model in document.models() {
        let of_model = document.instances().enumerate().filter(|(_, instance)| instance.model == model);
        let instances = of_model.map(|(index, _)| {
            let mesh = scene.instances.get(index).map(|instance| &scene.meshes[instance.mesh]);
            let materials = mesh.map_or_else(Vec::new, |mesh| materials_of(mesh));
            entry(Selected::Instance(index), materials.into_iter().map(material).collect())
        });
        let mut instances: Vec<Node> = instances.collect();
        if instances.len() > 1 {
            instances = vec![group(model, instances)];
        }
        nodes.extend(instances);
    }
    nodes.retain(|node| node.what != What::Group || !node.children.is_empty());
    nodes
}

/// Name of the branch of lights.
const LIGHTS: &str = "lights";

/// The materials of a mesh, by the order of its triangles.
fn materials_of(mesh: &Mesh) -> Vec<usize> {
    let (mut rest, mut found) = (&mesh.triangle_materials[..], Vec::new());
    while let Some(&first) = rest.first() {
        found.push(first as usize);
        rest = &rest[rest.partition_point(|material| *material <= first).max(1)..];
    }
    found
}

impl Node {
    /// Keeps what has `searched` in its name with all below it, the branches to it, which are open, and what is selected;
    /// returns whether anything is left.
    fn search(&mut self, searched: &str, selected: Option<What>) -> bool {
        let is_found = self.name.to_lowercase().contains(searched);
        if !is_found {
            self.children.retain_mut(|child| child.search(searched, selected));
        }
        self.is_open = !is_found || self.what == What::Group;
        is_found || !self.children.is_empty() || Some(self.what) == selected
    }

    fn has(&self, what: Option<What>) -> bool {
        Some(self.what) == what || self.children.iter().any(|child| child.has(what))
    }

    fn draw(&self, ui: &mut Ui, parent: Id, chosen: &Chosen, out: &mut Output) {
        if self.children.is_empty() {
            return self.label(ui, chosen, out);
        }
        let id = parent.with((self.what, &self.name));
        let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, self.is_open);
        if chosen.is_new && self.children.iter().any(|child| child.has(chosen.selected)) {
            state.set_open(true);
        }
        let header = state.show_header(ui, |ui| self.label(ui, chosen, out));
        let (toggle, ..) = header.body(|ui| {
            for child in &self.children {
                child.draw(ui, id, chosen, out);
            }
        });
        out.place(ui, &format!("branch {}", self.name), &toggle);
    }

    fn label(&self, ui: &mut Ui, chosen: &Chosen, out: &mut Output) {
        let is_selected = chosen.selected == Some(self.what);
        let action = match self.what {
            What::Group => {
                ui.label(format!("{} ({})", self.name, self.children.len()));
                return;
            }
            What::Entry(this) => Action::from(EditAction::Select(Some(this))),
            What::Material(material) => ViewAction::ChooseMaterial(material).into(),
        };
        let is_chosen = is_selected || chosen.material == Some(self.what);
        let name = RichText::new(&self.name);
        let is_material = matches!(self.what, What::Material(_));
        let name = if is_material { name.italics() } else { name };
        let label = ui.add(Button::selectable(is_chosen, name).truncate());
        out.click(ui, &format!("node {}", self.name), &label, action);
        if is_selected && chosen.is_new {
            label.scroll_to_me(None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, what: What, children: Vec<Node>) -> Node {
        Node { name: name.to_owned(), what, children, is_open: false }
    }

    fn chairs() -> Node {
        let chair = |index: usize, name: &str| {
            let materials = vec![
                node("Wood", What::Material(0), Vec::new()),
                node("cloth", What::Material(1), Vec::new()),
            ];
            node(name, What::Entry(Selected::Instance(index)), materials)
        };
        node("chair", What::Group, vec![chair(0, "left"), chair(1, "right")])
    }

    #[test]
    fn a_search_opens_the_branches_to_what_it_finds() {
        let mut found = chairs();
        assert!(found.search("wood", None) && found.is_open);
        for chair in &found.children {
            assert!(chair.is_open && chair.children.len() == 1 && chair.children[0].name == "Wood");
        }
        let mut found = chairs();
        assert!(found.search("right", None) && found.is_open && found.children.len() == 1);
        assert!(!found.children[0].is_open && found.children[0].children.len() == 2);
        assert!(!chairs().search("table", None));
    }

    #[test]
    fn what_is_selected_stays_in_a_search() {
        let mut found = chairs();
        assert!(found.search("table", Some(What::Entry(Selected::Instance(1)))));
        assert!(found.is_open && found.children.len() == 1 && found.children[0].name == "right");
    }

    #[test]
    fn each_material_of_a_mesh_is_there_once() {
        let mesh = Mesh { triangle_materials: vec![1, 1, 4, 4, 4, 7], ..Mesh::default() };
        assert_eq!(materials_of(&mesh), [1, 4, 7]);
    }
}
