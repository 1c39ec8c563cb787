//! Rooms made of quads and boxes in which methods of lighting have gone wrong before.

use std::fmt::Write;
use std::sync::Arc;

use glam::Vec3;
use glowworm::scene::Scene;

use super::support::named_scene;

const GREY: &str = "newmtl grey\nKd 0.6 0.6 0.6\n";

/// The text of a Wavefront OBJ, quad by quad; all grey, all two-sided.
#[derive(Default)]
pub struct Model(String);

impl Model {
    /// A quad by its corners, which follow one another.
    pub fn quad(mut self, corners: [[f32; 3]; 4]) -> Self {
        for [x, y, z] in corners {
            writeln!(self.0, "v {x} {y} {z}").unwrap();
        }
        self.0 += "f -4 -3 -2 -1\n";
        self
    }

    /// A rectangle across an axis.
    pub fn rectangle(self, axis: usize, at: f32, low: [f32; 2], high: [f32; 2]) -> Self {
        let corner = |[u, v]: [f32; 2]| {
            let mut corner = [at; 3];
            (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (u, v);
            corner
        };
        self.quad([low, [high[0], low[1]], high, [low[0], high[1]]].map(corner))
    }

    /// A rectangle with a hole, of four that meet at their edges only.
    pub fn pierced(self, axis: usize, at: f32, [low, high]: [[f32; 2]; 2], hole: [[f32; 2]; 2]) -> Self {
        self.rectangle(axis, at, low, [hole[0][0], high[1]])
            .rectangle(axis, at, [hole[1][0], low[1]], high)
            .rectangle(axis, at, [hole[0][0], low[1]], [hole[1][0], hole[0][1]])
            .rectangle(axis, at, [hole[0][0], hole[1][1]], [hole[1][0], high[1]])
    }

    /// The six sides of a box.
    pub fn block(self, low: [f32; 3], high: [f32; 3]) -> Self {
        (0..3).fold(self, |model, axis| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let [a, b] = [low, high].map(|corner| [corner[u], corner[v]]);
            model.rectangle(axis, low[axis], a, b).rectangle(axis, high[axis], a, b)
        })
    }
}

/// A scene of these models, each an instance of its own, and of what `rest` says in a scene file.
pub fn scene_of(models: &[Model], rest: &str) -> Arc<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("grey.mtl"), GREY).unwrap();
    let mut text = String::new();
    for (index, Model(quads)) in models.iter().enumerate() {
        let obj = format!("part{index}.obj");
        std::fs::write(file(&obj), format!("mtllib grey.mtl\nusemtl grey\n{quads}")).unwrap();
        writeln!(
            text,
            "[[models]]\nname = \"{index}\"\npath = \"{obj}\"\n[[instances]]\nmodel = \"{index}\""
        )
        .unwrap();
    }
    std::fs::write(file("room.toml"), text + rest).unwrap();
    named_scene(file("room.toml").to_str().unwrap(), None)
}

/// A room, open towards the camera, lit by an uplighter: a light over a plate close under the ceiling. All its light comes from
/// bright VPLs side by side, and much of what they send on ends at the plate, a hand's breadth away.
pub fn uplighter() -> Arc<Scene> {
    let room = Model::default()
        .rectangle(1, 0.0, [-3.0, -2.5], [3.0, 2.5])
        .rectangle(1, 3.0, [-3.0, -2.5], [3.0, 2.5])
        .rectangle(0, -2.5, [0.0, -3.0], [3.0, 3.0])
        .rectangle(0, 2.5, [0.0, -3.0], [3.0, 3.0])
        .rectangle(2, -3.0, [-2.5, 0.0], [2.5, 3.0]);
    let objects = Model::default()
        .block([-1.4, 0.7, -1.6], [0.2, 0.78, -0.6])
        .block([-1.3, 0.0, -1.5], [-1.1, 0.7, -0.7])
        .block([-0.1, 0.0, -1.5], [0.1, 0.7, -0.7])
        .block([-2.4, 0.0, -2.9], [-1.2, 2.0, -2.5])
        .block([1.17, 0.0, -1.43], [1.23, 2.7, -1.37])
        .block([0.8, 2.7, -1.8], [1.6, 2.72, -1.0]);
    scene_of(
        &[room, objects],
        r#"
        [[lights]]
        type = "spot"
        position = [1.2, 2.78, -1.4]
        direction = [0, 1, 0]
        intensity = [40, 40, 40]
        inner_deg = 30
        outer_deg = 60
        [camera]
        eye = [0, 1.6, 5]
        target = [0, 1.3, -1]
        vfov_deg = 42
        "#,
    )
}

