//! The view: session, divided window, time, camera, resolution and inspector, with the actions that change what is shown.

use std::sync::Arc;

use super::action::{HandleMode, RightSide, ViewAction};
use super::clock::Clock;
use super::error::DemoError;
use super::file_picture::{FilePicture, Reading};
use super::flight::Flight;
use super::inspector::Inspector;
use super::interface::Interface;
use super::picture_size::PictureSize;
use super::recorder::Recording;
use super::session::Session;
use super::split::{Right, Split};
use super::undo::Press;
use crate::estimators;
use crate::estimators::vpls::{PathStyle, SlotState, VplDebugView, Vpls};
use crate::output::automatic_exposure;
use crate::renderer::DebugView;
use crate::scene::Camera;
use crate::settings::Settings;
use crate::vulkan::Device;

/// VPL paths that are shown at first: few enough to be told apart.
const FEW_PATHS: u32 = 128;

/// The state of what is shown. The session drops first, the device after all.
pub(super) struct View {
    pub session: Option<Session>,
    pub split: Option<Split>,
    /// The picture that is to be right of the divider.
    pub reading: Option<Reading>,
    pub recording: Recording,
    pub clock: Clock,
    pub flight: Flight,
    pub size: PictureSize,
    pub inspector: Inspector,
    pub handles: HandleMode,
    /// Style and number of VPL paths, remembered while they are hidden.
    paths: (PathStyle, Option<u32>),
    pub interface: Interface,
}

impl View {
    /// A view without a scene.
    pub fn new(clock: Clock, size: PictureSize, interface: Interface) -> Self {
        Self {
            session: None,
            split: None,
            reading: None,
            recording: Recording::default(),
            clock,
            flight: Flight::new(1.0, None),
            size,
            inspector: Inspector::default(),
            handles: HandleMode::default(),
            paths: (PathStyle::default(), Some(FEW_PATHS)),
            interface,
        }
    }

    /// The scene's own camera, which may be animated.
    pub fn scene_camera(&self) -> Option<Camera> {
        self.session.as_ref().map(|session| session.live_scene.pose(self.clock.time).camera)
    }

    /// Executes an action.
    ///
    /// # Errors
    /// Nothing has changed, or the device is lost.
    pub fn perform(
        &mut self,
        action: ViewAction,
        press: Press,
        device: &Arc<Device>,
    ) -> Result<(), DemoError> {
        match action {
            ViewAction::TogglePause => self.clock.paused = !self.clock.paused,
            ViewAction::Pause(paused) => self.clock.paused = paused,
            ViewAction::Scrub(time) => self.clock.time = time.max(0.0),
            ViewAction::SetPacing(pacing) => self.clock.pacing = pacing,
            ViewAction::Home => self.flight.moved = None,
            ViewAction::StoreBookmark(number) => {
                if let Some(own) = self.scene_camera() {
                    self.flight.bookmarks.insert(number, self.flight.camera(&own));
                    self.interface.message = format!("camera stored as bookmark {}", number + 1);
                }
            }
            ViewAction::GoToBookmark(number) => {
                self.flight.moved = self.flight.bookmarks.get(&number).copied().or(self.flight.moved);
            }
            ViewAction::SetCoarseness(pixels) => self.size.set_coarseness(pixels),
            ViewAction::Expose(stops) => self.expose(stops, press)?,
            ViewAction::Split(side) => self.divide(side, device)?,
            ViewAction::ToggleSplit => {
                let is_on = matches!(&self.split, Some(Split { right: Right::Renderer(_), .. }));
                let side = self.session.as_ref().map(|session| RightSide::beside(&session.settings));
                self.divide(side.filter(|_| !is_on), device)?;
            }
            ViewAction::ToggleReference => {
                let is_on = matches!(&self.split, Some(Split { right: Right::Reference(_), .. }));
                self.divide((!is_on).then_some(RightSide::Reference), device)?;
            }
            ViewAction::MoveDivider(at) => self.change_split(|split| split.at = at),
            ViewAction::Flip => self.change_split(|split| split.at = if split.at > 0.5 { 0.0 } else { 1.0 }),
            ViewAction::ToggleDifference => {
                self.change_split(|split| split.shows_difference = !split.shows_difference);
            }
            ViewAction::View(view) => self.show(&view)?,
            ViewAction::StepBuffer(by) => self.step_buffer(by)?,
            ViewAction::StepVpl(by) => self.step_vpl(by)?,
            ViewAction::AllVpls => self.change_vpl_view(|view| view.single_vpl = None)?,
            ViewAction::TogglePaths => {
                let (style, sample) = self.paths;
                self.change_vpl_view(|view| {
                    view.vpl_paths = if view.vpl_paths.is_some() { None } else { Some(style) };
                    view.path_sample = sample;
                })?;
            }
            ViewAction::ToggleInspector => self.inspector.toggle(),
            ViewAction::ChooseMaterial(material) => self.inspector.choose(Some(material)),
        }
        Ok(())
    }

