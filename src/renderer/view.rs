//! Debug views: they stand in place of the picture, or are drawn over it.
//!
//! In: a [`DebugView`]. Out: which passes run after `combine`; with the default view none does.

use glam::Vec3;

use super::{DebugView, RenderError, Renderer};
use crate::estimators::{self, Estimator, ViewInputs};
use crate::passes::buffer_view::{BufferViewInputs, BufferViewPass, COMBINED, number_of};
use crate::passes::effect_view::{EffectViewPass, VIEWS, Visualization};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::overlay::{Line, OverlayPass};
use crate::vulkan::{Buffer, Frame, Image, VulkanError};

/// The passes of views, made when they are first needed.
#[derive(Default)]
pub(super) struct ViewPasses {
    buffer: Option<BufferViewPass>,
    effect: Option<EffectViewPass>,
    overlay: Option<OverlayPass>,
}

/// The results of the frame's passes that a view shows.
pub(super) struct ViewFrame<'a> {
    pub view: &'a DebugView,
    /// Origin of positions in the frame, world units.
    pub anchor: Vec3,
    pub inputs: &'a FrameInputs<'a>,
    pub irradiance: &'a Image,
    pub direct_shadows: &'a Image,
    pub direct: &'a Image,
    /// The image of an effect, if the view shows one.
    pub effect: Option<(&'a Image, Visualization)>,
    /// World-space bounds of all that is visible.
    pub bounds: (Vec3, Vec3),
    pub exposure: &'a Buffer,
    pub display: &'a Image,
}

impl ViewPasses {
    /// Writes the view over the picture.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        estimator: &dyn Estimator,
        shown: &ViewFrame<'_>,
    ) -> Result<(), VulkanError> {
        let ViewFrame { view, inputs, exposure, display, .. } = *shown;
        match (number_of(&view.buffer), &self.buffer) {
            (Some(number), Some(pass)) => {
                let alone = estimator.shown_irradiance(frame, inputs)?;
                if view.buffer != COMBINED || alone.is_some() {
                    let buffers = BufferViewInputs {
                        frame: inputs,
                        direct_shadows: shown.direct_shadows,
                        direct: shown.direct,
                        irradiance: alone.unwrap_or(shown.irradiance),
                        bounds: shown.bounds,
                        exposure,
                    };
                    pass.record(frame, number, &buffers, display)?;
                }
            }
            (None, _) if VIEWS.iter().any(|known| known.name == view.buffer) => {
                let Some(pass) = &self.effect else { return Ok(()) };
                pass.record(frame, inputs.uniforms, shown.effect, exposure, display)?;
            }
            (None, _) => {
                // Views of methods and filters that are not in use stay so.
                frame.clear_image(display, [0.0, 0.0, 0.0, 1.0]);
                estimator.draw_view(frame, &ViewInputs { frame: inputs, exposure, display }, &view.buffer)?;
            }
            (Some(_), None) => {}
        }
        let Some(overlay) = &self.overlay else { return Ok(()) };
        let mut lines = estimator.lines();
        let about = |at: Vec3| at - shown.anchor;
        lines.extend(view.lines.iter().map(|line| Line {
            from: about(line.from),
            to: about(line.to),
            ..*line
        }));
        overlay.record(frame, inputs.uniforms, &lines, &inputs.gbuffer.depth, display)
    }
}

impl Renderer {
    /// Shows `view` from the next frame on.
    ///
    /// # Errors
    /// Where the device cannot make what the view needs; the view then stays as it was.
    pub fn set_view(&mut self, view: &DebugView) -> Result<(), RenderError> {
        self.estimator.set_view(view)?;
        if *view != DebugView::default() {
            if self.views.buffer.is_none() {
                self.views.buffer =
                    Some(BufferViewPass::new(&self.device, self.gpu_scene.variant().thin_surfaces)?);
            }
            if self.views.effect.is_none() {
                self.views.effect = Some(EffectViewPass::new(&self.device)?);
            }
            if self.views.overlay.is_none() {
                self.views.overlay = Some(OverlayPass::new(&self.device)?);
            }
        }
        if view.is_picture() != self.view.is_picture() {
            self.clock.disturb();
        }
        self.redraws |= *view != self.view;
        self.view.clone_from(view);
        Ok(())
    }

    /// Users should know these facts about the method and the scene, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let method = estimators::method(&self.resolved);
        let mut warnings = self.estimator.warnings();
        if self.passes.reflections.is_some() && !method.lights_hits {
            warnings.push(format!(
                "--indirect {}: it cannot light what reflections see beyond the screen, so that lacks indirect light there",
                method.name()
            ));
        }
        warnings
    }

    /// The view that is shown.
    pub fn view(&self) -> &DebugView {
        &self.view
    }

    /// The display image of the last frame: RGBA8, sRGB-encoded. A change of size makes another image.
    pub fn display(&self) -> &Image {
        self.passes.combine.display()
    }
}
