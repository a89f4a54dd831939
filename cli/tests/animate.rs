//! Films in one file, and what becomes of frames when something goes wrong.
#![cfg(feature = "render")]

mod common;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Folder, HELLO, Ran, exists};
use serde_json::Value;

fn animate(folder: &Folder, flags: &str) -> Ran {
    folder.run(&format!("animate hello.kin --backend cpu --json {flags}"))
}

fn took(ran: &Ran) -> (u64, u64) {
    let took: Value = serde_json::from_str(&ran.out).unwrap();
    assert!(took["wall_s"].as_f64() >= took["render_s"].as_f64(), "{took}");
    (took["frames"].as_u64().unwrap(), took["skipped"].as_u64().unwrap())
}

/// How long a frame lasts, and its bytes.
type ApngFrame = ((u16, u16), Vec<u8>);

/// How often an APNG plays, and its frames.
fn apng(path: &Path) -> (u32, Vec<ApngFrame>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let control = *reader.info().animation_control().unwrap();
    let mut frames = Vec::new();
    for _ in 0..control.num_frames {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let frame = reader.info().frame_control().unwrap();
        frames.push(((frame.delay_num, frame.delay_den), bytes));
    }
    (control.num_plays, frames)
}

fn png(path: &Path) -> Vec<u8> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    bytes
}

/// The frames of a GIF as they are shown, three bytes a pixel, and the hundredths of a second that each lasts.
fn gif(path: &Path) -> (gif::Repeat, Vec<(u16, Vec<u8>)>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(File::open(path).unwrap()).unwrap();
    let (width, height) = (usize::from(reader.width()), usize::from(reader.height()));
    let mut shown = vec![0; 3 * width * height];
    let mut frames = Vec::new();
    while let Some(frame) = reader.read_next_frame().unwrap() {
        for (i, rgba) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, rgba)| rgba[3] > 0) {
            let x = usize::from(frame.left) + i % usize::from(frame.width);
            let y = usize::from(frame.top) + i / usize::from(frame.width);
            shown[3 * (y * width + x)..][..3].copy_from_slice(&rgba[..3]);
        }
        frames.push((frame.delay, shown.clone()));
    }
    (reader.repeat(), frames)
}

#[test]
fn eight_seconds_are_192_frames() {
    let folder = Folder::new();
    let scene = HELLO.replace("fps: 8, duration: 2s", "fps: 24, duration: 8s").replace("(24, 16)", "(8, 6)");
    folder.write("hello.kin", &scene);
    let flags = "--samples 1";
    assert_eq!(took(&animate(&folder, flags).check(0, &[])), (192, 0));
    let names = folder.names("out");
    assert_eq!(names.len(), 192);
    assert_eq!((&*names[0], &*names[191]), ("frame.0000.png", "frame.0191.png"));
    // Two halves by two processes are the whole.
    for half in ["0..96", "96..192"] {
        assert_eq!(
            took(&animate(&folder, &format!("{flags} --frames {half} -o halves/frame.####.png")).check(0, &[])),
            (96, 0)
        );
    }
    assert_eq!(folder.names("halves"), names);
    for name in &names {
        assert!(folder.read(&format!("out/{name}")) == folder.read(&format!("halves/{name}")), "{name}");
    }
    animate(&folder, &format!("{flags} -o a.gif")).check(0, &[]);
    let (repeat, frames) = gif(&folder.path("a.gif"));
    assert!(repeat == gif::Repeat::Infinite && frames.len() == 192);
    assert_eq!(frames.iter().map(|(delay, _)| u32::from(*delay)).sum::<u32>(), 800);
    assert!(frames.iter().all(|(delay, _)| (4..=5).contains(delay)));
    assert_eq!(took(&animate(&folder, &format!("{flags} --step 50 -o step/#.png")).check(0, &[])), (4, 0));
    assert_eq!(folder.names("step"), ["0.png", "100.png", "150.png", "50.png"]);
}

