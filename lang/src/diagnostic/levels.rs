//! How findings are taken: what flags and `kinora.toml` say about codes.

use super::{Applicability, Diagnostic, Severity, codes};
use crate::source::{Source, Span};
use crate::suggest::suggest;
use toml_edit::{Document, Item, TableLike, Value};

/// How a warning is taken. Errors stay errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// It is not shown.
    Allow,
    /// It is shown.
    Warn,
    /// It is an error.
    Deny,
}

impl Level {
    const ALL: [(&str, Level); 3] = [("allow", Level::Allow), ("warn", Level::Warn), ("deny", Level::Deny)];

    fn of(word: &str) -> Option<Level> {
        Level::ALL.iter().find(|(name, _)| *name == word).map(|(_, level)| *level)
    }
}

/// What stands for every warning.
const WARNINGS: &str = "warnings";

/// The levels of codes: what is said of a code holds before what is said of all `warnings`, and what is said later before
/// what was said earlier.
///
/// ```
/// use kinora_lang::diagnostic::{Level, Levels};
/// let mut levels = Levels::default();
/// levels.set("W0401", Level::Allow).unwrap();
/// levels.set("warnings", Level::Deny).unwrap();
/// assert_eq!((levels.level("W0401"), levels.level("W0402")), (Level::Allow, Level::Deny));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Levels(Vec<(&'static str, Level)>);

impl Levels {
    /// Says how a code, or all `warnings`, are taken.
    ///
    /// # Errors
    /// There is no such code, or it is an error's and should be less than that: one clause.
    pub fn set(&mut self, word: &str, level: Level) -> Result<(), String> {
        let code = match codes::find(word) {
            _ if word == WARNINGS => WARNINGS,
            None => return Err(no_code(word)),
            Some(row) if row.code.starts_with('E') && level != Level::Deny => {
                return Err(format!("`{}` is an error and stays one: only warnings can be allowed", row.code));
            }
            Some(row) => row.code,
        };
        self.0.push((code, level));
        Ok(())
    }

    /// These, and then those.
    pub fn then(mut self, later: &Levels) -> Levels {
        self.0.extend_from_slice(&later.0);
        self
    }

    /// How the code of a warning is taken.
    pub fn level(&self, code: &str) -> Level {
        let said = |word: &str| self.0.iter().rev().find(|(of, _)| *of == word).map(|(_, level)| *level);
        said(code).or_else(|| said(WARNINGS)).unwrap_or(Level::Warn)
    }

    /// The diagnostic as it is to be taken; `None` where it is not shown.
    pub fn apply(&self, mut found: Diagnostic) -> Option<Diagnostic> {
        if found.is_error() {
            return Some(found);
        }
        match self.level(found.code) {
            Level::Allow => return None,
            Level::Warn => {}
            Level::Deny => found.severity = Severity::Error,
        }
        Some(found)
    }
}

/// Why a word is no code, with those that it may have been meant to be.
pub fn no_code(word: &str) -> String {
    match codes::near(word).as_slice() {
        [] => format!("there is no code `{word}`; `kinora explain --all` lists them"),
        near => format!("there is no code `{word}`; did you mean {}?", near.join(", ")),
    }
}

/// The levels of a project: `[lints]` in its `kinora.toml`. A key is a code or `warnings` and its value a level, or a key
/// is a level and its value those words.
///
/// ```
/// use kinora_lang::diagnostic::{Level, levels_of_project};
/// use kinora_lang::source::{FileId, Source};
///
/// let text = "[lints]\nwarnings = \"deny\"\nallow = [\"W0401\", \"W0201\"]\n";
/// let (levels, wrong) = levels_of_project(&Source::new(FileId(0), "kinora.toml", text));
/// assert_eq!((levels.level("W0201"), levels.level("W0402"), wrong.len()), (Level::Allow, Level::Deny, 0));
/// ```
pub fn levels_of_project(source: &Source) -> (Levels, Vec<Diagnostic>) {
    let mut project = Project { source, levels: Levels::default(), wrong: Vec::new() };
    match Document::parse(&*source.text) {
        Ok(document) => project.read(document.as_table()),
        Err(error) => {
            let message = error.message().split('\n').next().unwrap_or_default().to_string();
            project.report(error.span(), format!("kinora.toml is not TOML: {message}"), "here");
        }
    }
    (project.levels, project.wrong)
}

struct Project<'s> {
    source: &'s Source,
    levels: Levels,
    wrong: Vec<Diagnostic>,
}

type Place = Option<std::ops::Range<usize>>;

const TABLES: [&str; 1] = ["lints"];

