//! Warnings that a scene allows: `// allow(W0401): reason` on a line of its own above the line that gets them.

use std::collections::HashMap;

use super::{Applicability, Diagnostic, codes, levels::no_code};
use crate::source::{FileId, Source, Span};
use crate::syntax::line_comments;

const WORD: &str = "allow(";

/// One code of one comment.
struct Allowance<'s> {
    source: &'s Source,
    /// The comment, to the end of its line.
    comment: Span,
    /// The code, as it is written and as it is.
    word: Span,
    code: &'static str,
    /// The only code of its comment.
    alone: bool,
    /// The line it is about, from 0.
    line: u32,
    /// Whether that is the first line with anything on it: what is wrong with the whole file counts to that.
    first: bool,
}

/// Leaves out the warnings that their scenes allow, and says which allowances are none (W0902) or allow nothing (W0903;
/// not where there are errors, as then not every warning is found).
pub fn honour(mut diagnostics: Vec<Diagnostic>, sources: &[Source]) -> Vec<Diagnostic> {
    let mut wrong = Vec::new();
    let allowances: Vec<Allowance<'_>> = sources.iter().flat_map(|source| allowances(source, &mut wrong)).collect();
    let mut used = vec![false; allowances.len()];
    let index = Index::new(&allowances);
    diagnostics.retain(|found| {
        let by = index.find(found, sources);
        if let Some(used) = by.and_then(|by| used.get_mut(by)) {
            *used = true;
        }
        by.is_none()
    });
    if !diagnostics.iter().any(Diagnostic::is_error) {
        wrong.extend(allowances.iter().zip(used).filter(|(_, used)| !used).map(|(allowance, _)| allowance.unused()));
    }
    diagnostics.append(&mut wrong);
    diagnostics
}

/// The first allowance of each code that is about a line, about a whole file, and about no file.
#[derive(Default)]
struct Index {
    lines: HashMap<(FileId, u32, &'static str), usize>,
    files: HashMap<(Option<FileId>, &'static str), usize>,
}

impl Index {
    fn new(allowances: &[Allowance<'_>]) -> Index {
        let mut index = Index::default();
        for (at, &Allowance { source, code, line, first, .. }) in allowances.iter().enumerate() {
            index.lines.entry((source.id, line, code)).or_insert(at);
            for file in [Some(source.id), None].into_iter().filter(|_| first) {
                index.files.entry((file, code)).or_insert(at);
            }
        }
        index
    }

    /// The first that allows a warning.
    fn find(&self, found: &Diagnostic, sources: &[Source]) -> Option<usize> {
        if found.is_error() {
            return None;
        }
        let Some((file, span)) = found.place() else { return self.files.get(&(None, found.code)).copied() };
        let source = sources.iter().find(|source| source.id == file)?;
        let whole = (span.end == 0).then(|| self.files.get(&(Some(file), found.code))).flatten();
        let line = self.lines.get(&(file, source.line_index(span.start), found.code));
        whole.into_iter().chain(line).min().copied()
    }
}

impl Allowance<'_> {
    /// W0903.
    fn unused(&self) -> Diagnostic {
        let code = self.source.slice(self.word);
        let found = Diagnostic::new("W0903", format!("`{code}` is allowed, but does not occur")).primary(
            self.source.id,
            self.word,
            format!("line {} does not get it", self.line + 1),
        );
        match self.alone {
            true => {
                let start = self.source.line_start(self.source.line_index(self.comment.start));
                let end = self.source.line_start(self.source.line_index(self.comment.start) + 1);
                found.fix(Applicability::Maybe, "remove the comment", self.source.id, Span::new(start, end), "")
            }
            false => found.help(format!("remove `{code}`")),
        }
    }
}

fn allowances<'s>(source: &'s Source, wrong: &mut Vec<Diagnostic>) -> Vec<Allowance<'s>> {
    let mut found = Vec::new();
    if !source.text.contains(WORD) {
        return found;
    }
    let says = lines_that_say(source);
    for start in line_comments(&source.text) {
        let line = source.line_index(start as u32);
        let whole = source.line_span(line);
        let comment = Span::new(start as u32, whole.end);
        let text = source.slice(comment);
        let Some(inside) = text.strip_prefix("//").and_then(|text| text.trim_start().strip_prefix(WORD)) else {
            continue;
        };
        let mut report = |message: String, span: Span, label: &str, help: &str| {
            wrong.push(Diagnostic::new("W0902", message).primary(source.id, span, label).help(help));
        };
        if !source.slice(Span::new(whole.start, comment.start)).trim().is_empty() {
            report(
                "an allowance stands on a line of its own".into(),
                comment,
                "behind something else",
                "write it on the line above",
            );
            continue;
        }
        let Some((list, _)) = inside.split_once(')') else {
            report("this `(` is never closed".into(), comment, "here", "write `// allow(W0401): why`");
            continue;
        };
        let above = says.partition_point(|says| *says <= line);
        // The next line that is neither empty nor a comment.
        let (line, first) = (says.get(above).copied().unwrap_or(line + 1), above == 0);
        let mut start = comment.end - inside.len() as u32;
        for part in list.split(',') {
            let text = part.trim();
            let offset = start + (part.len() - part.trim_start().len()) as u32;
            let word = Span::new(offset, offset + text.len() as u32);
            start += part.len() as u32 + 1;
            match codes::find(text) {
                None => report(no_code(text), word, "no code of a warning", "write `// allow(W0401): why`"),
                Some(row) if row.code.starts_with('E') => report(
                    format!("`{}` is an error: only warnings can be allowed", row.code),
                    word,
                    "an error's code",
                    "remove it, and what is wrong below",
                ),
                Some(row) => {
                    let (code, alone) = (row.code, !list.contains(','));
                    found.push(Allowance { source, comment, word, code, alone, line, first });
                }
            }
        }
    }
    found
}

