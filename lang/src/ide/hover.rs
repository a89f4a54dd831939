//! What stands at a place, in words.

use super::Analysis;
use super::cursor::{Owner, Slot, called, is_kind, owner, schema_kind, slot};
use crate::builtin::{self, Builtin, ease};
use crate::dimension::{show, unit};
use crate::eval::Symbol;
use crate::schema::{self, Default, Kind, Property, Since, type_name};
use crate::source::Span;
use crate::syntax::{Part, SyntaxKind as K};

/// What is said about a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hover {
    /// What it is about.
    pub span: Span,
    /// Markdown.
    pub text: String,
    /// The expression, in [`Modules::texts`](crate::modules::Modules::texts), whose value belongs below, if there is one.
    pub value: Option<Span>,
}

/// What stands at an offset.
pub fn hover(analysis: &Analysis, offset: u32) -> Option<Hover> {
    let source = &analysis.tree.source;
    let token = analysis.tree.root().word_at(source.clamp(offset))?;
    let said = |text: String| Some(Hover { span: token.span(), text, value: None });
    let parent = token.parent();
    let parent_kind = parent.map_or(K::File, Part::kind);
    match token.kind() {
        kind if kind.is_trivia() => None,
        K::KeyName | K::String if matches!(parent_kind, K::Property | K::EqProperty) && is_first(token) => {
            let property_part = parent?;
            let value = value_of(property_part);
            let Owner::Node(node) = owner(property_part) else { return None };
            if let Some((kind, row)) = schema_kind(node).and_then(|kind| Some((kind, kind.property(token.text())?))) {
                return Some(Hover { span: token.span(), text: property(kind.name, row), value });
            }
            name(analysis, offset, value)
        }
        K::KeyName if parent_kind == K::NamedArg => {
            let Slot::Argument { args, .. } = slot(parent?) else { return None };
            let function = called(args)?;
            name(analysis, offset, None).or_else(|| {
                let row = builtin::find(function)?;
                let param = row.params.iter().find(|param| param.name == token.text())?;
                let words: Vec<String> = param.words.iter().map(|word| format!("`{}`", word.name)).collect();
                let words = if words.is_empty() { String::new() } else { format!(": {}", words.join(", ")) };
                said(format!("**{}** of `{}` · {}{words}", param.name, row.signature(), param.takes))
            })
        }
        K::Path => path(analysis, token, offset),
        K::Ident => match parent_kind {
            K::Ty => type_name(token.text()).and_then(|row| said(format!("**{}** · {}", row.name, row.doc))),
            _ => name(analysis, offset, None),
        },
        K::Digits | K::Unit => {
            let number = parent.filter(|part| part.kind() == K::Number)?;
            let digits = number.tokens().find(|part| part.kind() == K::Digits)?.text().replace('_', "");
            let with = number.tokens().find(|part| part.kind() == K::Unit)?.text();
            let (factor, of) = unit(with)?;
            let value: f64 = digits.parse().ok()?;
            let text = match with.contains('f') && crate::dimension::frames(with) != 0 {
                true => format!("`{}` · {}, counted in frames", number.text(), of.with_article()),
                false => format!("`{}` · {}: {}", number.text(), of.with_article(), show(value * factor, of)),
            };
            Some(Hover { span: number.span(), text, value: None })
        }
        K::Color => {
            let [r, g, b, _] = super::colors::channels(token.text())?;
            let linear = [r, g, b].map(|channel| format!("{:.4}", builtin::srgb_to_linear(f64::from(channel) / 255.0)));
            said(format!("`{}` · a colour: {r}, {g}, {b} of 255, `linear({})`", token.text(), linear.join(", ")))
        }
        kind if kind.is_keyword() || kind == K::Boolean => {
            said(format!("**{}** · {}", token.text(), word(token.text())?))
        }
        K::String if parent_kind == K::ImportDecl => {
            let start = parent?.span().start;
            let own = analysis.modules.list.first()?;
            let (_, to) = own.imports().find(|(import, _)| import.span.start == start)?;
            let module = analysis.modules.list.get(to?)?;
            let mut names = Vec::new();
            for item in super::outline::outline(&module.file.items) {
                if !item.name.starts_with('_') && item.is_declaration {
                    names.push(format!("`{}`", item.name));
                }
            }
            names.truncate(40);
            said(format!("**{}** · declares {}", module.source.name, names.join(", ")))
        }
        _ => None,
    }
}

