//! Which frames to render, as they are written on the command line, and the names of their files.
//!
//! A list is made of parts with commas between them: `a..b` (without b, as ranges of the language), `a-b` (both ends, as
//! render farms write it), either with `:step`, or one number. Numbers may be negative.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// More frames than this in one list is taken for a slip.
const MOST: u64 = 1_000_000;

/// Reads a list of frames; a frame that is named twice counts once, where it is first.
///
/// # Errors
/// One clause that says what is wrong with the list.
pub fn parse(list: &str) -> Result<Vec<i64>, String> {
    let mut frames = Vec::new();
    for part in list.split(',') {
        let mut part_frames = range(part.trim())?;
        let left = MOST.saturating_sub(frames.len() as u64);
        if part_frames.count > left {
            return Err(format!("`{list}` names more than {MOST} frames"));
        }
        frames.extend(part_frames.numbers());
    }
    let mut seen = HashSet::new();
    frames.retain(|frame| seen.insert(*frame));
    match frames.is_empty() {
        true => Err(format!("`{list}` names no frame")),
        false => Ok(frames),
    }
}

/// Writes a list of frames as [`parse`] reads it: `3,5-7`.
pub fn list(frames: &[i64]) -> String {
    let runs = frames.chunk_by(|a, b| a.checked_add(1) == Some(*b));
    let run = |run: &[i64]| match run {
        [first, .., last] => format!("{first}-{last}"),
        [only] => only.to_string(),
        [] => String::new(),
    };
    runs.map(run).collect::<Vec<_>>().join(",")
}

struct Range {
    first: i64,
    step: i64,
    count: u64,
}

impl Range {
    fn numbers(&mut self) -> impl Iterator<Item = i64> {
        let (first, step) = (self.first, self.step);
        (0..self.count).map(move |n| first.saturating_add(step.saturating_mul(n as i64)))
    }
}

fn range(part: &str) -> Result<Range, String> {
    let wrong = || format!("`{part}` is no frame list: write `0..96`, `1-96`, `0..96:2`, `7` or several with commas");
    let (span, step) = match part.split_once(':') {
        Some((span, step)) => (span, step.parse::<i64>().ok().filter(|step| *step > 0).ok_or_else(wrong)?),
        None => (part, 1),
    };
    // The sign of the first number is not the dash of `a-b`.
    let digits = span.char_indices().skip(1).find(|(_, c)| !c.is_ascii_digit()).map_or(span.len(), |(at, _)| at);
    let (first, rest) = span.split_at(digits);
    let first = number(first).ok_or_else(wrong)?;
    // One past the last.
    let end = match (rest.strip_prefix(".."), rest.strip_prefix('-')) {
        _ if rest.is_empty() => i128::from(first) + 1,
        (Some(end), _) => i128::from(number(end).ok_or_else(wrong)?),
        (_, Some(last)) => i128::from(number(last).ok_or_else(wrong)?) + 1,
        _ => return Err(wrong()),
    };
    let length = end - i128::from(first);
    if length < 0 {
        return Err(format!("`{part}` runs backwards"));
    }
    let count = u64::try_from((length + i128::from(step) - 1) / i128::from(step)).unwrap_or(u64::MAX);
    Ok(Range { first, step, count })
}

fn number(text: &str) -> Option<i64> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    (!digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())).then(|| text.parse().ok()).flatten()
}

/// A path whose file name has a place for the frame's number: `####`, `%04d` or `{frame:04}`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    width: usize,
    after: String,
}

impl Pattern {
    /// Reads a pattern; `None` if there is no place for a number.
    pub fn parse(path: &Path) -> Option<Pattern> {
        let name = path.file_name()?.to_str()?;
        let (before, width, after) = hashes(name).or_else(|| percent(name)).or_else(|| braces(name))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Some(Pattern { folder, before: before.into(), width: width.min(18), after: after.into() })
    }

    /// The folder that the files lie in; empty for the current one.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a frame may have a file of this name.
    pub fn is_of(&self, name: &str) -> bool {
        let number = name.strip_prefix(&*self.before).and_then(|rest| rest.strip_suffix(&*self.after));
        number.is_some_and(|number| self::number(number).is_some())
    }

    /// The file of a frame. The number has at least as many digits as the pattern says, a minus sign not counted.
    pub fn file(&self, frame: i64) -> PathBuf {
        let sign = if frame < 0 { "-" } else { "" };
        let (Pattern { before, width, after, .. }, digits) = (self, frame.unsigned_abs());
        self.folder.join(format!("{before}{sign}{digits:0width$}{after}"))
    }
}