#[test]
fn an_apng_has_the_frames_of_a_sequence() {
    let folder = Folder::hello();
    for flags in ["", "--bits 16", "--crop 3,2,7,9 --frames 2..4", "--set render.background=transparent"] {
        animate(&folder, &format!("{flags} --force -o out/#.png")).check(0, &[]);
        animate(&folder, &format!("{flags} -o a.apng")).check(0, &[]);
        let (plays, frames) = apng(&folder.path("a.apng"));
        let first = if flags.contains("--frames") { 2 } else { 0 };
        assert_eq!((plays, frames.len()), (0, if first == 2 { 2 } else { 16 }), "{flags}");
        for (i, (delay, bytes)) in frames.iter().enumerate() {
            assert_eq!(*delay, (1, 8));
            assert!(*bytes == png(&folder.path(&format!("out/{}.png", i + first))), "{flags}: frame {i}");
        }
        std::fs::remove_dir_all(folder.path("out")).unwrap();
        assert_eq!(folder.names("."), ["a.apng", "hello.kin"]);
    }
}

#[test]
fn a_gif_looks_like_the_sequence() {
    let folder = Folder::hello();
    animate(&folder, "--samples 64 -o out/#.png").check(0, &[]);
    animate(&folder, "--samples 64 -o a.gif").check(0, &[]);
    let (repeat, frames) = gif(&folder.path("a.gif"));
    assert!(repeat == gif::Repeat::Infinite && frames.len() == 16);
    for (i, (_, shown)) in frames.iter().enumerate() {
        let expected = png(&folder.path(&format!("out/{i}.png")));
        let off: u64 = shown.iter().zip(&expected).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        let mean = off as f64 / expected.len() as f64;
        assert!(mean < 3.0, "frame {i} is off by {mean}");
    }
}

#[test]
fn the_same_film_is_the_same_bytes_and_is_not_made_twice() {
    let folder = Folder::hello();
    for ending in ["apng", "gif"] {
        let name = format!("a.{ending}");
        assert_eq!(took(&animate(&folder, &format!("-o {name} --threads 1")).check(0, &[])), (16, 0));
        let bytes = folder.read(&name);
        assert!(bytes.windows(12).any(|piece| piece == b"kinora:scene"));
        assert_eq!(took(&animate(&folder, &format!("-o b.{ending} --threads 2 --resume")).check(0, &[])), (16, 0));
        assert!(folder.read(&format!("b.{ending}")) == bytes, "{ending}");
        assert_eq!(took(&animate(&folder, &format!("-o {name} --resume")).check(0, &[])), (0, 16));
        assert_eq!(took(&animate(&folder, &format!("-o {name} --resume --frames 0..15")).check(0, &[])), (15, 0));
        assert_eq!(
            took(&animate(&folder, &format!("-o {name} --resume --force --frames 0..15")).check(0, &[])),
            (15, 0)
        );
        assert!(folder.names(".").iter().all(|name| !name.starts_with('.')));
    }
}

#[test]
fn a_frame_without_a_picture_leaves_no_film() {
    let folder = Folder::new();
    folder.write("hello.kin", &HELLO.replace("radius: 50cm", "radius: 50cm * abs(frame - 1) * abs(frame - 2)"));
    let ran = animate(&folder, "--frames 0..5 -o out/#.png");
    assert_eq!(took(&ran), (3, 0));
    ran.check(1, &["frame 1 has no picture", "2 of 5 frames have no picture: 1-2"]);
    let ran = animate(&folder, "--frames 0..5 -o a.apng")
        .check(1, &["2 of 5 frames have no picture: 1-2", "a.apng", "--resume"]);
    assert_eq!(took(&ran), (3, 0));
    assert!(!exists(&folder.path("a.apng")));
    folder.write("hello.kin", HELLO);
    animate(&folder, "--frames 0..5 -o a.apng --resume").check(0, &[]);
    assert!(exists(&folder.path("a.apng")));
    assert!(!exists(&folder.path(".a.apng.frames")));
}

