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
//! 2, where the comment's slashes are, and `//!` for a diagnostic without a place. The comments are taken out before the
//! scene is read. `UPDATE_EXPECT=1 cargo test` writes them anew.

use kinora_lang::diagnostic::{Applicability, Diagnostic, Fix};
use kinora_lang::source::{FileId, Source, Span};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Checks every `.kin` file under `tests/suite/FOLDER`, sorted; returns the codes that were expected.
pub fn run(folder: &str, check: impl Fn(&Source) -> Vec<Diagnostic>) -> Vec<String> {
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
        let text = without_expectations(&file);
        let read = |text: &str| check(&Source::new(FileId(0), name.as_str(), text));
        let found = read(&text);
        codes.extend(found.iter().map(|found| found.code.to_string()));
        let actual = with_expectations(&text, &found);
        if actual != file && std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&path, &actual).unwrap();
        } else if actual != file {
            writeln!(failed, "--- {name}: expected\n{file}\n--- {name}: found\n{actual}").unwrap();
        }
        failed += &bad_fixes(&name, &text, &found, read);
        for (end, _) in text.char_indices() {
            read(&text[..end]);
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

fn with_expectations(text: &str, found: &[Diagnostic]) -> String {
    let source = Source::new(FileId(0), "", text);
    let mut out = String::new();
    for found in found.iter().filter(|found| found.labels.is_empty()) {
        writeln!(out, "//! {} {}", found.code, found.message).unwrap();
        details(&mut out, &source, found);
    }
    for (index, line) in text.split_inclusive('\n').enumerate() {
        out += line;
        for found in found {
            let Some((_, span)) = found.place() else { continue };
            if source.position(span.start).line as usize != index + 1 {
                continue;
            }
            if !out.ends_with('\n') {
                out.push('\n');
            }
            writeln!(out, "{} {} {}", marker(&source, span), found.code, found.message).unwrap();
            details(&mut out, &source, found);
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

fn details(out: &mut String, source: &Source, found: &Diagnostic) {
    for label in found.labels.iter().skip(1) {
        let place = source.position(label.span.start);
        writeln!(out, "// see {}:{}: {}", place.line, place.column, label.text).unwrap();
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
fn bad_fixes(name: &str, text: &str, found: &[Diagnostic], read: impl Fn(&str) -> Vec<Diagnostic>) -> String {
    let mut failed = String::new();
    let keys = |found: &[Diagnostic]| -> Vec<(String, String)> {
        found.iter().map(|found| (found.code.to_string(), found.message.clone())).collect()
    };
    for (index, diagnostic) in found.iter().enumerate() {
        for fix in diagnostic.fixes.iter().filter(|fix| fix.applicability == Applicability::Safe) {
            let fixed = apply(text, fix);
            let mut left = keys(found);
            left.remove(index);
            for key in keys(&read(&fixed)) {
                match left.iter().position(|left| *left == key) {
                    Some(known) => drop(left.remove(known)),
                    None => writeln!(failed, "{name}: after `{}` comes {key:?}:\n{fixed}", fix.message).unwrap(),
                }
            }
        }
    }
    failed
}

fn apply(text: &str, fix: &Fix) -> String {
    let mut edits = fix.edits.clone();
    edits.sort_by_key(|edit| std::cmp::Reverse(edit.span));
    let mut text = text.to_string();
    for edit in edits {
        text.replace_range(edit.span.start as usize..edit.span.end as usize, &edit.insert);
    }
    text
}
