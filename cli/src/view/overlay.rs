//! What the window shows with the picture: what is wrong with the text, the timeline and the status line.

use std::time::{Duration, Instant};

use egui::{
    Align, Align2, Area, CentralPanel, Color32, Frame, Id, Key, Label, Layout, Modifiers, Panel, PointerButton, Rect,
    Response, RichText, ScrollArea, Sense, Stroke, Ui, vec2,
};

use super::model::{Gesture, Model};
use super::panels::{Facts, Panels};
use super::picture_bar;
use super::shown::Shown;
use super::transport;

const PANEL: Color32 = Color32::from_rgb(34, 22, 22);
const GOOD: Color32 = Color32::from_rgb(110, 190, 110);
const WARN: Color32 = Color32::from_rgb(230, 180, 80);
const BAD: Color32 = Color32::from_rgb(240, 100, 90);
/// How much nearer a wheel brings, a point of scrolling.
const DOLLY_A_POINT: f64 = 0.002;
/// Distances to the pivot that flying goes in a second.
const FLIGHT: f64 = 0.8;
/// The longest step of a flight, in seconds: a window that was not drawn for a while does not jump.
const LONGEST_STEP_S: f32 = 0.1;

/// What the status line says besides.
pub struct Status<'a> {
    /// What renders.
    pub facts: Facts<'a>,
    /// How long the last reload took.
    pub reload: Option<Duration>,
    /// What it made anew.
    pub rebuilt: &'a str,
    /// How long each step of it took.
    pub stages: &'a str,
}

/// Draws all of it and acts on what the user does.
pub fn show(
    ui: &mut Ui,
    model: &mut Model,
    panels: &mut Panels,
    shown: Option<&mut Shown>,
    status: &Status<'_>,
    now: Instant,
) {
    keys(ui, model, panels, now);
    if !ui.text_edit_focused() {
        picture_bar::keys(ui, model, shown.as_deref());
    }
    if !panels.at_start() {
        let bar = Panel::top("picture bar").show_separator_line(false);
        bar.show(ui, |ui| picture_bar::show(ui, model, shown.as_deref()));
    }
    Panel::bottom("status").show(ui, |ui| status_line(ui, model, panels, shown.as_deref(), status, now));
    if panels.at_start() {
        panels.show(ui, model, &status.facts, now);
        CentralPanel::default_margins().show(ui, |ui| {
            panels.start_page(ui);
            messages(ui, model, panels, ui.max_rect(), now);
        });
        return;
    }
    if model.timeline.shown() {
        Panel::bottom("timeline").show_separator_line(false).show(ui, |ui| transport::show(ui, model, panels, now));
    }
    panels.show(ui, model, &status.facts, now);
    CentralPanel::no_frame().show(ui, |ui| {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let picture = shown.and_then(|shown| shown.put(ui, area, model.zoom));
        let whole = picture.unwrap_or(area);
        if !picture_bar::gestures(ui, model, &response, area, whole) {
            camera(ui, model, &response, whole.height(), now);
            if let Some(picture) = picture {
                click(model, panels, &response, picture, now);
            }
        }
        picture_bar::region(ui, model, whole);
        if let Some(picture) = picture {
            panels.over_picture(ui, model, picture, area, now);
        }
        if panels.is_focusing() && response.hovered() {
            ui.set_cursor_icon(egui::CursorIcon::Crosshair);
        }
        findings(ui, model, area);
        messages(ui, model, panels, area, now);
    });
}

fn messages(ui: &Ui, model: &Model, panels: &Panels, area: Rect, now: Instant) {
    if let Some(text) = model.toast(now).or_else(|| panels.message(now)) {
        toast(ui, text, area);
    }
}

fn keys(ui: &Ui, model: &mut Model, panels: &mut Panels, now: Instant) {
    if ui.text_edit_focused() {
        return;
    }
    panels.keys(ui, model, now);
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if model.timeline.shown() {
        if pressed(Key::Space) {
            model.timeline.toggle();
        }
        let [first, last] = model.timeline.range();
        for (key, frame) in [(Key::Home, first), (Key::End, last)] {
            if pressed(key) {
                model.seek(frame, now);
            }
        }
        // However often they were pressed since the window was drawn.
        let count = |key| ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) as i64;
        let steps = count(Key::ArrowRight) - count(Key::ArrowLeft);
        model.seek(model.timeline.frame() + steps, now);
        let frame = model.timeline.frame();
        if pressed(Key::I) {
            model.timeline.set_range(frame, last.max(frame));
        }
        if pressed(Key::O) {
            model.timeline.set_range(first.min(frame), frame);
        }
        if pressed(Key::L) {
            model.timeline.looping = !model.timeline.looping;
        }
    }
    if pressed(Key::R) {
        model.reset_view();
    }
}

/// Turns drags, the wheel and the keys of flight into gestures; `height`: of the picture, in points.
fn camera(ui: &Ui, model: &mut Model, response: &Response, height: f32, now: Instant) {
    let drag = (response.drag_delta() / height.max(1.0)).into();
    let drag: [f64; 2] = <[f32; 2]>::map(drag, f64::from);
    if drag != [0.0; 2] {
        let shift = ui.input(|input| input.modifiers.shift);
        if response.dragged_by(PointerButton::Middle) || (shift && response.dragged_by(PointerButton::Primary)) {
            model.gesture(Gesture::Pan(drag), now);
        } else if response.dragged_by(PointerButton::Primary) {
            model.gesture(Gesture::Turn(drag), now);
        } else if response.dragged_by(PointerButton::Secondary) {
            model.gesture(Gesture::Look(drag), now);
        }
    }
    if response.is_pointer_button_down_on() && ui.input(|input| input.pointer.secondary_down()) {
        fly(ui, model, now);
    }
    let wheel = ui.input(|input| input.smooth_scroll_delta().y);
    if response.hovered() && wheel != 0.0 {
        model.gesture(Gesture::Dolly((-f64::from(wheel) * DOLLY_A_POINT).exp()), now);
    }
}

