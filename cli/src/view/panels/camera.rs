//! The panel of the camera: which one takes the picture, its lens, and the same as text.

use std::f64::consts::TAU;

use egui::{Button, ComboBox, DragValue, Grid, RichText, Ui};
use glam::DVec3;
use kinora_scene::{Projection, Scene};

use super::control::short;
use crate::view::orbit::Orbit;
use crate::view::wish::Desired;

/// What the panel asks for.
#[derive(Debug, Default, PartialEq)]
pub struct Asked {
    /// The camera as it is now.
    pub view: Option<Orbit>,
    /// Back to the scene's own.
    pub reset: bool,
}

/// Draws the panel. `orbit` is the camera as it is seen, `moved` whether it is another than the scene's; `focusing`: the
/// next click into the picture says what is in focus.
pub fn show(
    ui: &mut Ui,
    scene: &Scene,
    orbit: Option<&Orbit>,
    moved: bool,
    focusing: &mut bool,
    desired: &mut Desired,
) -> Asked {
    let mut asked = Asked::default();
    which(ui, scene, desired);
    let Some(orbit) = orbit else {
        ui.label("There is no picture at this time.");
        return asked;
    };
    let mut new = orbit.clone();
    Grid::new("lens").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| lens(ui, &mut new, focusing));
    if new != *orbit {
        asked.view = Some(new);
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        if ui.button("Copy as text").on_hover_text("A `camera` block for the scene").clicked() {
            ui.ctx().copy_text(text(orbit));
        }
        let reset = ui.add_enabled(moved, Button::new("Reset view"));
        asked.reset = reset.on_hover_text("Back to the scene's camera (R)").clicked();
    });
    ui.add_space(6.0);
    let eye = orbit.view.world_from_camera.translation;
    ui.label(RichText::new(format!("at ({}, {}, {})", short(eye.x), short(eye.y), short(eye.z))).small().weak());
    ui.label(RichText::new("Drag turns, shift moves, the wheel comes nearer. Hold the right button to look around and fly with W A S D, Q and E.").small().weak());
    asked
}

fn which(ui: &mut Ui, scene: &Scene, desired: &mut Desired) {
    let name = |at: usize| scene.cameras.get(at).map_or("", |camera| &camera.name);
    let now = scene.camera.map_or("none", name).to_owned();
    ui.horizontal(|ui| {
        ui.label("Camera");
        ui.add_enabled_ui(scene.cameras.len() > 1 || desired.changes.camera.is_some(), |ui| {
            ComboBox::from_id_salt("camera").selected_text(&now).width(150.0).truncate().show_ui(ui, |ui| {
                if ui.selectable_label(desired.changes.camera.is_none(), "as the text says").clicked() {
                    desired.changes.camera = None;
                }
                for at in 0..scene.cameras.len() {
                    // Of several of one name only the first can be asked for.
                    if (0..at).any(|before| name(before) == name(at)) {
                        continue;
                    }
                    let chosen = desired.changes.camera.as_deref() == Some(name(at));
                    if ui.selectable_label(chosen, name(at)).clicked() {
                        desired.changes.camera = Some(name(at).into());
                    }
                }
            });
        });
    });
    ui.separator();
}

fn drag(value: &mut f64) -> DragValue<'_> {
    DragValue::new(value).custom_formatter(|value, _| short(value))
}

fn lens(ui: &mut Ui, orbit: &mut Orbit, focusing: &mut bool) {
    let view = &mut orbit.view;
    match &mut view.projection {
        Projection::Perspective { fov } | Projection::Fisheye { fov } => {
            ui.label("Field of view");
            let mut degrees = fov.to_degrees();
            if ui.add(drag(&mut degrees).suffix("°").speed(0.25).range(1.0..=175.0)).changed() {
                *fov = degrees.to_radians();
            }
            ui.end_row();
        }
        Projection::Orthographic { height_m } => {
            ui.label("Height");
            let speed = (*height_m * 0.01).max(1e-4);
            ui.add(drag(height_m).suffix(" m").speed(speed).range(1e-4..=1e7));
            ui.end_row();
        }
        Projection::Panorama => {}
    }
    if !matches!(view.projection, Projection::Perspective { .. }) {
        return;
    }
    ui.label("Aperture");
    let mut mm = view.aperture_m * 1e3;
    if ui.add(drag(&mut mm).suffix(" mm").speed(0.2).range(0.0..=1e4)).changed() {
        view.aperture_m = mm * 1e-3;
    }
    ui.end_row();
    ui.label("Focus");
    ui.horizontal(|ui| {
        let speed = (view.focus_m * 0.01).max(1e-4);
        ui.add(drag(&mut view.focus_m).suffix(" m").speed(speed).range(1e-4..=1e7));
        ui.toggle_value(focusing, "Pick").on_hover_text("The next click into the picture says what is in focus (F)");
    });
    ui.end_row();
}

