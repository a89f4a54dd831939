//! What a scene says about its pictures: `// test: cornell.png, samples 64, flip < 0.02` on a line of its own names a
//! reference picture, how the scene is rendered for it, and how far the two may differ.

use std::collections::HashMap;

use crate::diagnostic::{Applicability, Diagnostic};
use crate::files::resolve;
use crate::source::{Source, Span};
use crate::suggest::suggest;
use crate::syntax::line_comments;

/// The word that such a comment begins with.
const MARK: &str = "test:";

/// How much a picture may differ where nothing is said of it.
const FLIP: f64 = 0.02;

/// A picture that a scene is to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The line that says so, from 1.
    pub line: u32,
    /// All that it says, as it is written.
    pub text: String,
    /// The reference, as it is written: as seen from the scene, or from the project's root with a leading `/`.
    pub file: String,
    /// The reference from the project's root.
    pub path: String,
    /// Of the film.
    pub frame: i64,
    /// Samples a pixel, if not the scene's own.
    pub samples: Option<u32>,
    /// Width and height in pixels, if not the scene's own.
    pub size: Option<[u32; 2]>,
    /// Seed of the noise, if not the scene's own.
    pub seed: Option<u32>,
    /// The camera, if not the scene's own.
    pub camera: Option<String>,
    /// Names and values of `param`s.
    pub params: Vec<(String, String)>,
    /// The mean of FLIP is below this, of 0 to 1.
    pub flip: Option<f64>,
    /// The mean of (picture − reference)² / (reference² + 0.01) is below this.
    pub error: Option<f64>,
}

/// What can be said after the file.
const WORDS: [&str; 8] = ["samples", "size", "frame", "seed", "camera", "param", "flip", "error"];

/// The endings of pictures that can be compared.
pub const ENDINGS: [&str; 5] = ["png", "jpg", "jpeg", "exr", "hdr"];

/// The claims in a scene's text, in order, and what is wrong with those that are none (W0904). The source is named from
/// the project's root.
///
/// ```
/// use kinora_lang::claims::claims;
/// use kinora_lang::source::{FileId, Source};
///
/// let source = Source::new(FileId(0), "scenes/a.kin", "lang 1\n// test: a.png, samples 64, flip < 0.01\n");
/// let found = claims(&source);
/// let claim = found[0].as_ref().unwrap();
/// assert_eq!((claim.line, &*claim.path, claim.samples, claim.flip), (2, "scenes/a.png", Some(64), Some(0.01)));
/// ```
pub fn claims(source: &Source) -> Vec<Result<Claim, Box<Diagnostic>>> {
    let mut found = Vec::new();
    if !source.text.contains(MARK) {
        return found;
    }
    let mut named: HashMap<String, Span> = HashMap::new();
    for start in line_comments(&source.text) {
        let whole = source.line_span(source.line_index(start as u32));
        let comment = Span::new(start as u32, whole.end);
        let text = source.slice(comment);
        let Some(rest) = text.strip_prefix("//").and_then(|text| text.trim_start().strip_prefix(MARK)) else {
            continue;
        };
        if !source.slice(Span::new(whole.start, comment.start)).trim().is_empty() {
            let wrong = wrong(source, comment, "a test stands on a line of its own", "behind something else");
            found.push(Err(Box::new(wrong.help("write it on the line above"))));
            continue;
        }
        let rest = Span::new(comment.end - rest.len() as u32, comment.end);
        let claim = Reader { source, comment, rest }.claim();
        found.push(claim.and_then(|(claim, span)| match named.insert(claim.path.clone(), span) {
            None => Ok(claim),
            Some(before) => {
                let wrong = wrong(source, span, format!("`{}` is named twice", claim.file), "named again");
                let wrong = wrong.label(source.id, before, "named here");
                Err(Box::new(wrong.help("give each picture of the scene a reference of its own")))
            }
        }));
    }
    found
}

/// What is wrong with the claims in a text.
pub fn misread(source: &Source) -> Vec<Diagnostic> {
    claims(source).into_iter().filter_map(Result::err).map(|found| *found).collect()
}

