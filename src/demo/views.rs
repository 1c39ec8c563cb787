//! Actions that choose what the picture shows: debug views, single VPLs, the divided window, the tour.

use std::path::PathBuf;

use super::DemoError;
use super::action::Action;
use super::app::Open;
use super::file_picture::FilePicture;
use super::panel::PathsState;
use super::recorder::Recording;
use super::split::{Right, RightSide, Split};
use super::tour::{Before, Tour};
use crate::estimators;
use crate::estimators::vpls::{SlotState, VplDebugView, Vpls};
use crate::renderer::DebugView;
use crate::settings::Settings;

impl Open {
    /// Executes the actions that choose what is shown.
    pub(super) fn look(&mut self, action: Action) -> Result<(), DemoError> {
        match action {
            Action::Split(side) => self.divide(side)?,
            Action::ToggleSplit => self.toggle_split()?,
            Action::ToggleReference => self.toggle_reference()?,
            Action::MoveDivider(at) => self.change_split(|split| split.at = at),
            Action::ToggleDifference => {
                self.change_split(|split| split.shows_difference = !split.shows_difference);
            }
            Action::View(view) => self.view(&view)?,
            Action::StepBuffer(by) => self.step_buffer(by)?,
            Action::StepVpl(by) => self.step_vpl(by)?,
            Action::AllVpls => self.change_vpl_view(|view| view.single_vpl = None)?,
            Action::TogglePaths => {
                let PathsState { style, sample } = self.panel.paths;
                self.change_vpl_view(|view| {
                    view.vpl_paths = if view.vpl_paths.is_some() { None } else { Some(style) };
                    view.path_sample = sample;
                })?;
            }
            Action::Flip => self.change_split(|split| split.at = if split.at > 0.5 { 0.0 } else { 1.0 }),
            Action::ToggleInspector => self.inspector.toggle(),
            Action::ChooseMaterial(material) => self.inspector.choose(Some(material)),
            // [`App::perform`](super::app::App::perform) and [`Open::change`] have taken all others.
            _ => {}
        }
        Ok(())
    }

    /// Begins the tour, with a contact sheet at its end if that has a file; or ends it.
    pub(super) fn toggle_tour(&mut self, sheet: Option<PathBuf>) -> Result<(), DemoError> {
        if self.tour.is_some() {
            return self.end_tour();
        }
        let Some(session) = &mut self.session else { return Ok(()) };
        let before = Before {
            settings: session.settings.clone(),
            view: session.renderer.view().clone(),
            camera: self.flight.moved(),
            paused: self.clock.paused,
            automatic: self.resolution.automatic,
            undo: std::mem::take(&mut session.undo),
        };
        self.tour = Some(Tour::new(before, sheet));
        self.split = None;
        self.panel.hidden = true;
        Ok(())
    }

    /// Ends the tour where it is; everything goes back to how it was.
    pub(super) fn end_tour(&mut self) -> Result<(), DemoError> {
        let (Some(tour), Some(session)) = (self.tour.take(), &mut self.session) else { return Ok(()) };
        let (before, closes) = tour.end()?;
        self.closing |= closes;
        self.panel.hidden = false;
        (self.clock.paused, self.resolution.automatic) = (before.paused, before.automatic);
        self.comparison = None;
        self.split = None;
        match before.camera {
            Some(camera) => self.flight.go_to(camera),
            None => self.flight.home(),
        }
        session.undo = before.undo;
        let settings = Settings { size: session.settings.size, ..before.settings };
        self.view(&before.view)?;
        self.set(&settings)
    }

    /// Divides the window between two methods, or goes back to one picture.
    pub(super) fn toggle_split(&mut self) -> Result<(), DemoError> {
        let is_on = self.split.as_ref().is_some_and(|split| matches!(split.right, Right::Renderer(_)));
        let side = self.session.as_ref().map(|session| RightSide::beside(&session.settings));
        self.divide(side.filter(|_| !is_on))
    }

