//! What stands beside the picture: parameters, camera, scene, rendering, and what goes with them.

pub mod camera;
pub mod control;
pub mod curves;
pub mod device;
pub mod editor;
pub mod keys;
pub mod look;
pub mod outline;
pub mod params;
pub mod prefs;
pub mod render;
pub mod scene;
pub mod start;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{
    Align2, Button, Key, Panel, Pos2, Rect, RichText, ScrollArea, TextEdit, TextureHandle, TextureOptions, Ui, vec2,
};
use glam::DVec3;
use kinora_scene::Scene;
use serde::{Deserialize, Serialize};

use super::model::Model;
use super::orbit;
use super::wish::Wish;
use crate::flags::BackendName;
use crate::terminal;
use curves::Moves;
use device::Devices;
use look::{Seen, Sight, Window, with_children};
use outline::{Outline, Part};
use params::Params;
use prefs::{Prefs, Theme};
use render::Render;
use scene::Selected;
use start::{Draft, Dropped, Page};

/// How long a message stays.
const MESSAGE: Duration = Duration::from_secs(6);
/// The longest side of what is looked at, in pixels.
const SIGHT: f32 = 960.0;

/// What the panel at the side shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tab {
    /// The scene's parameters.
    Params,
    /// The camera.
    Camera,
    /// The tree, what is chosen, and statistics.
    Scene,
    /// Pictures and films.
    Render,
}

/// What only the window can do.
pub enum Action {
    /// Save what the window shows.
    Photograph(PathBuf),
    /// Render with something else.
    Device(device::Choice),
}

/// What the window tells its panels.
pub struct Facts<'a> {
    /// What renders.
    pub device: &'a str,
    /// What was chosen to render.
    pub backend: BackendName,
    /// Rays of the picture so far, and how long they took.
    pub rays: Option<(u64, Duration)>,
    /// Samples a pixel so far.
    pub samples: u32,
}

/// All panels.
pub struct Panels {
    /// What is remembered.
    pub prefs: Prefs,
    /// What the window is to do.
    pub actions: Vec<Action>,
    wish: Arc<Wish>,
    window: Arc<Window>,
    params: Params,
    render: Render,
    devices: Devices,
    page: Page,
    draft: Option<Draft>,
    outline: Option<(u64, Outline)>,
    tree: scene::Tree,
    selected: Option<Selected>,
    moves: Option<(u64, Part, Moves)>,
    /// Where a node is: of which load, which and when.
    placed: Option<((u64, usize, u64), Option<DVec3>)>,
    seen: Option<Seen>,
    asked: Option<Sight>,
    click: Option<Click>,
    lines: Option<(Vec<Part>, Option<TextureHandle>)>,
    focusing: bool,
    help: bool,
    message: Option<(String, Instant)>,
}

/// A click into the picture that is not answered yet.
#[derive(Clone, Copy)]
struct Click {
    /// 0..=1 from the left and from the top.
    place: [f32; 2],
    /// Whether it says what is in focus, or what is chosen.
    focus: bool,
}

impl Panels {
    /// Panels that change `wish`.
    pub fn new(wish: Arc<Wish>, window: Arc<Window>, prefs: Prefs) -> Panels {
        Panels {
            prefs,
            actions: Vec::new(),
            wish,
            window,
            params: Params::default(),
            render: Render::default(),
            devices: Devices::default(),
            page: Page::default(),
            draft: None,
            outline: None,
            tree: scene::Tree::default(),
            selected: None,
            moves: None,
            placed: None,
            seen: None,
            asked: None,
            click: None,
            lines: None,
            focusing: false,
            help: false,
            message: None,
        }
    }

    /// Takes another load of the scene.
    pub fn take(&mut self, model: &Model) {
        let Some(loaded) = &model.good else { return };
        self.params.take(&loaded.params, &self.wish.get().0.live);
        (self.outline, self.moves) = (None, None);
        if let Some(path) = self.selected.as_ref().map(|selected| selected.path.clone())
            && self.outline(model).is_none_or(|outline| outline.find(&path).is_none())
        {
            self.selected = None;
        }
        if self.click.is_some() {
            self.asked = None;
        }
    }

