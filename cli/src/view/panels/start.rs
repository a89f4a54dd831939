//! How a scene comes to be: from an example, from a file that was dropped, or by its name.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use egui::{Align, Button, Label, Layout, Rect, RichText, ScrollArea, TextEdit, Ui, UiBuilder, pos2, vec2};
use glam::DVec3;
use kinora_lang::source::FileId;
use kinora_scene::{Shape, Still, World};

use super::control::short;
use crate::session::{self, Changes};

/// A scene that comes with the program.
pub struct Example {
    /// What its file is called.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! example {
    ($name:literal, $about:literal) => {
        Example { name: $name, about: $about, text: include_str!(concat!("../../../../examples/", $name, ".kin")) }
    };
}

/// Those that need no other file.
pub const EXAMPLES: [Example; 12] = [
    example!("hello", "a ball under the sky, in a few lines"),
    example!("cornell", "the box that everything is measured by"),
    example!("materials", "every material side by side"),
    example!("lens", "what is in focus and what is not"),
    example!("sky", "clear air and its sun"),
    example!("night", "many small lights"),
    example!("orbit", "a film: a camera on its way round"),
    example!("bounce", "a film: a ball, by keyframes"),
    example!("dominoes", "a film: bodies that fall, by physics"),
    example!("pendulums", "a film: joints and springs"),
    example!("procedural", "patterns that are computed"),
    example!("forest", "thousands of copies of one tree"),
];

/// The endings of what a new scene can be made of.
const MODELS: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];
const SKIES: [&str; 2] = ["hdr", "exr"];
/// More copies than these of one name are not made.
const MOST: u32 = 10_000;

/// What a file that was dropped is good for.
pub enum Dropped {
    /// It is a scene.
    Scene(PathBuf),
    /// A scene can be made of it.
    Draft(Draft),
}

/// A scene that is not saved yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// Where it is to be: its own file must lie in the project, beside what it uses.
    pub folder: PathBuf,
    /// The name of the file, without `.kin`.
    pub stem: String,
    /// The text.
    pub text: String,
}

/// What `path` is good for.
///
/// # Errors
/// Nothing, in words.
pub fn dropped(path: &Path) -> Result<Dropped, String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ending == "kin" {
        return Ok(Dropped::Scene(path.to_path_buf()));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = match &*ending {
        model if MODELS.contains(&model) => of_model(path, &name),
        sky if SKIES.contains(&sky) => of_sky(&name),
        _ => {
            return Err(format!(
                "`{name}` is no scene, model or sky: drop .kin, .glb, .gltf, .obj, .ply, .stl, .hdr or .exr"
            ));
        }
    };
    let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Dropped::Draft(Draft { folder, stem, text }))
}

fn text_between_quotes(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"")
}

/// A scene around a model, with a camera that sees all of it.
fn of_model(path: &Path, name: &str) -> String {
    let text = |centre: DVec3, radius: f64| {
        let eye = centre + DVec3::new(0.6, 0.35, 1.0).normalize() * radius * 3.4;
        let at = |v: DVec3| format!("({}, {}, {})", short(v.x), short(v.y), short(v.z));
        let name = text_between_quotes(name);
        format!(
            "lang 1\n\nrender {{ resolution: (960, 640), samples: 64, camera: main }}\n\n\
            camera main {{\n    position: {}\n    look_at: {}\n    fov: 36deg\n}}\n\n\
            sky {{ color: #8fb4e0, strength: 0.6 }}\n\
            sun {{ direction: (-1, -1.6, -0.8), irradiance: 2.5W/m^2, angle: 2deg }}\n\n\
            model object {{ file: \"{name}\" }}\n",
            at(eye),
            at(centre),
        )
    };
    let guess = text(DVec3::ZERO, 1.0);
    let world =
        session::load_bytes(FileId::default(), &path.with_extension("kin"), guess.as_bytes(), &Changes::default());
    let world = world.ok().and_then(|loaded| {
        let shutter = loaded.scene.as_ref()?.clock.shutter_of(0);
        loaded.sample(shutter).ok()
    });
    match world.as_ref().and_then(bounds) {
        Some((centre, radius)) => text(centre, radius),
        None => guess,
    }
}

