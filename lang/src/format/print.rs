//! Layouts to text.

use super::WIDTH;
use super::doc::{Doc, Kind};

/// Columns of a step to the right.
const STEP: usize = 4;
/// Code of up to so many columns has its comments aligned with those of its neighbours.
const ALIGNED: usize = 60;

/// Lays it out. Ends with one line break, or is empty.
pub(super) fn print(doc: &Doc<'_>) -> String {
    let mut printer = Printer { lines: vec![Line::default()], fresh: true };
    printer.run(doc);
    finish(printer.lines)
}

#[derive(Default)]
struct Line {
    indent: usize,
    /// May hold line breaks, of comments and of what stays as it is.
    code: String,
    /// Columns, the indentation included; of the last line of `code`.
    width: usize,
    /// What comes last.
    comment: String,
}

struct Printer {
    lines: Vec<Line>,
    /// Nothing is on the last line, and it is not yet indented.
    fresh: bool,
}

#[derive(Clone, Copy)]
struct Command<'d, 'a> {
    indent: usize,
    flat: bool,
    doc: &'d Doc<'a>,
}

impl Printer {
    fn run(&mut self, doc: &Doc<'_>) {
        let mut stack = vec![Command { indent: 0, flat: false, doc }];
        while let Some(Command { indent, flat, doc }) = stack.pop() {
            match &doc.kind {
                Kind::Text(text) => self.text(indent, text),
                Kind::Space => self.space(),
                Kind::Line { flat: text, .. } if flat => match *text {
                    " " => self.space(),
                    text => self.text(indent, text),
                },
                Kind::Line { blank, .. } | Kind::Hard { blank } => self.end_line(*blank),
                Kind::Fill if flat => self.text(indent, ", "),
                Kind::Fill => {
                    self.text(indent, ",");
                    let waiting = !self.last().comment.is_empty();
                    let room = WIDTH.saturating_sub(self.last().width + 1);
                    if waiting || !fits(&[], &stack, room) { self.end_line(false) } else { self.space() }
                }
                Kind::Fresh if !self.fresh => self.end_line(false),
                Kind::Fresh | Kind::Break => {}
                Kind::IfBroken(text) if !flat => self.text(indent, text),
                Kind::IfBroken(_) => {}
                Kind::Suffix(text) => self.suffix(indent, text),
                Kind::Concat(parts) => {
                    stack.extend(parts.iter().rev().map(|doc| Command { indent, flat, doc }));
                }
                Kind::Indent(inner) => stack.push(Command { indent: indent + STEP, flat, doc: inner }),
                Kind::Group(inner) => {
                    let width = if self.fresh { indent } else { self.last().width };
                    let whole = Command { indent, flat: true, doc: inner };
                    let flat = flat || !inner.forced && fits(&[whole], &stack, WIDTH.saturating_sub(width));
                    stack.push(Command { indent, flat, doc: inner });
                }
            }
        }
    }

    fn last(&mut self) -> &mut Line {
        if self.lines.is_empty() {
            self.lines.push(Line::default());
        }
        let at = self.lines.len() - 1;
        &mut self.lines[at]
    }

    fn text(&mut self, indent: usize, text: &str) {
        if text.is_empty() {
            return;
        }
        let fresh = std::mem::take(&mut self.fresh);
        let line = self.last();
        if fresh {
            line.indent = indent;
            line.width = indent;
        }
        line.code.push_str(text);
        line.width = match text.rsplit_once('\n') {
            Some((_, last)) => last.chars().count(),
            None => line.width + text.chars().count(),
        };
    }

    fn space(&mut self) {
        let fresh = self.fresh;
        let line = self.last();
        if !fresh && !line.code.ends_with([' ', '(', '[']) {
            line.code.push(' ');
            line.width += 1;
        }
    }

    fn end_line(&mut self, blank: bool) {
        self.fresh = true;
        self.lines.push(Line::default());
        if blank {
            self.lines.push(Line::default());
        }
    }

    fn suffix(&mut self, indent: usize, text: &str) {
        let comment = &mut self.last().comment;
        if comment.starts_with("/*") && comment.ends_with("*/") {
            comment.push(' ');
        } else if !comment.is_empty() {
            // A second one would become a part of the first.
            self.end_line(false);
        }
        if self.fresh {
            self.text(indent, text);
            return self.end_line(false);
        }
        self.last().comment.push_str(text);
    }
}

/// Whether what comes first, and what follows up to a place where a line may end, has room.
fn fits<'d, 'a>(first: &[Command<'d, 'a>], rest: &[Command<'d, 'a>], mut room: usize) -> bool {
    let mut open = first.to_vec();
    let mut rest = rest.iter().rev();
    loop {
        let Some(Command { indent, flat, doc }) = open.pop().or_else(|| rest.next().copied()) else { return true };
        let needed = match &doc.kind {
            Kind::Text(text) => match text.split_once('\n') {
                Some((first, _)) => return first.chars().count() <= room,
                None => text.chars().count(),
            },
            Kind::Space => 1,
            Kind::Line { flat: text, .. } if flat => text.len(),
            Kind::Fill if flat => 2,
            Kind::Fill => return room >= 1,
            Kind::Line { .. } | Kind::Hard { .. } | Kind::Fresh => return true,
            Kind::Break | Kind::Suffix(_) => 0,
            Kind::IfBroken(text) => {
                if flat {
                    0
                } else {
                    text.len()
                }
            }
            Kind::Concat(parts) => {
                open.extend(parts.iter().rev().map(|doc| Command { indent, flat, doc }));
                0
            }
            Kind::Indent(doc) | Kind::Group(doc) => {
                open.push(Command { indent, flat, doc });
                0
            }
        };
        let Some(left) = room.checked_sub(needed) else { return false };
        room = left;
    }
}

fn finish(lines: Vec<Line>) -> String {
    let mut out = String::new();
    let mut at = 0;
    while at < lines.len() {
        let run = lines[at..].iter().take_while(|line| is_aligned(line, lines[at].indent)).count();
        let column = lines[at..at + run].iter().map(|line| line.code.trim_end().chars().count()).max().unwrap_or(0);
        for line in &lines[at..at + run.max(1)] {
            let code = line.code.trim_end_matches(' ');
            if !code.is_empty() {
                out.extend(std::iter::repeat_n(' ', line.indent));
                out.push_str(code);
            }
            if !line.comment.is_empty() {
                let pad = column.saturating_sub(if run > 0 { code.chars().count() } else { column });
                out.extend(std::iter::repeat_n(' ', pad + 1));
                out.push_str(&line.comment);
            }
            out.push('\n');
        }
        at += run.max(1);
    }
    let end = out.trim_end_matches('\n').len();
    out.truncate(end);
    if end > 0 {
        out.push('\n');
    }
    out
}

fn is_aligned(line: &Line, indent: usize) -> bool {
    let has_comment = !line.comment.is_empty() && !line.comment.contains('\n') && !line.code.contains('\n');
    has_comment && line.indent == indent && line.width <= ALIGNED
}
