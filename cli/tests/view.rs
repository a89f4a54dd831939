//! The viewer as a user has it: the real program in a real window, on an X server without a screen.
#![cfg(all(feature = "viewer", target_os = "linux"))]

#[allow(dead_code, reason = "each test of the viewer needs its own part of it")]
mod display;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use display::display;

/// The middle of the picture.
const MIDDLE: (usize, usize) = (560, 420);
/// Where the errors stand: the corner of their panel, left of its text.
const PANEL: (usize, usize) = (18, 54);
const PANEL_COLOR: [u8; 3] = [34, 22, 22];
const BACKGROUND: [u8; 3] = [24, 24, 24];

const RED: [u8; 3] = [255, 0, 0];
const GREEN: [u8; 3] = [0, 255, 0];
const BLUE: [u8; 3] = [0, 0, 255];

/// A picture of one colour.
fn scene(sky: &str) -> String {
    format!(
        "lang 1\n\nrender {{ resolution: (64, 64), samples: 4, tonemap: none }}\n\
        camera {{ position: (0, 0, 5), look_at: (0, 0, 0) }}\nsky {{ color: {sky} }}\n"
    )
}

/// Saves as editors do that write another file and give it the old one's name.
fn save_by_rename(path: &Path, text: &str) {
    let beside = path.with_extension("tmp");
    fs::write(&beside, text).unwrap();
    fs::rename(&beside, path).unwrap();
}

/// Saves as editors do that empty the file first.
fn save_by_truncation(path: &Path, text: &str) {
    let mut file = fs::File::create(path).unwrap();
    std::thread::sleep(Duration::from_millis(40));
    file.write_all(text.as_bytes()).unwrap();
}

#[test]
fn the_picture_follows_the_text() {
    let Some(display) = display("view") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);

    save_by_rename(&path, &scene("#00ff00"));
    display.shows(&mut view, MIDDLE, GREEN);
    let reload = view.good_reload();
    assert!(reload["first_pixel_ms"].as_f64() >= reload["reload_ms"].as_f64(), "{reload}");

    save_by_truncation(&path, &scene("#0000ff"));
    display.shows(&mut view, MIDDLE, BLUE);
    view.good_reload();

    // Neither the same text nor another file is a change: what is reported next is the error.
    save_by_rename(&path, &scene("#0000ff"));
    fs::write(display.file("other.kin"), "nothing").unwrap();

    fs::write(&path, scene("#00ff00").replace("lang 1", "lang 1\nrender {{{")).unwrap();
    let reload = view.reload();
    assert!(reload["errors"].as_u64() > Some(0), "{reload}");
    display.shows(&mut view, PANEL, PANEL_COLOR);
    display.shows(&mut view, MIDDLE, BLUE);
    assert!(view.errors().contains("scene.kin:2:"), "{}", view.errors());

    fs::write(&path, scene("#00ff00")).unwrap();
    display.shows(&mut view, MIDDLE, GREEN);
    display.shows(&mut view, PANEL, BACKGROUND);
    view.good_reload();

    fs::remove_file(&path).unwrap();
    assert_eq!(view.reload()["errors"], 1);
    display.shows(&mut view, PANEL, PANEL_COLOR);
    display.shows(&mut view, MIDDLE, GREEN);
    save_by_rename(&path, &scene("#ff0000"));
    display.shows(&mut view, MIDDLE, RED);
}