/// The middle of all meshes and how far they reach from there; none where there are none.
fn bounds(world: &World) -> Option<(DVec3, f64)> {
    let points = || {
        world.instances.iter().flat_map(|instance| {
            let positions: &[glam::Vec3] = match &instance.shape {
                Shape::<Still>::Mesh(mesh) => &mesh.positions,
                _ => &[],
            };
            positions.iter().map(|p| instance.world_from_object.transform_point3(p.as_dvec3()))
        })
    };
    let (low, high) = points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let centre = (low + high) * 0.5;
    let radius = (high - low).length() * 0.5;
    (centre.is_finite() && radius.is_finite() && radius > 0.0).then_some((centre, radius))
}

/// A scene under a picture of the sky: balls that show it.
fn of_sky(name: &str) -> String {
    let name = text_between_quotes(name);
    format!(
        "lang 1\n\nrender {{ resolution: (960, 540), samples: 64, camera: main }}\n\n\
        camera main {{\n    position: (0, 1.2, 5)\n    look_at: (0, 0.5, 0)\n    fov: 36deg\n}}\n\n\
        sky {{ file: \"{name}\", strength: 1, rotation: 0deg }}\n\n\
        sphere mirror {{ position: (-1.15, 0.5, 0), radius: 0.5, material: metal {{ color: #f0f0f0, roughness: 0.02 }} }}\n\
        sphere plain {{ position: (0, 0.5, 0), radius: 0.5, material: diffuse {{ color: #b0b0b0 }} }}\n\
        sphere lacquered {{ position: (1.15, 0.5, 0), radius: 0.5, material: glossy {{ base: diffuse {{ color: #a02818 }}, roughness: 0.1 }} }}\n\
        plane floor {{ material: diffuse {{ color: #808080 }} }}\n"
    )
}

/// Writes a file that is not there yet: `stem.kin`, or the first of `stem-2.kin`, `stem-3.kin` that is free.
///
/// # Errors
/// The folder does not take it.
pub fn write_new(folder: &Path, stem: &str, text: &str) -> Result<PathBuf, String> {
    write_numbered(folder, stem, "kin", text.as_bytes())
}

fn write_numbered(folder: &Path, stem: &str, ending: &str, bytes: &[u8]) -> Result<PathBuf, String> {
    let stem = stem.trim();
    if stem.is_empty() || stem.contains(['/', '\\']) {
        return Err(format!("`{stem}` is no name of a file"));
    }
    for path in numbered(folder, stem, ending) {
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                return match file.write_all(bytes) {
                    Ok(()) => Ok(path),
                    Err(error) => Err(format!("cannot write `{}`: {error}", path.display())),
                };
            }
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(format!("cannot write `{}`: {error}", path.display())),
        }
    }
    Err(format!("there are too many files called `{stem}`"))
}

fn numbered(folder: &Path, stem: &str, ending: &str) -> impl Iterator<Item = PathBuf> {
    let (folder, stem, ending) = (folder.to_path_buf(), stem.to_owned(), ending.to_owned());
    (1..=MOST).map(move |number| {
        let number = if number == 1 { String::new() } else { format!("-{number}") };
        folder.join(format!("{stem}{number}.{ending}"))
    })
}

/// The first of `stem.ending`, `stem-2.ending`... that is not there.
pub fn free_name(folder: &Path, stem: &str, ending: &str) -> Option<PathBuf> {
    numbered(folder, stem, ending).find(|path| !path.exists())
}

/// The page that is shown before there is a scene.
pub struct Page {
    folder: String,
    path: String,
    wrong: Option<String>,
}

impl Default for Page {
    fn default() -> Self {
        let folder = std::env::current_dir().map_or_else(|_| ".".into(), |folder| folder.display().to_string());
        Self { folder, path: String::new(), wrong: None }
    }
}

