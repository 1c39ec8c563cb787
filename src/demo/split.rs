//! The divided window: right of the divider the same world by other settings, the reference, or the picture of a file.
//!
//! Two methods take turns: each gets half of the time, so that the faster one draws more frames, and each shows the world as it
//! was when it drew. Where both are compared, they draw the same moment.

use std::sync::Arc;

use super::action::RightSide;
use super::error::DemoError;
use super::file_picture::FilePicture;
use super::live_metrics::{LiveMetrics, Logged, Shot};
use super::live_reference::LiveReference;
use super::session::Session;
use crate::estimators;
use crate::renderer::{RenderError, Renderer};
use crate::report::FrameReport;
use crate::settings::Settings;
use crate::vulkan::{Device, Pane};

/// Most frames that one side draws while the other waits.
const MOST_FRAMES: f64 = 32.0;

/// The divided window.
pub(super) struct Split {
    /// Where the divider is, share of the width.
    pub at: f32,
    /// Whether the error of the left side is shown in place of the pictures.
    pub shows_difference: bool,
    pub right: Right,
    pub metrics: LiveMetrics,
    /// Time that the frames of the left and of the right side took, ms, but for what both took.
    taken_ms: [f64; 2],
    /// Whether this frame is one of both sides.
    is_compared: bool,
}

/// Right of the divider.
pub(super) enum Right {
    Renderer(Box<Other>),
    Reference(Box<LiveReference>),
    Picture(Box<FilePicture>),
}

/// Another renderer of the session's world.
pub(super) struct Other {
    pub renderer: Renderer,
    pub settings: Settings,
    pub report: FrameReport,
}

impl RightSide {
    /// Settings that differ tellingly from `settings`: one temporal set beside several, or several beside one; VPLs beside other methods.
    pub fn beside(settings: &Settings) -> Self {
        let mut other = settings.clone();
        let axis = estimators::method(settings).axes.iter().find(|axis| axis.divides_work);
        if let Some(axis) = axis {
            let most = (axis.get)(&Settings::default());
            (axis.set)(&mut other, if (axis.get)(settings) == 1 { most } else { 1 });
        } else {
            other.indirect = Settings::default().indirect;
        }
        Self::Settings(Box::new(other))
    }
}

impl Split {
    /// Divides the window in the middle.
    pub fn new(right: Right) -> Self {
        Self {
            at: 0.5,
            shows_difference: false,
            right,
            metrics: LiveMetrics::default(),
            taken_ms: [0.0; 2],
            is_compared: true,
        }
    }

    /// Sets what is right of the divider.
    pub fn set_right(&mut self, right: Right) {
        self.right = right;
        self.restart();
    }

    /// Goes on with the renderer right of the divider by other settings.
    pub fn set_settings(&mut self, session: &Session, settings: &Settings) -> Result<(), DemoError> {
        if let Right::Renderer(other) = &mut self.right {
            let settings = Settings { size: session.settings.size, ..settings.clone() };
            other.renderer.set_settings(&settings, &session.pose)?;
            other.settings = settings;
        }
        self.restart();
        Ok(())
    }

    /// Compares and shares time anew, since one of the sides has changed.
    fn restart(&mut self) {
        self.metrics.forget();
        self.taken_ms = [0.0; 2];
    }

    /// Which sides are to draw this frame, left and right: that which has had less time, or both where they are compared.
    pub fn turns(&mut self, session: &Session) -> [bool; 2] {
        self.is_compared = self.metrics.is_due(self.pair(session));
        let Right::Renderer(other) = &self.right else { return [true; 2] };
        let costs = [&session.report, &other.report].map(|report| report.figures.total_ms);
        let less = usize::from(self.taken_ms[1] < self.taken_ms[0]);
        // Before the first reports, and where nothing moves, there is nothing to share.
        if self.is_compared || costs.contains(&0.0) {
            return [true; 2];
        }
        self.taken_ms[less] += costs[less];
        // The first frame of all compiles shaders: no side waits longer for it than for so many frames of the other.
        let (both, most) = (self.taken_ms[0].min(self.taken_ms[1]), MOST_FRAMES * costs[0].min(costs[1]));
        self.taken_ms = self.taken_ms.map(|ms| (ms - both).min(most));
        [less == 0, less == 1]
    }

