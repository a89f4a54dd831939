//! Runs scenes that carry their expected diagnostics as comments.
//!
//! Behind the line that a diagnostic is about comes a comment with carets under the span, the code and the message, then
//! its notes, helps and fixes:
//!
//! ```text
//!     radius 0.5
//! //        ^ E0105 expected `:` after `radius`
//! // fix (safe): write `radius: 0.5`
//! ```
//!
//! `|` stands for an empty span, `^^^>` for one that goes on over the line's end, `<1` for one that starts in column 1 or
//! 2, where the comment's slashes are, and `//!` for a diagnostic without a place, or in a file that is not of the case.
//! The comments are taken out before the scene is read. `UPDATE_EXPECT=1 cargo test` writes them anew.
//!
//! A line `// --- lib/paint.kin` begins another file of the case; `// -D name=value` stands for that flag.

use kinora_lang::diagnostic::{Applicability, Diagnostic, apply};
use kinora_lang::source::{Source, Span};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A scene with what it comes with.
#[derive(Clone)]
pub struct Case {
    /// Name and text of its files, the scene first.
    pub files: Vec<(String, String)>,
    /// Names and values of `-D`.
    pub params: Vec<(String, String)>,
}

const FILE: &str = "// --- ";
const PARAM: &str = "// -D ";

impl Case {
    /// Reads a scene and the files behind it.
    pub fn read(name: &str, text: &str) -> Case {
        let (mut files, mut params) = (vec![(name.to_string(), String::new())], Vec::new());
        for line in text.split_inclusive('\n') {
            if let Some(name) = line.strip_prefix(FILE) {
                files.push((name.trim().to_string(), String::new()));
                continue;
            }
            if let Some((name, value)) = line.strip_prefix(PARAM).and_then(|given| given.split_once('=')) {
                params.push((name.trim().to_string(), value.trim().to_string()));
            }
            files.last_mut().unwrap().1 += line;
        }
        Case { files, params }
    }

    fn with(&self, files: Vec<(String, String)>) -> Case {
        Case { files, params: self.params.clone() }
    }
}

/// What is found, in which texts.
pub type Found = (Vec<Diagnostic>, Vec<Source>);

/// Checks every `.kin` file under `tests/suite/FOLDER`, sorted; returns the codes that were expected.
pub fn run(folder: &str, check: impl Fn(&Case) -> Found) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/suite").join(folder);
    let mut files = Vec::new();
    collect(&root, &mut files);
    files.sort();
    assert!(!files.is_empty(), "no cases in {}", root.display());
    let mut failed = String::new();
    let mut codes = Vec::new();
    for path in files {
        let name = path.strip_prefix(&root).unwrap_or(&path).display().to_string().replace('\\', "/");
        let file = std::fs::read_to_string(&path).unwrap();
        let case = Case::read(&name, &without_expectations(&file));
        let (found, sources) = check(&case);
        codes.extend(found.iter().map(|found| found.code.to_string()));
        let actual = with_expectations(&case, &found, &sources);
        if actual != file && std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&path, &actual).unwrap();
        } else if actual != file {
            writeln!(failed, "--- {name}: expected\n{file}\n--- {name}: found\n{actual}").unwrap();
        }
        failed += &bad_fixes(&name, &case, &(found, sources), &check);
        let text = &case.files[0].1;
        for (end, _) in text.char_indices() {
            let mut files = case.files.clone();
            files[0].1.truncate(end);
            check(&case.with(files));
        }
    }
    assert!(failed.is_empty(), "{failed}");
    codes
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "kin") {
            files.push(path);
        }
    }
}

fn without_expectations(file: &str) -> String {
    let mut inside = false;
    let kept = file.split_inclusive('\n').filter(|line| {
        let head = is_head(line);
        inside = head || inside && is_detail(line);
        !inside
    });
    kept.collect()
}

fn is_head(line: &str) -> bool {
    let Some(rest) = line.strip_prefix("//") else { return false };
    let rest = rest.strip_prefix("<1").or(rest.strip_prefix("<2")).unwrap_or(rest);
    let code = match rest.strip_prefix("! ") {
        Some(code) => code,
        None => match rest.trim_start().trim_start_matches(['^', '|', '>']).strip_prefix(' ') {
            Some(code) if rest.contains(['^', '|']) => code,
            _ => return false,
        },
    };
    code.starts_with(['E', 'W']) && code.as_bytes().iter().skip(1).take(4).all(u8::is_ascii_digit)
}

