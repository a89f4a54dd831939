//! Commands that write scenes anew: `fmt` and `migrate` differ in what becomes of a text.

use std::io::Read;
use std::path::{Path, PathBuf};

use kinora_lang::Tree;
use kinora_lang::diagnostic::{Diagnostic, MAX_SHOWN, list};
use kinora_lang::source::{FileId, MAX_SOURCE_BYTES, Source, decode};
use similar::TextDiff;

use crate::exit::{self, Outcome};
use crate::flags::FileFlags;
use crate::write::write;
use crate::{report, terminal};

/// Which files, and whether they are written.
#[derive(Clone, Debug, clap::Args)]
pub struct RewriteFlags {
    #[command(flatten)]
    files: FileFlags,
    /// List the files that would change, write nothing, and end with exit code 1 if there are any
    #[arg(long)]
    check: bool,
    /// Show what would change, write nothing, and end with exit code 1 if there is anything
    #[arg(long)]
    diff: bool,
    /// What a scene from standard input is called
    #[arg(long, value_name = "PATH", default_value = "stdin.kin", hide_default_value = true)]
    stdin_path: PathBuf,
}

/// What became of a file.
enum Done {
    Same,
    Changed,
    /// It has mistakes, and was written anew round them.
    Partly,
    /// It stays as it is.
    Left,
}

/// Writes the files as `change` has them, which gets where a file lies and its tree.
///
/// # Errors
/// No file is meant. What keeps one file as it is, is said, and ends in 2.
pub fn rewrite(flags: &RewriteFlags, change: impl Fn(&Path, &Tree) -> Result<String, Vec<Diagnostic>>) -> Outcome {
    let files = flags.files.find()?;
    let (mut changed, mut partly, mut left) = (0, 0, 0);
    for file in &files {
        // A file that cannot be read or written keeps none of the others from being written.
        match one(flags, file, &change) {
            Ok(Done::Same) => {}
            Ok(Done::Changed) => changed += 1,
            Ok(Done::Partly) => partly += 1,
            Ok(Done::Left) => left += 1,
            Err(message) => {
                terminal::error(&message);
                left += 1;
            }
        }
    }
    let dry = flags.check || flags.diff;
    Ok(match (left, partly, changed) {
        (1.., _, _) => exit::FAILED,
        (_, 1.., _) => exit::FINDINGS,
        (_, _, 1..) if dry => exit::FINDINGS,
        _ => exit::CLEAN,
    })
}

fn one(
    flags: &RewriteFlags,
    file: &Path,
    change: impl Fn(&Path, &Tree) -> Result<String, Vec<Diagnostic>>,
) -> Result<Done, String> {
    let is_stdin = file == Path::new("-");
    let path = if is_stdin { &flags.stdin_path } else { file };
    let name = path.to_string_lossy().into_owned();
    let bytes = read(file, is_stdin)?;
    let (source, fault) = decode(FileId::default(), &name, &bytes);
    if let Some(fault) = fault {
        show(&[fault], &source);
        return Ok(Done::Left);
    }
    let tree = kinora_lang::parse(&source);
    let changed = change(path, &tree);
    // Of a file with mistakes the mistakes are said in any case.
    show(tree.errors(), &source);
    let text = match changed {
        Ok(text) => text,
        Err(found) => {
            if tree.errors().is_empty() {
                show(&found, &source);
            }
            return Ok(Done::Left);
        }
    };
    let differs = *text != *source.text;
    if flags.check && differs {
        terminal::out(&format!("{name}\n"))?;
    }
    if flags.diff && differs {
        let diff = TextDiff::from_lines(&*source.text, &text);
        let (before, after) = (format!("a/{name}"), format!("b/{name}"));
        terminal::out(&diff.unified_diff().header(&before, &after).to_string())?;
    }
    match (flags.check || flags.diff, is_stdin) {
        (true, _) => {}
        (false, true) => terminal::out(&text)?,
        (false, false) if differs => write(file, &text)?,
        (false, false) => {}
    }
    Ok(match (tree.errors().is_empty(), differs) {
        (false, _) => Done::Partly,
        (true, true) => Done::Changed,
        (true, false) => Done::Same,
    })
}

fn read(file: &Path, is_stdin: bool) -> Result<Vec<u8>, String> {
    let name = if is_stdin { "standard input".to_string() } else { format!("`{}`", file.display()) };
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("there is no file {name}"),
        _ => format!("cannot read {name}: {error}"),
    };
    let input: Box<dyn Read> = match is_stdin {
        true => Box::new(std::io::stdin()),
        // Asked before opening: opening a pipe would wait for its other end.
        false if !std::fs::metadata(file).map_err(failed)?.is_file() => {
            return Err(format!("cannot read {name}: it is no regular file"));
        }
        false => Box::new(std::fs::File::open(file).map_err(failed)?),
    };
    let mut bytes = Vec::new();
    input.take(MAX_SOURCE_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    match bytes.len() > MAX_SOURCE_BYTES {
        true => Err(format!("{name} is larger than {} MiB", MAX_SOURCE_BYTES >> 20)),
        false => Ok(bytes),
    }
}

fn show(found: &[Diagnostic], source: &Source) {
    if !found.is_empty() {
        terminal::err(&report::full(&list(found.to_vec(), MAX_SHOWN), std::slice::from_ref(source)));
    }
}
