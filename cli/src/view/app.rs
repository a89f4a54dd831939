//! The window and what happens in it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use kinora_lang::diagnostic::MAX_SHOWN;
use kinora_renderer::Backend;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::crew::{self, Worker};
use super::model::{Findings, Model};
use super::overlay::{self, Status};
use super::panels::device::Choice;
use super::panels::prefs::Theme;
use super::panels::{Action, Facts, Panels};
use super::photo::{After, Photo};
use super::reloads::{Reload, Reloads};
use super::screen::Screen;
use super::shown::Shown;
use super::watch::Load;
use crate::flags::PictureFlags;
use crate::session::Loaded;
use crate::terminal;

/// The longest step of the playhead: a window that was not drawn for a while does not jump.
const LONGEST_STEP_S: f64 = 0.25;

/// What the other threads have to say.
pub enum Wake {
    /// The text was read.
    Loaded(Box<Load>),
    /// The worker's desk holds a result.
    Rendered,
    /// It was looked what is where.
    Looked,
    /// What is to render is open, or is not.
    Opened(Choice, Box<Opened>),
}

/// A backend, or why there is none.
pub type Opened = Result<Box<dyn Backend>, String>;

/// What is not to change while the window is open.
pub struct Settings {
    /// What renders, in words.
    pub device: String,
    /// Whether reloads are told to stdout.
    pub json: bool,
    /// How pictures are made.
    pub picture: PictureFlags,
    /// What there is to say of a missing GPU.
    pub alone: Option<&'static str>,
}

