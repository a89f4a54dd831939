//! The viewer as a user has it: the real program in a real window, on an X server without a screen.
#![cfg(all(feature = "viewer", target_os = "linux"))]

mod display;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

use display::display;

/// The middle of the picture.
const MIDDLE: (usize, usize) = (560, 420);
/// Where the errors stand: the corner of their panel, left of its text.
const PANEL: (usize, usize) = (18, 30);
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
    assert_eq!(pixels[PANEL.0 * 3..PANEL.0 * 3 + 3], BACKGROUND);
}

#[test]
fn without_a_display_there_is_a_message() {
    let path = std::env::temp_dir().join(format!("kinora-nowhere-{}.kin", std::process::id()));
    fs::write(&path, scene("#ff0000")).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_kinora"));
    command.arg("view").arg(&path).args(["--backend", "cpu"]);
    let output =
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").output().unwrap();
    fs::remove_file(&path).unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot open a window"), "{output:?}");
}