/// The camera as a block of a scene, which shows the same.
pub fn text(orbit: &Orbit) -> String {
    let view = &orbit.view;
    let axes = view.world_from_camera.matrix3;
    let eye = view.world_from_camera.translation;
    let target = eye - axes.z_axis * orbit.distance_m;
    let mut lines = vec![format!("position: {}", vector(eye)), format!("look_at: {}", vector(target))];
    // What the language takes where nothing is said holds only for a level camera.
    let level = axes.x_axis.y.abs() < 1e-7 && axes.y_axis.y > 1e-6;
    if !level {
        lines.push(format!("up: {}", vector(axes.y_axis)));
    }
    match view.projection {
        Projection::Perspective { fov } => lines.push(format!("fov: {}deg", number(fov.to_degrees()))),
        Projection::Orthographic { height_m } => {
            lines.extend(["projection: orthographic".into(), format!("height: {}m", number(height_m))]);
        }
        Projection::Panorama => lines.push("projection: panorama".into()),
        Projection::Fisheye { fov } => {
            lines.extend(["projection: fisheye".into(), format!("fov: {}deg", number(fov.to_degrees()))]);
        }
    }
    if view.aperture_m > 0.0 {
        lines.push(format!("aperture: {}mm", number(view.aperture_m * 1e3)));
        lines.push(format!("focus: {}m", number(view.focus_m)));
        if view.blades.count > 0 {
            lines.push(format!("blades: {}", view.blades.count));
            let turn = view.blades.rotation.rem_euclid(TAU);
            if turn != 0.0 {
                lines.push(format!("blade_rotation: {}deg", number(turn.to_degrees())));
            }
        }
    }
    format!("camera view {{\n    {}\n}}\n", lines.join("\n    "))
}

fn vector(v: DVec3) -> String {
    format!("({}, {}, {})", number(v.x), number(v.y), number(v.z))
}

/// Enough digits that nobody sees the difference, and no more; never an exponent.
fn number(value: f64) -> String {
    let digits = (8 - value.abs().max(1e-3).log10().ceil() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};
    use kinora_scene::{Blades, View};

    use super::*;
    use crate::session::{self, Changes};
    use crate::view::orbit;

    /// The view that the text makes.
    fn compiled(text: &str) -> View {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.kin");
        std::fs::write(&path, format!("lang 1\n{text}sky {{ color: #fff }}\n")).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        let scene = loaded.scene.as_deref().unwrap_or_else(|| panic!("{text}\n{:?}", loaded.diagnostics));
        orbit::begin(scene, scene.clock.shutter_of(0)).unwrap().view
    }

    #[test]
    fn the_text_shows_the_same() {
        let eye = DVec3::new(1.234567891, -2.5, 1e3 + 0.125);
        let towards = |z: DVec3, up: DVec3| {
            let z = z.normalize();
            let x = up.cross(z).normalize();
            DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), eye)
        };
        let level = towards(DVec3::new(0.3, 0.2, 0.9), DVec3::Y);
        let rolled = towards(DVec3::new(-0.3, 0.2, 0.9), DVec3::new(0.5, 1.0, 0.0));
        let down = towards(DVec3::Y, DVec3::new(0.1, 0.0, -1.0));
        let upside_down = towards(DVec3::new(0.3, 0.2, 0.9), DVec3::NEG_Y);
        let pentagon = Blades { count: 5, rotation: 0.25 };
        for (place, projection, aperture_m, blades) in [
            (level, Projection::Perspective { fov: 0.7 }, 0.0, Blades::default()),
            (rolled, Projection::Perspective { fov: 0.02 }, 0.0125, Blades::default()),
            (down, Projection::Perspective { fov: 2.5 }, 1e-3, pentagon),
            (upside_down, Projection::Perspective { fov: 1.0 }, 0.0, Blades::default()),
            (level, Projection::Orthographic { height_m: 0.125 }, 0.0, Blades::default()),
            (rolled, Projection::Panorama, 0.0, Blades::default()),
            (level, Projection::Fisheye { fov: 3.0 }, 0.0, Blades::default()),
        ] {
            let projected = projection.clone();
            let view = View { world_from_camera: place, projection: projected, aperture_m, focus_m: 7.5, blades };
            let written = text(&Orbit { view: view.clone(), distance_m: 4.0 });
            let again = compiled(&written);
            let far = |a: DAffine3, b: DAffine3| {
                let axes = a.matrix3.to_cols_array().into_iter().zip(b.matrix3.to_cols_array());
                axes.map(|(a, b)| (a - b).abs()).fold(a.translation.distance(b.translation), f64::max)
            };
            assert!(far(place, again.world_from_camera) < 1e-6, "{written}\n{again:?}");
            match (again.projection, projection) {
                (Projection::Perspective { fov: a }, Projection::Perspective { fov: b })
                | (Projection::Fisheye { fov: a }, Projection::Fisheye { fov: b })
                | (Projection::Orthographic { height_m: a }, Projection::Orthographic { height_m: b }) => {
                    assert!((a / b - 1.0).abs() < 1e-6, "{written}");
                }
                (a, b) => assert_eq!(a, b, "{written}"),
            }
            assert!((again.aperture_m - aperture_m).abs() < 1e-9, "{written}");
            if aperture_m > 0.0 {
                assert!((again.focus_m - 7.5).abs() < 1e-6, "{written}");
                assert_eq!(again.blades.count, blades.count, "{written}");
                assert!((again.blades.rotation - blades.rotation).abs() < 1e-6, "{written}");
            }
        }
    }

    #[test]
    fn numbers_have_no_exponent_and_no_rest() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (0.1 + 0.2, "0.3"),
            (-2.5, "-2.5"),
            (1e-7, "0.0000001"),
            (123456.789, "123456.79"),
            (1e9, "1000000000"),
        ] {
            assert_eq!(number(value), expected);
        }
    }
}