/// A room with a niche in its far wall, and a bright light deep within it.
pub fn niche() -> Arc<Scene> {
    let room = Model::default()
        .rectangle(1, 0.0, [-3.0, -2.5], [3.0, 2.5])
        .rectangle(1, 3.0, [-3.0, -2.5], [3.0, 2.5])
        .rectangle(0, -2.5, [0.0, -3.0], [3.0, 3.0])
        .rectangle(0, 2.5, [0.0, -3.0], [3.0, 3.0])
        .rectangle(2, 3.0, [-2.5, 0.0], [2.5, 3.0])
        .pierced(2, -3.0, [[-2.5, 0.0], [2.5, 3.0]], [[-0.3, 1.1], [0.3, 1.7]]);
    let niche = Model::default()
        .rectangle(2, -3.4, [-0.3, 1.1], [0.3, 1.7])
        .rectangle(0, -0.3, [1.1, -3.4], [1.7, -3.0])
        .rectangle(0, 0.3, [1.1, -3.4], [1.7, -3.0])
        .rectangle(1, 1.1, [-3.4, -0.3], [-3.0, 0.3])
        .rectangle(1, 1.7, [-3.4, -0.3], [-3.0, 0.3]);
    let objects = Model::default()
        .block([-1.8, 0.0, -2.0], [-1.0, 0.9, -1.2])
        .block([0.9, 0.0, -1.0], [1.5, 1.6, -0.5]);
    scene_of(
        &[room, niche, objects],
        r#"
        [[lights]]
        type = "point"
        position = [0.05, 1.4, -3.3]
        intensity = [30, 30, 30]
        [camera]
        eye = [0.4, 1.6, 2.7]
        target = [0, 1.2, -2]
        vfov_deg = 55
        "#,
    )
}

/// Which way the sun shines on [`thin_room`].
pub const SUN: Vec3 = Vec3::new(-0.72, -0.6, 0.31);
/// Its irradiance across its direction, W/m².
pub const SUN_IRRADIANCE: f32 = 4.0;
/// The window of [`thin_room`], in the plane x = 2: least and most y and z.
pub const WINDOW: [[f32; 2]; 2] = [[0.8, -1.2], [1.9, 0.1]];

/// A room whose walls are quads without thickness that meet at their edges, with a window towards the sun. `apart`: floor,
/// ceiling and walls are meshes of their own.
pub fn thin_room(apart: bool, eye: [f32; 3], target: [f32; 3]) -> Arc<Scene> {
    let sides: [&dyn Fn(Model) -> Model; 6] = [
        &|model| model.rectangle(1, 0.0, [-2.0, -2.0], [2.0, 2.0]),
        &|model| model.rectangle(1, 2.5, [-2.0, -2.0], [2.0, 2.0]),
        &|model| model.rectangle(0, -2.0, [0.0, -2.0], [2.5, 2.0]),
        &|model| model.pierced(0, 2.0, [[0.0, -2.0], [2.5, 2.0]], WINDOW),
        &|model| model.rectangle(2, -2.0, [-2.0, 0.0], [2.0, 2.5]),
        &|model| model.rectangle(2, 2.0, [-2.0, 0.0], [2.0, 2.5]),
    ];
    let models: Vec<Model> = if apart {
        sides.iter().map(|side| side(Model::default())).collect()
    } else {
        vec![sides.iter().fold(Model::default(), |model, side| side(model))]
    };
    let rest = format!(
        "[[lights]]\ntype = \"directional\"\ndirection = {:?}\nirradiance = {:?}\n\
         [camera]\neye = {eye:?}\ntarget = {target:?}\nvfov_deg = 80\n",
        SUN.to_array(),
        [SUN_IRRADIANCE; 3]
    );
    scene_of(&models, &rest)
}

