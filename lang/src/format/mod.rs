//! The one way a scene is laid out: `kinora fmt`.
//!
//! There is nothing to choose. Indentation is four spaces, a line has [100](WIDTH) columns as far as there is a place to
//! end it, and what the author decides is which blocks are on one line: a block whose `{` ends its line is not. Text
//! within tokens stays, but for the digits of colours, which become lower case. Comments stay with what they are about,
//! and of several empty lines one stays.
//!
//! A tree becomes a layout ([`doc`]), and a layout text ([`print`]). The text is read again before it is given away: the
//! same tokens, but for separators, and the same comments must be in it.

mod build;
mod doc;
mod print;
mod trivia;

use crate::diagnostic::Diagnostic;
use crate::source::Source;
use crate::syntax::{SyntaxKind, Tree, parse};
use build::Round;

/// Columns of a line, as far as there is a place to end it.
pub const WIDTH: usize = 100;

/// A layout is laid out again until it stays: comments in odd places may find theirs in a second round.
const MOST_ROUNDS: usize = 8;

/// The text of a file as it should be laid out.
///
/// ```
/// use kinora_lang::format::format;
/// use kinora_lang::source::{FileId, Source};
/// let tree = kinora_lang::parse(&Source::new(FileId(0), "a.kin", "sphere  ball{radius :50cm ;color:#FFF}"));
/// assert_eq!(format(&tree).unwrap(), "sphere ball { radius: 50cm, color: #fff }\n");
/// ```
///
/// # Errors
/// The mistakes of a text that has some; or E1007, if the result would not mean the same.
pub fn format(tree: &Tree) -> Result<String, Vec<Diagnostic>> {
    match tree.errors() {
        [] => stable(tree, |tree| lay_out(tree, Round::Item)).ok_or_else(|| vec![changed()]),
        errors => Err(errors.to_vec()),
    }
}

/// As [`format`], of a text with mistakes too: the items that have some stay as they are, with all on their lines. Where
/// that would not mean the same, more round a mistake stays, and in the end all of it.
pub fn format_partial(tree: &Tree) -> String {
    let step = |tree: &Tree| lay_out(tree, Round::Item).or_else(|| lay_out(tree, Round::Top));
    stable(tree, step).unwrap_or_else(|| tree.source.text.to_string())
}

fn changed() -> Diagnostic {
    Diagnostic::new("E1007", "this is a bug in the tool")
        .note("the text laid out anew would not mean the same, so it stays as it is")
        .help("please report it, with the scene that shows it")
}

fn stable(tree: &Tree, step: impl Fn(&Tree) -> Option<Tree>) -> Option<String> {
    let mut tree = tree.clone();
    for _ in 0..MOST_ROUNDS {
        let next = step(&tree)?;
        if next.source.text == tree.source.text {
            return Some(next.source.text.to_string());
        }
        tree = next;
    }
    None
}

/// The text laid out and read again; nothing if it does not say the same.
fn lay_out(tree: &Tree, round: Round) -> Option<Tree> {
    let Source { id, name, text, .. } = &tree.source;
    let crlf = text.split_once('\n').is_some_and(|(line, _)| line.ends_with('\r'));
    let mut laid_out = print::print(&build::file(tree, round));
    if crlf {
        laid_out = laid_out.replace("\r\n", "\n").replace('\n', "\r\n");
    }
    if *laid_out == **text {
        return Some(tree.clone());
    }
    let next = parse(&Source::new(*id, name.clone(), laid_out));
    // One mistake a line is reported, so their number may change.
    let same = tree.errors().is_empty() == next.errors().is_empty() && content(tree) == content(&next);
    same.then_some(next)
}

/// What a text says: its tokens without separators, and its comments in any order. `a .b` and `a.b` are the same, and so
/// are `- 1` and `-1`.
fn content(tree: &Tree) -> (Vec<String>, Vec<String>) {
    let (mut tokens, mut comments) = (Vec::new(), Vec::new());
    for token in tree.root().tokens() {
        let text = token.text();
        match token.kind() {
            SyntaxKind::LineComment | SyntaxKind::DocComment | SyntaxKind::BlockComment => {
                comments.push(text.trim_end().replace("\r\n", "\n"));
            }
            kind if trivia::is_between(kind) => {}
            SyntaxKind::Path => {
                for (at, name) in text.split('.').enumerate() {
                    tokens.extend((at > 0).then(|| ".".to_string()));
                    tokens.push(name.to_string());
                }
            }
            SyntaxKind::Digits => match text.strip_prefix('-') {
                Some(digits) => tokens.extend(["-".to_string(), digits.to_string()]),
                None => tokens.push(text.to_string()),
            },
            SyntaxKind::Color => tokens.push(text.to_ascii_lowercase()),
            _ => tokens.push(text.trim_end().replace("\r\n", "\n")),
        }
    }
    comments.sort();
    (tokens, comments)
}