    /// Changes the settings; during a press as a step that can be taken back.
    pub fn set(&mut self, settings: &Settings, press: Option<Press>) -> Result<(), DemoError> {
        let Some(session) = &mut self.session else { return Ok(()) };
        let before = session.settings.clone();
        match press {
            Some(press) => session.step(press, |session| session.set_settings(settings))?,
            None => session.set_settings(settings)?,
        }
        if settings.size == before.size {
            self.size.resolution.forget();
        }
        let methods = |of: &Settings| (of.indirect, of.reflections);
        if methods(settings) != methods(&before) {
            self.interface.message = session.renderer.warnings().join("; ");
        }
        // A method's gain is to be seen in the rate, not in the number of pixels.
        let gain = |of: &Settings| (of.indirect, of.vpl.temporal_sets);
        if press.is_some() && self.size.resolution.automatic && gain(settings) != gain(&before) {
            self.size.hold();
            self.interface.message =
                "pixel size no longer follows the rate, so that rates compare".to_owned();
        }
        Ok(())
    }

    /// Changes the exposure by stops, from what it is now; or makes it automatic.
    fn expose(&mut self, stops: Option<f32>, press: Press) -> Result<(), DemoError> {
        let Some(session) = &self.session else { return Ok(()) };
        let mut settings = session.settings.clone();
        settings.exposure = match (stops, settings.exposure) {
            (None, _) => None,
            (Some(stops), Some(now)) => Some(now + stops),
            (Some(stops), None) => {
                let picture = session.renderer.read_picture(false)?;
                let now = automatic_exposure(&picture, settings.tone_map, std::iter::repeat(1.0)).log2();
                Some((2.0 * now).round() * 0.5 + stops)
            }
        };
        self.interface.message = match settings.exposure {
            Some(stops) => format!("exposure {stops:+.1} stops (0: automatic)"),
            None => "automatic exposure".to_owned(),
        };
        self.set(&settings, Some(press))
    }

    fn change_split(&mut self, change: impl FnOnce(&mut Split)) {
        if let Some(split) = &mut self.split {
            change(split);
        }
    }

    /// Divides the window, shows something else right of the divider, or goes back to one picture.
    fn divide(&mut self, side: Option<RightSide>, device: &Arc<Device>) -> Result<(), DemoError> {
        self.reading = None;
        let (Some(session), Some(side)) = (&mut self.session, side) else {
            self.split = None;
            return Ok(());
        };
        match side {
            RightSide::Reference => self.put_right(Right::Reference(Box::default())),
            RightSide::Picture(path) => {
                self.interface.message = format!("reading {}", path.display());
                self.reading = Some(FilePicture::read(path, &session.settings));
            }
            RightSide::Settings(settings) => {
                if let Some(split @ Split { right: Right::Renderer(_), .. }) = &mut self.split {
                    return split.set_settings(session, &settings);
                }
                let right = Right::of_settings(device, session, &settings)?;
                if let Recording::On(recorder) = &mut self.recording {
                    recorder.note_change(session, true);
                }
                self.put_right(right);
            }
        }
        Ok(())
    }