    /// Fetches what was seen.
    pub fn looked(&mut self, model: &mut Model, now: Instant) {
        if let Some(Ok(seen)) = self.window.results.take() {
            (self.seen, self.lines) = (Some(seen), None);
            self.answer(model, now);
        }
    }

    /// Says something for a while.
    pub fn say(&mut self, text: impl Into<String>, now: Instant) {
        self.message = Some((text.into(), now));
    }

    /// What is to be said.
    pub fn message(&self, now: Instant) -> Option<&str> {
        self.message.as_ref().filter(|(_, since)| now.duration_since(*since) < MESSAGE).map(|(text, _)| &**text)
    }

    /// How long nothing needs to be drawn for it.
    pub fn idle(&self, now: Instant) -> Option<Duration> {
        self.message
            .as_ref()
            .map(|(_, since)| (*since + MESSAGE).saturating_duration_since(now))
            .filter(|left| !left.is_zero())
    }

    /// Opens another scene.
    pub fn open(&mut self, path: PathBuf) {
        let path = std::path::absolute(&path).unwrap_or(path);
        self.wish.change(|desired| {
            if desired.path.as_ref() != Some(&path) {
                desired.live.clear();
                desired.changes.camera = None;
                desired.path = Some(path);
            }
        });
    }

    /// Takes a file that was dropped on the window.
    pub fn dropped(&mut self, path: &Path, now: Instant) {
        match start::dropped(path) {
            Ok(Dropped::Scene(path)) => self.open(path),
            Ok(Dropped::Draft(draft)) => self.draft = Some(draft),
            Err(why) => self.say(why, now),
        }
    }

    /// Whether the panel at the side is there.
    pub fn side(&self) -> bool {
        self.prefs.side.unwrap_or(!self.params.is_empty())
    }

    fn tab(&self) -> Tab {
        let first = if self.params.is_empty() { Tab::Camera } else { Tab::Params };
        self.prefs.tab.filter(|tab| *tab != Tab::Params || !self.params.is_empty()).unwrap_or(first)
    }

    /// Whether to show the page of the start.
    pub fn at_start(&self) -> bool {
        self.wish.get().0.path.is_none()
    }

    /// Draws the page of the start.
    pub fn start_page(&mut self, ui: &mut Ui) {
        if let Some(path) = self.page.show(ui) {
            self.open(path);
        }
    }