/// W0904.
fn wrong(source: &Source, span: Span, message: impl Into<String>, label: &str) -> Diagnostic {
    Diagnostic::new("W0904", message).primary(source.id, span, label)
}

/// One comment.
struct Reader<'s> {
    source: &'s Source,
    comment: Span,
    /// What stands behind the mark.
    rest: Span,
}

impl Reader<'_> {
    /// The claim, and where its file is written.
    fn claim(&self) -> Result<(Claim, Span), Box<Diagnostic>> {
        let source = self.source;
        let mut parts = self.parts().into_iter();
        let place = parts.next().unwrap_or(self.rest);
        let file = source.slice(place).trim_matches('"').to_string();
        if file.is_empty() {
            let wrong = wrong(source, self.comment, "a test names its reference", "no file is named");
            return Err(Box::new(wrong.help("write `// test: picture.png`")));
        }
        let path = resolve(&source.name, &file).map_err(|error| {
            // The text of a path that is not allowed, with the code that all of a test's mistakes have.
            Box::new(Diagnostic { code: "W0904", severity: W0904, ..error.diagnostic(source.id, place) })
        })?;
        let ending = path.rsplit('/').next().and_then(|name| name.rsplit_once('.')).map_or("", |(_, ending)| ending);
        if !ENDINGS.iter().any(|known| known.eq_ignore_ascii_case(ending)) {
            let known = "pictures are compared as .png, .jpg, .exr or .hdr";
            return Err(Box::new(
                wrong(source, place, format!("`{file}` is no picture to compare with"), "").help(known),
            ));
        }
        let mut claim = Claim {
            line: source.line_index(self.comment.start) + 1,
            text: source.slice(self.rest).trim().into(),
            file,
            path,
            frame: 0,
            samples: None,
            size: None,
            seed: None,
            camera: None,
            params: Vec::new(),
            flip: None,
            error: None,
        };
        let mut said = Vec::new();
        for part in parts {
            let word = self.say(&mut claim, part)?;
            if word != "param" && said.contains(&word) {
                return Err(Box::new(wrong(source, part, format!("`{word}` is said twice"), "said again")));
            }
            said.push(word);
        }
        if claim.flip.is_none() && claim.error.is_none() {
            claim.flip = Some(FLIP);
        }
        Ok((claim, place))
    }

    /// What stands between commas that are in no brackets and no quotes, without the space round it.
    fn parts(&self) -> Vec<Span> {
        let text = self.source.slice(self.rest);
        let (mut parts, mut start, mut depth, mut quoted) = (Vec::new(), 0, 0usize, false);
        let mut end_at = |start: usize, end: usize| {
            let part = &text[start..end];
            let before = part.len() - part.trim_start().len();
            let from = self.rest.start + (start + before) as u32;
            parts.push(Span::new(from, from + part.trim().len() as u32));
        };
        for (at, character) in text.char_indices() {
            match character {
                '"' => quoted = !quoted,
                '(' | '[' | '{' if !quoted => depth += 1,
                ')' | ']' | '}' if !quoted => depth = depth.saturating_sub(1),
                ',' if !quoted && depth == 0 => {
                    end_at(start, at);
                    start = at + 1;
                }
                _ => {}
            }
        }
        end_at(start, text.len());
        parts
    }

    /// Takes in one part behind the file; its word.
    fn say(&self, claim: &mut Claim, part: Span) -> Result<&'static str, Box<Diagnostic>> {
        let text = self.source.slice(part);
        let end = text.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(text.len());
        let (word, value) = text.split_at(end);
        let value = value.trim();
        let place = Span::new(part.start, part.start + end as u32);
        let Some(known) = WORDS.into_iter().find(|known| *known == word) else { return Err(self.unknown(word, place)) };
        let said = match known {
            "samples" => number(value, |samples| *samples > 0).map(|samples| claim.samples = Some(samples)),
            "frame" => number(value, |_| true).map(|frame| claim.frame = frame),
            "seed" => number(value, |_| true).map(|seed| claim.seed = Some(seed)),
            "size" => size(value).map(|size| claim.size = Some(size)),
            "camera" if value.is_empty() => Err("write the camera's name: `camera main`".into()),
            "camera" => {
                claim.camera = Some(value.into());
                Ok(())
            }
            "param" => pair(value).map(|pair| claim.params.push(pair)),
            "flip" => limit(value, 1.0).map(|flip| claim.flip = Some(flip)),
            _ => limit(value, f64::MAX).map(|error| claim.error = Some(error)),
        };
        said.map(|()| known).map_err(|how| {
            let message = match value {
                "" => format!("nothing is said after `{word}`"),
                value => format!("`{value}` means nothing after `{word}`"),
            };
            Box::new(wrong(self.source, part, message, "not understood").help(how.replace("WORD", word)))
        })
    }

    fn unknown(&self, word: &str, place: Span) -> Box<Diagnostic> {
        let message = match word {
            "" => "a test says something after each comma".to_string(),
            word => format!("`{word}` is not known here"),
        };
        let found = wrong(self.source, place, message, "no word of a test");
        let near = suggest(word, WORDS);
        let Some(first) = near.first().filter(|_| !word.is_empty()) else {
            return Box::new(found.help(format!("a test may say {}", WORDS.join(", "))));
        };
        let fix = format!("did you mean `{}`?", near.join("` or `"));
        Box::new(found.fix(Applicability::Maybe, fix, self.source.id, place, *first))
    }
}

