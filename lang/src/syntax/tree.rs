//! A parsed text.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

use super::ast::{self, File};
use super::parse::{Records, records};
use super::part::Part;
use super::scan::scan;
use super::{errors, expr, lower, shift};
use crate::diagnostic::Diagnostic;
use crate::source::{Source, Span};

/// A text as a lossless tree, and the mistakes in it. Cloning shares both.
#[derive(Debug, Clone)]
pub struct Tree {
    /// The text.
    pub source: Source,
    file: Arc<File>,
    errors: Arc<[Diagnostic]>,
    /// The nodes and tokens; those of a large text are made when they are asked for.
    records: OnceLock<Arc<Records>>,
}

/// Parses a file. Never fails: the leaves of the tree, joined, are the text.
///
/// ```
/// use kinora_lang::source::{FileId, Source};
/// let tree = kinora_lang::parse(&Source::new(FileId(0), "a.kin", "sphere ball { radius: 50cm"));
/// assert_eq!(tree.root().text(), "sphere ball { radius: 50cm");
/// assert_eq!(tree.errors()[0].message, "this `{` is never closed");
/// ```
pub fn parse(source: &Source) -> Tree {
    let scan = scan(&source.text);
    if let Some(file) = in_pieces(source, &scan.cuts) {
        return Tree { source: source.clone(), file: Arc::new(file), errors: Arc::default(), records: OnceLock::new() };
    }
    let records = whole(source, scan.too_deep, false);
    let root = records.root(&source.text);
    let found = errors::find(source, root, scan.too_deep, records.has_bad);
    let file = match found.too_deep {
        true => File { items: Vec::new(), span: root.span() },
        false => lower::file(root),
    };
    let (file, errors) = (Arc::new(file), found.errors.into());
    Tree { source: source.clone(), file, errors, records: OnceLock::from(Arc::new(records)) }
}

/// Parses a single value, as the one behind `-D name=`; returns it with the mistakes in it. Text behind the value is one.
pub fn parse_value(source: &Source) -> (ast::Expr, Vec<Diagnostic>) {
    let too_deep = scan(&source.text).too_deep;
    let records = whole(source, too_deep, true);
    let root = records.root(&source.text);
    let found = errors::find(source, root, too_deep, records.has_bad);
    let value = match lower::parts(root).find(|part| part.kind().is_value()) {
        Some(part) if !found.too_deep => expr::value(part),
        _ => lower::missing_in(root),
    };
    (value, found.errors)
}

fn whole(source: &Source, too_deep: Option<u32>, one_value: bool) -> Records {
    records(&source.text, Span::new(0, source.len()), too_deep.unwrap_or(source.len()), one_value)
}

/// Parses a text in pieces, on all cores; nothing where a piece has a mistake, which is to be seen in the whole text.
fn in_pieces(source: &Source, cuts: &[u32]) -> Option<File> {
    if cuts.is_empty() {
        return None;
    }
    let ends = cuts.iter().copied().chain([source.len()]);
    let spans: Vec<Span> =
        std::iter::once(0).chain(cuts.iter().copied()).zip(ends).map(|(start, end)| Span::new(start, end)).collect();
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || {
        let mut done = Vec::new();
        while let Some(span) = spans.get(next.fetch_add(1, Relaxed)).filter(|_| !failed.load(Relaxed)) {
            match piece(source, *span) {
                Some(items) => done.push((span.start, items)),
                None => failed.store(true, Relaxed),
            }
        }
        done
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(spans.len());
    let mut done = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut done = work();
        for other in others {
            match other.join() {
                Ok(more) => done.extend(more),
                Err(_) => failed.store(true, Relaxed),
            }
        }
        done
    });
    done.sort_unstable_by_key(|(start, _)| *start);
    let items = done.into_iter().flat_map(|(_, items)| items).collect();
    (!failed.into_inner()).then_some(File { items, span: Span::new(0, source.len()) })
}

fn piece(source: &Source, span: Span) -> Option<Vec<ast::Item>> {
    let records = records(&source.text, span, span.end, false);
    let root = records.root(&source.text);
    let found = errors::find(source, root, None, records.has_bad);
    (found.errors.is_empty() && !found.too_deep).then(|| lower::file(root).items)
}

impl Tree {
    /// The root node: every space and comment is in it.
    pub fn root(&self) -> Part<'_> {
        self.records.get_or_init(|| Arc::new(whole(&self.source, None, false))).root(&self.source.text)
    }

    /// The mistakes, in the order of the text, at most one a line.
    pub fn errors(&self) -> &[Diagnostic] {
        &self.errors
    }

    /// The file as the evaluator reads it. Expressions beyond [`ast::MAX_DEPTH`] are reported, and the file is then empty.
    pub fn file(&self) -> &Arc<File> {
        &self.file
    }

    /// The file with all its places moved by `base`: to where its text lies in [`Texts`](crate::source::Texts).
    pub fn file_at(&self, base: u32) -> Arc<File> {
        let mut file = self.file.clone();
        if base > 0 {
            shift::file(Arc::make_mut(&mut file), base);
        }
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

    #[test]
    fn pieces_say_what_the_whole_says() {
        let scenes = [include_str!("../../tests/scenes/cornell.kin"), include_str!("../../tests/scenes/dominoes.kin")];
        let text: String = scenes.into_iter().cycle().take(60).flat_map(|scene| [scene, "\n"]).collect();
        let source = Source::new(FileId(0), "a.kin", text.as_str());
        let cuts = scan(&text).cuts;
        assert!(cuts.len() > 3, "{cuts:?}");
        let file = in_pieces(&source, &cuts).unwrap();
        let records = whole(&source, None, false);
        assert_eq!(file, lower::file(records.root(&text)));
        let faulty = text.replacen("radius: 0.3,", "radius 0.3,", 20);
        let source = Source::new(FileId(0), "a.kin", faulty.as_str());
        assert!(in_pieces(&source, &scan(&faulty).cuts).is_none());
        assert_eq!(parse(&source).errors().len(), 20);
    }
}