// The last run of `#`.
fn hashes(name: &str) -> Option<(&str, usize, &str)> {
    let end = name.rfind('#')? + 1;
    let before = name[..end].trim_end_matches('#');
    Some((before, end - before.len(), &name[end..]))
}

fn percent(name: &str) -> Option<(&str, usize, &str)> {
    let (before, rest) = name.split_once('%')?;
    let (width, after) = rest.split_once('d')?;
    Some((before, width_of(width)?, after))
}

fn braces(name: &str) -> Option<(&str, usize, &str)> {
    let (before, rest) = name.split_once("{frame")?;
    let (width, after) = rest.split_once('}')?;
    let width = match width {
        "" => "",
        width => width.strip_prefix(':')?,
    };
    Some((before, width_of(width)?, after))
}

fn width_of(digits: &str) -> Option<usize> {
    match digits {
        "" => Some(1),
        digits => digits.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists() {
        for (list, expected) in [
            ("7", Some(vec![7])),
            ("-7", Some(vec![-7])),
            ("0..3", Some(vec![0, 1, 2])),
            ("1-3", Some(vec![1, 2, 3])),
            ("0..5:2", Some(vec![0, 2, 4])),
            ("0-4:2", Some(vec![0, 2, 4])),
            ("0..6:4", Some(vec![0, 4])),
            ("-2..1", Some(vec![-2, -1, 0])),
            ("-3--1", Some(vec![-3, -2, -1])),
            ("-5..-3", Some(vec![-5, -4])),
            ("9, 1-2 ,9,2", Some(vec![9, 1, 2])),
            ("5..5,1", Some(vec![1])),
            ("9223372036854775807", Some(vec![i64::MAX])),
            ("5..5", None),
            ("3..1", None),
            ("3-1", None),
            ("", None),
            ("1,", None),
            ("a", None),
            ("1..", None),
            ("..4", None),
            ("1-", None),
            ("--1", None),
            ("1.5", None),
            ("0..4:0", None),
            ("0..4:-1", None),
            ("0..4:", None),
            ("0..9999999999", None),
            ("-9223372036854775808-9223372036854775807", None),
            ("99999999999999999999", None),
            ("é..3", None),
        ] {
            assert_eq!(parse(list).ok(), expected, "{list:?}");
        }
    }

    #[test]
    fn lists_are_written_as_they_are_read() {
        for (frames, expected) in [
            (vec![], ""),
            (vec![7], "7"),
            (vec![3, 5, 6, 7, 9, 10], "3,5-7,9-10"),
            (vec![-3, -2, 0], "-3--2,0"),
            (vec![2, 1, 0], "2,1,0"),
            (vec![i64::MAX], "9223372036854775807"),
        ] {
            assert_eq!(list(&frames), expected);
            assert!(frames.is_empty() || parse(expected) == Ok(frames));
        }
    }

    #[test]
    fn names_of_frames() {
        let pattern = Pattern::parse(Path::new("out/f.####.png")).unwrap();
        for (name, expected) in [
            ("f.0001.png", true),
            ("f.-0001.png", true),
            ("f.12345.png", true),
            ("f..png", false),
            ("f.a.png", false),
            ("f.0001.exr", false),
            ("g.0001.png", false),
        ] {
            assert_eq!(pattern.is_of(name), expected, "{name}");
        }
    }

    #[test]
    fn names() {
        for (pattern, frame, expected) in [
            ("out/frame.####.png", 7, Some("out/frame.0007.png")),
            ("frame.####.png", -1, Some("frame.-0001.png")),
            ("frame.##.png", 1234, Some("frame.1234.png")),
            ("a#b.###.exr", 5, Some("a#b.005.exr")),
            ("f%04d.png", 12, Some("f0012.png")),
            ("f%d.png", 12, Some("f12.png")),
            ("f{frame:04}.png", 12, Some("f0012.png")),
            ("f{frame}.png", 12, Some("f12.png")),
            ("out####/frame.png", 1, None),
            ("frame.png", 1, None),
            ("f%xd.png", 1, None),
            ("f{frame:x}.png", 1, None),
            ("é%", 1, None),
        ] {
            let file = Pattern::parse(Path::new(pattern)).map(|found| found.file(frame));
            assert_eq!(file.as_deref(), expected.map(Path::new), "{pattern} {frame}");
        }
    }
}
