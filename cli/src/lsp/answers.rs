//! What `kinora_lang::ide` says, in the protocol's types.

use std::time::Duration;

use kinora_lang::eval::{Amount, Overrides, values_at};
use kinora_lang::format::{format, format_partial};
use kinora_lang::ide::{self, Analysis, CompletionKind, Entry, FoldKind, HintKind};
use kinora_lang::parse;
use kinora_lang::source::{Source, Span};
use lsp_types as lsp;
use similar::{DiffOp, TextDiff};

use super::position::Encoding;
use super::project::Project;

/// What an editor can show of suggestions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shows {
    pub snippets: bool,
    pub markdown: bool,
}

/// Frames a second and seconds, once they are needed: they take an evaluation of the whole scene.
pub type Clock<'a> = &'a mut dyn FnMut() -> Option<(f64, f64)>;

pub fn completions(
    analysis: &Analysis,
    project: &Project,
    offset: u32,
    encoding: Encoding,
    shows: Shows,
) -> Vec<lsp::CompletionItem> {
    let source = &analysis.tree.source;
    let found = ide::completions(analysis, offset, project.files());
    let item = |(at, found): (usize, ide::Completion)| {
        use lsp::CompletionItemKind as K;
        let kind = match found.kind {
            CompletionKind::Keyword => K::KEYWORD,
            CompletionKind::Kind => K::CLASS,
            CompletionKind::Property => K::PROPERTY,
            CompletionKind::Function => K::FUNCTION,
            CompletionKind::Value => K::VARIABLE,
            CompletionKind::Param => K::FIELD,
            CompletionKind::Node => K::VARIABLE,
            CompletionKind::Prefab => K::STRUCT,
            CompletionKind::Module => K::MODULE,
            CompletionKind::Word => K::ENUM_MEMBER,
            CompletionKind::Unit => K::UNIT,
            CompletionKind::Type => K::TYPE_PARAMETER,
            CompletionKind::File => K::FILE,
            CompletionKind::Folder => K::FOLDER,
        };
        let is_snippet = shows.snippets && found.snippet != found.plain;
        let new_text = if is_snippet { found.snippet } else { found.plain };
        let edit = lsp::TextEdit { range: encoding.range(source, found.replace), new_text };
        // What is needed next can be listed at once.
        let again = matches!(found.kind, CompletionKind::Folder) || is_snippet && edit.new_text.ends_with("$1");
        let command = again.then(|| lsp::Command {
            title: "suggest".into(),
            command: "editor.action.triggerSuggest".into(),
            arguments: None,
        });
        lsp::CompletionItem {
            label: found.label,
            kind: Some(kind),
            detail: (!found.detail.is_empty()).then_some(found.detail),
            sort_text: Some(format!("{}{at:05}", found.rank)),
            insert_text_format: Some(match is_snippet {
                true => lsp::InsertTextFormat::SNIPPET,
                false => lsp::InsertTextFormat::PLAIN_TEXT,
            }),
            text_edit: Some(lsp::CompletionTextEdit::Edit(edit)),
            command: command.filter(|_| shows.snippets),
            data: (!found.about.is_empty()).then(|| found.about.into()),
            ..lsp::CompletionItem::default()
        }
    };
    found.into_iter().enumerate().map(item).collect()
}

/// A suggestion with what is to be said about it.
pub fn resolve(mut item: lsp::CompletionItem, shows: Shows) -> lsp::CompletionItem {
    let about = item.data.as_ref().and_then(|data| data.as_str()).and_then(ide::document);
    item.documentation = about.map(|text| lsp::Documentation::MarkupContent(markup(text, shows)));
    item
}

fn markup(text: String, shows: Shows) -> lsp::MarkupContent {
    match shows.markdown {
        true => lsp::MarkupContent { kind: lsp::MarkupKind::Markdown, value: text },
        false => {
            let fences = |line: &&str| !line.starts_with("```");
            let value = text.lines().filter(fences).collect::<Vec<_>>().join("\n").replace(['`', '*'], "");
            lsp::MarkupContent { kind: lsp::MarkupKind::PlainText, value }
        }
    }
}

