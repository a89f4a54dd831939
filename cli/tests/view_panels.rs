//! The panels of the viewer in the hand of a user: the real program in a real window, moved by its mouse and keys.
#![cfg(all(feature = "viewer", target_os = "linux"))]

#[allow(dead_code, reason = "each test of the viewer needs its own part of it")]
mod display;
mod input;

use std::fs;
use std::process::Command;

use display::{display, eventually};
use input::Hand;

/// The middle of a picture beside which there is no panel.
const MIDDLE: (usize, usize) = (560, 330);
const RED: [u8; 3] = [255, 0, 0];
const WHITE: [u8; 3] = [255, 255, 255];

/// What is chosen is seen by a line of this colour.
const OUTLINE: [u8; 3] = [255, 160, 40];

const SPACE: u32 = 0x20;
const RIGHT: u32 = 0xff53;
const HOME: u32 = 0xff50;
const F12: u32 = 0xffc9;

fn still(params: &str, sky: &str) -> String {
    format!(
        "lang 1\n{params}\nrender {{ resolution: (64, 64), samples: 4, tonemap: none }}\n\
        camera {{ position: (0, 0, 5), look_at: (0, 0, 0) }}\nsky {{ color: {sky} }}\n"
    )
}

/// The pixel in the middle of a picture beside a panel of the usual width.
const BESIDE: (usize, usize) = (410, 360);

/// The handle of the first slider, at the left end of its way.
const SLIDER: (usize, usize) = (846, 127);

#[test]
fn the_slider_of_a_parameter_acts_at_once() {
    let Some(display) = display("slider") else { return };
    let path = display.file("scene.kin");
    let params = "param shade: float = 0 in 0..1\nparam on: bool = true";
    fs::write(&path, still(params, "if on { linear(1, shade, shade) } else { #000000 }")).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, BESIDE, RED);
    let mut hand = Hand::at(display.name());
    // From its left end to beyond its right one.
    hand.drag(SLIDER, (SLIDER.0 + 250, SLIDER.1), 1);
    display.shows(&mut view, BESIDE, WHITE);
    view.good_reload();
    // A save keeps it, as long as the parameter is there.
    fs::write(&path, still(params, "if on { linear(0, shade, 0) } else { #000000 }")).unwrap();
    display.shows(&mut view, BESIDE, [0, 255, 0]);
    let renamed = params.replace("shade", "other");
    fs::write(&path, still(&renamed, "if on { linear(0, other, 1) } else { #000000 }")).unwrap();
    display.shows(&mut view, BESIDE, [0, 0, 255]);
}

fn film() -> String {
    // Red, then white from the second frame on.
    "lang 1\nrender { resolution: (64, 64), samples: 4, tonemap: none, fps: 10, duration: 3s }\n\
     camera { position: (0, 0, 5), look_at: (0, 0, 0) }\n\
     sky { color: if time < 0.05s { #ff0000 } else { #ffffff } }\n"
        .into()
}

#[test]
fn time_passes_and_is_stepped_through() {
    let Some(display) = display("time") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, film()).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    let mut hand = Hand::at(display.name());
    hand.to(MIDDLE);
    hand.key(RIGHT);
    display.shows(&mut view, MIDDLE, WHITE);
    hand.key(HOME);
    display.shows(&mut view, MIDDLE, RED);
    // Played once, it stays at the end.
    hand.key(u32::from(b'l'));
    hand.key(SPACE);
    display.shows(&mut view, MIDDLE, WHITE);
}

#[test]
fn a_click_chooses_what_is_there() {
    let Some(display) = display("choose") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, still("", "#ff0000") + "sphere ball { radius: 1, material: emitter { color: #00ff00 } }\n")
        .unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, [0, 255, 0]);
    let mut hand = Hand::at(display.name());
    let outlined = || {
        let screen = display.screen();
        (MIDDLE.0 - 300..MIDDLE.0).any(|x| screen.pixel(x, MIDDLE.1) == OUTLINE)
    };
    assert!(!outlined());
    hand.click(MIDDLE, 1);
    assert!(eventually(outlined), "{}", view.errors());
    // The sky is nothing that could be chosen.
    hand.click((MIDDLE.0 - 320, MIDDLE.1), 1);
    assert!(eventually(|| !outlined()), "{}", view.errors());
}

/// Of a scene without parameters: the third tab, and the button for a picture in it.
const RENDER_TAB: (usize, usize) = (973, 41);
const RENDER_FRAME: (usize, usize) = (890, 171);

#[test]
fn a_picture_is_made_beside_the_window() {
    let Some(display) = display("render") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, still("", "#ff0000")).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    let mut hand = Hand::at(display.name());
    hand.to(MIDDLE);
    hand.key(u32::from(b'n'));
    // Where the panel is now was the picture.
    assert!(eventually(|| display.pixel(RENDER_FRAME.0, 300) != RED), "{}", view.errors());
    hand.click(RENDER_TAB, 1);
    // The background of the button.
    let panel = display.pixel(RENDER_FRAME.0, 300);
    assert!(eventually(|| display.pixel(RENDER_FRAME.0 - 48, RENDER_FRAME.1) != panel), "{}", view.errors());
    hand.click(RENDER_FRAME, 1);
    let made = display.file("scene.png");
    assert!(eventually(|| made.is_file()), "{}", view.errors());
    display.shows(&mut view, BESIDE, RED);
}

#[test]
fn the_window_is_photographed_by_a_key_and_nothing_is_overwritten() {
    let Some(display) = display("f12") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, still("", "#ff0000")).unwrap();
    fs::write(display.file("scene-view.png"), "mine").unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    let mut hand = Hand::at(display.name());
    hand.to(MIDDLE);
    hand.key(F12);
    let made = display.file("scene-view-2.png");
    assert!(eventually(|| made.is_file()), "{}", view.errors());
    assert_eq!(fs::read(display.file("scene-view.png")).unwrap(), b"mine");
}

#[test]
fn progress_is_told_to_programs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.kin");
    fs::write(&path, film()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_kinora"));
    let output = command.current_dir(folder.path()).args(["animate", "film.kin", "--frames", "0..3", "--samples", "1"]);
    let output = output.args(["--backend", "cpu", "--progress", "json", "-o", "a.####.png"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() >= 4, "{text}");
    assert!(lines.windows(2).all(|pair| pair[0]["progress"].as_f64() <= pair[1]["progress"].as_f64()), "{text}");
    assert_eq!(lines.last().unwrap(), &serde_json::json!({ "progress": 1.0, "frame": 3, "frames": 3 }), "{text}");
}