/// Flies as long as its keys are held.
fn fly(ui: &Ui, model: &mut Model, now: Instant) {
    let (way, seconds, fast) = ui.input(|input| {
        let along = |to: Key, back: Key| f64::from(i8::from(input.key_down(to)) - i8::from(input.key_down(back)));
        let way = [along(Key::D, Key::A), along(Key::E, Key::Q), along(Key::W, Key::S)];
        (way, input.stable_dt.min(LONGEST_STEP_S), input.modifiers.shift)
    });
    if way != [0.0; 3] {
        let step = FLIGHT * f64::from(seconds) * if fast { 4.0 } else { 1.0 };
        model.gesture(Gesture::Fly(way.map(|way| way * step)), now);
    }
    ui.ctx().request_repaint();
}

/// A click asks what is there.
fn click(model: &mut Model, panels: &mut Panels, response: &Response, picture: Rect, now: Instant) {
    let at = response.interact_pointer_pos().filter(|_| response.clicked_by(PointerButton::Primary));
    if let Some(at) = at.filter(|at| picture.contains(*at)) {
        let place = (at - picture.min) / picture.size();
        panels.clicked([place.x, place.y], model, now);
    }
}

/// What is wrong, over the picture, as long as it is wrong.
fn findings(ui: &Ui, model: &Model, area: Rect) {
    let mut text = model.findings.text.trim_end().to_owned();
    if let Some(trouble) = &model.trouble {
        text = format!("{trouble}\n\n{text}").trim_end().to_owned();
    }
    if text.is_empty() {
        return;
    }
    let what = match model.good {
        Some(_) => "The picture is the last good one.",
        None => "There is no picture yet.",
    };
    let inner = area.shrink(12.0);
    Area::new(Id::unique("findings")).fixed_pos(inner.min).constrain_to(inner).show(ui, |ui| {
        Frame::new().fill(PANEL).stroke(Stroke::new(1.0, BAD)).corner_radius(4.0).inner_margin(10.0).show(ui, |ui| {
            ui.set_max_width(inner.width() - 24.0);
            ui.label(RichText::new(what).color(BAD).strong());
            ScrollArea::both().max_height(inner.height() * 0.5).show(ui, |ui| {
                let text = RichText::new(text).monospace().color(Color32::from_gray(230));
                ui.add(Label::new(text).selectable(true).extend());
            });
        });
    });
}

fn toast(ui: &Ui, text: &str, area: Rect) {
    let at = area.center_bottom() - vec2(0.0, 16.0);
    Area::new(Id::unique("toast")).fixed_pos(at).pivot(Align2::CENTER_BOTTOM).interactable(false).show(ui, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| ui.add(Label::new(text).extend()));
    });
}

fn status_line(
    ui: &mut Ui,
    model: &mut Model,
    panels: &mut Panels,
    shown: Option<&Shown>,
    status: &Status<'_>,
    now: Instant,
) {
    ui.horizontal(|ui| {
        if !panels.at_start() {
            badge(ui, model);
            ui.separator();
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.menu_button("Menu", |ui| panels.menu(ui, now));
            if !panels.at_start() {
                let mut side = panels.side();
                if ui.toggle_value(&mut side, "Panels").on_hover_text("N").clicked() {
                    panels.prefs.side = Some(side);
                }
            }
            if model.orbit.is_some()
                && ui.button("Reset view").on_hover_text("Back to the scene's camera (R)").clicked()
            {
                model.reset_view();
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let words = words(model, panels, shown, status).join("  ·  ");
                ui.add(Label::new(words).truncate()).on_hover_text(status.stages);
            });
        });
    });
}

fn words(model: &Model, panels: &Panels, shown: Option<&Shown>, status: &Status<'_>) -> Vec<String> {
    let mut parts = Vec::new();
    parts.extend(panels.chosen_words());
    if let Some(shown) = shown {
        let [width, height] = shown.full;
        let preview = if shown.preview { " (preview)" } else { "" };
        let paused = if model.looking.paused { " (paused)" } else { "" };
        parts.push(format!("{} / {} samples{preview}{paused}", shown.samples, shown.wanted));
        parts.push(format!("{:.1} s", shown.time.as_secs_f64()));
        parts.push(format!("{width} × {height}"));
    }
    parts.push(status.facts.device.to_owned());
    if let Some(reload) = status.reload {
        let anew = if status.rebuilt.is_empty() { "" } else { ", anew: " };
        parts.push(format!("reloaded in {} ms{anew}{}", reload.as_millis(), status.rebuilt));
    }
    parts
}

fn badge(ui: &mut Ui, model: &Model) {
    let errors = model.findings.errors + usize::from(model.trouble.is_some());
    let warnings = model.findings.warnings;
    let (color, text) = match (errors, warnings) {
        (0, 0) if model.good.is_none() => (WARN, "reading".to_owned()),
        (0, 0) => (GOOD, "ok".to_owned()),
        (0, _) => (WARN, crate::report::counts(0, warnings)),
        _ => (BAD, crate::report::counts(errors, warnings)),
    };
    let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().circle_filled(dot.center(), 4.0, color);
    ui.label(RichText::new(text).color(color));
}