pub fn hover(
    analysis: &Analysis,
    offset: u32,
    clock: Clock<'_>,
    encoding: Encoding,
    shows: Shows,
) -> Option<lsp::Hover> {
    let found = ide::hover(analysis, offset)?;
    let mut text = found.text;
    if let Some(value) = found.value {
        let values = values_at(&analysis.modules, &Overrides::default(), &[value]);
        if let Some((_, watched)) = values.first() {
            text += &format!("\n\n= {} · {}", shown(&watched.value, clock, true), watched.what);
        }
    }
    let range = Some(encoding.range(&analysis.tree.source, found.span));
    Some(lsp::Hover { contents: lsp::HoverContents::Markup(markup(text, shows)), range })
}

/// A value, in words: of one that moves, where it begins and where it ends.
fn shown(value: &Amount, clock: Clock<'_>, long: bool) -> String {
    match value {
        Amount::Is(text, false) => format!("`{text}`"),
        Amount::Is(text, true) if long => format!("`{text}` the first time, then others"),
        Amount::Is(text, true) => format!("`{text}` …"),
        Amount::Surface => "differs from point to point".to_string(),
        Amount::Moves(moving) => {
            let (fps, end) = clock().unwrap_or((24.0, 0.0));
            let at = |time: f64| {
                let numbers: Vec<f64> =
                    moving.parts.iter().map(|part| kinora_animator::value(part, time, fps)).collect();
                moving.show(&numbers)
            };
            match (end > 0.0, long) {
                (true, true) => format!("`{}` at 0s, `{}` at {end}s", at(0.0), at(end)),
                (true, false) => format!("`{}` → `{}`", at(0.0), at(end)),
                (false, _) => format!("`{}` at 0s", at(0.0)),
            }
        }
    }
}

pub fn hints(analysis: &Analysis, within: Span, clock: Clock<'_>, encoding: Encoding) -> Vec<lsp::InlayHint> {
    let found = ide::hints(analysis, within);
    let values = values_at(&analysis.modules, &Overrides::default(), &ide::watched(&found));
    let source = &analysis.tree.source;
    let hint = |hint: ide::Hint| {
        let text = match hint.value {
            None => hint.text,
            Some(value) => {
                let (_, watched) = values.iter().find(|(span, _)| *span == value)?;
                // What is written out already says it.
                let text = shown(&watched.value, clock, false).replace('`', "");
                (text.trim() != source.slice(value).trim()).then(|| format!("= {text}"))?
            }
        };
        let before = hint.kind == HintKind::Parameter;
        Some(lsp::InlayHint {
            position: encoding.position(source, hint.offset),
            label: lsp::InlayHintLabel::String(text),
            kind: Some(if before { lsp::InlayHintKind::PARAMETER } else { lsp::InlayHintKind::TYPE }),
            text_edits: None,
            tooltip: None,
            padding_left: Some(!before),
            padding_right: Some(before),
            data: None,
        })
    };
    found.into_iter().filter_map(hint).collect()
}

pub fn signature(analysis: &Analysis, offset: u32, shows: Shows) -> Option<lsp::SignatureHelp> {
    let found = ide::signature(analysis, offset)?;
    // Offsets of labels count UTF-16 units whatever was agreed on.
    let units = |at: usize| Encoding::Utf16.len(found.label.get(..at).unwrap_or_default());
    let params = found.params.iter().map(|(start, end)| lsp::ParameterInformation {
        label: lsp::ParameterLabel::LabelOffsets([units(*start), units(*end)]),
        documentation: None,
    });
    let active = found.active.and_then(|active| u32::try_from(active).ok());
    let signature = lsp::SignatureInformation {
        parameters: Some(params.collect()),
        documentation: (!found.doc.is_empty())
            .then(|| lsp::Documentation::MarkupContent(markup(found.doc.clone(), shows))),
        active_parameter: active,
        label: found.label.clone(),
    };
    Some(lsp::SignatureHelp { signatures: vec![signature], active_signature: Some(0), active_parameter: active })
}