/// The program behind the window.
pub struct App {
    settings: Settings,
    worker: Worker,
    proxy: EventLoopProxy<Wake>,
    photo: Option<Photo>,
    model: Model,
    panels: Panels,
    /// The scene that is shown, and which reading of it.
    path: Option<PathBuf>,
    reading: Option<u64>,
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
    pub fn new(
        settings: Settings,
        mut panels: Panels,
        worker: Worker,
        proxy: EventLoopProxy<Wake>,
        photo: Option<Photo>,
    ) -> App {
        let egui = egui::Context::default();
        let now = Instant::now();
        let mut model = Model::default();
        (model.timeline.speed, model.timeline.looping) = (panels.prefs.speed, panels.prefs.looping);
        if let Some(text) = settings.alone {
            panels.no_gpu(text, now);
        }
        App {
            settings,
            worker,
            proxy,
            photo,
            model,
            panels,
            path: None,
            reading: None,
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
        let [width, height] = self.panels.prefs.size;
        let size = LogicalSize::new(width, height);
        let attributes = Window::default_attributes().with_title(self.title()).with_inner_size(size);
        let window = events.create_window(attributes).map_err(|error| format!("cannot open a window: {error}"))?;
        let window = Arc::new(window);
        let screen = Screen::open(events, window.clone())?;
        let side = Some(screen.max_side() as usize);
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(self.egui.clone(), ViewportId::ROOT, &window, scale, None, side);
        Ok(Open { window, screen, input })
    }

    fn title(&self) -> String {
        let name = self.path.as_ref().and_then(|path| path.file_name());
        name.map_or_else(|| "Kinora".into(), |name| format!("{} — Kinora", name.to_string_lossy()))
    }

    fn loaded(&mut self, load: Load) {
        let Load { loaded, since, took, path, reading, baking } = load;
        let baked_s = baking.zip(loaded.as_ref().ok()).map(|([step, _], loaded)| {
            let rate = loaded.scene.as_ref().map_or(1.0, |scene| scene.physics.simulation.rate_hz);
            step as f64 / rate
        });
        if let (Some(baked_s), true) = (baked_s, self.reading == Some(reading)) {
            if let Ok(loaded) = loaded {
                self.model.extend(Arc::new(loaded), baked_s);
            }
            return;
        }
        self.reading = Some(reading);
        if self.path.as_ref() != Some(&path) {
            self.model.forget();
            self.path = Some(path);
            self.shown = None;
            if let Some(open) = &self.open {
                open.window.set_title(&self.title());
            }
        }
        let findings = findings(&loaded);
        let errors = findings.errors;
        let times = loaded.as_ref().ok().map(|loaded| loaded.times);
        let good = self.model.take(loaded.ok().map(Arc::new), findings, Instant::now());
        self.model.timeline.baked_s = baked_s;
        if good {
            self.panels.take(&self.model);
        }
        if let Some(since) = since {
            let load = good.then_some(self.model.loads);
            let lines = self.reloads.read(since, took, times, load, errors);
            self.tell(lines);
        }
    }

    /// Another backend renders from now on, if it is there.
    fn opened(&mut self, choice: &Choice, backend: Opened) {
        let now = Instant::now();
        match backend {
            Ok(backend) => {
                self.settings.device = backend.device();
                self.settings.picture.backend = choice.name();
                self.worker = Worker::start(backend, self.proxy.clone());
                self.model.restart();
            }
            Err(why) => self.panels.say(why, now),
        }
    }

    /// What only the window can do of what the panels want.
    fn act(&mut self) {
        for action in std::mem::take(&mut self.panels.actions) {
            match action {
                Action::Photograph(path) => {
                    let after = After::Time(Duration::ZERO);
                    // One that is waited for comes first.
                    self.photo.get_or_insert(Photo { path, after, last: false });
                }
                Action::Device(choice) => crew::open(choice, self.settings.picture.clone(), self.proxy.clone()),
            }
        }
        let theme = match self.panels.prefs.theme {
            Theme::Dark => egui::ThemePreference::Dark,
            Theme::Light => egui::ThemePreference::Light,
            Theme::System => egui::ThemePreference::System,
        };
        if self.egui.options(|options| options.theme_preference) != theme {
            self.egui.set_theme(theme);
        }
    }

    /// The window is closed: what is set is remembered, and the work comes to its end.
    pub fn farewell(&mut self) {
        let size = self.open.as_ref().map(|open| {
            let size = open.window.inner_size().to_logical::<f32>(open.window.scale_factor());
            [size.width, size.height]
        });
        self.panels.remember(size, &self.model);
        self.worker.farewell();
    }

    fn rendered(&mut self) {
        match self.worker.desk.results.take() {
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
        self.act();
        let Some(open) = &mut self.open else { return };
        let now = Instant::now();
        let passed = now.duration_since(std::mem::replace(&mut self.drawn, now));
        let seen_s = self.shown.map(|shown| shown.open_s);
        self.model.pass(passed.as_secs_f64().min(LONGEST_STEP_S), seen_s, now);

        let input = open.input.take_egui_input(&open.window);
        let Reloads { last: reload, anew, steps, .. } = &self.reloads;
        let facts = Facts {
            device: &self.settings.device,
            backend: self.settings.picture.backend,
            rays: self.shown.map(|shown| (shown.rays, shown.time)),
            samples: self.shown.map_or(0, |shown| shown.samples),
        };
        let status = Status { facts, reload: *reload, rebuilt: anew, stages: steps };
        let output = self.egui.run_ui(input, |ui| {
            overlay::show(ui, &mut self.model, &mut self.panels, self.shown.as_mut(), &status, now);
        });
        open.input.handle_platform_output(&open.window, output.platform_output);
        if let Some(job) = self.model.job(open.screen.max_side(), now) {
            self.worker.desk.jobs.put(job);
        }
        let hopeless = self.model.good.is_none() && self.model.findings.errors > 0;
        let running = self.start.elapsed();
        let wait = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        // What appears takes egui another frame to lay out.
        let complete = wait.is_none_or(|wait| !wait.is_zero());
        let photo = self.photo.take_if(|photo| complete && photo.due(self.shown.as_ref(), running, hopeless));
        let shapes = self.egui.tessellate(output.shapes, output.pixels_per_point);
        let place = self.shown.and_then(|shown| shown.place).filter(|_| !self.panels.at_start());
        let (textures, scale) = (output.textures_delta, output.pixels_per_point);
        let image = open.screen.paint(place, &shapes, textures, scale, photo.is_some());

        let wait = [wait, self.model.idle(now), self.panels.idle(now)].into_iter().flatten().min();
        self.redraw_at = wait.and_then(|wait| now.checked_add(wait));
        let line = self.shown.and_then(|shown| self.reloads.pixel(shown.load, Instant::now()));
        self.tell(line);
        if !self.panels.actions.is_empty() {
            self.redraw();
        }
        if let (Some(photo), Some(image)) = (photo, image) {
            self.photographed(&photo, image.and_then(|image| photo.save(&image)), events);
        }
    }

    fn photographed(&mut self, photo: &Photo, saved: Result<(), String>, events: &ActiveEventLoop) {
        if photo.last {
            self.error = saved.err();
            events.exit();
            return;
        }
        let now = Instant::now();
        match saved {
            Ok(()) => self.panels.say(format!("saved as {}", photo.path.display()), now),
            Err(message) => {
                terminal::error(&message);
                self.panels.say(message, now);
            }
        }
        self.redraw();
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
            Wake::Looked => self.panels.looked(&mut self.model, Instant::now()),
            Wake::Opened(choice, backend) => self.opened(&choice, *backend),
        }
        self.redraw();
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let response = open.input.on_window_event(&open.window, &event);
        if is_by_hand(&event) {
            self.worker.desk.touch();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::Resized(size) => open.screen.resize(size.width, size.height),
            WindowEvent::RedrawRequested => return self.draw(events),
            WindowEvent::DroppedFile(path) => self.panels.dropped(&path, Instant::now()),
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
