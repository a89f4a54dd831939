//! What stands below the picture of a scene that moves: the playhead, what is played, keys and curves.

use std::time::Instant;

use egui::{Align, Button, Color32, Label, Layout, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};
use egui_plot::{Legend, Line, Plot, PlotPoints, VLine};

use super::model::Model;
use super::panels::Panels;
use super::panels::curves::Moves;
use super::timeline::Speed;

/// Height of the bar in points.
const BAR: f32 = 26.0;
/// Height of the curves in points.
const CURVES: f32 = 150.0;

/// Draws it and acts on what the user does.
pub fn show(ui: &mut Ui, model: &mut Model, panels: &mut Panels, now: Instant) {
    if panels.prefs.curves {
        let playhead_s = model.timeline.frame_s();
        let end_s = model.timeline.last_frame() as f64 / model.timeline.fps();
        match panels.moves(model).filter(|moves| !moves.curves.is_empty()) {
            Some(moves) => {
                if let Some(time_s) = curves(ui, moves, playhead_s, end_s) {
                    model.seek((time_s * model.timeline.fps()).round() as i64, now);
                }
            }
            None => {
                let what = match panels.chosen_words() {
                    Some(words) => format!("Nothing of {words} moves."),
                    None => "Choose something that moves: its curves are shown here.".into(),
                };
                ui.label(RichText::new(what).weak());
            }
        }
    }
    ui.horizontal(|ui| {
        buttons(ui, model, panels, now);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let timeline = &model.timeline;
            let (frame, last) = (timeline.frame(), timeline.last_frame());
            ui.monospace(format!("frame {frame:>3} / {last}   {:>6.2} s", timeline.frame_s()));
            if let Some(baked_s) = timeline.baked_s {
                let whole_s = (last as f64 / timeline.fps()).max(1e-9);
                let done = (baked_s / whole_s * 100.0).clamp(0.0, 100.0);
                ui.add(Label::new(RichText::new(format!("bodies {done:.0} %")).color(ui.visuals().warn_fg_color)));
            }
            let keys = panels.moves(model).map_or_else(Vec::new, |moves| moves.keys_s.clone());
            bar(ui, model, &keys, now);
        });
    });
}

fn buttons(ui: &mut Ui, model: &mut Model, panels: &mut Panels, now: Instant) {
    let [first, last] = model.timeline.range();
    let frame = model.timeline.frame();
    let to = |ui: &mut Ui, text: &str, hover: &str, frame: i64, model: &mut Model| {
        if ui.button(text).on_hover_text(hover).clicked() {
            model.seek(frame, now);
        }
    };
    to(ui, "|<", "To the first frame (Home)", first, model);
    to(ui, "<", "A frame back (←)", frame - 1, model);
    let what = if model.timeline.playing { "Pause" } else { "Play" };
    if ui.add(Button::new(what).min_size(vec2(48.0, 0.0))).on_hover_text("space").clicked() {
        model.timeline.toggle();
    }
    to(ui, ">", "A frame on (→)", frame + 1, model);
    to(ui, ">|", "To the last frame (End)", last, model);
    ui.toggle_value(&mut model.timeline.looping, "Loop").on_hover_text("Play again from the end (L)");
    let mut every = model.timeline.speed == Speed::EveryFrame;
    if ui.toggle_value(&mut every, "Every frame").on_hover_text("Show each frame, however long it takes").changed() {
        model.timeline.speed = if every { Speed::EveryFrame } else { Speed::RealTime };
    }
    if ui.button("In").on_hover_text("Play from this frame (I)").clicked() {
        model.timeline.set_range(frame, last.max(frame));
    }
    if ui.button("Out").on_hover_text("Play until this frame (O)").clicked() {
        model.timeline.set_range(first.min(frame), frame);
    }
    if model.timeline.has_range() && ui.button("All").on_hover_text("Play all of it").clicked() {
        model.timeline.clear_range();
    }
    ui.toggle_value(&mut panels.prefs.curves, "Curves").on_hover_text("What moves of what is chosen");
}

/// The bar: what is played, how far bodies are known, keys, and the playhead, which follows the pointer.
fn bar(ui: &mut Ui, model: &mut Model, keys_s: &[f64], now: Instant) {
    let size = vec2(ui.available_width().max(20.0), BAR);
    let (area, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let line = area.shrink2(vec2(6.0, 0.0));
    let timeline = &model.timeline;
    let last = timeline.last_frame().max(1) as f32;
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged() || response.clicked()) {
        let frame = ((at.x - line.left()) / line.width().max(1.0) * last).round() as i64;
        model.seek(frame.clamp(0, model.timeline.last_frame()), now);
    }
    let timeline = &model.timeline;
    let x = |frame: f32| line.left() + (frame / last).clamp(0.0, 1.0) * line.width();
    let strip = |from: f32, to: f32, height: f32| {
        Rect::from_min_max(pos2(from, area.center().y - height), pos2(to, area.center().y + height))
    };
    let visuals = ui.visuals();
    let painter = ui.painter();
    painter.rect_filled(strip(line.left(), line.right(), 3.0), 3.0, visuals.extreme_bg_color);
    let [first, end] = timeline.range().map(|frame| x(frame as f32));
    painter.rect_filled(strip(first, end, 3.0), 3.0, visuals.widgets.active.bg_fill.gamma_multiply(0.7));
    if let Some(baked_s) = timeline.baked_s {
        let known = x((baked_s * timeline.fps()) as f32);
        painter.rect_filled(strip(known, line.right(), 3.0), 3.0, visuals.warn_fg_color.gamma_multiply(0.45));
    }
    if timeline.has_range() {
        for at in [first, end] {
            painter.vline(at, area.center().y - 7.0..=area.center().y + 7.0, Stroke::new(1.5, visuals.text_color()));
        }
    }
    for key in keys_s {
        let at = pos2(x((key * timeline.fps()) as f32), area.center().y);
        let around = [vec2(0.0, -5.0), vec2(4.0, 0.0), vec2(0.0, 5.0), vec2(-4.0, 0.0)].map(|way| at + way);
        painter.add(egui::Shape::convex_polygon(around.to_vec(), Color32::from_rgb(255, 160, 40), Stroke::NONE));
    }
    let at = x(timeline.frame() as f32);
    let stroke = Stroke::new(2.0, if response.hovered() { visuals.strong_text_color() } else { visuals.text_color() });
    painter.vline(at, area.y_range(), stroke);
    painter.circle_filled(pos2(at, area.center().y), 4.5, stroke.color);
}

/// The curves; gives the time that is clicked on.
fn curves(ui: &mut Ui, moves: &Moves, playhead_s: f64, end_s: f64) -> Option<f64> {
    let plot = Plot::new("curves")
        .height(CURVES)
        .legend(Legend::default())
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .include_x(0.0)
        .include_x(end_s.max(1e-3))
        .x_axis_formatter(|mark, _| format!("{} s", mark.value));
    let shown = plot.show(ui, |plot| {
        for curve in &moves.curves {
            let points: PlotPoints<'_> = curve.points.iter().copied().collect();
            plot.line(Line::new(curve.name.clone(), points));
        }
        plot.vline(VLine::new("", playhead_s).color(Color32::from_gray(150)).allow_hover(false));
        plot.pointer_coordinate().map(|at| at.x)
    });
    let response = &shown.response;
    (response.clicked() || response.dragged()).then_some(shown.inner).flatten().filter(|time| time.is_finite())
}
