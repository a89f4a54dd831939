//! What stands in a scene's files, as a tree: the nodes with what is written inside them, and what each of them is in the
//! scene.

use std::collections::HashMap;

use kinora_lang::library;
use kinora_lang::source::{FileId, Source, Span};
use kinora_lang::syntax::ast::{Block, Expr, ExprKind, File, Item, Name, Node};

use crate::session::Loaded;

/// More than these are not listed.
const MOST: usize = 200_000;
/// Characters of a value that are listed.
const VALUE: usize = 60;

/// A part of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// Index into the scene's nodes.
    Node(usize),
    /// Index into its cameras.
    Camera(usize),
    /// Index into its lights.
    Light(usize),
    /// Its sky.
    Sky,
    /// How the picture is made.
    Render,
}

/// A line of the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is called in the tree, the same after an edit elsewhere.
    pub path: String,
    /// How deep it is: 0 for a file.
    pub depth: usize,
    /// `sphere`, `for i in 0..6`, the name of a file.
    pub what: String,
    /// The author's name.
    pub name: Option<String>,
    /// Where it stands: its name, else its kind.
    pub place: (FileId, Span),
    /// What it sets: the property and what is written.
    pub sets: Vec<(String, String)>,
    /// What it is in the scene: several things where it stands in a loop or a prefab.
    pub parts: Vec<Part>,
    /// Whether something stands inside it.
    pub opens: bool,
}

/// The tree, line by line, what is inside another below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// The lines.
    pub entries: Vec<Entry>,
    of_part: HashMap<Part, usize>,
}

/// The tree of a scene's own text and of what it imports, but for what comes with the program.
pub fn of(loaded: &Loaded) -> Outline {
    let mut outline = Outline::default();
    let mut parts = parts_by_place(loaded);
    for (at, source) in loaded.sources.iter().enumerate() {
        let is_scene = source.name.ends_with(".kin") || at == 0;
        if library::is_path(&source.name) || !is_scene {
            continue;
        }
        let parsed;
        let file = match at {
            0 => loaded.tree().file(),
            _ => {
                parsed = kinora_lang::parse(source);
                parsed.file()
            }
        };
        Reader { outline: &mut outline, source, parts: &mut parts }.file(file);
    }
    for (at, entry) in outline.entries.iter().enumerate() {
        outline.of_part.extend(entry.parts.iter().map(|part| (*part, at)));
    }
    outline
}

fn parts_by_place(loaded: &Loaded) -> HashMap<(FileId, u32), Vec<Part>> {
    let mut parts: HashMap<(FileId, u32), Vec<Part>> = HashMap::new();
    let mut add = |places: &[(FileId, Span)], part: fn(usize) -> Part| {
        for (at, (file, span)) in places.iter().enumerate() {
            parts.entry((*file, span.start)).or_default().push(part(at));
        }
    };
    add(&loaded.places.nodes, Part::Node);
    add(&loaded.places.cameras, Part::Camera);
    add(&loaded.places.lights, Part::Light);
    parts
}

impl Outline {
    /// The line of a part of the scene.
    pub fn of_part(&self, part: Part) -> Option<usize> {
        self.of_part.get(&part).copied()
    }

    /// The line with this path.
    pub fn find(&self, path: &str) -> Option<usize> {
        self.entries.iter().position(|entry| entry.path == path)
    }

    /// The lines that a line is inside of, the nearest first.
    pub fn around(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let mut depth = self.entries.get(at).map_or(0, |entry| entry.depth);
        (0..at).rev().filter(move |before| {
            let is_outer = self.entries.get(*before).is_some_and(|entry| entry.depth < depth);
            if is_outer {
                depth -= 1;
            }
            is_outer
        })
    }

    /// What a line and those inside it are in the scene.
    pub fn parts_within(&self, at: usize) -> Vec<Part> {
        let Some(first) = self.entries.get(at) else { return Vec::new() };
        let inside = self.entries.iter().skip(at + 1).take_while(|entry| entry.depth > first.depth);
        std::iter::once(first).chain(inside).flat_map(|entry| entry.parts.iter().copied()).collect()
    }
}

struct Reader<'a> {
    outline: &'a mut Outline,
    source: &'a Source,
    parts: &'a mut HashMap<(FileId, u32), Vec<Part>>,
}

