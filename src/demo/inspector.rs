//! Inspector: the material at a point, and the VPLs that light it.

use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};

use super::error::DemoError;
use super::session::Session;
use crate::estimators::vpls::{SlotHistory, SlotView, VplContribution, Vpls};
use crate::renderer::{DebugView, Line, Picked};
use crate::scene::WorldSurface;

/// Most VPLs to list.
const LISTED: usize = 24;
/// Time between readings of the pixel under the pointer.
const READ: Duration = Duration::from_millis(250);
/// Colours of visibility rays: unoccluded, occluded.
const RAY_COLOURS: [[f32; 4]; 2] = [[0.3, 1.0, 0.4, 0.9], [1.0, 0.2, 0.2, 0.7]];

/// The inspector: off, awaiting a click, or inspecting a point.
#[derive(Default)]
pub(super) struct Inspector {
    pub is_on: bool,
    /// The point that was clicked.
    pub point: Option<Picked>,
    /// The material to edit, at the point or chosen: index into the scene's.
    pub material: Option<usize>,
    /// The VPLs that light it, the strongest first.
    pub found: Vec<Found>,
    /// Whether the renderer's view holds lines of the inspector.
    drawn: bool,
    /// A description of the pixel under the pointer, and when it was read.
    pub pixel: Option<(String, Instant)>,
}

/// A VPL that lights the point.
pub(super) struct Found {
    pub contribution: VplContribution,
    pub slot: SlotView,
    /// Slots from the first bounce to this VPL.
    pub path: Vec<u32>,
    pub history: Option<SlotHistory>,
}

impl Inspector {
    pub fn toggle(&mut self) {
        self.is_on = !self.is_on;
        self.choose(None);
        self.found.clear();
    }

    /// Chooses a material, of no point; none: forgets both, which may be of another scene.
    pub fn choose(&mut self, material: Option<usize>) {
        (self.point, self.material) = (None, material);
    }

    /// Inspects the surface at a position of the picture.
    pub fn look(&mut self, session: &Session, at: Vec2) {
        self.point = session.pick(at);
        self.material = self.point.map(|point| point.material);
    }

    /// Reads the pixel at a position of the picture, a few times a second.
    pub fn read(&mut self, session: &Session, at: Vec2) -> Result<(), DemoError> {
        if !self.is_on || self.pixel.as_ref().is_some_and(|(_, since)| since.elapsed() < READ) {
            return Ok(());
        }
        let is_inside = at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all();
        self.pixel = None;
        let Some(picked) = session.pick(at).filter(|_| is_inside) else { return Ok(()) };
        let picture = session.renderer.read_picture(true)?;
        let [x, y] = [at.x * picture.width as f32, at.y * picture.height as f32].map(|at| at as usize);
        let pixel = y * picture.width + x;
        let [r, g, b] = picture.colour[pixel];
        let indirect = picture.layers.iter().find(|layer| layer.name == "indirect");
        let irradiance = indirect.map_or(String::new(), |layer| {
            let [r, g, b] = [0, 1, 2].map(|channel| layer.channels[channel].1[pixel]);
            format!("\nindirect irradiance {r:.3} {g:.3} {b:.3} W/m²")
        });
        let scene = &session.scene;
        let [instance, material] =
            [&scene.instances[picked.instance].name, &scene.materials[picked.material].name];
        let Vec3 { x: px, y: py, z: pz } = picked.surface.position;
        let text = format!(
            "pixel {x}, {y}: {instance}, {material}\nat {px:.3} {py:.3} {pz:.3}, {:.3} away\nradiance {r:.3} {g:.3} {b:.3} \
             W/m²/sr{irradiance}",
            picked.distance
        );
        self.pixel = Some((text, Instant::now()));
        Ok(())
    }

    /// Updates the list for the current pose, and draws the visibility rays.
    pub fn refresh(&mut self, session: &mut Session) -> Result<(), DemoError> {
        self.found.clear();
        let lines = match &self.point {
            None => Vec::new(),
            Some(point) => {
                let renderer = &session.renderer;
                let Some(estimator) = renderer.estimator::<Vpls>() else { return Ok(()) };
                let vpls = estimator.manager();
                let slots: Vec<SlotView> = vpls.slots().collect();
                let pose = session.pose.about(renderer.anchor());
                let position = point.surface.position - renderer.anchor();
                let surface = WorldSurface { position, ..point.surface };
                let contributions = estimator.inspect(renderer.world(&pose), &surface);
                self.found.extend(contributions.into_iter().take(LISTED).map(|contribution| {
                    let slot = slots[contribution.slot as usize];
                    Found {
                        contribution,
                        slot,
                        path: vpls.path_to(contribution.slot),
                        history: vpls.history(contribution.slot),
                    }
                }));
                let from = point.surface.position;
                self.found
                    .iter()
                    .map(|found| {
                        let to = found.contribution.position + renderer.anchor();
                        ray(from, to, &found.contribution)
                    })
                    .collect()
            }
        };
        if self.drawn || !lines.is_empty() {
            self.drawn = !lines.is_empty();
            let view = DebugView { lines, ..session.renderer.view().clone() };
            session.renderer.set_view(&view)?;
        }
        Ok(())
    }
}

fn ray(from: Vec3, to: Vec3, contribution: &VplContribution) -> Line {
    let colour = RAY_COLOURS[usize::from(!contribution.visible)];
    Line { from, to, colour, width: 1.5, hidden: 0.3 }
}
