//! The layouts a piece of text may take: text, places where a line may end, and groups that end all of them or none.
//!
//! After Wadler, "A prettier printer" (2003), with the comments of Prettier: one at the end of a line waits until the
//! line ends, whatever else still comes on it.

use std::borrow::Cow;

/// A layout.
pub(super) struct Doc<'a> {
    pub kind: Kind<'a>,
    /// Cannot be on one line.
    pub forced: bool,
    /// A comment in it waits for the line's end.
    waits: bool,
    /// A line may end in it.
    has_line: bool,
}

pub(super) enum Kind<'a> {
    /// As it is; line breaks in it are kept, and nothing is indented behind them.
    Text(Cow<'a, str>),
    /// A space, but not at a line's start, behind another or behind an opening bracket.
    Space,
    /// Written instead where its group is on one line; otherwise the line ends, with an empty one behind it if `blank`.
    Line {
        flat: &'static str,
        blank: bool,
    },
    /// The line ends if what follows, up to the next place of the kind, has no room on it.
    Fill,
    /// The line ends.
    Hard {
        blank: bool,
    },
    /// The line ends, if there is anything on it.
    Fresh,
    /// Nothing: the group is not on one line.
    Break,
    /// Only where the group is not on one line.
    IfBroken(&'static str),
    /// A comment that comes last on the line.
    Suffix(Cow<'a, str>),
    Concat(Vec<Doc<'a>>),
    /// Lines that start in it are one step further in.
    Indent(Box<Doc<'a>>),
    /// On one line if there is room, else all places that may end a line end one.
    Group(Box<Doc<'a>>),
}

impl<'a> Doc<'a> {
    fn new(kind: Kind<'a>) -> Doc<'a> {
        let mut doc = Doc { forced: false, waits: false, has_line: false, kind };
        match &doc.kind {
            Kind::Text(text) => doc.forced = text.contains('\n'),
            Kind::Space | Kind::IfBroken(_) => {}
            Kind::Line { .. } | Kind::Fill => doc.has_line = true,
            Kind::Hard { .. } | Kind::Fresh | Kind::Break => doc.forced = true,
            Kind::Suffix(_) => doc.waits = true,
            Kind::Concat(parts) => {
                let (mut forced, mut waits, mut has_line) = (false, false, false);
                for part in parts {
                    // The comment would swallow what follows, or be parted from what it is about.
                    forced |= part.forced || waits && (part.has_line || part.waits);
                    waits |= part.waits;
                    has_line |= part.has_line;
                }
                (doc.forced, doc.waits, doc.has_line) = (forced, waits, has_line);
            }
            Kind::Indent(inner) | Kind::Group(inner) => {
                (doc.forced, doc.waits, doc.has_line) = (inner.forced, inner.waits, inner.has_line);
            }
        }
        doc
    }

    pub fn text(text: impl Into<Cow<'a, str>>) -> Doc<'a> {
        Doc::new(Kind::Text(text.into()))
    }

    pub fn space() -> Doc<'a> {
        Doc::new(Kind::Space)
    }

    pub fn line(flat: &'static str, blank: bool) -> Doc<'a> {
        Doc::new(Kind::Line { flat, blank })
    }

    pub fn fill() -> Doc<'a> {
        Doc::new(Kind::Fill)
    }

    pub fn hard(blank: bool) -> Doc<'a> {
        Doc::new(Kind::Hard { blank })
    }

    pub fn fresh() -> Doc<'a> {
        Doc::new(Kind::Fresh)
    }

    pub fn forced_break() -> Doc<'a> {
        Doc::new(Kind::Break)
    }

    pub fn if_broken(text: &'static str) -> Doc<'a> {
        Doc::new(Kind::IfBroken(text))
    }

    pub fn suffix(text: impl Into<Cow<'a, str>>) -> Doc<'a> {
        Doc::new(Kind::Suffix(text.into()))
    }

    pub fn concat(parts: Vec<Doc<'a>>) -> Doc<'a> {
        Doc::new(Kind::Concat(parts))
    }

    pub fn indent(self) -> Doc<'a> {
        Doc::new(Kind::Indent(Box::new(self)))
    }

    pub fn group(self) -> Doc<'a> {
        Doc::new(Kind::Group(Box::new(self)))
    }
}
