//! Warnings that a scene allows: `// allow(W0401): reason` on a line of its own above the line that gets them.

use super::{Applicability, Diagnostic, codes, levels::no_code};
use crate::source::{Source, Span};
use crate::syntax::starts_comment;

const WORD: &str = "allow(";

/// One code of one comment.
struct Allowance<'s> {
    source: &'s Source,
    /// The comment, to the end of its line.
    comment: Span,
    /// The code.
    word: Span,
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
    diagnostics.retain(|found| {
        let by = allowances.iter().position(|allowance| allowance.allows(found));
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

impl Allowance<'_> {
    fn allows(&self, found: &Diagnostic) -> bool {
        if found.is_error() || !self.source.slice(self.word).eq_ignore_ascii_case(found.code) {
            return false;
        }
        match found.place() {
            Some((file, _)) if file != self.source.id => false,
            Some((_, span)) if self.first && span.end == 0 => true,
            Some((_, span)) => self.source.line_index(span.start) == self.line,
            None => self.first,
        }
    }

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
    for (at, _) in source.text.match_indices(WORD) {
        let line = source.line_index(at as u32);
        let whole = source.line_span(line);
        let before = source.slice(Span::new(whole.start, at as u32));
        let Some(slashes) = before.trim_end().strip_suffix("//") else { continue };
        let comment = Span::new(whole.start + slashes.len() as u32, whole.end);
        if slashes.ends_with('/') || !starts_comment(&source.text, comment.start as usize) {
            continue;
        }
        let mut report = |message: String, span: Span, label: &str, help: &str| {
            wrong.push(Diagnostic::new("W0902", message).primary(source.id, span, label).help(help));
        };
        if !slashes.trim().is_empty() {
            report(
                "an allowance stands on a line of its own".into(),
                comment,
                "behind something else",
                "write it on the line above",
            );
            continue;
        }
        let inside = Span::new(at as u32 + WORD.len() as u32, whole.end);
        let Some((list, _)) = source.slice(inside).split_once(')') else {
            report("this `(` is never closed".into(), comment, "here", "write `// allow(W0401): why`");
            continue;
        };
        let (line, first) = (line_below(source, line), is_first(source, line));
        let mut start = inside.start;
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
                Some(_) => {
                    found.push(Allowance { source, comment, word, alone: !list.contains(','), line, first });
                }
            }
        }
    }
    found
}

/// The next line that is neither empty nor a comment.
fn line_below(source: &Source, line: u32) -> u32 {
    let says = |line: &u32| {
        let text = source.slice(source.line_span(*line)).trim_start();
        !text.is_empty() && !text.starts_with("//")
    };
    (line + 1..source.line_count()).find(says).unwrap_or(line + 1)
}

/// Whether nothing but comments stands above a line.
fn is_first(source: &Source, line: u32) -> bool {
    (0..line).all(|line| {
        let text = source.slice(source.line_span(line)).trim_start();
        text.is_empty() || text.starts_with("//")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

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