    /// Shows the reference right of the divider, or goes back to one picture.
    pub(super) fn toggle_reference(&mut self) -> Result<(), DemoError> {
        let is_on = self.split.as_ref().is_some_and(|split| matches!(split.right, Right::Reference(_)));
        self.divide((!is_on).then_some(RightSide::Reference))
    }

    pub(super) fn change_split(&mut self, change: impl FnOnce(&mut Split)) {
        if let Some(split) = &mut self.split {
            change(split);
        }
    }

    /// Divides the window, shows something else right of the divider, or goes back to one picture.
    pub(super) fn divide(&mut self, side: Option<RightSide>) -> Result<(), DemoError> {
        self.reading = None;
        let (Some(session), Some(side)) = (&mut self.session, side) else {
            self.split = None;
            return Ok(());
        };
        let mut restarts = false;
        let right = match side {
            RightSide::Reference => Ok(Some(Right::Reference(Box::default()))),
            RightSide::Picture(path) => {
                self.panel.message = format!("reading {}", path.display());
                self.reading = Some(FilePicture::read(path, &session.settings));
                return Ok(());
            }
            RightSide::Settings(settings) => {
                let there = match &mut self.split {
                    Some(Split { right: Right::Renderer(other), .. }) => Some(&mut **other),
                    _ => None,
                };
                restarts = there.is_none();
                Right::of_settings(&self.gpu.device, session, &settings, there)
            }
        };
        match right {
            Err(error) if error.is_device_lost() => return Err(error),
            Err(error) => self.panel.error = Some(error.to_string()),
            Ok(right) => self.put_right(right),
        }
        if let (true, Recording::On(recorder), Some(session)) = (restarts, &mut self.recording, &self.session)
        {
            recorder.renewed(session);
        }
        Ok(())
    }

    fn put_right(&mut self, right: Option<Right>) {
        match (&mut self.split, right) {
            (Some(split), right) => split.set_right(right),
            (None, right) => self.split = right.map(Split::new),
        }
    }

    /// Shows a picture right of the divider once its file is read.
    pub(super) fn take_picture(&mut self) {
        let Some(reading) = self.reading.take_if(|reading| reading.is_finished()) else { return };
        self.panel.message.clear();
        match reading.join() {
            Ok(Ok(picture)) => self.put_right(Some(Right::Picture(Box::new(picture)))),
            Ok(Err(error)) => self.panel.error = Some(error.to_string()),
            Err(_) => self.panel.error = Some("the picture could not be read".to_owned()),
        }
    }

    pub(super) fn view(&mut self, view: &DebugView) -> Result<(), DemoError> {
        // Paths that are hidden are remembered, and nothing of them makes the view another than the picture.
        let mut view = view.clone();
        view.change_options(|options: &mut VplDebugView| match options.vpl_paths {
            Some(style) => self.panel.paths = PathsState { style, sample: options.path_sample },
            None => options.path_sample = None,
        });
        match &mut self.session {
            Some(session) => Ok(session.renderer.set_view(&view)?),
            None => Ok(()),
        }
    }

    pub(super) fn change_view(&mut self, change: impl FnOnce(&mut DebugView)) -> Result<(), DemoError> {
        let Some(session) = &self.session else { return Ok(()) };
        let mut view = session.renderer.view().clone();
        change(&mut view);
        self.view(&view)
    }

    fn change_vpl_view(&mut self, change: impl FnOnce(&mut VplDebugView)) -> Result<(), DemoError> {
        self.change_view(|view| view.change_options(change))
    }

    pub(super) fn step_buffer(&mut self, by: i32) -> Result<(), DemoError> {
        self.change_view(|view| {
            let all: Vec<&'static str> = estimators::views().map(|view| view.name).collect();
            let now = all.iter().position(|name| *name == view.buffer).unwrap_or(0);
            let next = (now as i32 + by).rem_euclid(all.len() as i32);
            view.buffer = all[next as usize].into();
        })
    }

    /// Steps to the next or previous valid VPL; from all VPLs to the first.
    pub(super) fn step_vpl(&mut self, by: i32) -> Result<(), DemoError> {
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
}
