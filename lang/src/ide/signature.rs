//! What a call takes, while it is written.

use super::Analysis;
use super::cursor::{Slot, called, slot};
use super::names::Declaration;
use crate::builtin;
use crate::eval::keys;
use crate::syntax::SyntaxKind as K;

/// A function that is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signature {
    /// `clamp(x: number, low: number, high: number) -> the same`
    pub label: String,
    /// Where in it the parameters stand, in bytes.
    pub params: Vec<(usize, usize)>,
    /// Which one is being written.
    pub active: Option<usize>,
    /// Markdown; may be empty.
    pub doc: String,
}

/// The call around an offset.
pub fn signature(analysis: &Analysis, offset: u32) -> Option<Signature> {
    let source = &analysis.tree.source;
    let offset = source.clamp(offset);
    let root = analysis.tree.root();
    // The innermost brackets that the offset is inside of.
    let args = root
        .all()
        .take_while(|part| part.span().start < offset)
        .filter(|part| {
            let closed = part.text().ends_with(')');
            part.kind() == K::Args && (offset < part.span().end || !closed && offset <= part.span().end)
        })
        .last()?;
    let name = called(args)?;
    let name_end = args.span().start;
    let commas = args.parts().filter(|part| part.kind() == K::Comma && part.span().end <= offset).count();
    let named = args.nodes().filter(|part| part.span().start <= offset && offset <= part.span().end).find_map(|part| {
        let inner = part.all().find(|inner| !inner.is_node())?;
        match (part.kind(), slot(inner)) {
            (K::NamedArg, _) => part.first_token().map(|token| token.text()),
            (_, Slot::Argument { name, .. }) => name,
            _ => None,
        }
    });
    let declared = analysis.name_at(name_end.saturating_sub(1)).and_then(|(_, to)| analysis.declaration(to));
    let (rows, result, doc): (Vec<(String, String, bool)>, String, String) = match declared {
        Some(Declaration::Fn(decl)) => {
            let texts = &analysis.modules.texts;
            let rows = decl.params.iter().map(|formal| {
                let text = texts.slice(formal.span).split_whitespace().collect::<Vec<_>>().join(" ");
                (formal.name.text.to_string(), text, false)
            });
            let result = decl.result.as_ref().map_or(String::new(), |ty| texts.slice(ty.span).to_string());
            (rows.collect(), result, decl.docs.as_deref().unwrap_or_default().to_string())
        }
        Some(_) => return None,
        None if name == "keys" => {
            let row =
                |(name, words): (&str, Vec<&str>)| (name.to_string(), format!("{name}: {}", words.join(" | ")), true);
            let rows = keys::options().map(row);
            (rows.into(), String::new(), "Options of keyframes.".into())
        }
        None => {
            let row = builtin::find(name)?;
            let rest = row.rest.map(|rest| (String::new(), format!("{rest} .."), false));
            let rows = row.params.iter().map(|param| {
                let optional = if param.optional { "?" } else { "" };
                (param.name.to_string(), format!("{}{optional}: {}", param.name, param.takes), row.rest.is_some())
            });
            (rest.into_iter().chain(rows).collect(), row.gives.to_string(), row.doc.to_string())
        }
    };
    let mut label = format!("{name}(");
    let mut params = Vec::new();
    for (i, (_, text, _)) in rows.iter().enumerate() {
        label += if i > 0 { ", " } else { "" };
        params.push((label.len(), label.len() + text.len()));
        label += text;
    }
    label += ")";
    if !result.is_empty() {
        label += &format!(" -> {result}");
    }
    let by_name = named.map(|named| rows.iter().position(|row| row.0 == named));
    let has_rest = rows.first().is_some_and(|row| row.0.is_empty());
    let active = match by_name {
        Some(found) => found,
        None if has_rest => Some(0),
        None => Some(commas).filter(|at| rows.get(*at).is_some_and(|row| !row.2)),
    };
    Some(Signature { label, params, active, doc })
}
