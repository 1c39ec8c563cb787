//! The divided window: right of the divider the same world at the same moment by other settings, or the reference.

use std::sync::Arc;

use serde::Serialize;

use super::DemoError;
use super::live_metrics::{LiveMetrics, Logged, Shot};
use super::live_reference::LiveReference;
use super::session::Session;
use crate::renderer::{RenderError, Renderer};
use crate::report::FrameReport;
use crate::settings::Settings;
use crate::vulkan::{Device, Pane};

/// The picture to show right of the divider.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RightSide {
    /// A renderer with these settings; their size is that of the picture.
    Settings(Box<Settings>),
    /// The path tracer's picture, as long as nothing moves.
    Reference,
}

/// The divided window.
pub(super) struct Split {
    /// Where the divider is, share of the width.
    pub at: f32,
    /// Whether the error of the left side is shown in place of the pictures.
    pub shows_difference: bool,
    pub right: Right,
    pub metrics: LiveMetrics,
}

/// Right of the divider.
pub(super) enum Right {
    Renderer(Box<Other>),
    Reference(Box<LiveReference>),
}

/// Another renderer of the session's world.
pub(super) struct Other {
    pub renderer: Renderer,
    pub settings: Settings,
    pub report: FrameReport,
}

impl Split {
    /// Divides the window in the middle. With a renderer, that of the session starts again, so that both have the same past.
    pub fn new(device: &Arc<Device>, session: &mut Session, side: RightSide) -> Result<Self, DemoError> {
        let right = Right::new(device, session, side)?;
        Ok(Self { at: 0.5, shows_difference: false, right, metrics: LiveMetrics::default() })
    }

    /// Sets what is right of the divider.
    pub fn set_right(
        &mut self,
        device: &Arc<Device>,
        session: &mut Session,
        side: RightSide,
    ) -> Result<(), DemoError> {
        match (&mut self.right, side) {
            (Right::Renderer(other), RightSide::Settings(settings)) => {
                let settings = Settings { size: session.settings.size, ..*settings };
                other.renderer.set_settings(&settings, &session.pose)?;
                other.settings = settings;
            }
            (right, side) => *right = Right::new(device, session, side)?,
        }
        self.metrics.forget();
        Ok(())
    }

    /// Draws the frame that the session has just drawn with this pace of exposure, and compares both sides now and then.
    pub fn render(&mut self, session: &Session, pace: f32) -> Result<(), DemoError> {
        match &mut self.right {
            Right::Renderer(other) => other.render(session, pace)?,
            Right::Reference(reference) => reference.follow(session),
        }
        if self.metrics.is_due()
            && let Some(right) = self.right_shot()?
        {
            self.metrics.compare(session.shot()?, right);
        }
        Ok(())
    }

    /// The right side's picture for the whole window; none where the reference has no picture yet.
    pub fn right_shot(&self) -> Result<Option<Shot>, DemoError> {
        Ok(match &self.right {
            Right::Renderer(other) => {
                Some(Shot { size: other.settings.size, pixels: other.renderer.read_display()? })
            }
            Right::Reference(reference) => reference.progress().map(|progress| progress.shot.clone()),
        })
    }

    /// A comparison for the log, once.
    pub fn take_log(&mut self) -> Option<Logged> {
        let samples = match &self.right {
            Right::Reference(reference) => reference.progress().map(|progress| progress.samples),
            Right::Renderer(_) => None,
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
            // The interface draws the reference over the picture.
            Right::Reference(_) => vec![pane(&session.renderer, [0.0, 1.0])],
        }
    }
}

impl Right {
    fn new(device: &Arc<Device>, session: &mut Session, side: RightSide) -> Result<Self, DemoError> {
        Ok(match side {
            RightSide::Reference => Self::Reference(Box::default()),
            RightSide::Settings(settings) => {
                let settings = Settings { size: session.settings.size, ..*settings };
                let prepared = session.renderer.prepared();
                let renderer = Renderer::with_scene(device, prepared.clone(), &settings, &session.pose)?;
                session.renderer.replace_scene(prepared, &session.settings, &session.pose)?;
                Self::Renderer(Box::new(Other { renderer, settings, report: FrameReport::default() }))
            }
        })
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