impl Reader<'_> {
    fn file(&mut self, file: &File) {
        let path = self.source.name.to_string();
        let at = self.enter(path.clone(), 0, path.clone(), None, Span::at(0));
        self.items(&file.items, &path, 1);
        self.close(at);
    }

    fn enter(&mut self, path: String, depth: usize, what: String, name: Option<String>, place: Span) -> usize {
        let place = (self.source.id, place);
        self.outline.entries.push(Entry {
            path,
            depth,
            what,
            name,
            place,
            sets: Vec::new(),
            parts: Vec::new(),
            opens: false,
        });
        self.outline.entries.len() - 1
    }

    /// A line knows whether something came to stand inside it.
    fn close(&mut self, at: usize) {
        let opens = self.outline.entries.len() > at + 1;
        if let Some(entry) = self.outline.entries.get_mut(at) {
            entry.opens = opens;
        }
    }

    /// A path for what is called `what` inside `outer`: the second of that name is another.
    fn path(&self, outer: &str, what: &str, seen: &mut HashMap<String, usize>) -> String {
        let count = seen.entry(what.to_owned()).or_default();
        *count += 1;
        if *count == 1 { format!("{outer}/{what}") } else { format!("{outer}/{what}#{count}") }
    }

    fn items(&mut self, items: &[Item], outer: &str, depth: usize) {
        let mut seen = HashMap::new();
        for item in items {
            if self.outline.entries.len() >= MOST {
                return;
            }
            match item {
                Item::Node(node) => self.node(node, "", outer, depth, &mut seen),
                Item::Property(set) => self.value(&set.value, &set.name.text, outer, depth, &mut seen),
                Item::Let(set) => {
                    let name = set.name.as_ref().map_or("", |name| &name.text);
                    self.value(&set.value, name, outer, depth, &mut seen);
                }
                Item::For(each) => self.block("for", each.head.span, each.body.as_ref(), outer, depth, &mut seen),
                Item::If(cases) => {
                    for (condition, body) in &cases.arms {
                        self.block("if", condition.span, body.as_ref(), outer, depth, &mut seen);
                    }
                    if let Some(body) = &cases.otherwise {
                        self.block("else", Span::at(body.span.start), Some(body), outer, depth, &mut seen);
                    }
                }
                Item::Prefab(prefab) => {
                    let place = prefab.name.as_ref().map_or(prefab.head, |name| name.span);
                    let name = prefab.name.as_ref().map(|name| name.text.to_string());
                    let path = self.path(outer, &format!("prefab {}", name.as_deref().unwrap_or("")), &mut seen);
                    let at = self.enter(path.clone(), depth, "prefab".into(), name, place);
                    self.items(prefab.body.as_ref().map_or(&[], |body| &body.items), &path, depth + 1);
                    self.close(at);
                }
                Item::Block(block) => self.items(&block.items, outer, depth),
                _ => {}
            }
        }
    }

    /// A loop or a case; what stands in none is not worth a line.
    fn block(
        &mut self,
        word: &str,
        head: Span,
        body: Option<&Block>,
        outer: &str,
        depth: usize,
        seen: &mut HashMap<String, usize>,
    ) {
        let Some(body) = body else { return };
        let written = shortened(self.source.slice(head));
        let what = if written.starts_with(word) || written.is_empty() { written } else { format!("{word} {written}") };
        let what = if what.is_empty() { word.to_owned() } else { what };
        let path = self.path(outer, word, seen);
        let at = self.enter(path.clone(), depth, what, None, head);
        self.items(&body.items, &path, depth + 1);
        if self.outline.entries.len() == at + 1 {
            self.outline.entries.pop();
        }
        self.close(at);
    }

    /// The nodes in a value.
    fn value(&mut self, value: &Expr, called: &str, outer: &str, depth: usize, seen: &mut HashMap<String, usize>) {
        match &value.kind {
            ExprKind::Node(node) => self.node(node, called, outer, depth, seen),
            ExprKind::If(cases) => {
                for (_, value) in &cases.arms {
                    self.value(value, called, outer, depth, seen);
                }
                self.value(&cases.otherwise, called, outer, depth, seen);
            }
            ExprKind::Call { args, .. } => {
                for arg in args {
                    self.value(&arg.value, called, outer, depth, seen);
                }
            }
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                for item in items {
                    self.value(item, called, outer, depth, seen);
                }
            }
            ExprKind::Comp(comp) => self.value(&comp.value, called, outer, depth, seen),
            _ => {}
        }
    }

    fn node(&mut self, node: &Node, called: &str, outer: &str, depth: usize, seen: &mut HashMap<String, usize>) {
        let kind: Vec<&str> = node.kind.segments.iter().map(|name| &*name.text).collect();
        let kind = kind.join(".");
        let name = node.name.as_ref().map(|name: &Name| name.text.to_string());
        let what = if called.is_empty() { kind } else { format!("{called}: {kind}") };
        let label = match &name {
            Some(name) => format!("{what} {name}"),
            None => what.clone(),
        };
        let path = self.path(outer, &label, seen);
        let place = node.name.as_ref().map_or(node.kind.span, |name| name.span);
        let at = self.enter(path.clone(), depth, what, name, place);
        let parts = self.parts.remove(&(self.source.id, place.start)).unwrap_or_default();
        let items = node.body.as_ref().map_or(&[][..], |body| &body.items);
        let sets = items.iter().filter_map(|item| match item {
            Item::Property(set) => Some((set.name.text.to_string(), shortened(self.source.slice(set.value.span)))),
            _ => None,
        });
        let sets: Vec<_> = sets.collect();
        if let Some(entry) = self.outline.entries.get_mut(at) {
            (entry.sets, entry.parts) = (sets, parts);
            match (called, &*entry.what) {
                ("", "sky") => entry.parts.push(Part::Sky),
                ("", "render") => entry.parts.push(Part::Render),
                _ => {}
            }
        }
        self.items(items, &path, depth + 1);
        self.close(at);
    }
}

