//! Changes while the renderer runs: other settings.

use super::passes::Passes;
use super::{RenderError, Renderer};
use crate::scene::Pose;
use crate::settings::{Settings, TracerKind};
use crate::vpl::{VplManager, World};

impl Renderer {
    /// Goes on with other settings, which were checked, from the next frame on; `pose` is where everything
    /// stands now.
    ///
    /// # Errors
    /// Where the device cannot do with them; the renderer then goes on with the old ones.
    pub fn set_settings(&mut self, settings: &Settings, pose: &Pose) -> Result<(), RenderError> {
        if settings.tracer == TracerKind::Hardware {
            return Err(RenderError::NoHardwareTracer);
        }
        if *settings == self.settings {
            return Ok(());
        }
        let mut passes = Passes::new(&self.device, &self.buffers, settings, self.scene.instances.len())?;
        passes.views.prepare(&self.device, &self.view, settings.size)?;
        // Frames on their way still use the old ones.
        self.device.wait_idle()?;
        self.passes = passes;
        self.bvh.update(&pose.instances);
        self.vpls = VplManager::new(World { scene: &self.scene, pose, bvh: &self.bvh }, settings);
        self.settings = settings.clone();
        Ok(())
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}