const W0904: crate::diagnostic::Severity = crate::diagnostic::Severity::Warning;

fn number<T: std::str::FromStr>(text: &str, fits: impl Fn(&T) -> bool) -> Result<T, String> {
    text.parse().ok().filter(fits).ok_or_else(|| "write a whole number: `WORD 64`".into())
}

fn limit(text: &str, most: f64) -> Result<f64, String> {
    let number = text.strip_prefix('<').and_then(|rest| rest.trim().parse().ok());
    let number = number.filter(|number: &f64| *number > 0.0 && *number <= most);
    number.ok_or_else(|| match most <= 1.0 {
        true => "write a limit above 0 and up to 1: `WORD < 0.02`".into(),
        false => "write a limit above 0: `WORD < 0.001`".into(),
    })
}

/// Width and height in pixels, 1 to 16384: `640x360`.
///
/// # Errors
/// How it is written.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| "write width x height in pixels, each 1 to 16384: 640x360".into())
}

/// A name and a value: `name=value`.
///
/// # Errors
/// How it is written.
pub fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().into(), value.trim().into())),
        _ => Err("write a name, `=` and a value".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::FileId;

    #[test]
    fn lines() {
        let text = "lang 1\n// test: a.png\nsphere { }\n  //test: out/b.exr, samples 64, size 320x180, frame -3, seed 7, \
            camera top, param at=(1, 2, 3), param n = 3, error<1e-3\r\n// a test: no\n/// test: no.png\n/*\n\
            // test: no.png\n*/ let a = \"// test: no.png\"\n// test: \"a, b.png\"\n";
        let all = claims(&Source::new(FileId(0), "scenes/a.kin", text));
        assert_eq!(all.len(), 3, "{all:?}");
        let a = all[0].as_ref().unwrap();
        assert_eq!((a.line, &*a.file, &*a.path), (2, "a.png", "scenes/a.png"));
        assert_eq!((a.frame, a.flip, a.error), (0, Some(FLIP), None));
        let b = all[1].as_ref().unwrap();
        assert_eq!((b.line, &*b.file, b.frame, b.samples), (4, "out/b.exr", -3, Some(64)));
        assert_eq!((b.size, b.seed, b.camera.as_deref()), (Some([320, 180]), Some(7), Some("top")));
        assert_eq!(b.params, [("at".to_string(), "(1, 2, 3)".to_string()), ("n".to_string(), "3".to_string())]);
        assert_eq!((b.flip, b.error), (None, Some(1e-3)));
        assert_eq!(all[2].as_ref().unwrap().path, "scenes/a, b.png");
    }
}
