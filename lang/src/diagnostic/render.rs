//! Diagnostics for people. The only module that knows annotate-snippets.

use super::{Diagnostic, Edit, Fix, Label, Severity};
use crate::source::{FileId, Source, Span};
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Patch, Renderer, Snippet};

/// How text is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// With escape codes for a terminal's colours.
    pub color: bool,
    /// With lines drawn by box characters instead of ASCII.
    pub unicode: bool,
    /// Columns that there are; long lines of the scene are cut to fit.
    pub width: u16,
}

impl Default for Style {
    fn default() -> Style {
        Style { color: false, unicode: false, width: 100 }
    }
}

/// Lines of the scene kept round a label: the renderer drops those it does not show.
const CONTEXT: u32 = 2;

/// A diagnostic with the lines it is about. Ends with a line break.
///
/// Places are clamped to the text, so a diagnostic of a text that changed meanwhile shows something wrong, but shows it.
pub fn render(found: &Diagnostic, sources: &[Source], style: Style) -> String {
    let renderer = if style.color { Renderer::styled() } else { Renderer::plain() };
    let decor = if style.unicode { DecorStyle::Unicode } else { DecorStyle::Ascii };
    let renderer = renderer.decor_style(decor).term_width(usize::from(style.width.max(20)));
    let level = match found.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut main = Group::with_title(level.primary_title(found.message.as_str()).id(found.code));
    for source in sources {
        let labels: Vec<&Label> = found.labels.iter().filter(|label| label.file == source.id).collect();
        if !labels.is_empty() {
            main = labelled(main, source, &labels);
        }
    }
    main = main.elements(found.notes.iter().map(|note| Level::NOTE.message(note.as_str())));
    let is_fix = |help: &&String| !found.fixes.iter().any(|fix| fix.message == **help);
    main = main.elements(found.helps.iter().filter(is_fix).map(|help| Level::HELP.message(help.as_str())));
    let fixes = found.fixes.iter().map(|fix| fixed(fix, sources));
    let groups: Vec<Group<'_>> = std::iter::once(main).chain(fixes).collect();
    renderer.render(&groups) + "\n"
}

/// `path:line:column: error[E0201]: message`, without a line break: for editors.
pub fn render_short(found: &Diagnostic, sources: &[Source]) -> String {
    let title = format!("{}[{}]: {}", found.severity.name(), found.code, found.message);
    let place = found.place().and_then(|(file, span)| Some((find(sources, file)?, span)));
    match place {
        Some((source, span)) => {
            let position = source.position(span.start);
            format!("{}:{}:{}: {title}", source.name, position.line, position.column)
        }
        None => title,
    }
}

fn find(sources: &[Source], file: FileId) -> Option<&Source> {
    sources.iter().find(|source| source.id == file)
}

/// Bytes of the scene that are shown in one piece, as the renderer goes through all of it: what lies further apart gets
/// pieces of its own, and of longer lines only the place is told.
const LARGE: u32 = 64 << 10;

/// The piece of a text round some spans: a large scene is not handed over whole.
struct Window<'a> {
    source: &'a Source,
    first_line: u32,
    whole: Span,
}

impl<'a> Window<'a> {
    fn round(source: &'a Source, spans: impl Iterator<Item = Span> + Clone) -> Window<'a> {
        let start = spans.clone().map(|span| span.start).min().unwrap_or_default();
        let end = spans.map(|span| span.end).max().unwrap_or_default();
        let first_line = source.line_index(source.clamp(start)).saturating_sub(CONTEXT);
        let last_line = source.line_index(source.clamp(end)).saturating_add(CONTEXT);
        let whole = Span::new(source.line_start(first_line), source.line_start(last_line.saturating_add(1)));
        Window { source, first_line, whole }
    }

    fn is_large(&self) -> bool {
        self.whole.len() > LARGE
    }

    /// A span as offsets in the window, on borders of characters.
    fn range(&self, span: Span) -> std::ops::Range<usize> {
        let inside = |offset| self.source.clamp(offset).clamp(self.whole.start, self.whole.end) - self.whole.start;
        inside(span.start) as usize..inside(span.end) as usize
    }

    fn text(&self) -> &'a str {
        self.source.slice(self.whole)
    }

    fn line(&self) -> usize {
        self.first_line as usize + 1
    }
}

fn labelled<'a>(group: Group<'a>, source: &'a Source, labels: &[&'a Label]) -> Group<'a> {
    let window = Window::round(source, labels.iter().map(|label| label.span));
    match labels {
        _ if !window.is_large() => group.element(annotated(&window, labels)),
        [only] => {
            let position = source.position(only.span.start);
            let (line, column) = (position.line as usize, position.column as usize);
            let group = group.element(Origin::path(&*source.name).line(line).char_column(column));
            if only.text.is_empty() { group } else { group.element(Level::NOTE.message(only.text.as_str())) }
        }
        labels => labels.iter().fold(group, |group, label| labelled(group, source, &[*label])),
    }
}

fn annotated<'a>(window: &Window<'a>, labels: &[&'a Label]) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
    let annotations = labels.iter().map(|label| {
        let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
        let annotation = kind.span(window.range(label.span));
        if label.text.is_empty() { annotation } else { annotation.label(label.text.as_str()) }
    });
    Snippet::source(window.text()).line_start(window.line()).path(&*window.source.name).annotations(annotations)
}

fn fixed<'a>(fix: &'a Fix, sources: &'a [Source]) -> Group<'a> {
    let mut group = Group::with_title(Level::HELP.secondary_title(fix.message.as_str()));
    for source in sources {
        let edits: Vec<&Edit> = fix.edits.iter().filter(|edit| edit.file == source.id).collect();
        if edits.is_empty() {
            continue;
        }
        let window = Window::round(source, edits.iter().map(|edit| edit.span));
        if window.is_large() {
            continue;
        }
        let patches = edits.iter().map(|edit| Patch::new(window.range(edit.span), edit.insert.as_str()));
        group = group
            .element(Snippet::source(window.text()).line_start(window.line()).path(&*source.name).patches(patches));
    }
    group
}
