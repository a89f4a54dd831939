//! The panel of parameters: one control each, which acts at once.

use egui::widgets::color_picker::color_edit_button_srgb;
use egui::{Align, Checkbox, DragValue, Label, Layout, RichText, ScrollArea, Slider, TextEdit, Ui, vec2};
use kinora_lang::eval::Param;

use super::control::{Control, Kind, Setting, of_params, short};
use crate::view::wish::{Desired, Live};

/// The panel.
#[derive(Default)]
pub struct Params {
    controls: Vec<Control>,
    /// What is set by hand, as long as nothing newer comes of the text.
    held: Vec<(String, Setting)>,
}

impl Params {
    /// Takes the parameters of another text. What `live` sets is as it was set, though these may be older.
    pub fn take(&mut self, params: &[Param], live: &[Live]) {
        self.held.retain(|(name, _)| live.iter().any(|live| live.name == *name));
        self.controls = of_params(params);
        for control in &mut self.controls {
            let held = self.held.iter().find(|(name, _)| *name == control.name);
            // Held only as what the control still is.
            if let Some((_, value)) =
                held.filter(|(_, value)| std::mem::discriminant(value) == std::mem::discriminant(&control.value))
            {
                control.value = value.clone();
            }
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.controls.is_empty()
    }

    fn set(&mut self, control: &Control, desired: &mut Desired) {
        desired.live.retain(|live| live.name != control.name);
        self.held.retain(|(name, _)| *name != control.name);
        desired.live.push(Live { name: control.name.clone(), ty: control.ty.clone(), text: control.text() });
        self.held.push((control.name.clone(), control.value.clone()));
    }

    /// Draws the panel; what is changed becomes part of what is `desired`.
    pub fn show(&mut self, ui: &mut Ui, desired: &mut Desired) {
        ui.horizontal(|ui| {
            let changed = !desired.live.is_empty();
            if ui.add_enabled(changed, egui::Button::new("Reset all")).on_hover_text("As the text says").clicked() {
                desired.live.clear();
                self.held.clear();
            }
            let set = desired.all_changes().params;
            let copy = ui.add_enabled(!set.is_empty(), egui::Button::new("Copy as -D"));
            if copy.on_hover_text("For `kinora render` and the others").clicked() {
                ui.ctx().copy_text(as_flags(&set));
            }
        });
        ui.separator();
        let mut controls = std::mem::take(&mut self.controls);
        ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
            for control in &mut controls {
                let by_hand = desired.live.iter().any(|live| live.name == control.name);
                let mut reset = false;
                let id = control.name.clone();
                let changed = ui.push_id(id, |ui| row(ui, control, by_hand, &mut reset)).inner;
                if changed {
                    self.set(control, desired);
                }
                if reset {
                    desired.live.retain(|live| live.name != control.name);
                    self.held.retain(|(name, _)| *name != control.name);
                }
                ui.add_space(6.0);
            }
        });
        self.controls = controls;
    }
}

/// A parameter; whether it was changed.
fn row(ui: &mut Ui, control: &mut Control, by_hand: bool, reset: &mut bool) -> bool {
    ui.horizontal(|ui| {
        let name = RichText::new(&control.name);
        let name = if by_hand { name.strong() } else { name };
        let label = ui.add(Label::new(name).truncate());
        label.on_hover_text(format!("{}: {}\nThe text says {}", control.name, control.ty, control.written));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if by_hand {
                *reset = ui.small_button("Reset").on_hover_text(format!("Back to {}", control.written)).clicked();
            }
        });
    });
    let changed = widget(ui, control);
    if let Some(doc) = &control.doc {
        ui.add(Label::new(RichText::new(doc).small().weak()).wrap());
    }
    changed
}

fn widget(ui: &mut Ui, control: &mut Control) -> bool {
    match (&mut control.value, &control.kind) {
        (Setting::Number(value), Kind::Number { unit, range, int }) => {
            let suffix = suffix(&unit.text);
            match range {
                Some([low, high]) => {
                    ui.spacing_mut().slider_width = (ui.available_width() - 92.0).max(40.0);
                    let slider = Slider::new(value, *low..=*high).suffix(suffix);
                    let slider = if *int { slider.integer() } else { slider.custom_formatter(|value, _| short(value)) };
                    ui.add(slider).changed()
                }
                None => {
                    let step = if *int { 0.1 } else { step(*value) };
                    let drag = DragValue::new(value).suffix(suffix).speed(step);
                    let drag =
                        if *int { drag.fixed_decimals(0) } else { drag.custom_formatter(|value, _| short(value)) };
                    ui.add_sized(vec2(120.0, 20.0), drag).changed()
                }
            }
        }
        (Setting::Switch(on), _) => {
            let what = if *on { "on" } else { "off" };
            ui.add(Checkbox::new(on, what)).changed()
        }
        (Setting::Color(color), _) => {
            ui.horizontal(|ui| {
                ui.spacing_mut().interact_size.x = 72.0;
                let changed = color_edit_button_srgb(ui, color).changed();
                let [r, g, b] = *color;
                ui.monospace(format!("#{r:02x}{g:02x}{b:02x}"));
                changed
            })
            .inner
        }
        (Setting::Text(text), _) => ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY)).changed(),
        (Setting::Vector(parts), kind) => {
            ui.horizontal(|ui| {
                let width = ((ui.available_width() - 16.0) / parts.len().max(1) as f32).clamp(40.0, 90.0);
                let mut changed = false;
                for part in parts {
                    let step = step(*part);
                    let drag = DragValue::new(part).suffix(suffix(unit_text(kind))).speed(step);
                    changed |=
                        ui.add_sized(vec2(width, 20.0), drag.custom_formatter(|value, _| short(value))).changed();
                }
                changed
            })
            .inner
        }
        _ => false,
    }
}

fn unit_text(kind: &Kind) -> &str {
    match kind {
        Kind::Number { unit, .. } | Kind::Vector { unit } => &unit.text,
        _ => "",
    }
}

fn suffix(unit: &str) -> String {
    if unit.is_empty() || unit == "%" { unit.into() } else { format!(" {unit}") }
}

/// How much a drag over a point changes a number that has no range.
fn step(value: f64) -> f64 {
    (value.abs() * 0.01).max(0.001)
}

/// The flags that set these values, for a shell.
pub fn as_flags(params: &[(String, String)]) -> String {
    let mut seen: Vec<&str> = Vec::new();
    let mut flags = Vec::new();
    // What comes last holds.
    for (name, text) in params.iter().rev() {
        if !seen.contains(&&**name) {
            seen.push(name);
            flags.push(format!("-D {}", shell(&format!("{name}={text}"))));
        }
    }
    flags.reverse();
    flags.join(" ")
}

/// A word for a shell, in quotes where it needs them.
pub fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-+=.,/:%^@".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_for_a_shell() {
        let set = |name: &str, text: &str| (name.to_string(), text.to_string());
        let all = [set("a", "1"), set("b", "#fff"), set("c", "it's"), set("a", "0.5"), set("m.d", "2cm")];
        assert_eq!(as_flags(&all), r"-D 'b=#fff' -D 'c=it'\''s' -D a=0.5 -D m.d=2cm");
        assert_eq!(as_flags(&[]), "");
    }
}
