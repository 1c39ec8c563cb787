//! A frame of the window: loaded scenes, panel, actions, render, present.

use std::time::Instant;

use serde_json::json;

use super::action::Action;
use super::app::{App, Open};
use super::flight::Flight;
use super::history::Sample;
use super::loader::Built;
use super::panel::{self, Shown};
use super::recorder::Recorder;
use super::recorder::Recording;
use super::screenshot::Saving;
use super::session::{Change, Session};
use super::{DemoError, Launch};
use crate::vulkan::{Pane, Presented, UiDrawing};

impl App {
    pub(super) fn frame(&mut self) -> Result<(), DemoError> {
        self.take_built()?;
        self.take_saved();
        let Some(open) = &mut self.open else { return Ok(()) };
        open.take_picture();
        if let Some(rows) = open.follow_comparison() {
            self.log.event("compared", rows);
        }
        open.follow_size();
        let step = open.session.as_ref().map_or(0.0, |session| session.settings.time_step);
        if open.is_measuring() {
            open.clock.hold()
        } else {
            open.clock.tick(step)
        }
        open.follow_rate();
        open.fly();
        if let Some(stop) = open.follow_tour(&self.launch)? {
            self.log.event("tour-stop", stop);
        }
        open.drag_handle();
        let started = Instant::now();
        let (primitives, pixels_per_point) = open.run_panel(&self.launch);
        let ui_cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        let asked = open.panel.pending.clone();
        self.perform_all()?;
        let Some(open) = &mut self.open else { return Ok(()) };
        open.press.end_frame();
        open.name_window();
        if let Some(pending) = open.panel.pending.clone().filter(|pending| asked.as_ref() != Some(pending)) {
            self.log.event("unsaved", pending);
        }
        if open.places != open.panel.places {
            open.places.clone_from(&open.panel.places);
            self.log.event("layout", &open.places);
        }
        open.draw_session()?;
        if let Some(split) = &mut open.split
            && let Some(metrics) = split.take_log()
        {
            self.log.event("metrics", metrics);
        }
        let drawing =
            UiDrawing { primitives, textures: std::mem::take(&mut open.textures), pixels_per_point };
        let panes = match (&open.session, &open.split) {
            (Some(session), Some(split)) => split.panes(session),
            (Some(session), None) => {
                vec![Pane { picture: session.renderer.display(), columns: [0.0, 1.0] }]
            }
            (None, _) => Vec::new(),
        };
        open.window.pre_present_notify();
        let presented = open.gpu.presenter.present(&panes, open.viewport(), &drawing)?;
        open.count_announced();
        if presented == Presented::Skipped {
            open.textures.append(drawing.textures);
            return Ok(());
        }
        let sample = Sample {
            interval_ms: open.clock.interval_ms(),
            ui_cpu_ms,
            ui_device_ms: open.gpu.presenter.ui_ms(),
            report: open.session.as_ref().map(|session| session.report.clone()).unwrap_or_default(),
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
            Some(Err(error)) if open.session.is_none() => return Err(error),
            Some(Err(error)) => {
                self.log.event("scene-failed", error.to_string());
                open.refuse(error)?;
            }
        }
        Ok(())
    }
}

impl App {
    /// Reports finished file writes.
    pub(super) fn take_saved(&mut self) {
        let Some(open) = &mut self.open else { return };
        let (done, waiting) = std::mem::take(&mut open.saving).into_iter().partition(Saving::is_done);
        open.saving = waiting;
        for mut saving in done {
            let scene = saving.scene.take();
            match saving.finish() {
                Ok(path) => {
                    // One that could not be written is not saved.
                    if let (Some(scene), Some(session)) = (scene, &mut open.session)
                        && scene.name == session.name
                    {
                        (session.saved_edits, session.saved) = (scene.edits, Some(scene.saved));
                    }
                    self.log.event("saved", &path);
                    open.panel.message = format!("saved {}", path.display());
                }
                Err(error) => {
                    self.log.event("not-saved", &error);
                    open.panel.error = Some(error);
                }
            }
        }
    }
}

impl Open {
    /// Goes on with a loaded scene, or the current one with a rebuilt renderer.
    fn switch_to(&mut self, built: Built) -> Result<(), DemoError> {
        if self.is_measuring() || !built.same {
            self.comparison = None;
        }
        match &mut self.session {
            Some(session) if built.same && session.name == built.name => {
                let view = session.renderer.view().clone();
                let wanted = session.settings.clone();
                let reuses_renderer = built.renderer.is_none();
                let change = match session.renew(built) {
                    Ok(change) => change,
                    Err(error) => return self.refuse(error),
                };
                if reuses_renderer {
                    if let Recording::On(recorder) = &mut self.recording {
                        recorder.edited(session);
                    }
                    // Later edits may need another one.
                    if change == Change::Rebuild {
                        self.rebuild();
                    }
                    return Ok(());
                }
                session.renderer.set_view(&view)?;
                // The new renderer counts its frames anew.
                if let Some(split) = &mut self.split {
                    split.metrics.forget();
                }
                match &mut self.recording {
                    Recording::On(recorder) => recorder.renewed(session),
                    Recording::Waiting => self.recording = Recording::On(Box::new(Recorder::new(session))),
                    Recording::Off => {}
                }
                if session.settings != wanted {
                    self.actions.push(Action::Set(Box::new(wanted)));
                }
                // Edits made meanwhile may need another rebuild.
                if change == Change::Rebuild {
                    self.rebuild();
                }
            }
            _ => {
                // An edit of a scene that is no longer shown.
                let Some(mut session) = Session::new(built) else { return Ok(()) };
                if let Some(kept) = self.kept.take() {
                    session.restore(kept)?;
                } else {
                    let warnings = session.renderer.warnings().into_iter();
                    session
                        .live_scene
                        .warnings
                        .extend(warnings.map(|warning| format!("{}: {warning}", session.live_scene.name)));
                    session.live_scene.warnings.iter().for_each(|warning| log::warn!("{warning}"));
                    self.panel.message = session.live_scene.warnings.join("; ");
                    self.flight = Flight::new(session.radius, session.live_scene.metres_per_unit);
                    self.clock.time = 0.0;
                }
                (self.split, self.reading) = (None, None);
                self.panel.hidden &= self.tour.take().is_none();
                self.session = Some(session);
                self.inspector.forget();
                // A recording covers one scene.
                if !matches!(self.recording, Recording::Off) {
                    self.actions.push(Action::ToggleRecording);
                }
            }
        }
        self.history.clear();
        self.resolution.forget();
        // The window may have been resized meanwhile.
        self.resized = Some(Instant::now());
        Ok(())
    }