#[test]
fn a_frame_whose_file_cannot_be_written_does_not_stop_the_others() {
    let folder = Folder::hello();
    std::fs::create_dir_all(folder.path("out/2.png")).unwrap();
    let ran = animate(&folder, "--frames 0..4 -o out/#.png");
    assert_eq!(took(&ran), (3, 0));
    ran.check(2, &["frame 2: cannot write", "1 of 4 frames have no picture: 2"]);
    assert_eq!(folder.names("out"), ["0.png", "1.png", "2.png", "3.png"]);
}

#[test]
fn what_cannot_be_filmed_is_refused_before_there_is_work() {
    let folder = Folder::hello();
    folder.write("plain", "");
    for (line, piece) in [
        ("-o a.png", "or name a film in one file, such as a.mp4"),
        ("-o a.####.gif", "leave the place for the frame's number out"),
        ("-o a.gif --bits 16", "`--bits 16` is for .png and .apng"),
        ("-o a.gif --aov id", "adds layers to an .exr"),
        ("-o a.gif --set render.background=transparent", "cannot be transparent"),
        ("-o a.gif --set render.fps=60", "at most 50 frames a second"),
        ("-o plain/a.gif", "cannot make the folder `plain`"),
        ("-o a.apng --frames 4..1", "runs backwards"),
        ("-o a.apng --step 0", "--step"),
        ("-o a.avi", "cannot be written as `.avi`"),
    ] {
        animate(&folder, &format!("{line} --samples 1000000000")).check(2, &[piece]);
    }
    folder.run("render hello.kin -o a.gif").check(2, &["`kinora animate` writes it"]);
    assert_eq!(folder.names("."), ["hello.kin", "plain"]);
}

