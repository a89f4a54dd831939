//! The panel of the scene: its tree by file and node, what is chosen, and how much there is of everything.

use std::collections::HashSet;
use std::path::PathBuf;

use egui::{Align, Grid, Label, RichText, ScrollArea, Sense, TextStyle, TextWrapMode, Ui, vec2};
use glam::DVec3;
use kinora_scene::{Scene, Shape, Shutter};

use super::Facts;
use super::control::short;
use super::outline::{Entry, Outline, Part};
use crate::commands::inspect;
use crate::memory;
use crate::session::Loaded;

/// What is chosen: a line of the tree, and which of the things that it is in the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selected {
    /// The line's path.
    pub path: String,
    /// Which of its parts; all of them, and what is inside, where none is said.
    pub nth: Option<usize>,
}

impl Selected {
    /// The line of a part of the scene, and that part of it.
    pub fn of(outline: &Outline, part: Part) -> Option<Selected> {
        let entry = outline.entries.get(outline.of_part(part)?)?;
        Some(Selected { path: entry.path.clone(), nth: entry.parts.iter().position(|own| *own == part) })
    }

    /// What it is in the scene.
    pub fn parts(&self, outline: &Outline) -> Vec<Part> {
        let Some(at) = outline.find(&self.path) else { return Vec::new() };
        let one = self.nth.and_then(|nth| outline.entries.get(at)?.parts.get(nth).copied());
        one.map_or_else(|| outline.parts_within(at), |part| vec![part])
    }
}

/// The tree as it is seen.
#[derive(Default)]
pub struct Tree {
    open: HashSet<String>,
    closed: HashSet<String>,
    /// The line to scroll to.
    reveal: Option<String>,
}

impl Tree {
    /// Opens what a line is inside of, and shows it.
    pub fn reveal(&mut self, outline: &Outline, path: &str) {
        let Some(at) = outline.find(path) else { return };
        for outer in outline.around(at) {
            if let Some(entry) = outline.entries.get(outer) {
                self.closed.remove(&entry.path);
                self.open.insert(entry.path.clone());
            }
        }
        self.reveal = Some(path.to_owned());
    }

    /// Files are open at first, all else is closed.
    fn is_open(&self, entry: &Entry) -> bool {
        if entry.depth == 0 { !self.closed.contains(&entry.path) } else { self.open.contains(&entry.path) }
    }

    fn toggle(&mut self, entry: &Entry) {
        let (list, path) = (if entry.depth == 0 { &mut self.closed } else { &mut self.open }, entry.path.clone());
        if !list.remove(&path) {
            list.insert(path);
        }
    }

    /// The lines that are seen.
    pub fn lines(&self, outline: &Outline) -> Vec<usize> {
        let mut seen = Vec::new();
        let mut below = usize::MAX;
        for (at, entry) in outline.entries.iter().enumerate() {
            if entry.depth > below {
                continue;
            }
            below = if entry.opens && !self.is_open(entry) { entry.depth } else { usize::MAX };
            seen.push(at);
        }
        seen
    }

    /// Draws it, at most so many points high.
    pub fn show(&mut self, ui: &mut Ui, outline: &Outline, selected: &mut Option<Selected>, height: f32) {
        let lines = self.lines(outline);
        let row = ui.text_style_height(&TextStyle::Body) + 2.0;
        ui.spacing_mut().item_spacing.y = 1.0;
        let target = self.reveal.take().and_then(|path| lines.iter().position(|at| outline.entries[*at].path == path));
        let mut area = ScrollArea::both().id_salt("tree").max_height(height).auto_shrink([false, false]);
        if let Some(line) = target {
            area = area.vertical_scroll_offset(((line as f32) * (row + 1.0) - height * 0.4).max(0.0));
        }
        area.show_rows(ui, row, lines.len(), |ui, range| {
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            for at in range.filter_map(|line| lines.get(line)) {
                let Some(entry) = outline.entries.get(*at) else { continue };
                self.line(ui, entry, row, selected);
            }
        });
        ui.spacing_mut().item_spacing.y = 3.0;
    }

