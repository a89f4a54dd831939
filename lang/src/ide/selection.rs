//! From the word at a place outwards.

use crate::source::Span;
use crate::syntax::Tree;

/// The spans around an offset that mean something, each in the next one.
pub fn selection(tree: &Tree, offset: u32) -> Vec<Span> {
    let whole = Span::new(0, tree.source.len());
    let Some(token) = tree.root().word_at(tree.source.clamp(offset)) else { return vec![whole] };
    let mut found: Vec<Span> = Vec::new();
    for part in token.ancestors() {
        let span = part.span();
        // Without its brackets first.
        if part.is_node() && found.last().is_some_and(|last| last.start > span.start) && span.len() >= 2 {
            let text = part.text();
            let closed = [('{', '}'), ('(', ')'), ('[', ']')];
            if closed.iter().any(|(open, close)| text.starts_with(*open) && text.ends_with(*close)) {
                let inner = &text[1..text.len() - 1];
                let before = (inner.len() - inner.trim_start().len()) as u32;
                let inside = Span::new(span.start + 1 + before, span.start + 1 + inner.trim_end().len() as u32);
                if found
                    .last()
                    .is_some_and(|last| inside.start <= last.start && last.end <= inside.end && inside != *last)
                {
                    found.push(inside);
                }
            }
        }
        if found.last() != Some(&span)
            && found.last().is_none_or(|last| span.start <= last.start && last.end <= span.end)
        {
            found.push(span);
        }
    }
    if found.last() != Some(&whole) {
        found.push(whole);
    }
    found
}
