//! The window and what happens in it.

use std::sync::Arc;
use std::time::Instant;

use egui::ViewportId;
use kinora_lang::diagnostic::MAX_SHOWN;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use super::model::{Findings, Model};
use super::overlay::{self, Status};
use super::photo::Photo;
use super::reloads::{Reload, Reloads};
use super::screen::Screen;
use super::shown::Shown;
use super::watch::Load;
use super::work::Desk;
use crate::session::Loaded;
use crate::terminal;

/// Size of a new window in points.
const SIZE: LogicalSize<u32> = LogicalSize::new(1120, 760);
/// The longest step of the playhead: a window that was not drawn for a while does not jump.
const LONGEST_STEP_S: f64 = 0.25;

/// What the other threads have to say.
pub enum Wake {
    /// The text was read.
    Loaded(Box<Load>),
    /// [`Desk::results`] holds something.
    Rendered,
}

/// What is not to change while the window is open.
pub struct Settings {
    /// Title of the window.
    pub title: String,
    /// What renders, in words.
    pub device: String,
    /// Whether reloads are told to stdout.
    pub json: bool,
}

/// The program behind the window.
pub struct App {
    settings: Settings,
    desk: Arc<Desk>,
    photo: Option<Photo>,
    model: Model,
    reloads: Reloads,
    shown: Option<Shown>,
    egui: egui::Context,
    open: Option<Open>,
    start: Instant,
    drawn: Instant,
    redraw_at: Option<Instant>,
    /// Why the program ends early.
    pub error: Option<String>,
}

struct Open {
    window: Arc<Window>,
    screen: Screen,
    input: egui_winit::State,
}

impl App {
    /// A program without a window yet.
    pub fn new(settings: Settings, desk: Arc<Desk>, photo: Option<Photo>) -> App {
        let egui = egui::Context::default();
        egui.set_theme(egui::Theme::Dark);
        let now = Instant::now();
        App {
            settings,
            desk,
            photo,
            model: Model::default(),
            reloads: Reloads::default(),
            shown: None,
            egui,
            open: None,
            start: now,
            drawn: now,
            redraw_at: None,
            error: None,
        }
    }

    fn open(&self, events: &ActiveEventLoop) -> Result<Open, String> {
        let attributes = Window::default_attributes().with_title(&self.settings.title).with_inner_size(SIZE);
        let window = events.create_window(attributes).map_err(|error| format!("cannot open a window: {error}"))?;
        let window = Arc::new(window);
        let screen = Screen::open(events, window.clone())?;
        let side = Some(screen.max_side() as usize);
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(self.egui.clone(), ViewportId::ROOT, &window, scale, None, side);
        Ok(Open { window, screen, input })
    }

    fn loaded(&mut self, load: Load) {
        let Load { loaded, since, took } = load;
        let findings = findings(&loaded);
        let errors = findings.errors;
        let times = loaded.as_ref().ok().map(|loaded| loaded.times);
        let good = self.model.take(loaded.ok().map(Arc::new), findings, Instant::now());
        if let Some(since) = since {
            let load = good.then_some(self.model.loads);
            let lines = self.reloads.read(since, took, times, load, errors);
            self.tell(lines);
        }
    }

    fn rendered(&mut self) {
        match self.desk.results.take() {
            Some(Ok(picture)) => {
                if let Some(open) = &mut self.open {
                    open.screen.take(picture.size, &picture.rgba);
                    self.shown = Some(Shown::from(&picture));
                }
                self.reloads.made(picture.load, &picture.making);
                self.model.trouble = None;
            }
            Some(Err(failure)) if failure.load == self.model.loads => {
                if self.model.trouble.as_ref() != Some(&failure.text) {
                    terminal::err(&format!("{}\n", failure.text));
                }
                self.model.trouble = Some(failure.text);
                let lines = self.reloads.give_up(1);
                self.tell(lines);
            }
            _ => {}
        }
    }

    fn tell(&self, reloads: impl IntoIterator<Item = Reload>) {
        for reload in reloads.into_iter().filter(|_| self.settings.json) {
            let line = serde_json::to_string(&reload).unwrap_or_default();
            // A stdout that takes nothing is no reason to close the window.
            let _ = terminal::out(&(line + "\n"));
        }
    }