fn symbol_kind(what: ide::What) -> lsp::SymbolKind {
    use ide::What;
    match what {
        What::Value => lsp::SymbolKind::CONSTANT,
        What::Param => lsp::SymbolKind::VARIABLE,
        What::Function => lsp::SymbolKind::FUNCTION,
        What::Prefab => lsp::SymbolKind::CLASS,
        What::Node => lsp::SymbolKind::OBJECT,
        What::Material => lsp::SymbolKind::STRUCT,
        What::Group => lsp::SymbolKind::NAMESPACE,
        What::Camera => lsp::SymbolKind::INTERFACE,
        What::Settings => lsp::SymbolKind::FIELD,
        What::Property => lsp::SymbolKind::PROPERTY,
        What::Module => lsp::SymbolKind::MODULE,
    }
}

pub fn outline(source: &Source, entries: Vec<Entry>, encoding: Encoding) -> Vec<lsp::DocumentSymbol> {
    let symbol = |entry: Entry| {
        let name = if entry.name.trim().is_empty() { entry.detail.clone() } else { entry.name };
        #[allow(deprecated)] // A field that cannot be left out.
        lsp::DocumentSymbol {
            name: if name.trim().is_empty() { "?".into() } else { name },
            detail: Some(entry.detail),
            kind: symbol_kind(entry.what),
            tags: None,
            deprecated: None,
            range: encoding.range(source, entry.span),
            selection_range: encoding.range(source, entry.name_span),
            children: Some(outline(source, entry.children, encoding)),
        }
    };
    entries.into_iter().map(symbol).collect()
}

/// The same as a list, with the name of what each is in.
pub fn flat_outline(
    source: &Source,
    uri: &lsp::Uri,
    entries: &[Entry],
    encoding: Encoding,
) -> Vec<lsp::SymbolInformation> {
    let mut found = Vec::new();
    let mut open: Vec<(&Entry, Option<&str>)> = entries.iter().map(|entry| (entry, None)).collect();
    while let Some((entry, inside)) = open.pop() {
        open.extend(entry.children.iter().map(|child| (child, Some(&*entry.name))));
        if entry.what == ide::What::Property {
            continue;
        }
        let location = lsp::Location { uri: uri.clone(), range: encoding.range(source, entry.name_span) };
        #[allow(deprecated)] // A field that cannot be left out.
        found.push(lsp::SymbolInformation {
            name: entry.name.clone(),
            kind: symbol_kind(entry.what),
            tags: None,
            deprecated: None,
            location,
            container_name: inside.map(str::to_string),
        });
    }
    found.sort_by_key(|symbol| symbol.location.range.start);
    found
}

pub fn tokens(analysis: &Analysis, within: Option<Span>, encoding: Encoding) -> lsp::SemanticTokens {
    let source = &analysis.tree.source;
    let (mut line, mut start) = (0, 0);
    let mut data = Vec::new();
    for token in ide::tokens(analysis, within) {
        let at = encoding.position(source, token.span.start);
        let token_type = ide::TokenKind::ALL.iter().position(|row| row.0 == token.kind).unwrap_or(0) as u32;
        let bit = |modifier: &ide::Modifier| {
            1 << ide::Modifier::ALL.iter().position(|row| row.0 == *modifier).unwrap_or(0) as u32
        };
        data.push(lsp::SemanticToken {
            delta_line: at.line - line,
            delta_start: if at.line == line { at.character - start } else { at.character },
            length: encoding.len(source.slice(token.span)),
            token_type,
            token_modifiers_bitset: token.modifiers.iter().map(bit).sum(),
        });
        (line, start) = (at.line, at.character);
    }
    lsp::SemanticTokens { result_id: None, data }
}