    fn line(&mut self, ui: &mut Ui, entry: &Entry, row: f32, selected: &mut Option<Selected>) {
        let chosen = selected.as_ref().is_some_and(|selected| selected.path == entry.path);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.add_space(entry.depth as f32 * 12.0);
            let (icon, response) =
                ui.allocate_exact_size(vec2(12.0, row), if entry.opens { Sense::click() } else { Sense::hover() });
            if entry.opens {
                let openness = if self.is_open(entry) { 1.0 } else { 0.0 };
                let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(icon));
                egui::collapsing_header::paint_default_icon(&mut inner, openness, &response);
                if response.clicked() {
                    self.toggle(entry);
                }
            }
            let mut text = RichText::new(&entry.what);
            if entry.depth == 0 {
                text = text.strong();
            }
            let label = match &entry.name {
                Some(name) => RichText::new(format!("{} {name}", entry.what)),
                None => text,
            };
            if ui.selectable_label(chosen, label).clicked() {
                *selected = (!chosen).then(|| Selected { path: entry.path.clone(), nth: None });
            }
            if entry.parts.len() > 1 {
                ui.label(RichText::new(format!("× {}", entry.parts.len())).weak());
            }
        });
    }
}

/// Draws what is known of a line; gives the file, line and column that are to be opened in the editor.
pub fn details(
    ui: &mut Ui,
    loaded: &Loaded,
    scene: &Scene,
    outline: &Outline,
    at: usize,
    nth: Option<usize>,
    place: &mut dyn FnMut(usize) -> Option<DVec3>,
) -> Option<(PathBuf, [u32; 2])> {
    let entry = outline.entries.get(at)?;
    let mut edit = None;
    let (file, span) = entry.place;
    let position = loaded.sources.iter().find(|source| source.id == file).map(|source| source.position(span.start));
    let path = loaded.path_of(file);
    ui.horizontal(|ui| {
        let name = entry.name.as_ref().map_or(String::new(), |name| format!(" {name}"));
        ui.add(Label::new(RichText::new(format!("{}{name}", entry.what)).strong()).truncate());
    });
    ui.horizontal(|ui| {
        if let (Some(position), Some(path)) = (position, path) {
            if ui.button("Open in editor").clicked() {
                edit = Some((path.clone(), [position.line, position.column]));
            }
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            ui.add(Label::new(RichText::new(format!("{name}:{}", position.line)).weak()).truncate());
        }
    });
    Grid::new("details").num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.add(Label::new(value).truncate());
            ui.end_row();
        };
        match (entry.parts.len(), nth) {
            (0 | 1, _) => {}
            (count, Some(nth)) => row("which", format!("{} of {count}", nth + 1)),
            (count, None) => row("how many", count.to_string()),
        }
        let part = nth.and_then(|nth| entry.parts.get(nth)).or(entry.parts.first()).copied();
        if let Some(Part::Node(node)) = part {
            if let Some(centre) = place(node) {
                row("at", format!("({}, {}, {})", short(centre.x), short(centre.y), short(centre.z)));
            }
            if let Some(Shape::Mesh(mesh)) = scene.nodes.get(node).and_then(|node| node.shape.as_ref()) {
                row("triangles", mesh.triangles.len().to_string());
            }
        }
        for (name, value) in &entry.sets {
            row(name, value.clone());
        }
    });
    edit
}

/// Where a node is in the world; none where it is not seen.
pub fn place_of(loaded: &Loaded, node: usize, shutter: Shutter) -> Option<DVec3> {
    let shutter = Shutter { close_s: shutter.open_s, ..shutter };
    let world = loaded.sample(shutter).ok()?;
    let instance = world.instances.iter().find(|instance| instance.node == node)?;
    Some(instance.world_from_object.translation)
}

/// How much there is of everything.
pub fn statistics(ui: &mut Ui, scene: &Scene, facts: &Facts<'_>) {
    let mut text = inspect::overview(scene);
    if let Some((rays, time)) = facts.rays.filter(|(rays, _)| *rays > 0) {
        let rate = rays as f64 / time.as_secs_f64().max(1e-3) / 1e6;
        text += &format!("rays      {:.1} million, {rate:.2} million a second\n", rays as f64 / 1e6);
        text += &format!("samples   {} a pixel in {:.1} s\n", facts.samples, time.as_secs_f64());
    }
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    if let Some(peak) = memory::peak_bytes() {
        text += &format!("memory    {:.0} MiB at most\n", mib(peak));
    }
    if let Some(free) = memory::free_bytes() {
        text += &format!("free      {:.0} MiB\n", mib(free));
    }
    ui.with_layout(egui::Layout::top_down(Align::Min), |ui| {
        ui.add(Label::new(RichText::new(text.trim_end()).monospace().size(11.0)).wrap().selectable(true));
    });
}
