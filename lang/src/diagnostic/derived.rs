//! What is left out because a syntax error explains it: a mistake is said once.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::Diagnostic;
use crate::source::{FileId, Source, Span};
use crate::syntax::block_end;

/// Errors after which all that is written is known.
const LOSES_NOTHING: &[&str] = &["E0106", "E0115", "E0116", "E0118"];

/// Errors in the head of something: what it declares, on whatever line, is not known.
const IN_HEADS: &[&str] = &["E0103", "E0112", "E0113", "E0114"];

/// What the syntax errors of one file put in doubt.
#[derive(Default)]
struct Doubt<'s> {
    /// Where they are.
    places: BTreeSet<u32>,
    /// The words of their lines: what is declared or used there is perhaps not known.
    words: HashSet<String>,
    lines: HashSet<u32>,
    /// Of the lines, those of heads and those of conditions.
    heads: HashSet<u32>,
    conditions: HashSet<u32>,
    /// From where a block was closed too early to where that shows.
    astray: Option<Span>,
    /// Where the first block that is never closed should have ended.
    open_from: Option<u32>,
    source: Option<&'s Source>,
}

/// Leaves out of `found` what follows from syntax errors: what is said of a text that has one inside, names that their
/// lines may declare or use, and what stands in the wrong block because one was never closed.
pub fn without_derived(found: &mut Vec<Diagnostic>, syntax: &[Diagnostic], sources: &[Source]) {
    let mut doubts: HashMap<FileId, Doubt<'_>> = HashMap::new();
    for error in syntax.iter().filter(|error| error.code.starts_with("E01")) {
        let Some((file, span)) = error.place() else { continue };
        let Some(source) = sources.iter().find(|source| source.id == file) else { continue };
        let doubt = doubts.entry(file).or_default();
        doubt.source = Some(source);
        doubt.places.insert(span.start);
        if error.code == "E0101" {
            let from = error.labels.get(1).map_or(span.start, |label| label.span.start);
            doubt.open_from = Some(doubt.open_from.map_or(from, |before| before.min(from)));
        }
        if let ("E0102", Some(early)) = (error.code, error.labels.get(1)) {
            doubt.astray = doubt.astray.or(Some(Span::new(early.span.start, span.end)));
        }
        let line = source.line_index(span.start);
        if IN_HEADS.contains(&error.code) {
            doubt.heads.insert(line);
        }
        if error.code == "E0126" {
            doubt.conditions.insert(line);
        }
        if let ("E0108", Some(next)) = (error.code, error.labels.get(1)) {
            doubt.places.extend([next.span.start, next.span.end.saturating_sub(1)]);
            doubt.words.extend(source.slice(next.span).split_whitespace().map(str::to_string));
        }
        if !LOSES_NOTHING.contains(&error.code) && doubt.lines.insert(line) {
            let text = source.slice(source.line_span(line));
            let no_word = |character: char| !unicode_ident::is_xid_continue(character);
            let parts = text.split(no_word);
            let joined = text.split(|character| character != '-' && no_word(character));
            let joined = joined.filter(|word| word.contains('-')).map(|word| word.replace('-', "_"));
            doubt.words.extend(parts.filter(|word| !word.is_empty()).map(str::to_string).chain(joined));
        }
    }
    if !doubts.is_empty() {
        found.retain(|found| {
            let Some((file, span)) = found.place() else { return true };
            doubts.get(&file).is_none_or(|doubt| !doubt.explains(found.code, span))
        });
    }
}

impl Doubt<'_> {
    fn explains(&self, code: &str, span: Span) -> bool {
        let name = || self.source.map_or("", |source| source.slice(span));
        let on =
            |lines: &HashSet<u32>| self.source.is_some_and(|source| lines.contains(&source.line_index(span.start)));
        let own_line = || on(&self.lines) && !on(&self.heads);
        match code {
            "W0201" if self.words.contains(name()) => true,
            "E0215" if self.astray.is_some_and(|astray| astray.start < span.start && span.start < astray.end) => true,
            "E0311" if on(&self.conditions) => true,
            "E0207" | "E0209" if self.holds_place(span.end) => true,
            "E0215" | "E0707" if self.open_from.is_some_and(|from| span.start >= from) => true,
            "E0202" | "E0203" | "E0210" if !own_line() && self.words.contains(name()) => true,
            _ => self.places.range(span.start..span.end).next().is_some(),
        }
    }

    /// Whether one of the errors is in the block that begins on the line of an offset: what it does not set is perhaps
    /// in what could not be read.
    fn holds_place(&self, offset: u32) -> bool {
        let Some(source) = self.source else { return false };
        let line = source.line_span(source.line_index(offset));
        let Some(open) = source.slice(Span::new(offset, line.end)).find('{') else { return false };
        let open = offset + open as u32;
        let end = block_end(&source.text, open as usize) as u32;
        self.places.range(open..end).next().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, syntax: (&'static str, &str), found: (&'static str, &str), stays: bool) {
        let at = |(code, part): (&'static str, &str)| {
            let start = text.rfind(part).unwrap() as u32;
            Diagnostic::new(code, "m").primary(FileId(0), Span::new(start, start + part.len() as u32), "")
        };
        let mut list = vec![at(found)];
        without_derived(&mut list, &[at(syntax)], &[Source::new(FileId(0), "a.kin", text)]);
        assert_eq!(!list.is_empty(), stays, "{text}");
    }

    #[test]
    fn a_mistake_is_said_once() {
        check("diffuse my-red { }\nbox { material: my_red }", ("E0114", "-"), ("E0203", "my_red"), false);
        check("diffuse my-red { }\nbox { material: blue }", ("E0114", "-"), ("E0203", "blue"), true);
        check("box { radius 1, material: blue }", ("E0105", " 1"), ("E0203", "blue"), true);
        check("let a = [1, 2\nbox { }", ("E0104", "["), ("W0201", "a"), false);
        check("mesh { file: \"C:\\m\" }", ("E0111", "\\m"), ("E0704", "\"C:\\m\""), false);
        check("box a {\nbox b { }", ("E0101", "a {"), ("E0215", "b"), false);
        check("box a { }\nbox b { ", ("E0101", "b {"), ("E0215", "a"), true);
    }
}