pub fn folds(source: &Source, folds: Vec<ide::Fold>) -> Vec<lsp::FoldingRange> {
    let fold = |fold: ide::Fold| {
        let (start_line, mut end_line) = (source.line_index(fold.span.start), source.line_index(fold.span.end));
        let kind = match fold.kind {
            FoldKind::Block => {
                // The line of the closing bracket stays to be seen.
                let last = source.slice(source.line_span(end_line)).trim_start().starts_with(['}', ')', ']']);
                end_line -= u32::from(last && end_line > start_line);
                None
            }
            FoldKind::Comment => Some(lsp::FoldingRangeKind::Comment),
            FoldKind::Imports => Some(lsp::FoldingRangeKind::Imports),
        };
        lsp::FoldingRange {
            start_line,
            start_character: None,
            end_line,
            end_character: None,
            kind,
            collapsed_text: None,
        }
    };
    folds.into_iter().map(fold).filter(|fold| fold.start_line < fold.end_line).collect()
}

pub fn colors(source: &Source, colors: Vec<ide::ColorAt>, encoding: Encoding) -> Vec<lsp::ColorInformation> {
    let information = |color: ide::ColorAt| {
        let [red, green, blue] = color.srgb.map(|channel| channel as f32);
        lsp::ColorInformation {
            range: encoding.range(source, color.span),
            color: lsp::Color { red, green, blue, alpha: 1.0 },
        }
    };
    colors.into_iter().map(information).collect()
}

pub fn spellings(
    source: &Source,
    params: &lsp::ColorPresentationParams,
    encoding: Encoding,
) -> Vec<lsp::ColorPresentation> {
    let there = source.slice(encoding.span(source, params.range));
    let lsp::Color { red, green, blue, .. } = params.color;
    let spellings = ide::spellings([red, green, blue].map(f64::from), there);
    let presentation = |label: String| lsp::ColorPresentation {
        text_edit: Some(lsp::TextEdit { range: params.range, new_text: label.clone() }),
        additional_text_edits: None,
        label,
    };
    spellings.into_iter().map(presentation).collect()
}

pub fn selections(analysis: &Analysis, positions: &[lsp::Position], encoding: Encoding) -> Vec<lsp::SelectionRange> {
    let source = &analysis.tree.source;
    let range = |position: &lsp::Position| {
        let spans = ide::selection(&analysis.tree, encoding.offset(source, *position));
        let mut around: Option<Box<lsp::SelectionRange>> = None;
        for span in spans.iter().rev() {
            around = Some(Box::new(lsp::SelectionRange { range: encoding.range(source, *span), parent: around }));
        }
        *around.unwrap_or_else(|| {
            Box::new(lsp::SelectionRange { range: lsp::Range { start: *position, end: *position }, parent: None })
        })
    };
    positions.iter().map(range).collect()
}

/// The edits that lay a text out. With `within`, only those that touch these lines. Nothing where it has mistakes, unless
/// `partial`: then what is whole is laid out.
pub fn formatting(analysis: &Analysis, within: Option<Span>, partial: bool, encoding: Encoding) -> Vec<lsp::TextEdit> {
    let source = &analysis.tree.source;
    let laid_out = match format(&analysis.tree) {
        Ok(text) => text,
        Err(_) if partial => format_partial(&analysis.tree),
        Err(_) => return Vec::new(),
    };
    let mut edits = line_edits(&source.text, &laid_out);
    if let Some(within) = within {
        let first = source.line_start(source.line_index(within.start));
        let last = source.line_start(source.line_index(within.end.max(within.start + 1) - 1) + 1);
        edits.retain(|(span, _)| first <= span.start && span.end <= last);
        // Some of the changes alone must leave the text what it is.
        let some = parse(&Source::new(source.id, source.name.clone(), edited(&source.text, &edits)));
        let same = format(&some).ok().unwrap_or_else(|| format_partial(&some)) == laid_out;
        if !same {
            return Vec::new();
        }
    }
    let edit = |(span, new_text)| lsp::TextEdit { range: encoding.range(source, span), new_text };
    edits.into_iter().map(edit).collect()
}

