//! What a scene says about its pictures: `// test: cornell.png, samples 64, flip < 0.02`.

use kinora_lang::suggest::suggest;

/// The first words of such a line.
const MARK: &str = "// test:";

/// How much a picture may differ where nothing is said of it.
const FLIP: f64 = 0.02;

/// A picture that a scene is to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The line that says so, from 1.
    pub line: usize,
    /// The reference, beside the scene.
    pub file: String,
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
    /// Values of `param`s.
    pub params: Vec<(String, String)>,
    /// The mean of FLIP is below this.
    pub flip: Option<f64>,
    /// The relative error² is below this.
    pub error: Option<f64>,
}

/// A line that cannot be understood, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misread {
    pub line: usize,
    pub why: String,
}

/// What can be said after the file.
const WORDS: [&str; 8] = ["samples", "size", "frame", "seed", "camera", "flip", "error", "param"];

/// The claims in a scene's text, in order.
pub fn claims(text: &str) -> Vec<Result<Claim, Misread>> {
    let lines = text.lines().enumerate();
    let lines = lines.filter_map(|(at, line)| Some((at + 1, line.trim_start().strip_prefix(MARK)?)));
    lines.map(|(line, rest)| claim(line, rest).map_err(|why| Misread { line, why })).collect()
}

fn claim(line: usize, text: &str) -> Result<Claim, String> {
    let mut parts = text.split(',').map(str::trim);
    let file = parts.next().unwrap_or("").trim_matches('"').to_string();
    if file.is_empty() {
        return Err("name the reference: `// test: picture.png`".into());
    }
    let mut claim = Claim {
        line,
        file,
        frame: 0,
        samples: None,
        size: None,
        seed: None,
        camera: None,
        params: Vec::new(),
        flip: None,
        error: None,
    };
    for part in parts {
        let (word, value) = part.split_once(char::is_whitespace).unwrap_or((part, ""));
        let value = value.trim();
        match word {
            "samples" => claim.samples = Some(number(word, value, |samples| *samples > 0)?),
            "frame" => claim.frame = number(word, value, |_| true)?,
            "seed" => claim.seed = Some(number(word, value, |_| true)?),
            "size" => claim.size = Some(crate::flags::size(value)?),
            "camera" if !value.is_empty() => claim.camera = Some(value.into()),
            "camera" => return Err("write the camera's name after `camera`".into()),
            "param" => claim.params.push(crate::flags::pair(value)?),
            "flip" => claim.flip = Some(limit(word, value)?),
            "error" => claim.error = Some(limit(word, value)?),
            _ => {
                let way_out = match suggest(word, WORDS).as_slice() {
                    [] => format!("it knows {}", WORDS.join(", ")),
                    close => format!("did you mean `{}`?", close.join("` or `")),
                };
                return Err(format!("`{word}` is not known here; {way_out}"));
            }
        }
    }
    if claim.flip.is_none() && claim.error.is_none() {
        claim.flip = Some(FLIP);
    }
    Ok(claim)
}

fn number<T: std::str::FromStr>(word: &str, text: &str, fits: impl Fn(&T) -> bool) -> Result<T, String> {
    text.parse().ok().filter(fits).ok_or_else(|| format!("`{word}` needs a whole number: `{word} 64`"))
}

fn limit(word: &str, text: &str) -> Result<f64, String> {
    let number = text.strip_prefix('<').and_then(|rest| rest.trim().parse().ok());
    let number = number.filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| format!("`{word}` needs a limit: `{word} < 0.02`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines() {
        let text = "lang 1\n// test: a.png\nsphere { }\n  // test: out/b.exr, samples 64, size 320x180, frame -3, seed 7, \
            camera top, param hue=0.5, param n=3, error < 1e-3\n// a test: no\n";
        let all = claims(text);
        assert_eq!(all.len(), 2);
        let a = all[0].as_ref().unwrap();
        assert_eq!((a.line, &*a.file, a.frame, a.flip, a.error), (2, "a.png", 0, Some(FLIP), None));
        let b = all[1].as_ref().unwrap();
        assert_eq!((b.line, &*b.file, b.frame, b.samples), (4, "out/b.exr", -3, Some(64)));
        assert_eq!((b.size, b.seed, b.camera.as_deref()), (Some([320, 180]), Some(7), Some("top")));
        assert_eq!(b.params, [("hue".to_string(), "0.5".to_string()), ("n".to_string(), "3".to_string())]);
        assert_eq!((b.flip, b.error), (None, Some(1e-3)));
    }

    #[test]
    fn mistakes() {
        for (text, why) in [
            ("", "name the reference"),
            (" a.png, smaples 3", "`smaples` is not known here; did you mean `samples`?"),
            (" a.png, samples 0", "whole number"),
            (" a.png, samples", "whole number"),
            (" a.png, flip 0.1", "`flip < 0.02`"),
            (" a.png, flip < x", "`flip < 0.02`"),
            (" a.png, flip < -1", "`flip < 0.02`"),
            (" a.png, size 3", "width x height"),
            (" a.png, camera", "name"),
            (" a.png, param x", "`=`"),
            (" a.png,", "it knows samples"),
        ] {
            let found = claims(&format!("// test:{text}\n"));
            let Err(Misread { line: 1, why: said }) = &found[0] else { panic!("{text}") };
            assert!(said.contains(why), "{text}: {said}");
        }
    }
}
