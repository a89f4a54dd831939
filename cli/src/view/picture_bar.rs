//! The line above the picture: what is shown of it, how bright, which part, how large.

use egui::{
    Button, ComboBox, CursorIcon, DragValue, Key, Modifiers, PointerButton, Pos2, Rect, Response, Stroke, StrokeKind,
    Ui,
};
use kinora_scene::{Shown, Tonemap};

use super::model::Model;
use super::picture::{Looking, STOPS, Zoom};
use super::shown;

const SHOWN: [(Shown, &str); 8] = [
    (Shown::Beauty, "beauty"),
    (Shown::Albedo, "albedo"),
    (Shown::Normal, "normal"),
    (Shown::Depth, "depth"),
    (Shown::Id, "id"),
    (Shown::Samples, "samples"),
    (Shown::Cost, "cost"),
    (Shown::Bvh, "BVH boxes"),
];
const TONEMAPS: [(Tonemap, &str); 3] = [(Tonemap::Agx, "AgX"), (Tonemap::Aces, "ACES"), (Tonemap::None, "none")];

/// Draws the line.
pub fn show(ui: &mut Ui, model: &mut Model, on_screen: Option<&shown::Shown>) {
    ui.horizontal(|ui| {
        let mut looking = model.looking.clone();
        choice(ui, "view", "What the picture shows", &SHOWN, &mut looking.shown);
        let exposure = DragValue::new(&mut looking.stops).speed(0.02).range(STOPS).fixed_decimals(1).suffix(" stops");
        ui.add(exposure).on_hover_text("Exposure, on top of the scene's. Nothing is rendered again");
        choice(ui, "tone", "Tone curve. Nothing is rendered again", &TONEMAPS, &mut looking.tonemap);
        if looking != (Looking { region: looking.region, paused: looking.paused, ..Looking::default() })
            && ui.button("As written").on_hover_text("Show what the scene says").clicked()
        {
            looking = Looking { region: looking.region, paused: looking.paused, ..Looking::default() };
        }
        ui.separator();
        let pause = if looking.paused { "Resume" } else { "Pause" };
        if ui.add(Button::new(pause)).on_hover_text("Add no more samples (P)").clicked() {
            looking.paused = !looking.paused;
        }
        let region = Button::selectable(model.choosing || looking.region.is_some(), "Region");
        if ui.add(region).on_hover_text("Render a part: drag a frame over the picture").clicked() {
            let chosen = looking.region.take().is_some();
            model.choosing = !chosen && !model.choosing;
        }
        ui.separator();
        let percent = on_screen.and_then(shown::Shown::percent).unwrap_or(100.0);
        if ui
            .button(format!("{percent:.0} %"))
            .on_hover_text(
                "Fit into the window (0). Zoom with ctrl and the wheel, move with ctrl and a drag; 1: pixel for pixel",
            )
            .clicked()
        {
            model.zoom = Zoom::default();
        }
        model.look(looking);
    });
}

fn choice<T: Copy + PartialEq>(ui: &mut Ui, id: &str, help: &str, all: &[(T, &str)], chosen: &mut Option<T>) {
    let name = all.iter().find(|(value, _)| Some(*value) == *chosen).map_or("as written", |(_, name)| name);
    let combo = ComboBox::from_id_salt(id).selected_text(format!("{id}: {name}")).width(124.0);
    let list = combo.show_ui(ui, |ui| {
        ui.selectable_value(chosen, None, "as written");
        for (value, name) in all {
            ui.selectable_value(chosen, Some(*value), *name);
        }
    });
    list.response.on_hover_text(help);
}

/// Keys of the picture.
pub fn keys(ui: &Ui, model: &mut Model, on_screen: Option<&shown::Shown>) {
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if pressed(Key::P) {
        let paused = !model.looking.paused;
        model.look(Looking { paused, ..model.looking.clone() });
    }
    if pressed(Key::Num0) {
        model.zoom = Zoom::default();
    }
    if pressed(Key::Num1)
        && let Some(percent) = on_screen.and_then(shown::Shown::percent)
    {
        model.zoom.scale(100.0 / percent, [0.0; 2]);
    }
    if model.choosing && pressed(Key::Escape) {
        model.choosing = false;
    }
}

/// What the pointer does with the picture itself, where ctrl is held or a part of it is chosen; true if that is so, and
/// the pointer has nothing to say to the camera. `whole`: the area; `rect`: the picture in it.
pub fn gestures(ui: &Ui, model: &mut Model, response: &Response, whole: Rect, rect: Rect) -> bool {
    let (zoom, ctrl) = ui.input(|input| (input.zoom_delta(), input.modifiers.command));
    // One picture height that fills the area.
    let unit = (rect.height() / model.zoom.factor()).max(1.0);
    let from_middle = |at: Pos2| <[f32; 2]>::from((at - whole.center()) / unit);
    if response.hovered() && zoom != 1.0 {
        let at = response.hover_pos().map_or([0.0; 2], from_middle);
        model.zoom.scale(zoom, at);
        return true;
    }
    if model.choosing {
        return choose(ui, model, response, rect);
    }
    let pans = ctrl && response.dragged_by(PointerButton::Primary);
    if pans {
        model.zoom.pan((response.drag_delta() / unit).into());
    }
    pans
}

fn choose(ui: &Ui, model: &mut Model, response: &Response, rect: Rect) -> bool {
    ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    let share = |at: Pos2| {
        let at = (at - rect.min) / rect.size();
        [f64::from(at.x), f64::from(at.y)]
    };
    let from = ui.input(|input| input.pointer.press_origin());
    if let (Some(from), Some(to)) = (from, response.interact_pointer_pos()) {
        if response.drag_stopped() {
            let mut looking = model.looking.clone();
            looking.choose(share(from), share(to));
            model.look(looking);
            model.choosing = false;
        } else if response.dragged() {
            frame(ui, Rect::from_two_pos(from, to).intersect(rect));
        }
    }
    true
}

/// The part that is rendered, on the picture.
pub fn region(ui: &Ui, model: &Model, rect: Rect) {
    let Some([left, top, right, bottom]) = model.looking.region else { return };
    let at = |x: f64, y: f64| rect.min + rect.size() * egui::vec2(x as f32, y as f32);
    frame(ui, Rect::from_min_max(at(left, top), at(right, bottom)));
}

fn frame(ui: &Ui, rect: Rect) {
    let stroke = Stroke::new(1.0, egui::Color32::from_rgb(230, 180, 80));
    ui.painter().rect_stroke(rect, 0.0, stroke, StrokeKind::Outside);
}
