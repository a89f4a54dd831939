//! What the grammar lets pass so that it stays flat, and forms of other languages that it reads on purpose.

use super::*;
use crate::diagnostic::Applicability::{Maybe, Safe};
use crate::diagnostic::Edit;
use crate::syntax::expr::{COMPARISON, RANGE, binary_op, level};
use crate::syntax::scan;

impl Finder<'_> {
    /// `radius = 0.5`
    pub(super) fn eq_property(&mut self, node: Part<'_>) {
        let mut rest = parts(node);
        let (Some(key), Some(equals)) = (rest.next(), rest.next()) else { return };
        let sign = equals.span();
        let has_value = parts(node).nth(2).is_some_and(|value| value.kind() != SyntaxKind::Missing);
        let mut found =
            self.error("E0106", "properties use `:`, not `=`", sign, "use `:`").note("`=` is for `let`").fix(
                if has_value { Safe } else { Maybe },
                "use `:`",
                self.file(),
                Span::new(key.span().end, sign.end),
                ":",
            );
        if node.parent().is_some_and(|parent| parent.kind() == SyntaxKind::File) {
            found = found.help("to give a value a name, put `let` before it");
        }
        self.push(found);
    }

    /// `a < b < c`, `0..1..2`
    pub(super) fn chain(&mut self, node: Part<'_>) {
        let mut range: Option<Span> = None;
        let mut comparison: Option<Span> = None;
        for part in parts(node).filter(|part| part.kind() == SyntaxKind::Op) {
            let here = part.span();
            let level = level(binary_op(self.text(here)));
            if level < COMPARISON {
                comparison = None;
            }
            if level == RANGE && range.replace(here).is_some() {
                let found = self.error("E0124", "ranges cannot be chained", here, "second `..`");
                return self.push(found.help("a range has two ends: `0..10`"));
            }
            if level != COMPARISON {
                continue;
            }
            if let Some(first) = comparison.replace(here) {
                let middle = self.text(Span::new(first.end, here.start)).trim();
                let written = format!("&& {middle} ");
                let help = "join two comparisons with `&&`";
                let found = self.error("E0124", "comparisons cannot be chained", here, "second comparison").fix(
                    Safe,
                    help,
                    self.file(),
                    Span::at(here.start),
                    written,
                );
                return self.push(found);
            }
        }
    }

    /// `f(a: 1, 2)`
    pub(super) fn argument_order(&mut self, node: Part<'_>) {
        let mut named: Option<Span> = None;
        for part in parts(node) {
            match part.kind() {
                SyntaxKind::NamedArg => named = named.or(Some(part.span())),
                kind if kind.is_value() && kind != SyntaxKind::Missing => {
                    if let Some(first) = named {
                        let found = self
                            .error("E0128", "plain values come before named ones", part.span(), "has no name")
                            .label(self.file(), first, "first value with a name");
                        return self.push(found.help("move it to the front, or give it a name"));
                    }
                }
                _ => {}
            }
        }
    }

    /// `list<float`, `list<float>>`
    pub(super) fn angles(&mut self, node: Part<'_>) {
        let mut open: Vec<Span> = Vec::new();
        for part in parts(node) {
            match part.kind() {
                SyntaxKind::Less => open.push(part.span()),
                SyntaxKind::Greater if open.pop().is_none() => {
                    let found = self.error("E0126", "unmatched `>`", part.span(), "closes nothing").help("remove it");
                    return self.push(found);
                }
                _ => {}
            }
        }
        if let Some(last) = open.pop() {
            let end = Span::at(node.span().end);
            let found = self.error("E0126", "this `<` is never closed", last, "no `>` follows");
            self.push(found.fix(Safe, "add `>`", self.file(), end, ">".repeat(open.len() + 1)));
        }
    }

    /// `1.` and what follows it
    pub(super) fn number_point(&mut self, node: Part<'_>) {
        let Some(number) = before(node).filter(|base| base.kind() == SyntaxKind::Number) else { return };
        let number = number.span();
        let point = Span::new(number.start, node.span().start + 1);
        let text = self.text(number);
        let digits = text.trim_end_matches(|character: char| character.is_alphabetic() || character == '%');
        let written = match digits == text && !text.contains('.') {
            true => format!("{text}.0"),
            false => text.to_string(),
        };
        let found = self
            .error("E0116", "numbers need a digit on both sides of the point", point, "no digit behind the point")
            .fix(Safe, format!("write `{written}`"), self.file(), point, written);
        self.push(found);
        // `1.` swallows the name on the next line, whose `:` then stands alone.
        if let Some(rest) = self.bad_after(node.span().end) {
            self.merged.insert(rest.span.start);
        }
    }

    /// `[for i in a: b, c]`
    pub(super) fn comprehension(&mut self, node: Part<'_>) {
        if !node.nodes().any(|child| child.kind() == SyntaxKind::Comp) {
            return;
        }
        if let Some(second) = parts(node).find(|part| part.kind().is_value()) {
            let found = self.error("E0127", "a list with `for` holds nothing else", second.span(), "second value");
            self.push(found.help("close the list before it"));
        }
    }

    /// `elseif x { }` reads as a node of the kind `elseif`.
    pub(super) fn else_if(&mut self, node: Part<'_>) {
        let Some(first) = parts(node).next() else { return };
        if is_else_if(self.text(first.span())) {
            self.write_else_if(first.span());
        }
    }

    pub(super) fn write_else_if(&mut self, word: Span) {
        let found = self.error("E0123", "expected `{` or `if` after `else`", word, "not a word of the language").fix(
            Safe,
            "write `else if`",
            self.file(),
            word,
            "else if",
        );
        self.push(found);
    }

    /// What stands behind the value of `-D name=value`.
    pub(super) fn after_value(&mut self, node: Part<'_>) {
        let mut rest = parts(node).skip_while(|part| !part.kind().is_value());
        let Some(value) = rest.next() else { return };
        if value.kind() == SyntaxKind::Missing {
            return;
        }
        if let Some(next) = rest.next() {
            let place = Span::new(next.span().start, self.source.len());
            let label = "one value is expected";
            let found = self.error(
                "E0127",
                format!("unexpected `{}` after the value", excerpt(self.text(place))),
                place,
                label,
            );
            self.push_urgent(found);
        }
    }

    /// `-` in what should be one name: `my-ball`.
    pub(super) fn dashed_name(&mut self, name: Span) {
        let text = self.text(name);
        let Some(dash) = text.find('-') else { return };
        let at = Span::new(name.start + dash as u32, name.start + dash as u32 + 1);
        let written = text.replace('-', "_");
        let dashes = text.match_indices('-').map(|(offset, _)| {
            let start = name.start + offset as u32;
            Edit { file: self.file(), span: Span::new(start, start + 1), insert: "_".to_string() }
        });
        let mut edits: Vec<Edit> = dashes.collect();
        // It is called so in other places, too.
        self.renamed += 1;
        if self.renamed <= RENAMED {
            let places = scan::words(&self.source.text, text).into_iter().map(|at| at as u32);
            let others = places.filter(|at| *at != name.start).map(|at| Span::new(at, at + name.len()));
            edits.extend(others.map(|span| Edit { file: self.file(), span, insert: written.clone() }));
        }
        let found = self.error("E0114", "`-` is not allowed in names", at, format!("in the name `{text}`")).fix_edits(
            Safe,
            format!("write `{written}`"),
            edits,
        );
        self.push(found);
    }

    /// POV-Ray's `<0, 1, 0>`
    pub(super) fn angle_vector(&mut self, start: u32) {
        let line = self.source.line_span(self.source.line_index(start));
        let rest = self.text(Span::new(start, line.end.min(start.saturating_add(256))));
        let mut found = self.error(
            "E0125",
            "vectors are written `(0, 1, 0)`",
            Span::new(start, start + 1),
            "`<` compares two values",
        );
        if let Some(end) = rest.find('>') {
            let inside = rest.get(1..end).unwrap_or_default();
            let written = written_vector(inside);
            let span = Span::new(start, start + end as u32 + 1);
            let applicability = if inside.contains(['(', '<', '"']) { Maybe } else { Safe };
            found = found.fix(applicability, format!("write `{written}`"), self.file(), span, written);
        }
        self.push(found);
    }
}

/// What is between `<` and `>` as a vector.
pub(super) fn written_vector(inside: &str) -> String {
    format!("({})", inside.split(',').map(|value| with_digit(value.trim())).collect::<Vec<_>>().join(", "))
}

/// `.5` as `0.5`
fn with_digit(value: &str) -> String {
    match value.strip_prefix("-.").map(|rest| ("-0.", rest)).or(value.strip_prefix('.').map(|rest| ("0.", rest))) {
        Some((start, rest)) => format!("{start}{rest}"),
        None => value.to_string(),
    }
}

/// `else if` in one word, as other languages have it.
pub(super) fn is_else_if(word: &str) -> bool {
    matches!(word, "elseif" | "elif" | "elsif" | "elsf")
}
