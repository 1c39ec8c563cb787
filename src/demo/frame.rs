//! A frame of the window: loaded scenes, panel, actions, render, present.

use std::time::Instant;

use serde_json::json;

use super::action::{Action, AppAction, EditAction};
use super::app::{App, OpenWindow};
use super::compare::Row;
use super::error::DemoError;
use super::flight::Flight;
use super::history::{History, Sample};
use super::launch::Launch;
use super::loader::Built;
use super::panel::Shown;
use super::recorder::{Recorder, Recording};
use super::session::Session;
use super::view::View;
use crate::settings::Settings;
use crate::vulkan::{Pane, Presented, UiDrawing};

impl App {
    pub(super) fn frame(&mut self) -> Result<(), DemoError> {
        self.take_built()?;
        self.take_saved();
        let Some(open) = &mut self.open else { return Ok(()) };
        open.view.take_picture();
        if let Some(rows) = open.follow_comparison() {
            self.log.event("compared", rows);
        }
        open.follow_size();
        let step = open.view.session.as_ref().map_or(0.0, |session| session.settings.time_step);
        if open.is_measuring() {
            open.view.clock.hold();
        } else {
            open.view.clock.tick(step);
        }
        open.view.follow_rate(open.is_busy(), open.screen.refresh_rate());
        // Move the camera by the held keys.
        if let Some(own) = open.view.scene_camera() {
            open.view.flight.running = open.input.modifiers.shift_key();
            open.view.flight.advance(&own, open.view.clock.seconds() as f32);
        }
        if let Some(stop) = open.follow_tour(&self.launch)? {
            self.log.event("tour-stop", stop);
        }
        open.actions.extend(open.input.dragged(&open.view, &open.screen));
        let started = Instant::now();
        let (primitives, pixels_per_point) = open.run_panel(&self.launch);
        let ui_cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        let asked = open.view.interface.pending.clone();
        self.perform_all()?;
        let Some(open) = &mut self.open else { return Ok(()) };
        open.input.press.end_frame();
        open.name_window();
        if let Some(pending) = open.view.interface.pending.as_ref().filter(|now| asked.as_ref() != Some(now))
        {
            self.log.event("unsaved", pending);
        }
        if let Some(layout) = open.screen.take_layout() {
            self.log.event("layout", layout);
        }
        open.draw_session()?;
        if let Some(split) = &mut open.view.split
            && let Some(metrics) = split.take_log()
        {
            self.log.event("metrics", metrics);
        }
        let textures = std::mem::take(&mut open.screen.textures);
        let drawing = UiDrawing { primitives, textures, pixels_per_point };
        let panes = match (&open.view.session, &open.view.split) {
            (Some(session), Some(split)) => split.panes(session),
            (Some(session), None) => {
                vec![Pane { picture: session.renderer.display(), columns: [0.0, 1.0] }]
            }
            (None, _) => Vec::new(),
        };
        open.screen.window.pre_present_notify();
        let viewport = open.screen.viewport(&open.view.interface);
        let presented = open.gpu.presenter.present(&panes, viewport, &drawing)?;
        open.view.interface.count_announced();
        if presented == Presented::Skipped {
            open.screen.textures.append(drawing.textures);
            return Ok(());
        }
        let session = open.view.session.as_ref();
        let sample = Sample {
            interval_ms: open.view.clock.interval_ms(),
            ui_cpu_ms,
            ui_device_ms: open.gpu.presenter.ui_ms(),
            report: session.map(|session| session.report.clone()).unwrap_or_default(),
        };
        self.log.shown(&sample);
        if !open.is_measuring() {
            open.history.push(sample);
        }
        Ok(())
    }

    /// Shows a scene once it is loaded.
    fn take_built(&mut self) -> Result<(), DemoError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match open.loader.poll() {
            None => {}
            Some(Ok(built)) => {
                match &built.renderer {
                    Some(renderer) => self.log.event(
                        "scene",
                        json!({
                            "name": built.name,
                            "settings": built.settings,
                            "same": built.same,
                            "tracer": renderer.tracer(),
                        }),
                    ),
                    None => self.log.event("scene-edited", &built.name),
                }
                open.switch_to(built)?;
            }
            // Without any scene this is fatal.
            Some(Err(error)) if open.view.session.is_none() => return Err(error),
            Some(Err(error)) => {
                self.log.event("scene-failed", error.to_string());
                open.refuse(error)?;
            }
        }
        Ok(())
    }
}

impl OpenWindow {
    /// Takes in the runs measured meanwhile; returns the rows of a comparison that is done, once.
    fn follow_comparison(&mut self) -> Option<Vec<Row>> {
        let comparison = self.comparison.as_mut().filter(|comparison| comparison.bench.is_running())?;
        if let Err(error) = comparison.follow() {
            self.view.interface.error = Some(error.to_string());
            self.comparison = None;
            return None;
        }
        (!comparison.bench.is_running()).then(|| comparison.rows.clone())
    }

    /// Resizes the presenter at once, and the picture some time after the last change.
    fn follow_size(&mut self) {
        let window = self.screen.window.inner_size();
        self.gpu.presenter.resize([window.width, window.height]);
        let viewport = self.screen.viewport(&self.view.interface);
        self.view.size.follow(viewport);
        if self.is_measuring() || self.view.interface.has_waiting() {
            return;
        }
        if let (Some(size), Some(session)) = (self.view.size.take_due(), &self.view.session)
            && session.settings.size != size
        {
            let settings = Settings { size, ..session.settings.clone() };
            self.actions.push(EditAction::Set(Box::new(settings)));
        }
    }