fn is_detail(line: &str) -> bool {
    ["// note: ", "// help: ", "// fix (", "// see "].iter().any(|start| line.starts_with(start))
}

fn with_expectations(case: &Case, found: &[Diagnostic], sources: &[Source]) -> String {
    let source_of = |found: &Diagnostic| {
        let (file, _) = found.place()?;
        sources.iter().find(|source| source.id == file)
    };
    let mut out = String::new();
    for found in found {
        match source_of(found) {
            Some(source) if case.files.iter().any(|(name, _)| *name == *source.name) => continue,
            Some(source) => {
                let at = source.position(found.place().unwrap().1.start);
                writeln!(out, "//! {} {} ({}:{}:{})", found.code, found.message, source.name, at.line, at.column)
            }
            None => writeln!(out, "//! {} {}", found.code, found.message),
        }
        .unwrap();
        details(&mut out, sources, found);
    }
    for (index, (name, text)) in case.files.iter().enumerate() {
        if index > 0 {
            writeln!(out, "{FILE}{name}").unwrap();
        }
        for (index, line) in text.split_inclusive('\n').enumerate() {
            out += line;
            for found in found {
                let Some((source, (_, span))) = source_of(found).zip(found.place()) else { continue };
                if *source.name != **name || source.position(span.start).line as usize != index + 1 {
                    continue;
                }
                if !out.ends_with('\n') {
                    out.push('\n');
                }
                writeln!(out, "{} {} {}", marker(source, span), found.code, found.message).unwrap();
                details(&mut out, sources, found);
            }
        }
    }
    out
}

fn marker(source: &Source, span: Span) -> String {
    let column = source.position(span.start).column as usize;
    let line = source.line_span(source.line_index(span.start));
    let inside = Span::new(span.start, span.end.min(line.end));
    let mut carets = match span.is_empty() {
        true => "|".to_string(),
        false => "^".repeat(source.slice(inside).chars().count().max(1)),
    };
    if span.end > line.end {
        carets.push('>');
    }
    match column {
        1 | 2 => format!("//<{column} {carets}"),
        _ => format!("//{}{carets}", " ".repeat(column - 3)),
    }
}

fn details(out: &mut String, sources: &[Source], found: &Diagnostic) {
    for label in found.labels.iter().skip(1) {
        let Some(source) = sources.iter().find(|source| source.id == label.file) else { continue };
        let place = source.position(label.span.start);
        let other = if found.labels[0].file == label.file { String::new() } else { format!("{}:", source.name) };
        writeln!(out, "// see {other}{}:{}: {}", place.line, place.column, label.text).unwrap();
    }
    for note in &found.notes {
        writeln!(out, "// note: {note}").unwrap();
    }
    for help in &found.helps {
        writeln!(out, "// help: {help}").unwrap();
    }
    for fix in &found.fixes {
        writeln!(out, "// fix ({}): {}", fix.applicability.name(), fix.message).unwrap();
    }
}

/// Applies each safe fix alone: its diagnostic must go, and none may come.
fn bad_fixes(name: &str, case: &Case, (found, sources): &Found, check: impl Fn(&Case) -> Found) -> String {
    let mut failed = String::new();
    let keys = |found: &[Diagnostic]| -> Vec<(String, String)> {
        found.iter().map(|found| (found.code.to_string(), found.message.clone())).collect()
    };
    for (index, diagnostic) in found.iter().enumerate() {
        for fix in diagnostic.fixes.iter().filter(|fix| fix.applicability == Applicability::Safe) {
            let mut files = case.files.clone();
            for (name, text) in &mut files {
                if let Some(source) = sources.iter().find(|source| *source.name == **name) {
                    *text = apply(text, source.id, &fix.edits);
                }
            }
            let mut left = keys(found);
            left.remove(index);
            for key in keys(&check(&case.with(files.clone())).0) {
                match left.iter().position(|left| *left == key) {
                    Some(known) => drop(left.remove(known)),
                    None => writeln!(failed, "{name}: after `{}` comes {key:?}:\n{files:?}", fix.message).unwrap(),
                }
            }
        }
    }
    failed
}