    /// Names the scene in the window's title, with an asterisk while it has unsaved edits.
    fn name_window(&mut self) {
        let Some(session) = &self.session else { return };
        let edited = if session.is_edited() { "*" } else { "" };
        let title = format!("{edited}{} - glowworm", session.name);
        if self.title != title {
            self.window.set_title(&title);
            self.title = title;
        }
    }

    /// Shows why a scene could not be built, and takes back the edits that wanted it.
    fn refuse(&mut self, error: DemoError) -> Result<(), DemoError> {
        if error.is_device_lost() {
            return Err(error);
        }
        self.panel.error = Some(error.to_string());
        self.session.as_mut().map_or(Ok(()), Session::revert)?;
        Ok(())
    }

    /// Goes on with the tour; the caption of a stop that begins.
    fn follow_tour(&mut self, launch: &Launch) -> Result<Option<&'static str>, DemoError> {
        if self.session.is_some() && std::mem::take(&mut self.tour_waits) {
            self.toggle_tour(launch.contact_sheet.clone())?;
        }
        if self.has_waiting() {
            return Ok(None);
        }
        let (Some(session), Some(tour)) = (&self.session, &mut self.tour) else { return Ok(None) };
        let own = session.live_scene.pose(self.clock.time).camera;
        let seconds = self.clock.interval_ms() * 1e-3;
        let Some(frame) = tour.advance(seconds, &own, session, self.split.as_ref())? else {
            self.end_tour()?;
            return Ok(None);
        };
        let caption = frame.begins.then(|| tour.caption());
        self.flight.go_to(frame.camera);
        self.actions.extend(frame.actions);
        Ok(caption)
    }

    /// Moves the camera by the held keys.
    fn fly(&mut self) {
        let Some(session) = &self.session else { return };
        let own = session.live_scene.pose(self.clock.time).camera;
        self.flight.running = self.modifiers.shift_key();
        self.flight.advance(&own, self.clock.seconds() as f32);
    }

    fn run_panel(&mut self, launch: &Launch) -> (Vec<egui::ClippedPrimitive>, f32) {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut actions = Vec::new();
        let output = context.run_ui(input, |ui| {
            let mut shown =
                Shown {
                    session: self.session.as_ref(),
                    split: self.split.as_ref(),
                    comparison: self.comparison.as_ref(),
                    caption: self.tour.as_ref().zip(self.session.as_ref()).map(|(tour, session)| {
                        tour.said(session, self.split.as_ref(), self.comparison.as_ref())
                    }),
                    assets: launch.assets.as_deref(),
                    clock: &mut self.clock,
                    history: &self.history,
                    loader: &self.loader,
                    gpu: &self.gpu,
                    resolution: &self.resolution,
                    recording: &self.recording,
                    inspector: &self.inspector,
                    mode: self.mode,
                };
            actions.extend(panel::draw(ui, &mut self.panel, &mut shown));
        });
        if self.has_waiting() {
            actions.retain(|action| !matches!(action, Action::Set(_)));
        }
        self.actions.extend(actions);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        self.textures.append(output.textures_delta);
        let scale = output.pixels_per_point;
        (context.tessellate(output.shapes, scale), scale)
    }

    fn draw_session(&mut self) -> Result<(), DemoError> {
        let (is_measuring, pointer) = (self.is_measuring(), self.pointer_in_picture());
        let Some(session) = self.session.as_mut().filter(|_| !is_measuring) else { return Ok(()) };
        self.inspector.refresh(session)?;
        let camera = self.flight.camera(&session.live_scene.pose(self.clock.time).camera);
        let pace = self.clock.exposure_pace();
        let turns = self.split.as_mut().map_or([true; 2], |split| split.turns(session));
        // A recording has every frame of the left side.
        let [left, right] = if matches!(self.recording, Recording::Off) { turns } else { [true; 2] };
        session.go_to_time(self.clock.time, camera);
        if left {
            session.render(pace)?;
        }
        self.inspector.read(session, pointer)?;
        if let Some(split) = &mut self.split {
            split.render(session, pace, right)?;
        }
        if let Recording::On(recorder) = &mut self.recording {
            recorder.frame(session);
        }
        Ok(())
    }
}
