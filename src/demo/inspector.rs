//! Inspector: the material at a point, and the VPLs that light it.

use glam::{Vec2, Vec3};

use super::DemoError;
use super::session::Session;
use crate::estimators::vpls::{SlotHistory, SlotView, VplContribution, Vpls};
use crate::renderer::{DebugView, Line, Picked};
use crate::scene::WorldSurface;

/// Most VPLs to list.
const LISTED: usize = 24;
/// Colours of visibility rays: unoccluded, occluded.
const RAY_COLOURS: [[f32; 4]; 2] = [[0.3, 1.0, 0.4, 0.9], [1.0, 0.2, 0.2, 0.7]];

/// The inspector: off, awaiting a click, or inspecting a point.
#[derive(Default)]
pub(super) struct Inspector {
    on: bool,
    point: Option<Picked>,
    /// The VPLs that light it, the strongest first.
    pub found: Vec<Found>,
    /// Whether the renderer's view holds lines of the inspector.
    drawn: bool,
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
    pub fn is_on(&self) -> bool {
        self.on
    }

    pub fn toggle(&mut self) {
        self.on = !self.on;
        self.point = None;
        self.found.clear();
    }

    /// Whether a point was clicked.
    pub fn has_point(&self) -> bool {
        self.point.is_some()
    }

    /// Forgets the point, which was one of another scene.
    pub fn forget(&mut self) {
        self.point = None;
    }

    /// The material at the point: index into the scene's.
    pub fn material(&self) -> Option<usize> {
        self.point.map(|point| point.material)
    }

    /// Inspects the surface at a position of the picture.
    pub fn look(&mut self, session: &Session, at: Vec2) {
        self.point = session.pick(at);
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