/// The lines that are neither empty nor comments, from 0.
fn lines_that_say(source: &Source) -> Vec<u32> {
    let says = |line: &u32| {
        let text = source.slice(source.line_span(*line)).trim_start();
        !text.is_empty() && !text.starts_with("//")
    };
    (0..source.line_count()).filter(says).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, at: Option<&str>, expected: &[(&str, &str)]) {
        let source = Source::new(FileId(0), "a.kin", text);
        let mut found = Diagnostic::new("W0201", "`x` is never used");
        if let Some(at) = at {
            found = found.primary(FileId(0), Span::at(text.find(at).unwrap() as u32), "");
        }
        let left = honour(vec![found], &[source]);
        let left: Vec<_> = left.iter().map(|found| (found.code, found.message.as_str())).collect();
        assert_eq!(left, expected, "{text}");
    }

    #[test]
    fn allowances_of_a_text() {
        const LEFT: (&str, &str) = ("W0201", "`x` is never used");
        let unused = |code: &'static str| {
            (
                "W0903",
                if code == "W0201" {
                    "`W0201` is allowed, but does not occur"
                } else {
                    "`W0402` is allowed, but does not occur"
                },
            )
        };
        check("// allow(W0201): later\nlet x = 1", Some("x ="), &[]);
        check("  //allow( w0201 )\n\n// more\n  let x = 1", Some("x ="), &[]);
        check("// allow(W0201)\n// allow(W0402)\nlet x = 1", Some("x ="), &[unused("W0402")]);
        check("// allow(W0201, W0402): both\nlet x = 1", Some("x ="), &[unused("W0402")]);
        check("// allow(W0201)\nlet y = 1\nlet x = 1", Some("x ="), &[LEFT, unused("W0201")]);
        check("// about\n// allow(W0201)\n\nlang 1", None, &[]);
        check("lang 1\n// allow(W0201)\nlet x = 1", None, &[LEFT, unused("W0201")]);
        check("/// allow(W0201)\nlet x = 1", Some("x ="), &[LEFT]);
        check("/*\n// allow(W0201)\n*/ let x = 1", Some("x ="), &[LEFT]);
        check("let t = \"// allow(W0201)\"\nlet x = 1", Some("x ="), &[LEFT]);
        check("let x = 1 // allow(W0201)", Some("x ="), &[LEFT, ("W0902", "an allowance stands on a line of its own")]);
        check("// allow(W0201\nlet x = 1", Some("x ="), &[LEFT, ("W0902", "this `(` is never closed")]);
        check(
            "// allow(W0210)\nlet x = 1",
            Some("x ="),
            &[LEFT, ("W0902", "there is no code `W0210`; did you mean E0210, W0510, W0710?")],
        );
        check(
            "// allow(E0201)\nlet x = 1",
            Some("x ="),
            &[LEFT, ("W0902", "`E0201` is an error: only warnings can be allowed")],
        );
    }
}
