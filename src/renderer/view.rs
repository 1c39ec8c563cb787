//! What is shown instead of the picture, or drawn over it: ways to look into the method.
//!
//! In: a [`DebugView`]. Out: which passes run after `combine`; with the default view none does.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::passes::PassInputs;
use super::paths::PathView;
use super::{RenderError, Renderer};
use crate::passes::buffer_view::{BufferViewInputs, BufferViewPass};
use crate::passes::direct_shadows::Shadows;
use crate::passes::gbuffer::GBuffer;
use crate::passes::overlay::OverlayPass;
use crate::passes::set_history::SetHistory;
use crate::passes::tracer::RayTracer;
use crate::passes::vpl_light::{VplLightInputs, VplLightPass};
use crate::vpl::{GpuVpl, VplManager, World};
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError};

pub use crate::passes::buffer_view::BufferView;
pub use crate::passes::overlay::Line;

/// What the colours of light paths mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PathStyle {
    /// The VPL's bounce.
    #[default]
    Bounce,
    /// Its flux.
    Flux,
    /// How many frames ago it was shot.
    Age,
    /// Its temporal set.
    Set,
}

impl PathStyle {
    /// All styles, in the order in which they are offered.
    pub const ALL: [Self; 4] = [Self::Bounce, Self::Flux, Self::Age, Self::Set];

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Bounce => "Bounce",
            Self::Flux => "Flux",
            Self::Age => "Age",
            Self::Set => "Temporal set",
        }
    }
}

/// What to show. The default is the picture, at no cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DebugView {
    /// What to show in place of the picture.
    pub buffer: BufferView,
    /// Which temporal set [`BufferView::SetBuffer`] and [`BufferView::SetReprojected`] show.
    pub set: u32,
    /// Draw VPLs as points and their paths as lines.
    pub vpl_paths: Option<PathStyle>,
    /// Show the light and the path of the VPL in this slot alone, as bright as if all VPLs were like it.
    pub single_vpl: Option<u32>,
    /// Lines to draw over everything.
    pub lines: Vec<Line>,
}

impl DebugView {
    /// Whether anything takes the picture's place.
    fn replaces(&self) -> bool {
        self.buffer != BufferView::Combined || self.single_vpl.is_some()
    }

    /// Whether anything is drawn over the picture.
    fn draws_lines(&self) -> bool {
        self.vpl_paths.is_some() || !self.lines.is_empty()
    }
}

/// The passes of a view, made when they are first needed.
#[derive(Default)]
pub(super) struct ViewPasses {
    buffer: Option<Arc<BufferViewPass>>,
    pub(super) vpl_light: Option<VplLightPass>,
    overlay: Option<Arc<OverlayPass>>,
}

/// The view with what the CPU knows of it in this frame.
pub(super) struct ViewOfFrame<'a> {
    pub view: &'a DebugView,
    /// The single VPL, if it is there.
    pub vpl: Option<GpuVpl>,
    /// What its light is multiplied by.
    pub weight: f32,
    /// All lines.
    pub lines: Vec<Line>,
}

impl<'a> ViewOfFrame<'a> {
    /// What the CPU knows of `view` in the world of this frame; none where there is nothing to show.
    pub fn new(view: &'a DebugView, vpls: &VplManager, world: World<'_>, size: [u32; 2]) -> Option<Self> {
        if !view.replaces() && !view.draws_lines() {
            return None;
        }
        let paths = |style| PathView { style, single: view.single_vpl, height: size[1] }.lines(vpls);
        let mut lines = view.vpl_paths.map(paths).unwrap_or_default();
        lines.extend(&view.lines);
        Some(Self {
            view,
            vpl: view.single_vpl.and_then(|slot| vpls.gpu_vpl(world, slot)),
            weight: vpls.counters().valid as f32,
            lines,
        })
    }
}

