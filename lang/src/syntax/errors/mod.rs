//! The mistakes of a tree, from its error nodes and from what the grammar lets pass on purpose.
//!
//! At most one a line: what a mistake drags after it is mostly on its own line, and the next run shows the rest.

mod bad;
mod between;
mod brackets;
mod confusable;
mod leaves;
mod missing;
mod shape;
mod units;

use super::ast::MAX_DEPTH;
use super::expr::depth_cost;
use super::kind::SyntaxKind;
use super::lower::parts;
use super::part::Part;
use super::scan::MAX_NESTING;
use crate::diagnostic::{Diagnostic, MOST};
use crate::source::{FileId, Source, Span};
use std::collections::{BTreeMap, BTreeSet};

/// What [`find`] finds.
pub(super) struct Found {
    pub errors: Vec<Diagnostic>,
    /// Whether an expression is deeper than [`MAX_DEPTH`].
    pub too_deep: bool,
}

/// All mistakes of a tree, in the order of the text. `stopped` is where parsing had to stop, if it had; `has_bad` is
/// whether some text could not be read.
pub(super) fn find(source: &Source, root: Part<'_>, stopped: Option<u32>, has_bad: bool) -> Found {
    let mut finder = Finder::new(source, root, stopped, has_bad);
    if let Some(offset) = stopped {
        finder.nested(Span::new(offset, offset + 1), MAX_NESTING as u32);
    }
    leaves::control_characters(&mut finder, root.span());
    let mut depth = 0u32;
    // The nodes that are open, and what each costs.
    let mut open: Vec<(u32, Part<'_>)> = Vec::new();
    let mut too_deep = false;
    for part in root.all() {
        if !part.kind().is_node() {
            if part.span().start >= finder.passed {
                finder.token(part);
            }
            continue;
        }
        while let Some((cost, _)) = open.pop_if(|(_, node)| !node.holds(part)) {
            depth = depth.saturating_sub(cost);
        }
        let cost = depth_cost(part);
        open.push((cost, part));
        depth = depth.saturating_add(cost);
        if depth > MAX_DEPTH && !too_deep {
            too_deep = true;
            finder.nested(part.span(), MAX_DEPTH);
        }
        if part.span().start >= finder.passed {
            finder.node(part);
        }
    }
    Found { errors: finder.finish(), too_deep }
}

struct Finder<'a> {
    source: &'a Source,
    /// Urgent or not, and the finding.
    found: Vec<(bool, Diagnostic)>,
    /// Unread text: start to end, and whether it is inside of a bracket.
    bad: BTreeMap<u32, Bad>,
    /// Unread text that is reported together with what is missing before it.
    merged: BTreeSet<u32>,
    /// Brackets inside of unterminated strings: they were meant to be outside.
    swallowed: Vec<(u32, char)>,
    /// The first `{` among them.
    swallowed_brace: Option<u32>,
    /// Offset from which on everything is cut off, or swallowed by an unclosed comment.
    lost: Option<u32>,
    /// Where something is known to be missing already.
    missing_at: Option<u32>,
    /// The first error node or token, of whatever kind.
    first_error: Option<Span>,
    /// The line of the last finding, how many there are on it in a row, and up to where it is therefore passed over.
    crowd: (u32, usize),
    passed: u32,
    /// Parts that were looked through for the cause of stray brackets.
    searched: usize,
    /// Keywords that were used as names, which is reported.
    keywords: BTreeSet<&'a str>,
    /// Blocks that were meant as vectors, which is reported.
    braced: BTreeSet<u32>,
    /// How many names have been looked for in the whole text.
    renamed: usize,
}

/// Of so many findings on one line, of which one is reported, the rest of the line is passed over.
const CROWD: usize = 64;

/// So many names are looked for in the whole text, so that a fix changes all of them.
const RENAMED: usize = 16;

/// Text that no rule could read.
#[derive(Debug, Clone, Copy)]
struct Bad {
    span: Span,
    /// Whether it is in a bracket, where values are separated by `,`.
    is_elem: bool,
}

