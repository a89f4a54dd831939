//! What the window shows with the picture: what is wrong with the text, the timeline and the status line.

use std::time::{Duration, Instant};

use egui::{
    Align, Align2, Area, Button, CentralPanel, Color32, Frame, Id, Key, Label, Layout, Modifiers, Panel, PointerButton,
    Rect, Response, RichText, ScrollArea, Sense, Slider, Stroke, Ui, vec2,
};

use super::model::{Gesture, Model};
use super::picture_bar;
use super::shown::Shown;

const PANEL: Color32 = Color32::from_rgb(34, 22, 22);
const GOOD: Color32 = Color32::from_rgb(110, 190, 110);
const WARN: Color32 = Color32::from_rgb(230, 180, 80);
const BAD: Color32 = Color32::from_rgb(240, 100, 90);
/// How much nearer a wheel brings, a point of scrolling.
const DOLLY_A_POINT: f64 = 0.002;

/// What the status line says besides.
pub struct Status<'a> {
    /// What renders.
    pub device: &'a str,
    /// How long the last reload took.
    pub reload: Option<Duration>,
    /// What it made anew.
    pub rebuilt: &'a str,
    /// How long each step of it took.
    pub stages: &'a str,
}

/// Draws all of it and acts on what the user does.
pub fn show(ui: &mut Ui, model: &mut Model, shown: Option<&mut Shown>, status: &Status<'_>, now: Instant) {
    keys(ui, model, now);
    if !ui.text_edit_focused() {
        picture_bar::keys(ui, model, shown.as_deref());
    }
    Panel::top("picture bar").show_separator_line(false).show(ui, |ui| picture_bar::show(ui, model, shown.as_deref()));
    Panel::bottom("status").show(ui, |ui| status_line(ui, model, shown.as_deref(), status));
    if model.timeline.shown() {
        Panel::bottom("timeline").show_separator_line(false).show(ui, |ui| timeline(ui, model, now));
    }
    CentralPanel::no_frame().show(ui, |ui| {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let picture = shown.and_then(|shown| shown.put(ui, area, model.zoom)).unwrap_or(area);
        if !picture_bar::gestures(ui, model, &response, area, picture) {
            camera(ui, model, &response, picture.height(), now);
        }
        picture_bar::region(ui, model, picture);
        findings(ui, model, area);
        if let Some(text) = model.toast(now) {
            toast(ui, text, area);
        }
    });
}

fn keys(ui: &Ui, model: &mut Model, now: Instant) {
    if ui.text_edit_focused() {
        return;
    }
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if model.timeline.shown() {
        if pressed(Key::Space) {
            model.timeline.playing = !model.timeline.playing;
        }
        for (key, frame) in [
            (Key::ArrowLeft, model.timeline.frame() - 1),
            (Key::ArrowRight, model.timeline.frame() + 1),
            (Key::Home, 0),
            (Key::End, i64::MAX),
        ] {
            if pressed(key) {
                model.seek(frame, now);
            }
        }
    }
    if pressed(Key::R) {
        model.reset_view();
    }
}

/// Turns drags and the wheel into gestures; `height`: of the picture, in points.
fn camera(ui: &Ui, model: &mut Model, response: &Response, height: f32, now: Instant) {
    let drag = (response.drag_delta() / height.max(1.0)).into();
    let drag: [f64; 2] = <[f32; 2]>::map(drag, f64::from);
    if drag != [0.0; 2] {
        let shift = ui.input(|input| input.modifiers.shift);
        if response.dragged_by(PointerButton::Middle) || (shift && response.dragged_by(PointerButton::Primary)) {
            model.gesture(Gesture::Pan(drag), now);
        } else if response.dragged_by(PointerButton::Primary) {
            model.gesture(Gesture::Turn(drag), now);
        }
    }
    let wheel = ui.input(|input| input.smooth_scroll_delta().y);
    if response.hovered() && wheel != 0.0 {
        model.gesture(Gesture::Dolly((-f64::from(wheel) * DOLLY_A_POINT).exp()), now);
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

fn timeline(ui: &mut Ui, model: &mut Model, now: Instant) {
    ui.horizontal(|ui| {
        let what = if model.timeline.playing { "Pause" } else { "Play" };
        if ui.add(Button::new(what).min_size(vec2(48.0, 0.0))).on_hover_text("space").clicked() {
            model.timeline.playing = !model.timeline.playing;
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (frame, last) = (model.timeline.frame(), model.timeline.last_frame());
            ui.monospace(format!("frame {frame:>3} / {last}   {:>6.2} s", model.timeline.frame_s()));
            ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(20.0);
            let mut chosen = frame;
            if ui.add(Slider::new(&mut chosen, 0..=last.max(1)).show_value(false)).changed() {
                model.seek(chosen, now);
            }
        });
    });
}

fn status_line(ui: &mut Ui, model: &mut Model, shown: Option<&Shown>, status: &Status<'_>) {
    ui.horizontal(|ui| {
        badge(ui, model);
        ui.separator();
        let mut parts = Vec::new();
        if let Some(shown) = shown {
            let [width, height] = shown.full;
            let preview = if shown.preview { " (preview)" } else { "" };
            let paused = if model.looking.paused { " (paused)" } else { "" };
            parts.push(format!("{} / {} samples{preview}{paused}", shown.samples, shown.wanted));
            parts.push(format!("{:.1} s", shown.time.as_secs_f64()));
            parts.push(format!("{width} × {height}"));
        }
        parts.push(status.device.to_owned());
        if let Some(reload) = status.reload {
            let anew = if status.rebuilt.is_empty() { "" } else { ", anew: " };
            parts.push(format!("reloaded in {} ms{anew}{}", reload.as_millis(), status.rebuilt));
        }
        ui.add(Label::new(parts.join("  ·  ")).truncate()).on_hover_text(status.stages);
        if model.orbit.is_some() {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Reset view").on_hover_text("Back to the scene's camera (R)").clicked() {
                    model.reset_view();
                }
            });
        }
    });
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