#[test]
fn two_processes_do_not_make_the_same_film() {
    let folder = Folder::hello();
    let mut first = folder.command("animate hello.kin --backend cpu --frames 0..90000 --size 64x64 -o a.apng");
    let mut first = first.stderr(Stdio::null()).spawn().unwrap();
    wait_for(&folder.path(".a.apng.frames/frame.0000.png"));
    animate(&folder, "-o a.apng").check(2, &["another process is making `a.apng`"]);
    first.kill().unwrap();
    first.wait().unwrap();
    animate(&folder, "-o a.apng").check(0, &[]);
    assert_eq!(folder.names("."), ["a.apng", "hello.kin"]);
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !exists(path) {
        assert!(start.elapsed() < Duration::from_secs(120), "{} does not come", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

const SLOW: &str = "--size 48x32 --samples 16 --frames 0..12";

/// Kills the program (as `kill -9` does) after each of these frames, and demands that what it goes on to is the same.
fn killed(folder: &Folder, output: &str, frames: &str, after: &[u32]) {
    let line = format!("animate hello.kin --backend cpu {SLOW} -o {output}");
    for frame in after {
        let mut child = folder.command(&format!("{line} --resume")).stderr(Stdio::null()).spawn().unwrap();
        wait_for(&folder.path(&frames.replace("####", &format!("{frame:04}"))));
        std::thread::sleep(Duration::from_millis(u64::from(*frame)));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let ran = folder.run(&format!("{line} --resume --json")).check(0, &[]);
    let (rendered, skipped) = took(&ran);
    assert_eq!(rendered + skipped, 12, "{}", ran.out);
    assert!(skipped > *after.last().unwrap_or(&0) as u64, "{}", ran.out);
}

#[test]
fn killed_sequences_go_on() {
    let folder = Folder::hello();
    let whole = folder.run(&format!("animate hello.kin --backend cpu {SLOW} -o whole/####.png --json")).check(0, &[]);
    assert_eq!(took(&whole), (12, 0));
    killed(&folder, "out/####.png", "out/####.png", &[0, 3, 4, 8]);
    assert_eq!(folder.names("out"), folder.names("whole"), "nothing is left behind");
    for name in folder.names("whole") {
        assert!(folder.read(&format!("out/{name}")) == folder.read(&format!("whole/{name}")), "{name}");
    }
}

#[test]
fn killed_films_go_on() {
    let folder = Folder::hello();
    let kinds = if real_ffmpeg() { &["apng", "gif", "mp4", "webm"][..] } else { &["apng", "gif"] };
    for kind in kinds {
        folder.run(&format!("animate hello.kin --backend cpu {SLOW} -o whole.{kind}")).check(0, &[]);
        killed(&folder, &format!("a.{kind}"), &format!(".a.{kind}.frames/frame.####.png"), &[0, 2, 7]);
        assert!(folder.read(&format!("a.{kind}")) == folder.read(&format!("whole.{kind}")), "{kind}");
        assert!(folder.names(".").iter().all(|name| !name.starts_with('.')), "{:?}", folder.names("."));
    }
}

#[test]
fn what_others_left_behind_is_swept_but_not_what_they_are_writing() {
    let folder = Folder::hello();
    for name in ["out/.0.png.123.tmp", "out/.7.png.124.tmp", "out/.other.png.125.tmp", "out/.0.png.tmp"] {
        folder.write(name, "half");
    }
    let busy = File::open(folder.path("out/.7.png.124.tmp")).unwrap();
    busy.lock().unwrap();
    animate(&folder, "--frames 0..1 -o out/#.png").check(0, &[]);
    assert_eq!(folder.names("out"), [".0.png.tmp", ".7.png.124.tmp", ".other.png.125.tmp", "0.png"]);
}

fn real_ffmpeg() -> bool {
    Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[test]
fn without_ffmpeg_it_says_what_to_do() {
    let folder = Folder::hello();
    for ending in ["mp4", "webm"] {
        let line = format!("animate hello.kin --samples 1000000000 -o a.{ending}");
        let output = folder.command(&line).env("PATH", folder.path(".")).output().unwrap();
        Ran::from(&line, output).check(2, &["install it", "on the PATH", ".apng, .gif and sequences", "need nothing"]);
    }
    assert_eq!(folder.names("."), ["hello.kin"]);
}

/// Runs with a shell script as ffmpeg, which finds the name of the film in $film and all of its input in a pipe.
#[cfg(unix)]
fn with_script(folder: &Folder, script: &str, flags: &str) -> Ran {
    use std::os::unix::fs::PermissionsExt;

    folder.write("bin/ffmpeg", &format!("#!/bin/sh\nprintf '%s\\n' \"$@\" > args\nfor film; do :; done\n{script}\n"));
    std::fs::set_permissions(folder.path("bin/ffmpeg"), PermissionsExt::from_mode(0o755)).unwrap();
    let line = format!("animate hello.kin --backend cpu --json {flags}");
    let paths = std::env::var_os("PATH").unwrap();
    let paths = std::iter::once(folder.path("bin")).chain(std::env::split_paths(&paths));
    let output = folder.command(&line).env("PATH", std::env::join_paths(paths).unwrap()).output().unwrap();
    Ran::from(&line, output)
}

#[cfg(unix)]
#[test]
fn ffmpeg_gets_the_frames_of_the_sequence() {
    let folder = Folder::hello();
    animate(&folder, "-o out/##.png").check(0, &[]);
    let whole: Vec<u8> =
        folder.names("out").iter().flat_map(|name| png(&folder.path(&format!("out/{name}")))).collect();
    for (ending, codec) in [("mp4", "libx264"), ("webm", "libvpx-vp9")] {
        with_script(&folder, "cat > \"$film\"; echo frame=16", &format!("-o a.{ending}")).check(0, &[]);
        assert!(folder.read(&format!("a.{ending}")) == whole, "{ending}");
        let args = String::from_utf8(folder.read("args")).unwrap();
        for piece in ["rgb24", "24x16", "8/1", codec, "yuv420p", "bt709", "iec61966-2-1", "+bitexact", "kinora:scene="]
        {
            assert!(args.lines().any(|word| word.contains(piece)), "{ending}: no {piece} in {args}");
        }
        assert!(!args.contains("pad="));
    }
    with_script(&folder, "cat > \"$film\"", "-o a.mp4 --size 25x16").check(0, &[]);
    assert!(String::from_utf8(folder.read("args")).unwrap().contains("pad=ceil(iw/2)*2:ceil(ih/2)*2"));
}

#[cfg(unix)]
#[test]
fn what_ffmpeg_does_wrong_is_told_and_no_frame_is_lost() {
    let folder = Folder::hello();
    for (script, pieces) in [
        ("cat > \"$film\"; echo frame=15", &["15 of 16 frames are in it"][..]),
        ("cat > /dev/null", &["cannot write `a.mp4`"]),
        ("cat > /dev/null; : > \"$film\"", &["the file is empty"]),
        ("cat > \"$film\"; echo 'no such codec' >&2; exit 1", &["no such codec"]),
        ("head -c 100 > \"$film\"; exec <&-; echo 'no room' >&2; exit 0", &["cannot write `a.mp4`"]),
    ] {
        with_script(&folder, script, "-o a.mp4").check(2, pieces).check(2, &["--resume goes on"]);
        assert_eq!(folder.names("."), [".a.mp4.frames", "args", "bin", "hello.kin"], "{script}");
        let kept = folder.names(".a.mp4.frames");
        assert!(kept.iter().all(|name| name == "lock" || name.ends_with(".png")), "{kept:?}");
    }
    let ran = with_script(&folder, "cat > \"$film\"; echo frame=16", "-o a.mp4 --resume").check(0, &[]);
    assert!(took(&ran).1 > 0);
    assert_eq!(folder.names("."), ["a.mp4", "args", "bin", "hello.kin"]);
}

#[test]
fn films_by_the_real_ffmpeg() {
    if !real_ffmpeg() {
        return;
    }
    let folder = Folder::hello();
    animate(&folder, "--size 33x23 --samples 64 -o out/##.png").check(0, &[]);
    for ending in ["mp4", "webm"] {
        animate(&folder, &format!("--size 33x23 --samples 64 -o a.{ending}")).check(0, &[]);
        animate(&folder, &format!("--size 33x23 --samples 64 -o b.{ending}")).check(0, &[]);
        assert!(folder.read(&format!("a.{ending}")) == folder.read(&format!("b.{ending}")), "{ending}");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-i"]).arg(folder.path(&format!("a.{ending}")));
        ffmpeg.args(["-vf", "scale=in_color_matrix=bt709", "-pix_fmt", "rgb24", "-f", "rawvideo", "-"]);
        let raw = ffmpeg.output().unwrap().stdout;
        assert_eq!(raw.len(), 16 * 34 * 24 * 3, "{ending}");
        for (i, name) in folder.names("out").iter().enumerate() {
            let frame = &raw[i * 34 * 24 * 3..];
            let expected = png(&folder.path(&format!("out/{name}")));
            let off: u64 = (0..23)
                .flat_map(|y| (0..33 * 3).map(move |x| (y, x)))
                .map(|(y, x)| u64::from(frame[y * 34 * 3 + x].abs_diff(expected[y * 33 * 3 + x])))
                .sum();
            let mean = off as f64 / expected.len() as f64;
            assert!(mean < 6.0, "{ending}: frame {i} is off by {mean}");
        }
        let resumed = animate(&folder, &format!("--size 33x23 --samples 64 -o a.{ending} --resume"));
        assert_eq!(took(&resumed), (0, 16), "{ending}");
    }
}