fn is_first(token: Part<'_>) -> bool {
    token.parent().and_then(Part::first_token).is_some_and(|first| first.span() == token.span())
}

/// The value of a property.
fn value_of(property: Part<'_>) -> Option<Span> {
    property.parts().skip_while(|part| part.kind() != K::Colon).find(|part| part.kind().is_value()).map(Part::span)
}

fn path(analysis: &Analysis, token: Part<'_>, offset: u32) -> Option<Hover> {
    let said = |text: String| Some(Hover { span: token.span(), text, value: None });
    let parent = token.parent()?;
    let of_node = is_kind(token);
    // The value of what is named, or of the call.
    let next = parent.parts().find(|part| part.span().start >= token.span().end);
    let args = next.filter(|part| part.kind() == K::Args);
    let whole = Span::new(token.span().start, args.map_or(token.span().end, |args| args.span().end));
    let is_last = !token.text().get((offset - token.span().start) as usize..).unwrap_or_default().contains('.');
    let value = (!of_node && is_last).then_some(whole);
    if let Some(found) = name(analysis, offset, value) {
        return Some(found);
    }
    if let Some((base, field)) = token.text().rsplit_once('.').filter(|_| is_last && !of_node) {
        let span = Span::new(token.span().end - field.len() as u32, token.span().end);
        let to = analysis.name_at(token.span().start + base.len() as u32).map(|(at, _)| at);
        let text = match to.and_then(|at| analysis.symbol(at)) {
            Some(Symbol::Node(Some(kind))) if kind.property(field).is_some() => {
                property(kind.name, kind.property(field)?)
            }
            _ => format!("**{field}** of `{base}`"),
        };
        return Some(Hover { span, text, value });
    }
    // Of several names the one at the offset.
    let before = token.text().get(..(offset.saturating_sub(token.span().start) as usize)).unwrap_or_default();
    let text = match (token.text().split_once('.'), before.contains('.')) {
        (Some((first, _)), false) => first,
        _ => token.text(),
    };
    if of_node {
        return schema::kind(text).and_then(|row| said(kind(row)));
    }
    match slot(token) {
        Slot::Ease => {
            let _ = ease::named(text)?;
            return said(format!("**{text}** · an easing: the way from the key before to this one"));
        }
        Slot::Property { node, row: Some(row), .. } => {
            let words: &[schema::Choice] = match row.ty {
                schema::Type::Choice(words) => words,
                _ => &[],
            };
            if words.iter().any(|word| word.name == text) {
                let kind = schema_kind(node)?;
                return said(format!("`{text}`, one of the words of\n\n{}", property(kind.name, row)));
            }
        }
        _ => {}
    }
    if let Some(row) = builtin::find(text) {
        return Some(Hover { span: token.span(), text: function(row), value });
    }
    word(text).map(|doc| Hover { span: token.span(), text: format!("**{text}** · {doc}"), value })
}

/// A name that is declared somewhere.
fn name(analysis: &Analysis, offset: u32, value: Option<Span>) -> Option<Hover> {
    let (span, to) = analysis.name_at(offset)?;
    let symbol = analysis.symbol(span)?;
    let texts = &analysis.modules.texts;
    let place = analysis.place(to);
    let mut text = String::new();
    let declaration = analysis.declaration(to);
    let line = match (symbol, declaration) {
        (Symbol::Module, _) => format!("import \"{}\" as {}", place.file, texts.slice(span)),
        (_, Some(declaration)) => declaration.line(texts),
        _ => texts.slice(to).to_string(),
    };
    text += &format!("```kinora\n{line}\n```");
    if let Some(docs) = declaration.and_then(|declaration| declaration.docs()) {
        text += &format!("\n\n{docs}");
    }
    if place.file != analysis.tree.source.name {
        text += &format!("\n\nin `{}`", place.file);
    }
    use super::names::Declaration as D;
    let of_declaration = match declaration {
        Some(D::Let(decl)) => Some(decl.value.span),
        Some(D::Param(decl)) => Some(decl.value.span),
        _ => None,
    };
    let value = match declaration {
        Some(D::Formal(_) | D::Loop(_)) => value,
        _ => of_declaration.or(value),
    };
    Some(Hover { span, text, value })
}