/// What the passes of the frame have made and a view shows.
pub(super) struct ViewSources<'a> {
    pub gbuffer: &'a GBuffer,
    pub shadows: &'a Shadows<'a>,
    pub direct: &'a Image,
    pub irradiance: &'a Image,
    pub class_irradiance: &'a Buffer,
    /// The sets that this frame adds to.
    pub drawn_sets: &'a SetHistory,
    /// The sets that the picture is made of.
    pub shown_sets: &'a SetHistory,
    pub exposure: &'a Buffer,
    pub display: &'a Image,
}

impl ViewPasses {
    /// Makes what `view` needs and is not there yet.
    pub fn prepare(
        &mut self,
        device: &Arc<Device>,
        tracer: RayTracer,
        view: &DebugView,
        extent: [u32; 2],
    ) -> Result<(), VulkanError> {
        if view.replaces() && self.buffer.is_none() {
            self.buffer = Some(Arc::new(BufferViewPass::new(device)?));
        }
        if view.single_vpl.is_some() && self.vpl_light.is_none() {
            self.vpl_light = Some(VplLightPass::new(device, tracer, extent)?);
        }
        if view.draws_lines() && self.overlay.is_none() {
            self.overlay = Some(Arc::new(OverlayPass::new(device)?));
        }
        Ok(())
    }

    /// The same passes for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let vpl_light = self.vpl_light.as_ref().map(|pass| pass.resized(device, extent)).transpose()?;
        Ok(Self { buffer: self.buffer.clone(), vpl_light, overlay: self.overlay.clone() })
    }

    /// Writes the view over the picture.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &PassInputs<'_>,
        shown: &ViewOfFrame<'_>,
        sources: &ViewSources<'_>,
    ) -> Result<(), VulkanError> {
        let gbuffer = sources.gbuffer;
        let one_vpl = match &self.vpl_light {
            Some(pass) if shown.view.single_vpl.is_some() => {
                let light = VplLightInputs {
                    frame: &inputs.frame,
                    gbuffer,
                    tracer: inputs.tracer,
                    vpl: shown.vpl,
                    weight: shown.weight,
                };
                Some(pass.record(frame, &light)?)
            }
            _ => None,
        };
        if let Some(pass) = self.buffer.as_ref().filter(|_| shown.view.replaces()) {
            let filtered = shown.view.buffer == BufferView::Filtered;
            let buffers = BufferViewInputs {
                frame: &inputs.frame,
                gbuffer,
                materials: &inputs.scene.materials,
                shadows: sources.shadows,
                direct: sources.direct,
                irradiance: one_vpl.unwrap_or(sources.irradiance),
                one_vpl: one_vpl.is_some(),
                class_irradiance: sources.class_irradiance,
                sets: if filtered { sources.drawn_sets } else { sources.shown_sets },
                set: if filtered { inputs.drawn.set } else { shown.view.set },
                interleave: inputs.settings.interleave,
                instances: &inputs.instances.data,
                pose: inputs.pose,
                bounds: inputs.bounds,
                exposure: sources.exposure,
            };
            pass.record(frame, shown.view.buffer, &buffers, sources.display)?;
        }
        match &self.overlay {
            Some(pass) => pass.record(frame, &inputs.frame, &shown.lines, &gbuffer.depth, sources.display),
            None => Ok(()),
        }
    }
}

impl Renderer {
    /// Shows `view` from the next frame on.
    ///
    /// # Errors
    /// Where the device cannot make what the view needs; the view then stays as it was.
    pub fn set_view(&mut self, view: &DebugView) -> Result<(), RenderError> {
        self.passes.views.prepare(&self.device, self.tracer.kind(), view, self.settings.size)?;
        self.view.clone_from(view);
        Ok(())
    }

    /// The view that is shown.
    pub fn view(&self) -> &DebugView {
        &self.view
    }

    /// What the last frame shows: RGBA8, sRGB-encoded. Another image after a change of size.
    pub fn display(&self) -> &Image {
        self.passes.combine.display()
    }
}
