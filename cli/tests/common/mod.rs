//! A folder of its own for every test, and the program run in it.

#![allow(dead_code, reason = "every test file uses a part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A scene that renders in no time.
pub const HELLO: &str = "lang 1\n
render { resolution: (24, 16), samples: 4, max_bounces: 2, fps: 8, duration: 2s }
camera main { position: (0, 1, 4), look_at: (0, 0.5, 0), fov: 40deg }
sky { color: #bcd7ff }
plane floor { material: diffuse { color: #808080 } }
sphere ball { position: (0, 0.5 + 0.1 * time / 1s, 0), radius: 50cm, material: diffuse { color: #d9402b } }
";

/// A folder that goes when the test ends.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("kinora-test-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    /// A folder with `hello.kin` in it.
    pub fn hello() -> Folder {
        let folder = Folder::new();
        folder.write("hello.kin", HELLO);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names in a folder inside, sorted.
    pub fn names(&self, inside: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(inside)).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program with these words as arguments, in this folder and with nothing in the environment that matters.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_kinora"));
        command.current_dir(&self.0).args(line.split_whitespace()).stdin(Stdio::null());
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "KINORA_FORMAT", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"]
        {
            command.env_remove(name);
        }
        command
    }

    /// Runs it.
    pub fn run(&self, line: &str) -> Ran {
        Ran::from(line, self.command(line).output().unwrap())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What came of a run.
pub struct Ran {
    pub line: String,
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    pub fn from(line: &str, output: Output) -> Ran {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Ran { line: line.into(), code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Demands an exit code and pieces of stderr.
    #[track_caller]
    pub fn check(self, code: i32, pieces: &[&str]) -> Ran {
        let Ran { line, out, err, .. } = &self;
        assert_eq!(self.code, Some(code), "kinora {line}\nstdout: {out}\nstderr: {err}");
        for piece in pieces {
            assert!(err.contains(piece), "kinora {line}: no {piece:?} in {err}");
        }
        self
    }
}

pub fn exists(path: &Path) -> bool {
    path.try_exists().unwrap()
}
