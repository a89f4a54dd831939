//! Films by the program ffmpeg: raw frames go in through a pipe, display values already, so that it has no say in how
//! light becomes colour. One thread and no dates: the same frames are the same bytes.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use super::{Head, Kind};

/// What ffmpeg says last is what went wrong.
const MOST_SAID: usize = 2000;

pub struct Ffmpeg {
    child: Child,
    // `None` once the last frame is in.
    frames: Option<ChildStdin>,
    said: Option<JoinHandle<String>>,
    counted: Option<JoinHandle<String>>,
    done: bool,
}

/// The program, where the PATH leads to one.
pub fn find() -> Option<PathBuf> {
    let name = if cfg!(windows) { "ffmpeg.exe" } else { "ffmpeg" };
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(name)).find(|path| path.is_file())
}

fn arguments(head: &Head) -> Vec<String> {
    let [width, height] = head.size;
    let mut words: Vec<String> = Vec::new();
    let mut add = |line: &str| words.extend(line.split(' ').map(String::from));
    add("-hide_banner -loglevel error -nostats -progress pipe:1 -y -f rawvideo -pix_fmt rgb24");
    add(&format!("-s {width}x{height} -r {}/{} -i pipe:0", head.rate.frames, head.rate.seconds));
    let mut filters = String::new();
    if width % 2 + height % 2 > 0 {
        // 4:2:0 wants even sides. The edge is repeated, as a black line would be seen.
        let [right, bottom] = [width % 2, height % 2];
        filters += &format!("pad=ceil(iw/2)*2:ceil(ih/2)*2,fillborders=right={right}:bottom={bottom}:mode=smear,");
    }
    filters += "scale=in_color_matrix=bt709:out_color_matrix=bt709";
    add(&format!("-an -vf {filters}"));
    add(match head.kind {
        Kind::Webm => "-c:v libvpx-vp9 -b:v 0 -crf 20 -deadline good -cpu-used 2",
        _ => "-c:v libx264 -preset slower -crf 18",
    });
    add("-pix_fmt yuv420p -color_range tv -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1");
    add("-threads 1 -fflags +bitexact -flags:v +bitexact -map_metadata -1");
    words.extend(["-metadata".into(), format!("comment={}", head.comment())]);
    words.extend(match head.kind {
        Kind::Webm => ["-f", "webm"].map(String::from).to_vec(),
        _ => ["-movflags", "+faststart", "-f", "mp4"].map(String::from).to_vec(),
    });
    words
}

impl Ffmpeg {
    pub fn begin(head: &Head, path: &Path) -> Result<Ffmpeg, String> {
        let program = find().ok_or("ffmpeg is not there any more")?;
        let mut command = Command::new(program);
        command.args(arguments(head)).arg(path).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| format!("ffmpeg does not start: {error}"))?;
        let (frames, said, counted) = (child.stdin.take(), child.stderr.take(), child.stdout.take());
        Ok(Ffmpeg { child, frames, said: said.map(last), counted: counted.map(last), done: false })
    }

    pub fn frame(&mut self, codes: &[u8]) -> Result<(), String> {
        let written = self.frames.as_mut().map_or(Ok(()), |pipe| pipe.write_all(codes));
        written.map_err(|error| {
            self.frames = None;
            let _ = self.child.wait();
            self.done = true;
            self.blame(&format!("it ended before the film did ({error})"))
        })
    }

    pub fn finish(mut self, wanted: u32) -> Result<(), String> {
        // Its end is where ffmpeg stops to wait for more.
        self.frames = None;
        let status = self.child.wait().map_err(|error| error.to_string())?;
        self.done = true;
        let progress = self.counted.take().and_then(|reader| reader.join().ok()).unwrap_or_default();
        let counted = progress.lines().rev().find_map(|line| line.strip_prefix("frame=")?.trim().parse::<u32>().ok());
        if !status.success() {
            return Err(self.blame(&status.to_string()));
        }
        // Its exit code says nothing of frames that got lost.
        match counted {
            Some(counted) if counted != wanted => Err(self.blame(&format!("{counted} of {wanted} frames are in it"))),
            _ => Ok(()),
        }
    }

    fn blame(&mut self, what: &str) -> String {
        let said = self.said.take().and_then(|reader| reader.join().ok()).unwrap_or_default();
        let said = said.trim();
        if said.is_empty() { format!("ffmpeg: {what}") } else { format!("ffmpeg: {what}\n{said}") }
    }
}

/// A film that is given up is not finished by ffmpeg either.
impl Drop for Ffmpeg {
    fn drop(&mut self) {
        if !self.done {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

// Reads all, so that the program never waits, and keeps the end.
fn last(mut stream: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let (mut kept, mut part) = (Vec::new(), [0; 1 << 12]);
        while let Ok(read @ 1..) = stream.read(&mut part) {
            kept.extend_from_slice(&part[..read]);
            let over = kept.len().saturating_sub(MOST_SAID);
            kept.drain(..over);
        }
        String::from_utf8_lossy(&kept).into_owned()
    })
}