    /// What the keys do.
    pub fn keys(&mut self, ui: &Ui, model: &mut Model, now: Instant) {
        let pressed = |key| ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key));
        let question =
            ui.input(|input| input.events.iter().any(|event| matches!(event, egui::Event::Text(text) if text == "?")));
        if question {
            self.help = !self.help;
        }
        if pressed(Key::N) {
            self.prefs.side = Some(!self.side());
        }
        if pressed(Key::F) {
            self.focusing = !self.focusing && model.good.is_some();
        }
        // There it leaves what is being chosen.
        if !model.choosing && pressed(Key::Escape) {
            (self.selected, self.focusing, self.help) = (None, false, false);
        }
        if pressed(Key::F12) {
            self.photograph(now);
        }
    }

    fn photograph(&mut self, now: Instant) {
        let path = self.wish.get().0.path;
        let stem =
            path.as_ref().and_then(|path| path.file_stem()).map_or("kinora".into(), |stem| stem.to_string_lossy());
        let stem = format!("{stem}-view");
        let beside = path.as_ref().and_then(|path| path.parent()).filter(|folder| !folder.as_os_str().is_empty());
        match start::free_name(beside.unwrap_or(Path::new(".")), &stem, "png") {
            Some(path) => self.actions.push(Action::Photograph(path)),
            None => self.say("there are too many pictures of the window already", now),
        }
    }

    /// Draws the panel at the side, and the windows.
    pub fn show(&mut self, ui: &mut Ui, model: &mut Model, facts: &Facts<'_>, now: Instant) {
        if let Some(wait) = self.render.poll() {
            ui.ctx().request_repaint_after(wait);
        }
        keys::show(ui.ctx(), &mut self.help);
        self.draft_window(ui, now);
        if self.at_start() || !self.side() {
            return;
        }
        let panel = Panel::right("side").default_size(self.prefs.side_width).size_range(220.0..=560.0);
        let shown = panel.show(ui, |ui| {
            ui.add_space(4.0);
            self.tabs(ui);
            ui.separator();
            match self.tab() {
                Tab::Params => {
                    let wish = self.wish.clone();
                    wish.change(|desired| self.params.show(ui, desired));
                }
                Tab::Camera => self.camera(ui, model, now),
                Tab::Scene => self.scene(ui, model, facts, now),
                Tab::Render => {
                    ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| self.renders(ui, model, facts));
                }
            }
        });
        self.prefs.side_width = shown.response.rect.width();
    }

    fn tabs(&mut self, ui: &mut Ui) {
        let now = self.tab();
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 6.0;
            let all =
                [(Tab::Params, "Parameters"), (Tab::Camera, "Camera"), (Tab::Scene, "Scene"), (Tab::Render, "Render")];
            for (tab, name) in all {
                if (tab != Tab::Params || !self.params.is_empty()) && ui.selectable_label(tab == now, name).clicked() {
                    self.prefs.tab = Some(tab);
                }
            }
        });
    }

    fn camera(&mut self, ui: &mut Ui, model: &mut Model, now: Instant) {
        let Some(loaded) = model.good.clone() else { return };
        let Some(scene) = loaded.scene.as_deref() else { return };
        let orbit = model.orbit.clone().or_else(|| orbit::begin(scene, model.timeline.shutter()));
        let (moved, wish) = (model.orbit.is_some(), self.wish.clone());
        let mut asked = camera::Asked::default();
        let focusing = &mut self.focusing;
        wish.change(|desired| asked = camera::show(ui, scene, orbit.as_ref(), moved, focusing, desired));
        if let Some(view) = asked.view {
            model.edit_view(|orbit| *orbit = view, now);
        }
        if asked.reset {
            model.reset_view();
        }
    }

    fn renders(&mut self, ui: &mut Ui, model: &Model, facts: &Facts<'_>) {
        let Some(scene) = model.good.as_ref().and_then(|loaded| loaded.scene.as_deref()) else { return };
        let desired = self.wish.get().0;
        self.render.show(ui, scene, model.timeline.frame(), model.orbit.is_some(), &desired, facts.backend);
    }

    fn scene(&mut self, ui: &mut Ui, model: &Model, facts: &Facts<'_>, now: Instant) {
        let Some(loaded) = model.good.clone() else { return };
        let Some(scene) = loaded.scene.as_deref() else { return };
        let load = model.loads;
        self.outline(model);
        let Some((_, outline)) = &self.outline else { return };
        let before = self.selected.clone();
        let height = ui.available_height();
        self.tree.show(ui, outline, &mut self.selected, height * 0.45);
        ui.separator();
        let mut edit = None;
        ScrollArea::vertical().id_salt("details").auto_shrink([false, true]).show(ui, |ui| {
            match self.selected.as_ref().and_then(|selected| outline.find(&selected.path)) {
                Some(at) => {
                    let nth = self.selected.as_ref().and_then(|selected| selected.nth);
                    let shutter = model.timeline.shutter();
                    let placed = &mut self.placed;
                    let mut place = |node: usize| {
                        let key = (load, node, shutter.open_s.to_bits());
                        if placed.is_none_or(|(of, _)| of != key) {
                            *placed = Some((key, scene::place_of(&loaded, node, shutter)));
                        }
                        placed.and_then(|(_, place)| place)
                    };
                    edit = scene::details(ui, &loaded, scene, outline, at, nth, &mut place);
                }
                None => {
                    ui.label(RichText::new("Click into the picture or the tree to choose something.").weak());
                }
            }
            ui.add_space(4.0);
            ui.collapsing("Statistics", |ui| scene::statistics(ui, scene, facts));
            ui.collapsing("Device", |ui| {
                if let Some(choice) = self.devices.show(ui, facts) {
                    self.actions.push(Action::Device(choice));
                }
            });
        });
        if let Some((path, place)) = edit {
            self.edit(&path, place, now);
        }
        if self.selected != before {
            self.lines = None;
        }
    }

    fn edit(&mut self, path: &Path, place: [u32; 2], now: Instant) {
        let visual = std::env::var("VISUAL").ok();
        let command = editor::command(Some(&self.prefs.editor), visual.as_deref(), path, place);
        let opened = command.ok_or_else(|| "the command of the editor cannot be read".into());
        if let Err(why) = opened.and_then(|command| editor::open(&command)) {
            self.say(format!("{why}. Set the command of the editor in the menu"), now);
        }
    }

    /// The tree of the scene as it is.
    fn outline(&mut self, model: &Model) -> Option<&Outline> {
        let loaded = model.good.as_ref()?;
        if self.outline.as_ref().is_none_or(|(load, _)| *load != model.loads) {
            self.outline = Some((model.loads, outline::of(loaded)));
        }
        self.outline.as_ref().map(|(_, outline)| outline)
    }

    /// What is chosen.
    fn chosen(&mut self, model: &Model) -> Vec<Part> {
        let Some(selected) = self.selected.clone() else { return Vec::new() };
        let Some(outline) = self.outline(model) else { return Vec::new() };
        selected.parts(outline)
    }

    /// What moves of what is chosen.
    pub fn moves(&mut self, model: &Model) -> Option<&Moves> {
        let part = *self.chosen(model).first()?;
        if self.moves.as_ref().is_none_or(|(load, of, _)| (*load, *of) != (model.loads, part)) {
            let scene = model.good.as_ref()?.scene.as_deref()?;
            let end_s = model.timeline.last_frame() as f64 / model.timeline.fps();
            self.moves = Some((model.loads, part, curves::of_part(scene, part, end_s)));
        }
        self.moves.as_ref().map(|(.., moves)| moves)
    }

    /// A click into the picture.
    pub fn clicked(&mut self, place: [f32; 2], model: &mut Model, now: Instant) {
        self.click = Some(Click { place, focus: std::mem::take(&mut self.focusing) });
        self.answer(model, now);
    }

    /// Whether a click will say what is in focus.
    pub fn is_focusing(&self) -> bool {
        self.focusing
    }

    /// Answers a click, if what is seen is what is shown.
    fn answer(&mut self, model: &mut Model, now: Instant) {
        let (Some(click), Some(seen)) = (self.click, &self.seen) else { return };
        let Some(wanted) = model.sight(seen.sight.size) else { return };
        if !seen.sight.same(&wanted) {
            return;
        }
        self.click = None;
        let hit = seen.at(click.place);
        if click.focus {
            match hit {
                Some((_, depth_m)) => {
                    model.edit_view(|orbit| orbit.focus(depth_m), now);
                    self.say(format!("in focus: {} m", control::short(depth_m)), now);
                }
                None => self.say("there is nothing to focus on", now),
            }
            return;
        }
        let loads = model.loads;
        self.outline(model);
        self.selected = hit.and_then(|(part, _)| {
            let (load, outline) = self.outline.as_ref()?;
            (*load == loads).then(|| Selected::of(outline, part)).flatten()
        });
        if let (Some(selected), Some((_, outline))) = (&self.selected, &self.outline) {
            self.tree.reveal(outline, &selected.path);
        }
        self.lines = None;
    }

    /// Looks at what the picture shows, if someone wants to know; draws the outline of what is chosen over `picture`, in
    /// `clip`.
    pub fn over_picture(&mut self, ui: &Ui, model: &mut Model, picture: Rect, clip: Rect, now: Instant) {
        let wanted = self.click.is_some() || self.selected.is_some();
        let scale =
            ui.pixels_per_point() * (SIGHT / (picture.width().max(picture.height()) * ui.pixels_per_point())).min(1.0);
        let size = [picture.width(), picture.height()].map(|side| ((side * scale).round() as u32).max(1));
        let Some(sight) = model.sight(size).filter(|_| wanted && !model.is_moving(now)) else { return };
        let known = self.seen.as_ref().is_some_and(|seen| seen.sight.same(&sight));
        if known {
            self.answer(model, now);
        } else if !self.asked.as_ref().is_some_and(|asked| asked.same(&sight)) {
            self.asked = Some(sight.clone());
            self.window.sights.put(sight);
        }
        if !known {
            return;
        }
        let chosen = self.chosen(model);
        if chosen.is_empty() {
            return;
        }
        if self.lines.as_ref().is_none_or(|(of, _)| *of != chosen) {
            let image = model.good.as_ref().and_then(|loaded| loaded.scene.as_deref()).and_then(|scene: &Scene| {
                let all: HashSet<Part> = with_children(scene, &chosen);
                self.seen.as_ref()?.outline(&all)
            });
            let texture = image.map(|image| ui.ctx().load_texture("chosen", image, TextureOptions::LINEAR));
            self.lines = Some((chosen, texture));
        }
        if let Some((_, Some(texture))) = &self.lines {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter_at(clip).image(texture.id(), picture, whole, egui::Color32::WHITE);
        }
    }

    /// What is chosen, in words.
    pub fn chosen_words(&self) -> Option<String> {
        let selected = self.selected.as_ref()?;
        let (_, outline) = self.outline.as_ref()?;
        let entry = outline.entries.get(outline.find(&selected.path)?)?;
        let name = entry.name.as_ref().map_or(String::new(), |name| format!(" {name}"));
        let nth = selected.nth.filter(|_| entry.parts.len() > 1);
        let nth = nth.map_or(String::new(), |nth| format!(", {} of {}", nth + 1, entry.parts.len()));
        Some(format!("{}{name}{nth}", entry.what))
    }

    /// The menu of what is set for the viewer itself.
    pub fn menu(&mut self, ui: &mut Ui, now: Instant) {
        ui.set_width(290.0);
        let mut leave = false;
        ui.label("Dark or light");
        ui.horizontal(|ui| {
            for (theme, name) in [(Theme::Dark, "Dark"), (Theme::Light, "Light"), (Theme::System, "As the system")] {
                ui.selectable_value(&mut self.prefs.theme, theme, name);
            }
        });
        ui.separator();
        ui.label("Command of the editor");
        let hint = TextEdit::singleline(&mut self.prefs.editor).hint_text("$VISUAL, or code -g {file}:{line}:{column}");
        ui.add(hint.desired_width(f32::INFINITY)).on_hover_text("With {file}, {line} and {column} in it");
        ui.separator();
        if ui.button("Picture of the window (F12)").clicked() {
            self.photograph(now);
            ui.close();
        }
        if !self.at_start() && ui.button("Another scene…").clicked() {
            leave = true;
            ui.close();
        }
        if ui.button("Keys (?)").clicked() {
            self.help = true;
            ui.close();
        }
        if leave {
            self.wish.change(|desired| {
                desired.live.clear();
                desired.changes.camera = None;
                desired.path = None;
            });
        }
    }

    fn draft_window(&mut self, ui: &Ui, now: Instant) {
        let Some(draft) = &mut self.draft else { return };
        let (mut open, mut close, mut made) = (true, false, None);
        let window = egui::Window::new("New scene").open(&mut open).collapsible(false).default_width(460.0);
        let middle = ui.ctx().content_rect().center();
        window.pivot(Align2::CENTER_CENTER).default_pos(middle).show(ui.ctx(), |ui| {
            ui.horizontal(|ui| {
                ui.label("Name");
                ui.add(TextEdit::singleline(&mut draft.stem).desired_width(180.0));
                ui.label(".kin");
            });
            ui.label(RichText::new(format!("in {}", draft.folder.display())).small().weak());
            ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
                ui.add(TextEdit::multiline(&mut draft.text).code_editor().desired_width(f32::INFINITY));
            });
            ui.horizontal(|ui| {
                if ui.button("Save and open").clicked() {
                    made = Some(start::write_new(&draft.folder, &draft.stem, &draft.text));
                }
                if ui.button("Copy as text").clicked() {
                    ui.ctx().copy_text(draft.text.clone());
                    close = true;
                }
                if ui.add_sized(vec2(60.0, 20.0), Button::new("Cancel")).clicked() {
                    close = true;
                }
            });
        });
        if close || !open {
            self.draft = None;
        }
        match made {
            Some(Ok(path)) => {
                self.draft = None;
                self.say(format!("saved as {}", path.display()), now);
                self.open(path);
            }
            Some(Err(why)) => self.say(why, now),
            None => {}
        }
    }

    /// Remembers what is set, `size` being that of the window in points.
    pub fn remember(&mut self, size: Option<[f32; 2]>, model: &Model) {
        self.prefs.size = size.unwrap_or(self.prefs.size);
        (self.prefs.speed, self.prefs.looping) = (model.timeline.speed, model.timeline.looping);
        self.prefs.save();
    }

    /// Says that there is no such device, and what is done about it.
    pub fn no_gpu(&mut self, why: &str, now: Instant) {
        terminal::err(&format!("{why}\n"));
        self.say(why, now);
    }
}
