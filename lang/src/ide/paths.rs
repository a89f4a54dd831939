//! Files that a text names.

use crate::files::resolve;
use crate::library;
use crate::source::Span;
use crate::syntax::{Part, SyntaxKind as K, Tree};

use super::cursor::{Slot, called, slot};

/// A file that is named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathAt {
    /// The text between the quotes.
    pub span: Span,
    /// As written.
    pub written: String,
    /// From the project's root; `std/...` of what is part of this program.
    pub path: String,
}

/// The files that a text names, in its order: imports, `file:` and pictures.
pub fn paths(tree: &Tree) -> Vec<PathAt> {
    let tokens = tree.root().tokens().filter(|token| token.kind() == K::String && names_file(*token));
    tokens.filter_map(|token| path_at(tree, token)).collect()
}

fn names_file(token: Part<'_>) -> bool {
    if token.parent().is_some_and(|parent| parent.kind() == K::ImportDecl) {
        return true;
    }
    match slot(token) {
        Slot::Property { name, .. } => name == "file",
        Slot::Argument { args, .. } => matches!(called(args), Some("image" | "normal_map")),
        _ => false,
    }
}

fn path_at(tree: &Tree, token: Part<'_>) -> Option<PathAt> {
    let span = token.span();
    let written = token.text().strip_prefix('"')?.strip_suffix('"')?;
    if written.contains('\\') {
        return None;
    }
    let path = match library::is_path(written) {
        true => written.to_string(),
        false => resolve(&tree.source.name, written).ok()?,
    };
    Some(PathAt { span: Span::new(span.start + 1, span.end - 1), written: written.into(), path })
}

/// How the paths of a text are to be written when files move: `now` says where a file of the project will be. The text
/// itself may be one that moves.
pub fn moved(tree: &Tree, now: &dyn Fn(&str) -> String) -> Vec<(Span, String)> {
    let own = now(&tree.source.name);
    let found = paths(tree).into_iter().filter(|named| !library::is_path(&named.path));
    found
        .filter_map(|named| {
            let to = now(&named.path);
            if to == named.path && own == *tree.source.name {
                return None;
            }
            let written = match named.written.starts_with('/') {
                true => format!("/{to}"),
                false => relative(&own, &to),
            };
            // As it is where it still leads there: `./a` and the like.
            let stays = resolve(&own, &named.written).is_ok_and(|path| path == to);
            let written = written.replace('\\', "\\\\").replace('"', "\\\"");
            (!stays).then_some((named.span, written))
        })
        .collect()
}

/// The path to `to` as seen from the file `from`, both from the project's root.
fn relative(from: &str, to: &str) -> String {
    let folders: Vec<&str> = from.split('/').collect();
    let folders = &folders[..folders.len() - 1];
    let parts: Vec<&str> = to.split('/').collect();
    let same = folders.iter().zip(&parts[..parts.len() - 1]).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..", folders.len() - same);
    up.chain(parts[same..].iter().copied()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_file_to_file() {
        assert_eq!(relative("a.kin", "b.kin"), "b.kin");
        assert_eq!(relative("scenes/a.kin", "lib/b.kin"), "../lib/b.kin");
        assert_eq!(relative("a/b/c.kin", "a/d.kin"), "../d.kin");
        assert_eq!(relative("a.kin", "a/d.kin"), "a/d.kin");
    }
}