/// One line of it.
fn shortened(text: &str) -> String {
    let mut line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((at, _)) = line.char_indices().nth(VALUE) {
        line.truncate(at);
        line.push('…');
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{self, Changes};

    const SCENE: &str = "lang 1
import \"parts.kin\" as parts
camera { position: (0, 0, 5), look_at: (0, 0, 0) }
sky { color: #fff }
sun key { direction: (0, -1, 0), irradiance: 1W/m^2 }
prefab wall(at: vec3) { box { position: at } }
wall left { at: (1, 0, 0) }
wall right { at: (-1, 0, 0) }
group arm {
    sphere { radius: 1 }
    for i in 0..3 { sphere ball { radius: 0.5, position: (i, 0, 0) } }
    sphere { radius: 2, material: metal { color: #fff } }
}
parts.lamp { }
";

    fn loaded(edit: fn(&str) -> String) -> Loaded {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("parts.kin"), "prefab lamp() { disk bulb { radius: 1 } }\n").unwrap();
        let path = folder.path().join("scene.kin");
        std::fs::write(&path, edit(SCENE)).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        assert!(loaded.scene.is_some(), "{:?}", loaded.diagnostics);
        loaded
    }

    fn lines(outline: &Outline) -> Vec<String> {
        outline.entries.iter().map(|entry| format!("{} × {}", entry.path, entry.parts.len())).collect()
    }

    #[test]
    fn every_line_knows_what_it_is_in_the_scene() {
        let loaded = loaded(str::to_owned);
        let outline = of(&loaded);
        assert_eq!(
            lines(&outline),
            [
                "scene.kin × 0",
                "scene.kin/camera × 1",
                "scene.kin/sky × 1",
                "scene.kin/sun key × 1",
                "scene.kin/prefab wall × 0",
                "scene.kin/prefab wall/box × 2",
                "scene.kin/wall left × 1",
                "scene.kin/wall right × 1",
                "scene.kin/group arm × 1",
                "scene.kin/group arm/sphere × 1",
                "scene.kin/group arm/for × 0",
                "scene.kin/group arm/for/sphere ball × 3",
                "scene.kin/group arm/sphere#2 × 1",
                "scene.kin/group arm/sphere#2/material: metal × 0",
                "scene.kin/parts.lamp × 0",
                "parts.kin × 0",
                "parts.kin/prefab lamp × 0",
                "parts.kin/prefab lamp/disk bulb × 1",
            ]
        );
        let scene = loaded.scene.as_deref().unwrap();
        for at in 0..scene.nodes.len() {
            let entry = &outline.entries[outline.of_part(Part::Node(at)).expect("a line")];
            let name = entry.name.as_ref().unwrap_or(&entry.what);
            assert_eq!(*name, scene.nodes[at].name, "{}", entry.path);
        }
        let arm = outline.find("scene.kin/group arm").unwrap();
        assert_eq!(outline.parts_within(arm).len(), 6);
        let ball = outline.find("scene.kin/group arm/for/sphere ball").unwrap();
        let around: Vec<&str> = outline.around(ball).map(|at| &*outline.entries[at].path).collect();
        assert_eq!(around, ["scene.kin/group arm/for", "scene.kin/group arm", "scene.kin"]);
        assert_eq!(outline.entries[ball].sets[1], ("position".into(), "(i, 0, 0)".into()));
    }

    #[test]
    fn paths_survive_edits_elsewhere() {
        let before = of(&loaded(str::to_owned));
        let after = of(&loaded(|text| text.replace("sky {", "// more\n\nbox new { }\nsky {")));
        for entry in &before.entries {
            let found = &after.entries[after.find(&entry.path).expect(&entry.path)];
            assert_eq!((&found.what, &found.name, &found.sets), (&entry.what, &entry.name, &entry.sets));
        }
    }
}
