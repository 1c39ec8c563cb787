//! A frame of the window: loaded scenes, panel, actions, render, present.

use std::time::Instant;

use serde_json::json;

use super::action::Action;
use super::app::{App, Open, Recording};
use super::flight::Flight;
use super::history::Sample;
use super::loader::Built;
use super::panel::{self, Shown};
use super::recorder::Recorder;
use super::screenshot::Saving;
use super::stage::{Change, Stage};
use super::tour::Tour;
use super::{DemoError, Launch};
use crate::estimators::vpls::VplManager;
use crate::vulkan::{Pane, Presented, UiDrawing};

impl App {
    pub(super) fn frame(&mut self) -> Result<(), DemoError> {
        self.take_built()?;
        self.take_saved();
        let Some(open) = &mut self.open else { return Ok(()) };
        open.follow_size();
        let step = open.stage.as_ref().map_or(0.0, |stage| stage.settings.time_step);
        open.clock.tick(step);
        open.follow_rate();
        open.fly();
        if let Some(stop) = open.follow_tour(&self.launch)? {
            self.log.event("tour-stop", stop);
        }
        open.drag_handle();
        let started = Instant::now();
        let (primitives, pixels_per_point) = open.run_panel(&self.launch);
        let ui_cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        let asked = open.panel.leaving.clone();
        for action in std::mem::take(&mut open.actions) {
            self.perform(action)?;
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        open.press.end_frame();
        if let Some(leave) = open.panel.leaving.clone().filter(|leave| asked.as_ref() != Some(leave)) {
            self.log.event("unsaved", leave);
        }
        if open.places != open.panel.places {
            open.places.clone_from(&open.panel.places);
            self.log.event("layout", &open.places);
        }
        open.draw_stage()?;
        if let Some(split) = &mut open.split
            && let Some(metrics) = split.take_log()
        {
            self.log.event("metrics", metrics);
        }
        let drawing =
            UiDrawing { primitives, textures: std::mem::take(&mut open.textures), pixels_per_point };
        let panes = match (&open.stage, &open.split) {
            (Some(stage), Some(split)) => split.panes(stage),
            (Some(stage), None) => {
                vec![Pane { picture: stage.renderer.display(), columns: [0.0, 1.0] }]
            }
            (None, _) => Vec::new(),
        };
        open.window.pre_present_notify();
        let presented = open.gpu.presenter.present(&panes, open.viewport(), &drawing)?;
        if presented == Presented::Skipped {
            open.textures.append(drawing.textures);
            return Ok(());
        }
        let sample = Sample {
            interval_ms: open.clock.interval_ms(),
            ui_cpu_ms,
            ui_device_ms: open.gpu.presenter.ui_ms(),
            report: open.stage.as_ref().map(|stage| stage.report.clone()).unwrap_or_default(),
        };
        self.log.shown(&sample);
        open.history.push(sample);
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
                open.show(built)?;
            }
            // Without any scene this is fatal.
            Some(Err(error)) if open.stage.is_none() => return Err(error),
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
        for saving in done {
            match saving.finish() {
                Ok(path) => {
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
    /// Shows a loaded scene, or the current one with a rebuilt renderer.
    fn show(&mut self, built: Built) -> Result<(), DemoError> {
        match &mut self.stage {
            Some(stage) if built.same && stage.name == built.name => {
                let view = stage.renderer.view().clone();
                let wanted = stage.settings.clone();
                let goes_on = built.renderer.is_none();
                let change = match stage.renew(built) {
                    Ok(change) => change,
                    Err(error) => return self.refuse(error),
                };
                if goes_on {
                    if let Recording::On(recorder) = &mut self.recording {
                        recorder.edited(stage);
                    }
                    // Later edits may need another one.
                    if change == Change::Rebuild {
                        self.rebuild();
                    }
                    return Ok(());
                }
                stage.renderer.set_view(&view)?;
                match &mut self.recording {
                    Recording::On(recorder) => recorder.renewed(stage),
                    Recording::Waiting => self.recording = Recording::On(Box::new(Recorder::new(stage))),
                    Recording::Off => {}
                }
                if stage.settings != wanted {
                    self.actions.push(Action::Set(Box::new(wanted)));
                }
                // Edits made meanwhile may need another rebuild.
                if change == Change::Rebuild {
                    self.rebuild();
                }
            }
            _ => {
                // An edit of a scene that is no longer shown.
                let Some(mut stage) = Stage::new(built) else { return Ok(()) };
                if let Some(view) = self.saved_view.take() {
                    stage.renderer.set_view(&view)?;
                } else {
                    let warning = stage.renderer.vpls().and_then(VplManager::wasted_slots_warning);
                    stage
                        .rest
                        .warnings
                        .extend(warning.map(|warning| format!("{}: {warning}", stage.rest.name)));
                    stage.rest.warnings.iter().for_each(|warning| log::warn!("{warning}"));
                    self.panel.message = stage.rest.warnings.join("; ");
                    self.window.set_title(&format!("{} - glowworm", stage.name));
                    self.flight = Flight::new(stage.radius, stage.rest.metres_per_unit);
                    self.clock.time = 0.0;
                }
                self.split = None;
                self.panel.hidden &= self.tour.take().is_none();
                self.stage = Some(stage);
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

    /// Shows why a scene could not be built, and takes back the edits that wanted it.
    fn refuse(&mut self, error: DemoError) -> Result<(), DemoError> {
        if error.is_device_lost() {
            return Err(error);
        }
        self.panel.error = Some(error.to_string());
        self.stage.as_mut().map_or(Ok(()), Stage::take_back)?;
        Ok(())
    }

    /// Goes on with the tour; the caption of a stop that begins.
    fn follow_tour(&mut self, launch: &Launch) -> Result<Option<&'static str>, DemoError> {
        if self.stage.is_some() && std::mem::take(&mut self.tour_waits) {
            self.toggle_tour(launch.contact_sheet.clone())?;
        }
        let (Some(stage), Some(tour)) = (&self.stage, &mut self.tour) else { return Ok(None) };
        let own = stage.rest.pose(self.clock.time).camera;
        let seconds = self.clock.interval_ms() * 1e-3;
        let Some(frame) = tour.advance(seconds, &own, stage, self.split.as_ref())? else {
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
        let Some(stage) = &self.stage else { return };
        let own = stage.rest.pose(self.clock.time).camera;
        self.flight.running = self.modifiers.shift_key();
        self.flight.advance(&own, self.clock.seconds() as f32);
    }

    fn run_panel(&mut self, launch: &Launch) -> (Vec<egui::ClippedPrimitive>, f32) {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut actions = Vec::new();
        let output = context.run_ui(input, |ui| {
            let mut shown = Shown {
                stage: self.stage.as_ref(),
                split: self.split.as_ref(),
                caption: self.tour.as_ref().map(Tour::caption),
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
            actions.extend(panel::show(ui, &mut self.panel, &mut shown));
        });
        self.actions.extend(actions);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        self.textures.append(output.textures_delta);
        let scale = output.pixels_per_point;
        (context.tessellate(output.shapes, scale), scale)
    }

    fn draw_stage(&mut self) -> Result<(), DemoError> {
        let Some(stage) = &mut self.stage else { return Ok(()) };
        self.inspector.refresh(stage)?;
        let camera = self.flight.camera(&stage.rest.pose(self.clock.time).camera);
        let pace = self.clock.exposure_pace();
        stage.render(self.clock.time, camera, pace)?;
        if let Some(split) = &mut self.split {
            split.render(stage, pace)?;
        }
        if let Recording::On(recorder) = &mut self.recording {
            recorder.frame(stage);
        }
        Ok(())
    }
}