impl Page {
    /// Draws the page; gives the scene that is to be opened.
    pub fn show(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let mut open = None;
        let area = ui.available_rect_before_wrap().shrink2(vec2(12.0, 20.0));
        let width = area.width().min(600.0);
        let left = area.center().x - width * 0.5;
        let column = Rect::from_min_size(pos2(left, area.top()), vec2(width, area.height()));
        ui.scope_builder(UiBuilder::new().max_rect(column), |ui| {
            ui.heading("Kinora");
            ui.label(
                "Write a text file, see light. Drop a scene, a model or a picture of the sky onto this window, or:",
            );
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                let edit = TextEdit::singleline(&mut self.path).hint_text("scene.kin");
                let typed = ui.add_sized(vec2(ui.available_width() - 70.0, 22.0), edit);
                let enter = typed.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
                if (ui.add_sized(vec2(60.0, 22.0), Button::new("Open")).clicked() || enter)
                    && !self.path.trim().is_empty()
                {
                    open = self.named();
                }
            });
            ui.add_space(14.0);
            ui.horizontal(|ui| {
                ui.label("Examples, copied to");
                ui.add(TextEdit::singleline(&mut self.folder).desired_width(f32::INFINITY));
            });
            if let Some(wrong) = &self.wrong {
                ui.label(RichText::new(wrong).color(ui.visuals().error_fg_color));
            }
            ui.add_space(6.0);
            ScrollArea::vertical().show(ui, |ui| {
                for example in &EXAMPLES {
                    ui.horizontal(|ui| {
                        if ui.add_sized(vec2(110.0, 24.0), Button::new(example.name)).clicked() {
                            open = self.copied(example);
                        }
                        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                            ui.add(Label::new(example.about).truncate());
                        });
                    });
                }
            });
        });
        open
    }

    fn named(&mut self) -> Option<PathBuf> {
        let path = PathBuf::from(self.path.trim());
        self.wrong = (!path.is_file()).then(|| format!("there is no file `{}`", path.display()));
        self.wrong.is_none().then_some(path)
    }

    fn copied(&mut self, example: &Example) -> Option<PathBuf> {
        match write_new(Path::new(self.folder.trim()), example.name, example.text) {
            Ok(path) => Some(path),
            Err(why) => {
                self.wrong = Some(why);
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_need_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        for example in &EXAMPLES {
            let path = write_new(folder.path(), example.name, example.text).unwrap();
            let loaded = session::load(&path, &Changes::default()).unwrap();
            assert!(loaded.scene.is_some(), "{}: {:?}", example.name, loaded.diagnostics);
        }
    }

    #[test]
    fn nothing_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let names: Vec<PathBuf> = (0..3).map(|at| write_new(folder.path(), "a", &at.to_string()).unwrap()).collect();
        let expected = ["a.kin", "a-2.kin", "a-3.kin"].map(|name| folder.path().join(name));
        assert_eq!(names, expected);
        assert_eq!(std::fs::read_to_string(&expected[0]).unwrap(), "0");
        assert_eq!(free_name(folder.path(), "a", "kin"), Some(folder.path().join("a-4.kin")));
        for stem in ["", " ", "../a", "a/b"] {
            assert!(write_new(folder.path(), stem, "").is_err(), "{stem:?}");
        }
        assert!(write_new(&folder.path().join("nowhere"), "a", "").is_err());
    }

    #[test]
    fn what_is_dropped_becomes_a_scene() {
        let folder = tempfile::tempdir().unwrap();
        let obj = folder.path().join("my wall.obj");
        std::fs::write(&obj, "v 9 0 0\nv 11 0 0\nv 10 2 0\nf 1 2 3\n").unwrap();
        let Ok(Dropped::Draft(draft)) = dropped(&obj) else { panic!("a model is no scene") };
        assert_eq!((&*draft.stem, &draft.folder), ("my wall", &folder.path().to_path_buf()));
        let path = write_new(&draft.folder, &draft.stem, &draft.text).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        let scene = loaded.scene.as_deref().unwrap_or_else(|| panic!("{}\n{:?}", draft.text, loaded.diagnostics));
        let view = loaded.sample(scene.clock.shutter_of(0)).unwrap().view;
        let seen = view.world_from_camera.inverse().transform_point3(DVec3::new(10.0, 1.0, 0.0));
        assert!(seen.truncate().length() < 1e-4 && seen.z < -2.0, "it is not in the middle: {seen}");

        let sky = folder.path().join("sky \"x\".hdr");
        let flat = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".bytes().chain([128, 128, 128, 129].repeat(8));
        std::fs::write(&sky, flat.collect::<Vec<u8>>()).unwrap();
        let Ok(Dropped::Draft(draft)) = dropped(&sky) else { panic!("a sky is no scene") };
        let path = write_new(&draft.folder, "sky", &draft.text).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        assert!(loaded.scene.is_some(), "{}\n{:?}", draft.text, loaded.diagnostics);

        assert!(matches!(dropped(&path), Ok(Dropped::Scene(_))));
        assert!(dropped(Path::new("a.doc")).is_err());
        assert!(
            matches!(dropped(Path::new("/nowhere/broken.glb")), Ok(Dropped::Draft(_))),
            "its mistake is shown later"
        );
    }
}