    /// Draws the right side of the session's world as it stands, with this pace of exposure, if it is its turn, and compares both sides now
    /// and then.
    pub fn render(&mut self, session: &Session, pace: f32, is_turn: bool) -> Result<(), DemoError> {
        match &mut self.right {
            Right::Renderer(other) if is_turn => other.render(session, pace)?,
            Right::Renderer(_) => {}
            Right::Reference(reference) => reference.follow(session),
            Right::Picture(picture) => {
                picture.follow(&session.settings);
                if !picture.is_whole(&session.settings) {
                    self.metrics.forget();
                    return Ok(());
                }
            }
        }
        if self.is_compared
            && let Some(right) = self.right_shot()?
        {
            self.metrics.compare(session.shot()?, right, self.pair(session));
        }
        Ok(())
    }

    /// Tells the pictures of both sides from those before.
    fn pair(&self, session: &Session) -> [u64; 2] {
        let right = match &self.right {
            Right::Renderer(other) => other.renderer.drawn_frame(),
            Right::Reference(reference) => reference.version,
            Right::Picture(picture) => picture.version,
        };
        [session.renderer.drawn_frame(), right]
    }

    /// Whether no frame of the right side would differ from the last one. What the CPU draws goes on by itself.
    pub fn is_frozen(&self) -> bool {
        !matches!(&self.right, Right::Renderer(other) if !other.renderer.is_frozen())
    }

    /// The right side's picture for the whole window; none where the reference has no picture yet.
    pub fn right_shot(&self) -> Result<Option<Arc<Shot>>, DemoError> {
        if let Right::Renderer(other) = &self.right {
            let shot = Shot { size: other.settings.size, pixels: other.renderer.read_display()? };
            return Ok(Some(Arc::new(shot)));
        }
        Ok(self.right_of_cpu().cloned())
    }

    /// The right side's picture, if the CPU makes it.
    pub fn right_of_cpu(&self) -> Option<&Arc<Shot>> {
        match &self.right {
            Right::Renderer(_) => None,
            Right::Reference(reference) => reference.progress.as_ref().map(|progress| &progress.shot),
            Right::Picture(picture) => Some(&picture.shot),
        }
    }

    /// A comparison for the log, once.
    pub fn take_log(&mut self) -> Option<Logged> {
        let samples = match &self.right {
            Right::Reference(reference) => reference.progress.as_ref().map(|progress| progress.samples),
            Right::Renderer(_) | Right::Picture(_) => None,
        };
        self.metrics.take_log(samples)
    }

    /// The pictures to present.
    pub fn panes<'a>(&'a self, session: &'a Session) -> Vec<Pane<'a>> {
        let pane = |renderer: &'a Renderer, columns| Pane { picture: renderer.display(), columns };
        match &self.right {
            Right::Renderer(other) => {
                vec![pane(&session.renderer, [0.0, self.at]), pane(&other.renderer, [self.at, 1.0])]
            }
            // The interface draws pictures of the CPU over this one.
            Right::Reference(_) | Right::Picture(_) => vec![pane(&session.renderer, [0.0, 1.0])],
        }
    }
}

impl Right {
    /// A new renderer with these settings. The session's renderer starts again, so that both have the same past.
    pub fn of_settings(
        device: &Arc<Device>,
        session: &mut Session,
        settings: &Settings,
    ) -> Result<Self, DemoError> {
        let settings = Settings { size: session.settings.size, ..settings.clone() };
        let prepared = session.renderer.prepared();
        let renderer = Renderer::with_scene(device, prepared.clone(), &settings, &session.pose)?;
        session.renderer.replace_scene(prepared, &session.settings, &session.pose)?;
        Ok(Self::Renderer(Box::new(Other { renderer, settings, report: FrameReport::default() })))
    }
}

impl Other {
    fn render(&mut self, session: &Session, pace: f32) -> Result<(), RenderError> {
        if !Arc::ptr_eq(self.renderer.scene(), session.renderer.scene()) {
            self.renderer.set_scene(session.renderer.scene(), &session.pose)?;
        }
        if self.settings.size != session.settings.size {
            self.settings.size = session.settings.size;
            self.renderer.set_settings(&self.settings, &session.pose)?;
        }
        self.renderer.set_exposure_pace(pace);
        self.renderer.render(&session.pose)?;
        if let Some(report) = self.renderer.take_reports().pop() {
            self.report = report;
        }
        Ok(())
    }
}
