//! The divided window: right of the divider the same world at the same moment by other settings, or the truth.

use std::sync::Arc;

use serde::Serialize;

use super::DemoError;
use super::live_metrics::{LiveMetrics, Logged, Shot};
use super::stage::Stage;
use super::truth::Truth;
use crate::renderer::{RenderError, Renderer};
use crate::report::FrameReport;
use crate::settings::Settings;
use crate::vulkan::{Device, Pane};

/// What to show right of the divider.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RightSide {
    /// A renderer with these settings; their size is that of the picture.
    Settings(Box<Settings>),
    /// The path tracer's picture, as long as nothing moves.
    Truth,
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
    Truth(Box<Truth>),
}

/// Another renderer of the stage's world.
pub(super) struct Other {
    pub renderer: Renderer,
    pub settings: Settings,
    pub report: FrameReport,
}

impl Split {
    /// Divides the window in the middle. With a renderer, that of the stage starts again, so that both have the same past.
    pub fn new(device: &Arc<Device>, stage: &mut Stage, side: RightSide) -> Result<Self, DemoError> {
        let right = Right::new(device, stage, side)?;
        Ok(Self { at: 0.5, shows_difference: false, right, metrics: LiveMetrics::default() })
    }

    /// Shows something else right of the divider.
    pub fn show(
        &mut self,
        device: &Arc<Device>,
        stage: &mut Stage,
        side: RightSide,
    ) -> Result<(), DemoError> {
        match (&mut self.right, side) {
            (Right::Renderer(other), RightSide::Settings(settings)) => {
                let settings = Settings { size: stage.settings.size, ..*settings };
                other.renderer.set_settings(&settings, &stage.pose)?;
                other.settings = settings;
            }
            (right, side) => *right = Right::new(device, stage, side)?,
        }
        self.metrics.forget();
        Ok(())
    }

    /// Draws the frame that the stage has just drawn with this pace of exposure, and compares both sides now and then.
    pub fn render(&mut self, stage: &Stage, pace: f32) -> Result<(), DemoError> {
        match &mut self.right {
            Right::Renderer(other) => other.render(stage, pace)?,
            Right::Truth(truth) => truth.follow(stage),
        }
        if self.metrics.is_due()
            && let Some(right) = self.right_shot()?
        {
            self.metrics.compare(stage.shot()?, right);
        }
        Ok(())
    }

    /// What the whole window would show of the right side; none where the truth has no picture yet.
    pub fn right_shot(&self) -> Result<Option<Shot>, DemoError> {
        Ok(match &self.right {
            Right::Renderer(other) => {
                Some(Shot { size: other.settings.size, pixels: other.renderer.read_display()? })
            }
            Right::Truth(truth) => truth.progress().map(|progress| progress.shot.clone()),
        })
    }

    /// A comparison for the log, once.
    pub fn take_log(&mut self) -> Option<Logged> {
        let samples = match &self.right {
            Right::Truth(truth) => truth.progress().map(|progress| progress.samples),
            Right::Renderer(_) => None,
        };
        self.metrics.take_log(samples)
    }

    /// The pictures to present.
    pub fn panes<'a>(&'a self, stage: &'a Stage) -> Vec<Pane<'a>> {
        let pane = |renderer: &'a Renderer, columns| Pane { picture: renderer.display(), columns };
        match &self.right {
            Right::Renderer(other) => {
                vec![pane(&stage.renderer, [0.0, self.at]), pane(&other.renderer, [self.at, 1.0])]
            }
            // The interface draws the truth over the picture.
            Right::Truth(_) => vec![pane(&stage.renderer, [0.0, 1.0])],
        }
    }
}

impl Right {
    fn new(device: &Arc<Device>, stage: &mut Stage, side: RightSide) -> Result<Self, DemoError> {
        Ok(match side {
            RightSide::Truth => Self::Truth(Box::default()),
            RightSide::Settings(settings) => {
                let settings = Settings { size: stage.settings.size, ..*settings };
                let prepared = stage.renderer.prepared();
                let renderer = Renderer::with_scene(device, prepared.clone(), &settings, &stage.pose)?;
                stage.renderer.replace_scene(prepared, &stage.settings, &stage.pose)?;
                Self::Renderer(Box::new(Other { renderer, settings, report: FrameReport::default() }))
            }
        })
    }
}

impl Other {
    fn render(&mut self, stage: &Stage, pace: f32) -> Result<(), RenderError> {
        if !Arc::ptr_eq(self.renderer.scene(), stage.renderer.scene()) {
            self.renderer.set_scene(stage.renderer.scene(), &stage.pose)?;
        }
        if self.settings.size != stage.settings.size {
            self.settings.size = stage.settings.size;
            self.renderer.set_settings(&self.settings, &stage.pose)?;
        }
        self.renderer.set_exposure_pace(pace);
        self.renderer.render(&stage.pose)?;
        if let Some(report) = self.renderer.take_reports().pop() {
            self.report = report;
        }
        Ok(())
    }
}