    fn draw(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        let now = Instant::now();
        let passed = now.duration_since(std::mem::replace(&mut self.drawn, now));
        self.model.pass(passed.as_secs_f64().min(LONGEST_STEP_S), now);

        let input = open.input.take_egui_input(&open.window);
        let Reloads { last: reload, anew, steps, .. } = &self.reloads;
        let status = Status { device: &self.settings.device, reload: *reload, rebuilt: anew, stages: steps };
        let output = self.egui.run_ui(input, |ui| {
            overlay::show(ui, &mut self.model, self.shown.as_mut(), &status, now);
        });
        open.input.handle_platform_output(&open.window, output.platform_output);
        if let Some(job) = self.model.job(open.screen.max_side(), now) {
            self.desk.jobs.put(job);
        }
        let hopeless = self.model.good.is_none() && self.model.findings.errors > 0;
        let running = self.start.elapsed();
        let wait = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        // What appears takes egui another frame to lay out.
        let complete = wait.is_none_or(|wait| !wait.is_zero());
        let photo = self.photo.take_if(|photo| complete && photo.due(self.shown.as_ref(), running, hopeless));
        let shapes = self.egui.tessellate(output.shapes, output.pixels_per_point);
        let place = self.shown.and_then(|shown| shown.place);
        let (textures, scale) = (output.textures_delta, output.pixels_per_point);
        let image = open.screen.paint(place, &shapes, textures, scale, photo.is_some());

        let wait = [wait, self.model.idle(now)].into_iter().flatten().min();
        self.redraw_at = wait.and_then(|wait| now.checked_add(wait));
        let line = self.shown.and_then(|shown| self.reloads.pixel(shown.load, Instant::now()));
        self.tell(line);
        if let (Some(photo), Some(image)) = (photo, image) {
            self.photographed(&photo, image.and_then(|image| photo.save(&image)), events);
        }
    }

    fn photographed(&mut self, photo: &Photo, saved: Result<(), String>, events: &ActiveEventLoop) {
        if photo.last {
            self.error = saved.err();
            events.exit();
        } else if let Err(message) = saved {
            terminal::error(&message);
        }
    }

    fn redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }
}

/// What is wrong with the text; told to stderr, too.
fn findings(loaded: &Result<Loaded, String>) -> Findings {
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(message) => {
            terminal::error(message);
            return Findings { text: format!("error: {message}"), errors: 1, warnings: 0 };
        }
    };
    if !loaded.diagnostics.is_empty() {
        terminal::err(&loaded.show(&loaded.diagnostics));
    }
    let (errors, warnings): (Vec<_>, Vec<_>) = loaded.diagnostics.iter().partition(|found| found.is_error());
    let texts: Vec<String> = errors.iter().take(MAX_SHOWN).map(|found| loaded.plain(found)).collect();
    Findings { text: texts.join("\n\n"), errors: errors.len(), warnings: warnings.len() }
}

fn is_by_hand(event: &WindowEvent) -> bool {
    use WindowEvent::{CursorMoved, KeyboardInput, MouseInput, MouseWheel, Touch};
    matches!(event, CursorMoved { .. } | KeyboardInput { .. } | MouseInput { .. } | MouseWheel { .. } | Touch(_))
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match self.open(events) {
            Ok(open) => self.open = Some(open),
            Err(message) => {
                self.error = Some(message);
                events.exit();
            }
        }
        self.redraw();
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.redraw_at = None;
            self.redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Loaded(load) => self.loaded(*load),
            Wake::Rendered => self.rendered(),
        }
        self.redraw();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let response = open.input.on_window_event(&open.window, &event);
        if is_by_hand(&event) {
            self.desk.touch();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::Resized(size) => open.screen.resize(size.width, size.height),
            WindowEvent::RedrawRequested => return self.draw(events),
            _ => {}
        }
        if response.repaint {
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let photo = self.photo.as_ref().and_then(|photo| photo.at(self.start)).filter(|at| *at > Instant::now());
        let next = [self.redraw_at, photo].into_iter().flatten().min();
        events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