#[test]
fn every_way_to_save_is_seen() {
    let Some(display) = display("editors") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);

    // vim: a swap file beside, the old file becomes the backup, the text goes to a new file.
    let (swap, backup) = (display.file(".scene.kin.swp"), display.file("scene.kin~"));
    fs::write(&swap, "swap").unwrap();
    fs::rename(&path, &backup).unwrap();
    fs::write(&path, scene("#00ff00")).unwrap();
    fs::remove_file(&backup).unwrap();
    fs::remove_file(&swap).unwrap();
    display.shows(&mut view, MIDDLE, GREEN);

    // VS Code: the same file is written anew; with another setting, through a file beside.
    fs::write(&path, scene("#0000ff")).unwrap();
    display.shows(&mut view, MIDDLE, BLUE);
    save_by_rename(&path, &scene("#ff0000"));
    display.shows(&mut view, MIDDLE, RED);

    let sed = Command::new("sed").args(["-i", "s/#ff0000/#00ff00/"]).arg(&path).status().unwrap();
    assert!(sed.success());
    display.shows(&mut view, MIDDLE, GREEN);

    // In pieces, as over a slow network.
    let text = scene("#0000ff");
    let (first, second) = text.split_at(text.len() / 2);
    fs::write(&path, first).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    fs::OpenOptions::new().append(true).open(&path).unwrap().write_all(second.as_bytes()).unwrap();
    display.shows(&mut view, MIDDLE, BLUE);
}

#[test]
fn many_saves_end_in_the_last() {
    let Some(display) = display("many") else { return };
    let path = display.file("scene.kin");
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    for i in 0..99 {
        let text = if i % 7 == 3 { "sky {".into() } else { scene(&format!("#{:02x}{:02x}00", i, 200 - i)) };
        match i % 3 {
            0 => save_by_rename(&path, &text),
            1 => fs::write(&path, &text).unwrap(),
            _ => fs::File::create(&path).unwrap().write_all(text.as_bytes()).unwrap(),
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    fs::write(&path, scene("#0000ff")).unwrap();
    display.shows(&mut view, MIDDLE, BLUE);
    display.shows(&mut view, PANEL, BACKGROUND);
}

#[test]
fn whatever_a_scene_uses_is_watched() {
    let Some(display) = display("uses") else { return };
    let (path, lib, picture) = (display.file("scene.kin"), display.file("lib.kin"), display.file("maps/tile.png"));
    fs::create_dir(display.file("maps")).unwrap();
    let tile = |color: [u8; 3]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&color).unwrap();
        bytes
    };
    fs::write(&picture, tile(RED)).unwrap();
    let wall = |map: &str| {
        format!(
            "lang 1\nemitter wall {{ color: {map} }}\n\
            prefab panel() {{ quad {{ position: (0, 0, 0), normal: (0, 0, 1), size: (9, 9), material: wall }} }}\n"
        )
    };
    fs::write(&lib, wall("image(\"maps/tile.png\")")).unwrap();
    let text = scene("#000000").replace("lang 1\n", "lang 1\nimport { panel } from \"lib.kin\"\n");
    fs::write(&path, text + "panel { }\n").unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    // A picture.
    save_by_rename(&picture, "");
    display.shows(&mut view, PANEL, PANEL_COLOR);
    fs::write(&picture, tile(GREEN)).unwrap();
    display.shows(&mut view, MIDDLE, GREEN);
    display.shows(&mut view, PANEL, BACKGROUND);
    // An import.
    fs::write(&lib, wall("#0000ff")).unwrap();
    display.shows(&mut view, MIDDLE, BLUE);
    // The picture matters no more, and then it does again.
    fs::write(&picture, tile(RED)).unwrap();
    fs::write(&lib, wall("image(\"maps/tile.png\")")).unwrap();
    display.shows(&mut view, MIDDLE, RED);
}