/// A text with edits in their order carried out.
fn edited(text: &str, edits: &[(Span, String)]) -> String {
    let (mut result, mut at) = (String::with_capacity(text.len()), 0);
    for (span, new) in edits {
        result += text.get(at..span.start as usize).unwrap_or_default();
        result += new;
        at = span.end as usize;
    }
    result + text.get(at..).unwrap_or_default()
}

/// The lines that differ: where, and what comes there.
fn line_edits(old: &str, new: &str) -> Vec<(Span, String)> {
    if old == new {
        return Vec::new();
    }
    let starts = |text: &str| -> Vec<usize> {
        let mut at = 0;
        let mut starts: Vec<usize> = text
            .split_inclusive('\n')
            .map(|line| {
                at += line.len();
                at - line.len()
            })
            .collect();
        starts.push(text.len());
        starts
    };
    let (old_starts, new_starts) = (starts(old), starts(new));
    let old_lines: Vec<&str> = old.split_inclusive('\n').collect();
    let new_lines: Vec<&str> = new.split_inclusive('\n').collect();
    // Lines belong together where they differ in nothing but spaces.
    let words = |lines: &[&str]| -> Vec<String> {
        lines.iter().map(|line| line.split_whitespace().collect::<String>()).collect()
    };
    let (old_words, new_words) = (words(&old_lines), words(&new_lines));
    let old_words: Vec<&str> = old_words.iter().map(String::as_str).collect();
    let new_words: Vec<&str> = new_words.iter().map(String::as_str).collect();
    let diff = TextDiff::configure().timeout(LONGEST_DIFF).diff_slices(&old_words, &new_words);
    let mut edits = Vec::new();
    let mut change = |old_lines: std::ops::Range<usize>, own: std::ops::Range<usize>| {
        let span = Span::new(old_starts[old_lines.start] as u32, old_starts[old_lines.end] as u32);
        edits.push((span, new[new_starts[own.start]..new_starts[own.end]].to_string()));
    };
    for op in diff.ops() {
        let (there, here) = (op.old_range(), op.new_range());
        match op {
            DiffOp::Equal { .. } => there.zip(here).for_each(|(there, here)| {
                if old_lines[there] != new_lines[here] {
                    change(there..there + 1, here..here + 1);
                }
            }),
            _ => change(there, here),
        }
    }
    edits
}

/// After so long, the changes of a text are no longer made as small as they could be.
const LONGEST_DIFF: Duration = Duration::from_millis(300);

/// The edit that puts a `}` which was just typed below the line that its `{` is on.
pub fn close_brace(analysis: &Analysis, offset: u32, encoding: Encoding) -> Vec<lsp::TextEdit> {
    let source = &analysis.tree.source;
    let Some(at) = offset.checked_sub(1) else { return Vec::new() };
    let Some(brace) = analysis.tree.root().token_at(at).filter(|token| token.text() == "}") else { return Vec::new() };
    let line = source.line_start(source.line_index(at));
    let before = Span::new(line, brace.span().start);
    let Some(block) = brace.parent().filter(|_| source.slice(before).trim().is_empty()) else { return Vec::new() };
    let opens = source.line_span(source.line_index(block.span().start));
    let text = source.slice(opens);
    let indent = &text[..text.len() - text.trim_start().len()];
    match source.slice(before) == indent {
        true => Vec::new(),
        false => vec![lsp::TextEdit { range: encoding.range(source, before), new_text: indent.to_string() }],
    }
}

pub fn links(analysis: &Analysis, project: &Project, encoding: Encoding) -> Vec<lsp::DocumentLink> {
    let source = &analysis.tree.source;
    let link = |named: ide::PathAt| {
        let path = project.path(&named.path).filter(|path| path.is_file())?;
        Some(lsp::DocumentLink {
            range: encoding.range(source, named.span),
            target: Some(super::uri::of(&path)?),
            tooltip: Some(named.path),
            data: None,
        })
    };
    ide::paths(&analysis.tree).into_iter().filter_map(link).collect()
}
