//! An X display without a screen, and the viewer upon it.

mod close;
pub mod wire;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What is waited for comes within seconds, or not at all.
const PATIENCE: Duration = Duration::from_secs(120);

/// An X server that draws into a file.
pub struct Display {
    server: Child,
    name: String,
    folder: PathBuf,
}

/// Starts an X server on a free display; none if `KINORA_NO_DISPLAY=1` says that there can be none.
pub fn display(test: &str) -> Option<Display> {
    if std::env::var_os("KINORA_NO_DISPLAY").is_some_and(|value| value == "1") {
        return None;
    }
    let folder = std::env::temp_dir().join(format!("kinora-{test}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-fbdir"])
        .arg(&folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("Xvfb does not start: install xvfb, or set KINORA_NO_DISPLAY=1 to do without");
    let mut number = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
    assert!(!number.trim().is_empty(), "Xvfb gives no display");
    Some(Display { server, name: format!(":{}", number.trim()), folder })
}

impl Display {
    /// A file in a folder of this display's own.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// As `DISPLAY` has it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The viewer, not yet started.
    pub fn command(&self, scene: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_kinora"));
        command.args(["--color", "never", "view"]).arg(scene).args(["--backend", "cpu"]);
        // Nothing is remembered from one test to the next, nor from the user.
        command.env("XDG_CONFIG_HOME", &self.folder).current_dir(&self.folder);
        command.env("DISPLAY", &self.name).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command
    }

    /// The viewer on `scene`, told to report its reloads.
    pub fn view(&self, scene: &Path) -> View {
        let mut command = self.command(scene);
        let mut child = command.arg("--json").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (lines, errors): (Arc<Mutex<Vec<String>>>, Arc<Mutex<String>>) = Default::default();
        let (stdout, stderr) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        std::thread::spawn({
            let lines = lines.clone();
            move || {
                BufReader::new(stdout).lines().map_while(Result::ok).for_each(|line| lines.lock().unwrap().push(line))
            }
        });
        std::thread::spawn({
            let errors = errors.clone();
            move || {
                let lines = BufReader::new(stderr).lines().map_while(Result::ok);
                lines.for_each(|line| *errors.lock().unwrap() += &(line + "\n"));
            }
        });
        View { child, lines, errors }
    }

    /// What is on the screen: from the file into which the server draws, an XWD dump.
    pub fn screen(&self) -> Screen {
        let mut bytes = Vec::new();
        std::fs::File::open(self.folder.join("Xvfb_screen0")).unwrap().read_to_end(&mut bytes).unwrap();
        Screen(bytes)
    }

    /// The pixel of the screen at (x, y), red, green, blue.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        self.screen().pixel(x, y)
    }

    /// Closes the viewer's window; gives how long the program stays after that, and whether it ends well.
    pub fn close(&self, mut view: View) -> (Duration, bool) {
        close::close_windows(&self.name);
        let start = Instant::now();
        let mut ended = None;
        eventually(|| {
            ended = view.child.try_wait().unwrap();
            ended.is_some()
        });
        (start.elapsed(), ended.is_some_and(|ended| ended.success()))
    }

    /// Waits until the pixel at (x, y) is `color`.
    #[track_caller]
    pub fn shows(&self, view: &mut View, (x, y): (usize, usize), color: [u8; 3]) {
        let found = eventually(|| view.runs() && self.pixel(x, y) == color);
        assert!(found, "({x}, {y}) is {:?}, not {color:?}; stderr:\n{}", self.pixel(x, y), view.errors());
    }
}

/// A dump of the screen.
pub struct Screen(Vec<u8>);

impl Screen {
    /// The pixel at (x, y), red, green, blue.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        let bytes = &self.0;
        let word = |index: usize| u32::from_be_bytes(bytes[index * 4..index * 4 + 4].try_into().unwrap()) as usize;
        let (header, bits, row, colors) = (word(0), word(11), word(12), word(19));
        assert_eq!(bits, 32, "bits a pixel");
        let at = header + colors * 12 + y * row + x * 4;
        // Byte order 0: the least significant byte, blue, comes first.
        assert_eq!(word(7), 0, "byte order");
        [bytes[at + 2], bytes[at + 1], bytes[at]]
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A running viewer.
pub struct View {
    child: Child,
    lines: Arc<Mutex<Vec<String>>>,
    errors: Arc<Mutex<String>>,
}

impl View {
    fn runs(&mut self) -> bool {
        let ended = self.child.try_wait().unwrap();
        assert!(ended.is_none(), "the viewer ended with {ended:?}; stderr:\n{}", self.errors());
        true
    }

    /// What was written to stderr so far.
    pub fn errors(&self) -> String {
        self.errors.lock().unwrap().clone()
    }

    /// Waits for the report of the next reload without errors.
    #[track_caller]
    pub fn good_reload(&mut self) -> serde_json::Value {
        loop {
            let reload = self.reload();
            if reload["errors"] == 0 {
                return reload;
            }
        }
    }

    /// Waits for the report of the next reload.
    #[track_caller]
    pub fn reload(&mut self) -> serde_json::Value {
        let mut line = None;
        eventually(|| {
            let mut lines = self.lines.lock().unwrap();
            line = (!lines.is_empty()).then(|| lines.remove(0));
            drop(lines);
            self.runs() && line.is_some()
        });
        let line = line.unwrap_or_else(|| panic!("no reload was reported; stderr:\n{}", self.errors()));
        serde_json::from_str(&line).unwrap()
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Waits until something holds.
pub fn eventually(mut holds: impl FnMut() -> bool) -> bool {
    let end = Instant::now() + PATIENCE;
    loop {
        if holds() {
            return true;
        }
        if Instant::now() >= end {
            return false;
        }
        std::thread::sleep(Duration::from_millis(30));
    }
}