#[test]
fn only_what_changed_is_made_anew() {
    let Some(display) = display("anew") else { return };
    let path = display.file("scene.kin");
    let text = |color: &str, x: f64, eye: f64| {
        format!(
            "lang 1\nrender {{ resolution: (32, 32), samples: 2, tonemap: none }}\n\
            camera {{ position: (0, 0, {eye}), look_at: (0, 0, 0) }}\nsky {{ color: #ffffff }}\n\
            sphere ball {{ position: ({x}, 0, 0), material: emitter {{ color: {color} }} }}\n\
            sphere {{ position: (5, 0, 0), material: diffuse {{ color: {color} }} }}\n"
        )
    };
    fs::write(&path, text("#ff0000", 0.0, 5.0)).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    let mut edit = |text: String, expected: &[&str]| {
        save_by_rename(&path, &text);
        let reload = view.good_reload();
        assert_eq!(reload["rebuilt"], serde_json::json!(expected), "{reload}");
        let stages = reload["stages"].as_object().unwrap();
        assert!(stages.values().all(|ms| ms.as_f64() >= Some(0.0)), "{reload}");
    };
    edit(text("#ff0000", 0.0, 6.0), &["camera"]);
    edit(text("#ff0000", 0.5, 6.0), &["tree", "transforms", "lights"]);
    edit(text("#ff0000", 0.5, 6.0).replace("samples: 2", "samples: 3"), &[]);
    edit(text("#ff0000", 0.5, 6.0).replace("diffuse { color: #ff0000", "diffuse { color: #00ff00"), &["materials"]);
    edit(text("#ff0000", 0.5, 6.0).replace("diffuse { color: #ff0000", "diffuse { color: #0000ff"), &["materials"]);
}

#[test]
fn a_window_closes_while_it_renders() {
    let Some(display) = display("close") else { return };
    let path = display.file("scene.kin");
    let text = scene("#ff0000").replace("(64, 64), samples: 4", "(1600, 1200), samples: 100000");
    fs::write(&path, text + "sphere { position: (9, 0, 0), material: dielectric { ior: 1.5 } }\n").unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, MIDDLE, RED);
    let (time, well) = display.close(view);
    assert!(well, "it does not end well");
    // A second, on a machine that does nothing else.
    assert!(time < Duration::from_secs(5), "{time:?}");
}

#[test]
fn a_faulty_scene_waits_for_better_times() {
    let Some(display) = display("missing") else { return };
    let path = display.file("scene.kin");
    let mesh = "mesh { file: \"meshes/wall.obj\", material: emitter { color: #00ff00 } }\n";
    fs::write(&path, scene("#ff0000") + mesh).unwrap();
    let mut view = display.view(&path);
    display.shows(&mut view, PANEL, PANEL_COLOR);
    display.shows(&mut view, MIDDLE, BACKGROUND);
    assert!(view.errors().contains("E0701"), "{}", view.errors());

    fs::create_dir(display.file("meshes")).unwrap();
    let wall = |z| format!("v -9 -9 {z}\nv 9 -9 {z}\nv 0 18 {z}\nf 1 2 3\n");
    fs::write(display.file("meshes/wall.obj"), wall(0)).unwrap();
    display.shows(&mut view, MIDDLE, GREEN);
    display.shows(&mut view, PANEL, BACKGROUND);

    // Behind the camera: the mesh is watched, too.
    save_by_rename(&display.file("meshes/wall.obj"), &wall(9));
    display.shows(&mut view, MIDDLE, RED);
}

#[test]
fn the_window_can_be_photographed() {
    let Some(display) = display("photo") else { return };
    let (path, photo) = (display.file("scene.kin"), display.file("photo.png"));
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut command = display.command(&path);
    let output = command.arg("--screenshot").arg(&photo).args(["--after", "4", "--exit"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");

    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&photo).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let at = (MIDDLE.1 * info.width as usize + MIDDLE.0) * 3;
    assert_eq!(pixels[at..at + 3], RED);
    let beside = (PANEL.1 * info.width as usize + PANEL.0) * 3;
    assert_eq!(pixels[beside..beside + 3], BACKGROUND);
}

#[test]
fn without_a_display_there_is_a_message() {
    let path = std::env::temp_dir().join(format!("kinora-nowhere-{}.kin", std::process::id()));
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_kinora"));
    command.arg("view").arg(&path).args(["--backend", "cpu"]);
    let output =
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").output().unwrap();
    fs::remove_file(&path).unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot open a window"), "{output:?}");
}