impl Project<'_> {
    fn read(&mut self, document: &dyn TableLike) {
        for (name, item) in document.iter() {
            let place = document.key(name).and_then(|key| key.span());
            match (name, item.as_table_like()) {
                ("lints", Some(lints)) => self.lints(lints),
                ("lints", None) => self.report(place, "`lints` is a table".into(), "write `[lints]`"),
                _ => self.unknown(place, name),
            }
        }
    }

    /// W0714.
    fn unknown(&mut self, place: Place, name: &str) {
        let span = self.span(place);
        let found = Diagnostic::new("W0714", format!("`{name}` in kinora.toml means nothing"));
        let found = found.primary(self.source.id, span, "not known");
        self.wrong.push(match suggest(name, TABLES).first() {
            Some(near) => {
                found.fix(Applicability::Maybe, format!("did you mean `{near}`?"), self.source.id, span, *near)
            }
            None => found.help("it may have `[lints]`"),
        });
    }

    fn lints(&mut self, lints: &dyn TableLike) {
        for (key, item) in lints.iter() {
            let place = lints.key(key).and_then(|key| key.span());
            match Level::of(key) {
                Some(level) => self.words(key, level, item),
                None => match item.as_str().map(|word| (word, Level::of(word))) {
                    Some((_, Some(level))) => self.set(place, key, level),
                    Some((word, None)) => {
                        let message = format!("no level `{word}`");
                        self.report(item.span(), message, "levels are `allow`, `warn` and `deny`");
                    }
                    None => self.report(item.span().or(place), format!("`{key}` needs a level"), "as `\"allow\"`"),
                },
            }
        }
    }

    fn words(&mut self, key: &str, level: Level, item: &Item) {
        let one = item.as_value().filter(|value| value.is_str());
        let words: Vec<&Value> = one.into_iter().chain(item.as_array().into_iter().flatten()).collect();
        if words.is_empty() && item.as_array().is_none() {
            self.report(item.span(), format!("`{key}` needs codes"), "as `[\"W0401\"]`");
        }
        for value in words {
            match value.as_str() {
                Some(word) => self.set(value.span(), word, level),
                None => self.report(value.span(), format!("`{key}` needs codes"), "as `\"W0401\"`"),
            }
        }
    }

    fn set(&mut self, place: Place, word: &str, level: Level) {
        if let Err(message) = self.levels.set(word, level) {
            self.report(place, message, "not a code of a warning, nor `warnings`");
        }
    }

    /// E0713.
    fn report(&mut self, place: Place, message: String, label: &str) {
        let span = self.span(place);
        self.wrong.push(Diagnostic::new("E0713", message).primary(self.source.id, span, label));
    }

    fn span(&self, place: Place) -> Span {
        place.map_or(Span::at(0), |place| Span::new(place.start as u32, place.end as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

    #[test]
    fn what_is_wrong_in_a_project_file_has_its_place() {
        let check = |text: &str, expected: &[(&str, &str, &str)]| {
            let source = Source::new(FileId(0), "kinora.toml", text);
            let (_, wrong) = levels_of_project(&source);
            let found: Vec<_> = wrong
                .iter()
                .map(|found| (found.code, found.message.as_str(), source.slice(found.place().unwrap().1)))
                .collect();
            assert_eq!(found, expected, "{text}");
        };
        check("", &[]);
        check("# a comment\n[lints]\nW0401 = \"allow\"\ndeny = \"warnings\"\n", &[]);
        check(
            "[lints]\nW9999 = \"deny\"",
            &[("E0713", "there is no code `W9999`; `kinora explain --all` lists them", "W9999")],
        );
        check(
            "[lints]\nwarn = [\"E0201\"]",
            &[("E0713", "`E0201` is an error and stays one: only warnings can be allowed", "\"E0201\"")],
        );
        check("[lints]\nW0401 = \"off\"", &[("E0713", "no level `off`", "\"off\"")]);
        check("[lints]\nW0401 = 1", &[("E0713", "`W0401` needs a level", "1")]);
        check("[lints]\ndeny = 1", &[("E0713", "`deny` needs codes", "1")]);
        check("[lint]\nx = 1", &[("W0714", "`lint` in kinora.toml means nothing", "lint")]);
        assert_eq!(levels_of_project(&Source::new(FileId(0), "kinora.toml", "[lints\n")).1[0].code, "E0713");
    }

    #[test]
    fn errors_stay() {
        let mut levels = Levels::default();
        assert!(levels.set("E0201", Level::Allow).is_err());
        levels.set("warnings", Level::Allow).unwrap();
        assert!(levels.apply(Diagnostic::new("E0201", "m")).is_some());
        assert!(levels.apply(Diagnostic::new("W0201", "m")).is_none());
        levels.set("w0201", Level::Deny).unwrap();
        assert!(levels.apply(Diagnostic::new("W0201", "m")).unwrap().is_error());
    }
}