impl<'a> Finder<'a> {
    fn new(source: &'a Source, root: Part<'_>, stopped: Option<u32>, has_bad: bool) -> Finder<'a> {
        let mut bad = BTreeMap::new();
        let mut lost = stopped;
        let mut swallowed = Vec::new();
        for token in root.tokens().take_while(|_| has_bad) {
            let span = token.span();
            match token.kind() {
                SyntaxKind::BadItem | SyntaxKind::BadElem => {
                    bad.insert(span.start, Bad { span, is_elem: token.kind() == SyntaxKind::BadElem });
                    if let Some(at) = bad::open_quote(token.text()) {
                        swallowed.extend(brackets::brackets_in(&token.text()[at..], span.start + at as u32));
                    }
                    if let Some(at) = leaves::open_comment(token.text()) {
                        lost = Some(span.start + at as u32);
                    }
                }
                SyntaxKind::BadString => swallowed.extend(brackets::brackets_in(token.text(), span.start)),
                SyntaxKind::BlockComment if leaves::open_comment(token.text()).is_some() => lost = Some(span.start),
                _ => {}
            }
        }
        let lost = lost.map(|offset| source.slice(Span::new(0, offset)).trim_end().len() as u32);
        let swallowed_brace = swallowed.iter().find(|(_, sign)| *sign == '{').map(|(at, _)| *at);
        Finder {
            swallowed_brace,
            source,
            found: Vec::new(),
            bad,
            merged: BTreeSet::new(),
            swallowed,
            lost,
            missing_at: None,
            first_error: None,
            crowd: (u32::MAX, 0),
            passed: 0,
            searched: 0,
            keywords: BTreeSet::new(),
            braced: BTreeSet::new(),
            renamed: 0,
        }
    }

    fn file(&self) -> FileId {
        self.source.id
    }

    fn text(&self, span: Span) -> &'a str {
        self.source.slice(span)
    }

    fn push(&mut self, diagnostic: Diagnostic) {
        if let Some((_, span)) = diagnostic.place() {
            let line = self.source.line_index(span.start);
            self.crowd = (line, if self.crowd.0 == line { self.crowd.1 + 1 } else { 1 });
            if self.crowd.1 > CROWD {
                self.passed = self.source.line_start(line + 1);
            }
        }
        self.keep(false, diagnostic);
    }

    /// Reports what is the cause where several findings share a line.
    fn push_urgent(&mut self, diagnostic: Diagnostic) {
        self.keep(true, diagnostic);
    }

    fn keep(&mut self, urgent: bool, diagnostic: Diagnostic) {
        if self.found.len() >= MOST {
            self.passed = u32::MAX;
        }
        self.found.push((urgent, diagnostic));
    }

    fn error(
        &self,
        code: &'static str,
        message: impl Into<String>,
        span: Span,
        label: impl Into<String>,
    ) -> Diagnostic {
        Diagnostic::new(code, message).primary(self.file(), span, label)
    }

    fn nested(&mut self, span: Span, limit: u32) {
        let message = format!("nesting is deeper than {limit} levels");
        let found = self.error("E0122", message, span, "one level too many");
        self.push_urgent(found.help("split it: prefabs for nodes, `let` for values"));
    }

    fn finish(mut self) -> Vec<Diagnostic> {
        // Each error node may count on another one being reported; a tree with errors must not pass for one without.
        if let (true, Some(span)) = (self.found.is_empty(), self.first_error) {
            let found = self.error("E0127", "unexpected text", span, "cannot be read");
            self.push(found);
        }
        let place = |found: &Diagnostic| found.place().map_or(0, |(_, span)| span.start);
        self.found.sort_by_key(|(urgent, found)| (self.source.line_index(place(found)), !urgent, place(found)));
        self.found.dedup_by_key(|(_, found)| self.source.line_index(place(found)));
        self.found.into_iter().map(|(_, found)| found).collect()
    }

    fn token(&mut self, token: Part<'_>) {
        if token.kind().is_error() {
            self.first_error = self.first_error.or(Some(token.span()));
        }
        match token.kind() {
            SyntaxKind::BlockComment => self.block_comment(token),
            SyntaxKind::String => self.string(token),
            SyntaxKind::Color => self.color(token),
            SyntaxKind::BadUnit => self.bad_unit(token),
            SyntaxKind::BadString => self.bad_string(token.span()),
            SyntaxKind::BadName => {
                self.keywords.insert(self.text(token.span()));
                self.keyword_as_name(token.span());
            }
            SyntaxKind::ExtraComma => self.extra_comma(token.span()),
            SyntaxKind::StrayClose => self.stray_close(token),
            SyntaxKind::BadItem | SyntaxKind::BadElem => {
                let span = token.span();
                if let Some(at) = leaves::open_comment(token.text()) {
                    self.open_comment(span.start + at as u32);
                }
                if !self.merged.contains(&span.start) && !self.runs_on(token) {
                    self.bad_with(Bad { span, is_elem: token.kind() == SyntaxKind::BadElem }, None);
                }
            }
            _ => {}
        }
    }

    fn node(&mut self, node: Part<'_>) {
        if node.kind().is_error() {
            self.first_error = self.first_error.or(Some(node.span()));
        }
        match node.kind() {
            SyntaxKind::Missing => self.missing(node),
            SyntaxKind::Unclosed => self.unclosed(node),
            SyntaxKind::NoComma => self.no_comma(node),
            SyntaxKind::EqProperty => self.eq_property(node),
            SyntaxKind::Expr | SyntaxKind::Named => self.chain(node),
            SyntaxKind::Args => self.argument_order(node),
            SyntaxKind::Ty => self.angles(node),
            SyntaxKind::Field => self.number_point(node),
            SyntaxKind::List => self.comprehension(node),
            SyntaxKind::File | SyntaxKind::Block => self.separators(node),
            SyntaxKind::OneValue => self.after_value(node),
            _ => {}
        }
        match node.kind() {
            SyntaxKind::Block => self.orphan(node),
            SyntaxKind::Node => self.else_if(node),
            _ => {}
        }
    }

    /// Whether an error at the offset only says that the text was cut off there.
    fn is_lost(&self, offset: u32) -> bool {
        self.lost.is_some_and(|lost| offset >= lost)
    }

    /// Unread text that follows on the same line, behind spaces only.
    fn bad_after(&self, offset: u32) -> Option<Bad> {
        let line = self.source.line_span(self.source.line_index(offset));
        let rest = self.text(Span::new(offset, line.end));
        let start = offset + (rest.len() - rest.trim_start_matches([' ', '\t']).len()) as u32;
        self.bad.get(&start).copied()
    }
}

/// The nearest part before this one that means something.
fn before(part: Part<'_>) -> Option<Part<'_>> {
    std::iter::successors(part.previous(), |part| part.previous()).find(|part| !part.kind().is_trivia())
}

/// A piece of the text for a message: one line, cut where it is long.
fn excerpt(text: &str) -> String {
    let text = text.trim();
    let line = text.lines().next().unwrap_or_default().trim_end();
    let short: String = line.chars().take(40).collect();
    match short.len() < text.len() {
        true => format!("{}...", short.trim_end()),
        false => short,
    }
}