/// A property in words. Markdown.
pub fn property(kind: &str, row: &Property) -> String {
    let mut text = format!("**{kind}.{}** · {}", row.name, row.type_text());
    match row.default {
        Default::Computed => {}
        Default::Needed => text += " · needed",
        _ => text += &format!(" · not set: {}", row.default_text()),
    }
    let allowed = row.check.text();
    if !allowed.is_empty() {
        text += &format!(" · {allowed}");
    }
    text += &format!("\n\n{}", sentence(row.doc));
    match (row.animatable, row.varies) {
        (true, true) => text += " May change over time and over the surface.",
        (true, false) => text += " May change over time.",
        (false, true) => text += " May change over the surface.",
        (false, false) => {}
    }
    match row.since {
        Since::Now => {}
        Since::Later => text += " *Not yet.*",
        Since::Default => text += " *Only this value yet.*",
    }
    text
}

/// A kind of node in words. Markdown.
pub fn kind(row: &Kind) -> String {
    let names: Vec<String> =
        row.all().filter(|row| row.since != Since::Later).map(|row| format!("`{}`", row.name)).collect();
    let has = if names.is_empty() { String::new() } else { format!("\n\nProperties: {}", names.join(", ")) };
    format!("**{}** · {}\n\n{}{has}", row.name, row.sort.with_article(), sentence(row.doc))
}

/// A function in words. Markdown.
pub fn function(row: &Builtin) -> String {
    let params: Vec<String> = row
        .params
        .iter()
        .map(|param| {
            let optional = if param.optional { "?" } else { "" };
            format!("`{}{optional}`: {}", param.name, param.takes)
        })
        .collect();
    let rest = row.rest.map(|rest| format!("any number of {rest}"));
    let takes: Vec<String> = rest.into_iter().chain(params).collect();
    format!("```kinora\n{} -> {}\n```\n\n{}\n\n{}", row.signature(), row.gives, sentence(row.doc), takes.join(" · "))
}

fn sentence(doc: &str) -> String {
    let mut letters = doc.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default();
    let end = if doc.ends_with('.') { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}

/// A word of the language, or one that always means something.
pub fn word(word: &str) -> Option<&'static str> {
    Some(match word {
        "lang" => "the version of the language, in the first line",
        "import" => "names of another file: `import \"x.kin\" as x`, `import { a, b as c } from \"x.kin\"`",
        "from" => "the file that names are imported from",
        "as" => "the name that something imported has here",
        "let" => "a name for a value: `let name = value`",
        "param" => "a value that `-D name=value` and the viewer can set: `param name = 0.5 in 0..1`",
        "fn" => "a function: `fn name(a, b) = value`, or with a block that ends in `return`",
        "prefab" => "a kind of node of your own: `prefab name(a, b) { .. }`",
        "for" => "once for each item of a list or range: `for i in 0..10 { .. }`",
        "in" => "the list of a loop, or the range of a `param`",
        "if" => "a choice: `if condition { .. } else { .. }`",
        "else" => "what holds where no condition does",
        "return" => "what a function gives",
        "keys" => "a value over time: `keys { 0s: a  1s: b ease out_quad }`",
        "ease" => "the way to this key from the one before",
        "after" => "the time of a key, counted from the key before",
        "like" => "a copy of a node, with some properties changed",
        "true" | "false" => "a truth value",
        "time" => "the seconds since the start of the scene",
        "frame" => "`time` times `fps`",
        "p" => "the point of the surface in the scene's space, in metres",
        "p_local" => "the point of the surface in the shape's own space, in metres",
        "uv" => "the texture coordinates of the point of the surface",
        "normal" => "the direction away from the surface at this point",
        _ => return None,
    })
}
