//! Which comment belongs to which token.

use std::collections::HashMap;

use crate::syntax::{Part, SyntaxKind};

/// A comment before a token.
#[derive(Debug)]
pub(super) struct Comment {
    pub text: String,
    /// The line ends behind it.
    pub own_line: bool,
    /// An empty line stands before it.
    pub blank: bool,
}

/// What stands round a token.
#[derive(Debug, Default)]
pub(super) struct Around {
    pub before: Vec<Comment>,
    /// Comments at the end of its line.
    pub after: Vec<String>,
    /// An empty line stands right before it, behind the comments.
    pub blank: bool,
}

/// Tokens that have something round them, by where they start; the end of the text is one too.
pub(super) struct Trivia {
    around: HashMap<u32, Around>,
    end: Around,
}

/// `,` and `;` where they may as well be absent, and what has no meaning at all.
pub(super) fn is_between(kind: SyntaxKind) -> bool {
    kind.is_trivia() || matches!(kind, SyntaxKind::Comma | SyntaxKind::Semicolon)
}

impl Trivia {
    pub fn of(root: Part<'_>) -> Trivia {
        let mut trivia = Trivia { around: HashMap::new(), end: Around::default() };
        let mut gap = Gap::default();
        let mut previous: Option<u32> = None;
        for token in root.tokens() {
            if is_between(token.kind()) {
                gap.add(token);
                continue;
            }
            let start = token.span().start;
            let (after, around) = std::mem::take(&mut gap).split(previous.is_some(), false);
            trivia.add_after(previous, after);
            if !around.before.is_empty() || around.blank {
                trivia.around.insert(start, around);
            }
            previous = Some(start);
        }
        let (after, around) = gap.split(previous.is_some(), true);
        trivia.add_after(previous, after);
        trivia.end = around;
        trivia
    }

    fn add_after(&mut self, token: Option<u32>, after: Vec<String>) {
        if let Some(token) = token.filter(|_| !after.is_empty()) {
            self.around.entry(token).or_default().after = after;
        }
    }

    pub fn around(&self, token: Part<'_>) -> Option<&Around> {
        self.around.get(&token.span().start)
    }

    pub fn end(&self) -> &Around {
        &self.end
    }
}

/// The comments between two tokens, each with the line breaks before it.
#[derive(Default)]
struct Gap {
    comments: Vec<(String, usize)>,
    breaks: usize,
}

impl Gap {
    fn add(&mut self, token: Part<'_>) {
        match token.kind() {
            SyntaxKind::LineComment | SyntaxKind::DocComment | SyntaxKind::BlockComment => {
                let text = token.text().trim_end().replace("\r\n", "\n");
                self.comments.push((text, std::mem::take(&mut self.breaks)));
            }
            _ => self.breaks += token.text().matches('\n').count(),
        }
    }

    /// What belongs to the token before and to the one behind.
    fn split(self, has_previous: bool, is_end: bool) -> (Vec<String>, Around) {
        let Gap { comments, breaks } = self;
        let same_line = comments.iter().take_while(|(_, breaks)| *breaks == 0).count();
        let ends = is_end || breaks > 0 || same_line < comments.len();
        let behind = if has_previous && ends { same_line } else { 0 };
        let breaks_behind: Vec<usize> =
            comments.iter().skip(1).map(|(_, breaks)| *breaks).chain([if is_end { 1 } else { breaks }]).collect();
        let (mut after, mut before) = (Vec::new(), Vec::new());
        for (at, ((text, breaks), breaks_behind)) in comments.into_iter().zip(breaks_behind).enumerate() {
            match at < behind {
                true => after.push(text),
                false => before.push(Comment { text, own_line: breaks_behind > 0, blank: breaks > 1 }),
            }
        }
        (after, Around { before, after: Vec::new(), blank: breaks > 1 })
    }
}