/// A wall with columns and cornices, and a light above close to it: its light grazes the wall, and the shadows of the cornices
/// are long.
pub fn cornices() -> Arc<Scene> {
    let wall = Model::default().rectangle(2, 0.0, [-6.0, 0.0], [6.0, 9.0]).rectangle(
        1,
        0.0,
        [-1.0, -6.0],
        [8.0, 6.0],
    );
    let ledges = [2.3, 4.4, 6.5].into_iter().fold(Model::default(), |model, y| {
        model.block([-6.0, y, 0.0], [6.0, y + 0.12, 0.28]).block([-6.0, y - 0.1, 0.0], [6.0, y, 0.12])
    });
    let columns = [-4.0, -2.0, 0.0, 2.0, 4.0].into_iter().fold(Model::default(), |model, x| {
        model
            .block([x - 0.15, 0.0, 0.5], [x + 0.15, 3.6, 0.8])
            .block([x - 0.25, 3.6, 0.4], [x + 0.25, 3.8, 0.9])
    });
    scene_of(
        &[wall, ledges, columns],
        r#"
        [[lights]]
        type = "point"
        position = [0.7, 8.2, 0.9]
        intensity = [300, 290, 280]
        [camera]
        eye = [-2.5, 3.8, 8.5]
        target = [0, 3.9, 0]
        vfov_deg = 55
        "#,
    )
}

/// A room with a screen of bars, stairs without risers, a table on thin legs, frames and grooves on the walls: a pixel or three
/// wide at 320x180. The light is in the room beside it, so a pixel sees few of the VPLs: those that it sees through the door.
pub fn thin_features() -> Arc<Scene> {
    let (low, high) = ([-3.0, -3.0], [3.0, 7.0]);
    let room = Model::default()
        .rectangle(1, 0.0, low, high)
        .rectangle(1, 3.0, low, high)
        .rectangle(2, -3.0, [-3.0, 0.0], [7.0, 3.0])
        .rectangle(2, 3.0, [-3.0, 0.0], [7.0, 3.0])
        .rectangle(0, -3.0, [0.0, -3.0], [3.0, 3.0])
        .rectangle(0, 7.0, [0.0, -3.0], [3.0, 3.0])
        .pierced(0, 3.0, [[0.0, -3.0], [3.0, 3.0]], [[0.05, -0.4], [2.5, 2.2]]);
    let bars = (0..22).fold(Model::default(), |model, bar| {
        let x = -2.8 + 0.12 * bar as f32;
        model.block([x, 0.0, -0.54], [x + 0.03, 2.2, -0.49])
    });
    let bars =
        bars.block([-2.85, 2.2, -0.54], [-0.2, 2.25, -0.47]).block([-2.85, 1.1, -0.54], [-0.2, 1.14, -0.47]);
    let stairs = (0..12).fold(Model::default(), |model, step| {
        let (y, z) = (0.18 * (step + 1) as f32, -0.2 - 0.22 * step as f32);
        model.block([1.2, y - 0.04, z - 0.26], [2.6, y, z])
    });
    let legs = [[-0.1, 0.6], [0.8, 0.6], [-0.1, 1.2], [0.8, 1.2]].into_iter();
    let table = legs
        .fold(Model::default().block([-0.15, 0.72, 0.55], [0.89, 0.75, 1.29]), |model, [x, z]| {
            model.block([x, 0.0, z], [x + 0.04, 0.72, z + 0.04])
        });
    let grooves = (0..26).fold(Model::default(), |model, rib| {
        let y = 0.1 + 0.11 * rib as f32;
        model.block([-3.0, y, -3.0], [1.1, y + 0.06, -2.88])
    });
    scene_of(
        &[room, bars, stairs, table, grooves],
        r#"
        [[lights]]
        type = "point"
        position = [5.2, 2.2, -0.8]
        intensity = [100, 95, 90]
        [camera]
        eye = [0.2, 1.5, 2.9]
        target = [-0.1, 1.1, -1]
        vfov_deg = 58
        "#,
    )
}
