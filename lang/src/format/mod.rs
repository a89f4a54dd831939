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
use rowan::NodeOrToken;

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
        [] => stable(tree).ok_or_else(|| vec![changed()]),
        errors => Err(errors.to_vec()),
    }
}

/// As [`format`], of a text with mistakes too: the items and lines that have some stay as they are.
///
/// # Errors
/// E1007, if the result would not mean the same.
pub fn format_partial(tree: &Tree) -> Result<String, Box<Diagnostic>> {
    stable(tree).ok_or_else(|| Box::new(changed()))
}

fn changed() -> Diagnostic {
    Diagnostic::new("E1007", "this is a bug in the tool")
        .note("the text laid out anew would not mean the same, so it stays as it is")
        .help("please report it, with the scene that shows it")
}

fn stable(tree: &Tree) -> Option<String> {
    let said = content(tree);
    let mut tree = tree.clone();
    for _ in 0..MOST_ROUNDS {
        let crlf = tree.source.text.split_once('\n').is_some_and(|(line, _)| line.ends_with('\r'));
        let mut text = print::print(&build::file(&tree));
        if crlf {
            text = text.replace("\r\n", "\n").replace('\n', "\r\n");
        }
        if *text == *tree.source.text {
            return Some(text);
        }
        // One mistake a line is reported, so their number may change.
        let faulty = !tree.errors().is_empty();
        tree = parse(&Source::new(tree.source.id, tree.source.name.clone(), text));
        if !tree.errors().is_empty() != faulty || content(&tree) != said {
            return None;
        }
    }
    None
}

/// What a text says: its tokens without separators, and its comments in any order. `a .b` and `a.b` are the same, and so
/// are `- 1` and `-1`.
fn content(tree: &Tree) -> (Vec<String>, Vec<String>) {
    let (mut tokens, mut comments) = (Vec::new(), Vec::new());
    for token in tree.root().descendants_with_tokens().filter_map(NodeOrToken::into_token) {
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