    /// Goes on with a loaded scene, or the current one with a rebuilt renderer.
    fn switch_to(&mut self, built: Built) -> Result<(), DemoError> {
        if self.is_measuring() || !built.same {
            self.comparison = None;
        }
        match &mut self.view.session {
            Some(session) if built.same && session.name == built.name => {
                let view = session.renderer.view().clone();
                let requested = session.settings.clone();
                let is_rebuilt = built.renderer.is_some();
                let change = match session.renew(built) {
                    Ok(change) => change,
                    Err(error) => return self.refuse(error),
                };
                match &mut self.view.recording {
                    Recording::On(recorder) => recorder.note_change(session, is_rebuilt),
                    waiting @ Recording::Waiting if is_rebuilt => {
                        *waiting = Recording::On(Box::new(Recorder::new(session)));
                    }
                    Recording::Waiting | Recording::Off => {}
                }
                if is_rebuilt {
                    session.renderer.set_view(&view)?;
                    // The new renderer counts its frames anew.
                    if let Some(split) = &mut self.view.split {
                        split.metrics.forget();
                    }
                    if session.settings != requested {
                        self.actions.push(EditAction::Set(Box::new(requested)));
                    }
                }
                // Edits made meanwhile may need another build.
                self.take(change);
                if !is_rebuilt {
                    return Ok(());
                }
            }
            _ => {
                // An edit of a scene that is no longer shown.
                let Some(mut session) = Session::new(built) else { return Ok(()) };
                if let Some(state) = self.state.take() {
                    session.restore(state)?;
                } else {
                    let warnings = session.renderer.warnings().into_iter();
                    session
                        .live_scene
                        .warnings
                        .extend(warnings.map(|warning| format!("{}: {warning}", session.live_scene.name)));
                    session.live_scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
                    self.view.interface.message = session.live_scene.warnings.join("; ");
                    self.view.flight = Flight::new(session.radius, session.live_scene.metres_per_unit);
                    self.view.clock.time = 0.0;
                }
                (self.view.split, self.view.reading) = (None, None);
                self.view.interface.hidden &= self.tour.take().is_none();
                self.view.session = Some(session);
                self.view.inspector.choose(None);
                // A recording covers one scene.
                if !matches!(self.view.recording, Recording::Off) {
                    self.actions.push(AppAction::ToggleRecording);
                }
            }
        }
        self.history = History::default();
        self.view.size.resolution.forget();
        // The window may have been resized meanwhile.
        self.view.size.change();
        Ok(())
    }

    /// Names the scene in the window's title, with an asterisk while it has unsaved edits.
    fn name_window(&mut self) {
        let Some(session) = &self.view.session else { return };
        let edited = if session.is_edited() { "*" } else { "" };
        self.screen.set_title(format!("{edited}{} - glowworm", session.name));
    }

    /// Shows why a scene could not be built, and takes back the edits that asked for it.
    fn refuse(&mut self, error: DemoError) -> Result<(), DemoError> {
        if error.is_device_lost() {
            return Err(error);
        }
        self.view.interface.error = Some(error.to_string());
        self.view.session.as_mut().map_or(Ok(()), Session::revert)?;
        Ok(())
    }

    fn run_panel(&mut self, launch: &Launch) -> (Vec<egui::ClippedPrimitive>, f32) {
        let (view, comparison) = (&self.view, self.comparison.as_ref());
        let caption = self.tour.as_ref().zip(view.session.as_ref());
        let caption = caption.map(|(tour, session)| tour.said(session, view.split.as_ref(), comparison));
        let assets = launch.assets.as_deref();
        let (history, loader, gpu) = (&self.history, &self.loader, &self.gpu);
        let shown = Shown { view, comparison, caption, assets, history, loader, gpu };
        let (mut actions, primitives, scale) = self.screen.run_panel(&shown);
        if view.interface.has_waiting() {
            actions.0.retain(|action| !matches!(action, Action::Edit(EditAction::Set(_))));
        }
        self.actions.extend(actions.0);
        (primitives, scale)
    }

    fn draw_session(&mut self) -> Result<(), DemoError> {
        if self.is_measuring() {
            return Ok(());
        }
        let pointer = self.input.in_picture(&self.view, &self.screen);
        let own = self.view.scene_camera();
        let View { session, split, recording, clock, flight, inspector, .. } = &mut self.view;
        let (Some(session), Some(own)) = (session, own) else { return Ok(()) };
        inspector.refresh(session)?;
        let pace = clock.exposure_pace();
        let turns = split.as_mut().map_or([true; 2], |split| split.turns(session));
        // A recording has every frame of the left side.
        let [left, right] = if matches!(recording, Recording::Off) { turns } else { [true; 2] };
        session.go_to_time(clock.time, flight.camera(&own));
        if left {
            session.render(pace)?;
        }
        inspector.read(session, pointer)?;
        if let Some(split) = split {
            split.render(session, pace, right)?;
        }
        if let Recording::On(recorder) = recording {
            recorder.frame(session);
        }
        Ok(())
    }
}
