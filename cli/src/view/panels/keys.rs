//! The keyboard and the mouse, as a table and as a window.

use egui::{Align2, Context, Grid, RichText, Window};

/// What each key does, by what it is for.
pub const KEYS: &[(&str, &[(&str, &str)])] = &[
    (
        "Camera",
        &[
            ("drag", "turn about what is looked at"),
            ("shift + drag, middle button", "move across the picture"),
            ("wheel", "nearer, farther"),
            ("right button", "look around; with W A S D Q E: fly"),
            ("click", "choose what is there"),
            ("F", "focus on what is clicked next"),
            ("R", "back to the scene's camera"),
        ],
    ),
    (
        "Picture",
        &[
            ("P", "pause, resume"),
            ("ctrl + wheel, ctrl + drag", "zoom, move the picture"),
            ("0, 1", "fit into the window, pixel for pixel"),
        ],
    ),
    (
        "Time",
        &[
            ("space", "play, pause"),
            ("← →", "a frame back, a frame on"),
            ("Home, End", "to the first frame, to the last one"),
            ("I, O", "play from here, play until here"),
            ("L", "play again from the end, or stop there"),
        ],
    ),
    (
        "Window",
        &[
            ("N", "panels, or the picture alone"),
            ("F12", "a picture of the window as a PNG beside the scene"),
            ("Esc", "nothing chosen"),
            ("?", "these keys"),
        ],
    ),
];

/// Shows the table while `open`.
pub fn show(context: &Context, open: &mut bool) {
    let window = Window::new("Keys").open(open).collapsible(false).resizable(false).default_width(460.0);
    let middle = context.content_rect().center();
    window.pivot(Align2::CENTER_CENTER).default_pos(middle).show(context, |ui| {
        for (title, keys) in KEYS {
            ui.add_space(4.0);
            ui.strong(*title);
            Grid::new(title).num_columns(2).spacing([18.0, 4.0]).min_col_width(205.0).show(ui, |ui| {
                for (key, what) in *keys {
                    ui.label(RichText::new(*key).monospace());
                    ui.label(*what);
                    ui.end_row();
                }
            });
        }
    });
}
