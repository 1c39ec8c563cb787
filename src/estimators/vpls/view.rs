//! Ways to look into the method: its images, single VPLs, paths.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::set_buffers::{SetBuffers, SetPush};
use super::vpl_buffer::UploadedSet;
use crate::estimators::ViewInputs;
use crate::passes::buffer_view::View;
use crate::settings::MissingSets;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// The set buffer of the frame.
const FILTERED: &str = "filtered";
/// Needs a single VPL.
pub const VPL_VISIBILITY: &str = "vpl-visibility";

/// Shows how old light is.
pub const STALENESS: &str = "staleness";

/// Shows all VPLs as points.
pub const VPL_USEFULNESS: &str = "vpl-usefulness";

/// The views of the method. A view's place in the list is its number in shaders/estimators/vpls/vpl_view.comp.
pub const VIEWS: &[View] = &[
    View {
        name: "unfiltered",
        label: "This set, before the filter",
        about: "What this frame has rendered before the filter: each texel has a few VPLs of its own",
    },
    View {
        name: FILTERED,
        label: "This set, after the filter",
        about: "The set buffer of this frame: what it gathered, after the filter",
    },
    View {
        name: "set-buffer",
        label: "Set buffer as rendered",
        about: "The buffer of a set as it was rendered, by the camera of that time",
    },
    View {
        name: "set-reprojected",
        label: "Set buffer reprojected",
        about: "The buffer of a set brought into the current view; magenta where it has not seen the surface",
    },
    View {
        name: "set-count",
        label: "Valid sets per pixel",
        about: "How many of the sets have seen each pixel's surface: from black (none) over blue and green to yellow (all)",
    },
    View {
        name: STALENESS,
        label: "Staleness",
        about: "How many frames old the light of each pixel is, on average: from black (this frame) over blue and green to yellow (as many as there are sets, or more); magenta where no set has seen the surface",
    },
    View {
        name: VPL_VISIBILITY,
        label: "Visibility of a VPL",
        about: "Which pixels the single VPL sees: white",
    },
    View {
        name: VPL_USEFULNESS,
        label: "Usefulness of VPLs",
        about: "All VPLs over the dimmed indirect light: blue where they light something that the camera sees, orange where not",
    },
];

/// The colours of light paths show one of these.
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
    /// Whether it lights something that the camera sees.
    Usefulness,
}

impl PathStyle {
    /// All styles, in the order in which they are offered.
    pub const ALL: [Self; 5] = [Self::Bounce, Self::Flux, Self::Age, Self::Set, Self::Usefulness];

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Bounce => "Bounce",
            Self::Flux => "Flux",
            Self::Age => "Age",
            Self::Set => "Temporal set",
            Self::Usefulness => "Usefulness",
        }
    }
}

/// The options of the method's views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct VplDebugView {
    /// Which temporal set the views `set-buffer` and `set-reprojected` show.
    #[serde(skip_serializing_if = "is_first")]
    pub set: u32,
    /// Draw VPLs as points and their paths as lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vpl_paths: Option<PathStyle>,
    /// Draw at most this many of the paths, evenly chosen; none: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_sample: Option<u32>,
    /// Show the light and the path of the VPL in this slot alone, as bright as if all VPLs were like it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_vpl: Option<u32>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_first(set: &u32) -> bool {
    *set == 0
}

/// Whether a view shows one of the sets.
pub fn shows_a_set(view: &str) -> bool {
    view == "set-buffer" || view == "set-reprojected"
}

/// The colours of a share of 0, of 1, and between; twin: `share_colour` in shaders/include/false_colour.glsl.
pub const SHARE_COLOURS: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.05], [0.15, 0.2, 0.75], [0.1, 0.65, 0.45], [1.0, 0.92, 0.2]];

/// Draws [`VIEWS`].
pub struct VplViewPass {
    pipeline: ComputePipeline,
}

/// The pass reads these besides [`ViewInputs`].
pub struct VplViewSources<'a> {
    /// The VPLs of the frame's set.
    pub vpls: &'a UploadedSet,
    /// Irradiance before the filter.
    pub sampled_irradiance: &'a Image,
    /// Irradiance, or that of a single VPL.
    pub irradiance: &'a Image,
    /// The sets that this frame adds to, and the one that it rendered.
    pub rendered: (&'a SetBuffers, u32),
    /// The sets that the picture is made of, and the one to show.
    pub shown: (&'a SetBuffers, u32),
}

impl VplViewPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: ComputePipeline::new(device, "vpl_view", shaders::VPL_VIEW_COMP)? })
    }

    /// Writes one of [`VIEWS`] over the picture.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &ViewInputs<'_>,
        sources: &VplViewSources<'_>,
        view: &str,
    ) -> Result<(), VulkanError> {
        let (sets, set) = if view == FILTERED { sources.rendered } else { sources.shown };
        let Some(view) = VIEWS.iter().position(|known| known.name == view) else { return Ok(()) };
        let push = SetPush {
            shown_set: set.min(sets.count() - 1),
            view: view as u32,
            frame: inputs.frame.clock.frame as u32,
            rendered_step: sources.rendered.0.step(),
            ..sets.push(MissingSets::Dark, &[])
        };
        let pass = inputs
            .frame
            .bind(frame.pass("vpl_view", &self.pipeline))
            .read("gbuffer_instance", &inputs.frame.gbuffer.instance)
            .read("sampled_irradiance", sources.sampled_irradiance)
            .read("irradiance", sources.irradiance)
            .read("exposure", inputs.exposure)
            .write("display", inputs.display)
            .push(&push);
        let pass = sets.bind(sources.vpls.bind(pass));
        pass.dispatch_over(inputs.display.extent())
    }
}