    fn put_right(&mut self, right: Right) {
        match &mut self.split {
            Some(split) => split.set_right(right),
            None => self.split = Some(Split::new(right)),
        }
    }

    /// Shows a picture right of the divider once its file is read.
    pub fn take_picture(&mut self) {
        let Some(reading) = self.reading.take_if(|reading| reading.is_finished()) else { return };
        self.interface.message.clear();
        match reading.join() {
            Ok(Ok(picture)) => self.put_right(Right::Picture(Box::new(picture))),
            Ok(Err(error)) => self.interface.error = Some(error.to_string()),
            Err(_) => self.interface.error = Some("the picture could not be read".to_owned()),
        }
    }

    /// Sets the debug view.
    pub fn show(&mut self, view: &DebugView) -> Result<(), DemoError> {
        // Paths that are hidden are remembered, and nothing of them makes the view another than the picture.
        let mut view = view.clone();
        view.change_options(|options: &mut VplDebugView| match options.vpl_paths {
            Some(style) => self.paths = (style, options.path_sample),
            None => options.path_sample = None,
        });
        match &mut self.session {
            Some(session) => Ok(session.renderer.set_view(&view)?),
            None => Ok(()),
        }
    }

    fn change_view(&mut self, change: impl FnOnce(&mut DebugView)) -> Result<(), DemoError> {
        let Some(session) = &self.session else { return Ok(()) };
        let mut view = session.renderer.view().clone();
        change(&mut view);
        self.show(&view)
    }

    fn change_vpl_view(&mut self, change: impl FnOnce(&mut VplDebugView)) -> Result<(), DemoError> {
        self.change_view(|view| view.change_options(change))
    }

    fn step_buffer(&mut self, by: i32) -> Result<(), DemoError> {
        self.change_view(|view| {
            let all: Vec<&'static str> = estimators::views().map(|view| view.name).collect();
            let now = all.iter().position(|name| *name == view.buffer).unwrap_or(0);
            let next = (now as i32 + by).rem_euclid(all.len() as i32);
            view.buffer = all[next as usize].into();
        })
    }

    /// Steps to the next or previous valid VPL; from all VPLs to the first.
    fn step_vpl(&mut self, by: i32) -> Result<(), DemoError> {
        let Some(session) = &self.session else { return Ok(()) };
        let Some(vpls) = session.renderer.estimator::<Vpls>() else { return Ok(()) };
        let slots = vpls.manager().slots();
        let valid: Vec<u32> =
            slots.filter(|slot| slot.state == SlotState::Valid).map(|slot| slot.slot).collect();
        self.change_vpl_view(|view| {
            let next = match view.single_vpl {
                None => 0,
                Some(now) if by > 0 => valid.iter().position(|slot| *slot > now).unwrap_or(0),
                Some(now) => {
                    let before = valid.iter().rposition(|slot| *slot < now);
                    before.unwrap_or(valid.len().saturating_sub(1))
                }
            };
            view.single_vpl = valid.get(next).copied();
            // Show its path too.
            view.vpl_paths.get_or_insert_default();
        })
    }

    /// Whether the resolution is to be judged. Not while something else needs the machine, or a picture must keep its size.
    pub fn follows_rate(&self, is_busy: bool) -> bool {
        let is_fixed = self.split.as_ref().is_some_and(|split| !matches!(split.right, Right::Renderer(_)))
            || !matches!(self.recording, Recording::Off);
        self.size.resolution.automatic && self.size.changed.is_none() && !is_busy && !is_fixed
    }

    /// Gives the picture as many pixels as the target rate allows; `refresh`: frames that the display shows, per second.
    pub fn follow_rate(&mut self, is_busy: bool, refresh: Option<f64>) {
        match &self.session {
            Some(session) if self.follows_rate(is_busy) => {
                self.size.follow_rate(session, self.clock.interval_ms(), refresh);
            }
            _ => self.size.resolution.restart(),
        }
    }
}
