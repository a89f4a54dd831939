//! What the grammar expected and did not find: the place of the `missing` node tells what.

use super::*;
use crate::diagnostic::Applicability::{Maybe, Safe};

/// What to say about one missing thing.
struct Expected {
    code: &'static str,
    message: String,
    label: &'static str,
    help: String,
}

/// The label where a name is missing: what follows may be meant as one.
const A_NAME: &str = "expected a name";

/// Something missing that unread text follows.
pub(super) struct Missing {
    pub found: Diagnostic,
    pub wants_name: bool,
}

impl Finder<'_> {
    pub(super) fn missing(&mut self, node: Part<'_>) {
        let at = node.span().end;
        if self.is_lost(at) || self.missing_at.replace(at) == Some(at) {
            return;
        }
        let (Some(parent), before) = (node.parent(), before(node)) else { return };
        let bad = self.bad_after(at);
        if self.let_without_equals(parent, before, at, bad) || self.dash_behind_name(before, at) {
            return;
        }
        if parent.kind() == SyntaxKind::EqProperty {
            self.merged.extend(bad.map(|bad| bad.span.start));
        }
        let Some(expected) = self.expected(parent, before) else { return };
        let next = self.next_word(at);
        let wants_name = expected.label == A_NAME;
        if wants_name && is_keyword(self.text(next)) {
            self.merged.extend(bad.map(|bad| bad.span.start));
            return self.keyword_as_name(next);
        }
        let wants_else = parent.kind() == SyntaxKind::IfValue;
        if wants_else && super::shape::is_else_if(self.text(next)) {
            self.merged.extend(bad.map(|bad| bad.span.start));
            return self.write_else_if(next);
        }
        if expected.code == "E0108" && is_keyword(self.text(next)) && self.keywords.contains(self.text(next)) {
            self.merged.extend(bad.map(|bad| bad.span.start));
            return;
        }
        if expected.code == "E0108" && bad.is_none() && self.braced_vector(at) {
            return;
        }
        let wants_ease = before.is_some_and(|before| before.kind() == SyntaxKind::KwEase);
        if let Some(bad) = bad.filter(|_| wants_ease) {
            self.merged.insert(bad.span.start);
            return self.bad_ease(bad.span);
        }
        let place = bad.map_or(Span::at(at), |bad| self.trimmed(bad.span));
        let mut found = self.error(expected.code, expected.message, place, expected.label);
        if expected.code == "E0108" && is_keyword(self.text(next)) {
            found = found.help(format!("`{}` is a keyword: no value can have that name", self.text(next)));
        } else if !expected.help.is_empty() {
            found = found.help(expected.help);
        }
        match bad {
            Some(bad) => self.bad_with(bad, Some(Missing { found, wants_name })),
            None => self.push(found),
        }
    }

    /// `position: {0, 1, 0}`
    fn braced_vector(&mut self, at: u32) -> bool {
        let line = self.source.line_span(self.source.line_index(at));
        let rest = self.text(Span::new(at, line.end));
        let start = rest.len() - rest.trim_start().len();
        let Some(end) = rest.get(start..).filter(|rest| rest.starts_with('{')).and_then(|rest| rest.find('}')) else {
            return false;
        };
        let inside = rest.get(start + 1..start + end).unwrap_or_default();
        let plain = |text: &str| {
            let text = text.trim().trim_start_matches('-');
            text.starts_with(|digit: char| digit.is_ascii_digit()) && !text.contains([' ', ':', '{', '('])
        };
        if !inside.contains(',') || !inside.split(',').all(plain) {
            return false;
        }
        let written = format!("({})", inside.trim());
        let place = Span::new(at + start as u32, at + (start + end) as u32 + 1);
        let found = self.error("E0125", "vectors are written `(0, 1, 0)`", place, "braces hold properties").fix(
            Safe,
            format!("write `{written}`"),
            self.file(),
            place,
            written,
        );
        self.push(found);
        self.braced.insert(place.start);
        true
    }

    /// `ease ease-in-out`
    fn bad_ease(&mut self, span: Span) {
        let span = self.trimmed(span);
        let text = self.text(span);
        let end = text.find(|next: char| !(unicode_ident::is_xid_continue(next) || next == '-')).unwrap_or(text.len());
        let place = Span::new(span.start, span.start + end.max(1) as u32);
        let word = self.text(place);
        let found = self.error("E0609", format!("no easing `{word}`"), place, "not an easing");
        let found = match crate::builtin::ease::nearest(word) {
            Some(near) => found.fix(Safe, format!("write `{near}`"), self.file(), place, near),
            None => found.help("for example `linear`, `step`, `ease_in_out` or `out_cubic`"),
        };
        self.push(found);
    }

    /// `let x: 3`, `let x 3`, `param x: float`
    fn let_without_equals(&mut self, parent: Part<'_>, before: Option<Part<'_>>, at: u32, bad: Option<Bad>) -> bool {
        let word = match parent.kind() {
            SyntaxKind::LetDecl => "let",
            SyntaxKind::ParamDecl => "param",
            _ => return false,
        };
        let Some(before) = before else { return false };
        let rest = self.text(Span::new(at, self.source.line_span(self.source.line_index(at)).end)).trim_start();
        let message = format!("`{word}` needs `=`");
        let name = parts(parent).nth(1).map_or(String::new(), |name| self.text(name.span()).to_string());
        let found =
            match before.kind() {
                // A dash behind a name is a mistake of its own.
                SyntaxKind::Colon if !rest.starts_with('=') => {
                    let colon = before.span();
                    let value = bad.map_or("value".to_string(), |bad| excerpt(self.text(bad.span)));
                    let help = format!("write `{word} {name} = {value}`");
                    let name_end = colon.start - self.spaces_before(colon.start);
                    let applicability = if bad.is_some() { Safe } else { Maybe };
                    self.error("E0107", message, colon, "use `=`")
                        .note("`:` gives the type of a value, `=` the value")
                        .fix(applicability, help, self.file(), Span::new(name_end, colon.end), " =")
                }
                SyntaxKind::Ident | SyntaxKind::BadName | SyntaxKind::Ty if !rest.starts_with('-') => {
                    let label = "no `=` behind this";
                    let found = self.error("E0107", message, Span::at(at), label);
                    match bad {
                        Some(bad)
                            if self
                                .text(bad.span)
                                .starts_with(|first: char| first.is_alphanumeric() || "\"(#[".contains(first)) =>
                        {
                            found.fix(Maybe, "insert `=`", self.file(), Span::new(at, bad.span.start), " = ")
                        }
                        _ => found.help(format!("write `{word} {name} = ...`")),
                    }
                }
                _ => return false,
            };
        self.merged.extend(bad.map(|bad| bad.span.start));
        self.push(found);
        true
    }

    /// `let my-ball = 1`: the parser saw the name `my` and then a mistake.
    fn dash_behind_name(&mut self, before: Option<Part<'_>>, at: u32) -> bool {
        let Some(name) = before.filter(|before| before.kind() == SyntaxKind::Ident).map(Part::span) else {
            return false;
        };
        let rest = self.text(Span::new(at, self.source.line_span(self.source.line_index(at)).end));
        let length =
            rest.find(|next: char| !(unicode_ident::is_xid_continue(next) || next == '-')).unwrap_or(rest.len());
        let dashed = rest.get(..length).unwrap_or_default().trim_end_matches('-');
        let starts_name = dashed.strip_prefix('-').is_some_and(|rest| rest.starts_with(unicode_ident::is_xid_continue));
        if name.end != at || !starts_name {
            return false;
        }
        self.merged.extend(self.bad_after(at).map(|bad| bad.span.start));
        self.dashed_name(Span::new(name.start, at + dashed.len() as u32));
        true
    }

    fn expected(&self, parent: Part<'_>, before: Option<Part<'_>>) -> Option<Expected> {
        use SyntaxKind::*;
        let none = std::string::String::new;
        let value = |message: std::string::String| ("E0108", message, "expected a value", none());
        let token = |message: &str, label, help: &str| ("E0126", message.to_string(), label, help.to_string());
        let last = before.map(|part| part.kind());
        let word = before.map_or("", |part| self.text(part.span()));
        let after_word = || format!("missing value after `{word}`");
        let a_name = || token(&format!("expected a name after `{word}`"), A_NAME, "");
        let a_type = || {
            token(
                &format!("expected a type after `{word}`"),
                "expected a type",
                "types are `float`, `length`, `vec3` and so on",
            )
        };
        let (code, message, label, help) = match (parent.kind(), last) {
            (EqProperty, _) => return None,
            (Property | NamedArg, _) => {
                let key = parts(parent).next().map_or("", |key| self.text(key.span()));
                let help = match key {
                    "material" => "expected a material name or a `diffuse { }` block",
                    _ => "write a value behind the colon",
                };
                (
                    "E0108",
                    format!("missing value for `{}`", key.trim_matches('"')),
                    "expected a value",
                    help.to_string(),
                )
            }
            (Like, Some(KwLike)) => ("E0108", after_word(), "expected a node", "name the node to copy".to_string()),
            (Like, _) => token(
                "expected `{` after what is copied",
                "expected `{`",
                "say what differs: `like white { roughness: 1 }`",
            ),
            (LangDecl, _) => token("expected a version after `lang`", "expected a number", "write `lang 1`"),
            (ImportDecl, Some(Names)) => {
                token("expected `from` after the names", "expected `from`", "write `import { a, b } from \"file.kin\"`")
            }
            (ImportDecl | Rename, Some(KwAs)) | (Rename, _) => a_name(),
            (ImportDecl, _) => token(
                "expected a file name in quotes",
                "expected a file name",
                "write `import \"lib/metals.kin\" as metals`",
            ),
            (LetDecl | ParamDecl | FnDecl | PrefabDecl, Some(KwLet | KwParam | KwFn | KwPrefab)) => a_name(),
            (LetDecl | ParamDecl | Formal, Some(Equals)) | (FnDecl, Some(Equals)) => value(after_word()),
            (LetDecl | ParamDecl | Formal, Some(Colon)) | (FnDecl, Some(Arrow)) => a_type(),
            (ParamDecl, Some(KwIn)) => {
                ("E0108", "missing range after `in`".to_string(), "expected a range", "write `in 0..1`".to_string())
            }
            (LetDecl | ParamDecl, _) => token("expected `=`", "expected `=`", ""),
            (FnDecl, Some(Ident | BadName)) => {
                token("expected `(` after the name of a function", "expected `(`", "write `fn name(a, b) = a + b`")
            }
            (FnDecl, _) => token("expected `{` or `=` after the head of a function", "expected `{` or `=`", ""),
            (PrefabDecl, _) => token("expected `{` after the head of a prefab", "expected `{`", ""),
            (ForStmt | Comp, Some(KwFor | Comma)) => a_name(),
            (ForStmt | Comp, Some(Ident)) => {
                token("expected `in` after the name", "expected `in`", "write `for i in 0..10`")
            }
            (ForStmt | Comp, Some(KwIn)) => (
                "E0108",
                "missing list after `in`".to_string(),
                "expected a list or a range",
                "write `for i in 0..10`".to_string(),
            ),
            (Comp, Some(Colon)) => value(after_word()),
            (Comp, Some(KwIf)) => ("E0108", "missing condition after `if`".to_string(), "expected a condition", none()),
            (Comp, _) => token("expected `:` before the value", "expected `:`", "write `[for i in 0..10: i * 2]`"),
            (ForStmt, _) => token("expected `{` after the head of a loop", "expected `{`", ""),
            (IfStmt | IfValue, Some(KwIf)) => {
                ("E0108", "missing condition after `if`".to_string(), "expected a condition", none())
            }
            (IfStmt | IfValue, Some(KwElse)) => (
                "E0123",
                "expected `{` or `if` after `else`".to_string(),
                "expected `{` or `if`",
                "write `else { ... }`".to_string(),
            ),
            (IfValue, Some(Arm)) => token(
                "an `if` value needs `else`",
                "expected `else`",
                "say what the value is otherwise: `else { ... }`",
            ),
            (IfStmt | IfValue, _) => token("expected `{` after the condition", "expected `{`", ""),
            (Arm, _) => value("missing value in braces".to_string()),
            (Keys, _) => token("expected `{` after `keys`", "expected `{`", "write `keys { 0s: 1, 2s: 5 }`"),
            (Key, Some(KwAfter)) => value(after_word()),
            (Key, Some(Colon)) => value("missing value for this key".to_string()),
            (Key, Some(KwEase)) => ("E0108", after_word(), "expected a curve", "write `ease in_out_sine`".to_string()),
            (Key, _) => token("expected `:` after the time of a key", "expected `:`", "write `2s: value`"),
            (Expr | Named, _) => value(after_word()),
            (Field, _) => a_name(),
            (Index, _) => value("missing index".to_string()),
            (ReturnStmt, _) => value(after_word()),
            _ => value("missing value".to_string()),
        };
        Some(Expected { code, message, label, help })
    }

    /// The next word behind spaces.
    fn next_word(&self, at: u32) -> Span {
        let rest = self.text(Span::new(at, self.source.line_span(self.source.line_index(at)).end));
        let word = rest.trim_start();
        let start = at + (rest.len() - word.len()) as u32;
        let length = word.find(|next: char| !unicode_ident::is_xid_continue(next)).unwrap_or(word.len());
        Span::new(start, start + length as u32)
    }

    fn spaces_before(&self, at: u32) -> u32 {
        let line = self.text(Span::new(self.source.line_start(self.source.line_index(at)), at));
        (line.len() - line.trim_end().len()) as u32
    }

    pub(super) fn trimmed(&self, span: Span) -> Span {
        Span::new(span.start, span.start + self.text(span).trim_end().len() as u32)
    }
}

/// The words that cannot be names.
pub(super) fn is_keyword(word: &str) -> bool {
    matches!(
        word,
        "let"
            | "fn"
            | "prefab"
            | "for"
            | "in"
            | "if"
            | "else"
            | "import"
            | "from"
            | "as"
            | "param"
            | "return"
            | "keys"
            | "ease"
            | "after"
            | "like"
            | "lang"
            | "true"
            | "false"
    )
}
