//! What editors know of the language without the program: lists of words in `docs/editors`, written from the tables that the
//! program reads. `UPDATE_EXPECT=1` writes them anew.
//!
//! `kinora.tmLanguage.json` is its template with the lists in place of `{{name}}`. In other files a list stands between a line
//! `begin NAME` and a line `end NAME`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use kinora_lang::builtin::{BUILTINS, ease};
use kinora_lang::diagnostic::{codes, levels_of_project, render_short};
use kinora_lang::dimension::UNITS;
use kinora_lang::eval::surface::is_point;
use kinora_lang::files::Memory;
use kinora_lang::schema::{DEPRECATED, KINDS, MIX, TYPES, Type};
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval, parse};
use serde_json::{Value, json};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/editors")
}

fn read(path: &str) -> String {
    let path = folder().join(path);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.replace("\r\n", "\n")
}

/// Holds a file against what it should be, or writes it.
#[track_caller]
fn expect(path: &str, text: &str) {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(folder().join(path), text).unwrap();
    }
    assert!(read(path) == text, "docs/editors/{path} is out of step, UPDATE_EXPECT=1 writes it anew");
}

/// Words of `keys(..)`, and functions behind `ease`.
const KEYS: &[(&str, &[&str])] = &[
    ("interpolate", &["eased", "linear", "step", "spline", "hermite"]),
    ("outside", &["hold", "loop", "pingpong", "extend", "error"]),
    ("space", &["linear", "oklch"]),
];
const CURVES: &[&str] = &["bezier", "steps", "spring"];

/// What is always there.
const ALWAYS: &[&str] = &["time", "frame", "p", "p_local", "uv", "normal"];

/// The words of a list, sorted and each once.
fn words(list: &str) -> Vec<String> {
    let kinds = || KINDS.iter().chain([&MIX]);
    let names = |names: &mut dyn Iterator<Item = &'static str>| names.map(str::to_owned).collect::<BTreeSet<_>>();
    let all = match list {
        "keywords" => {
            let rule = include_str!("../src/grammar.pest").split("keyword = _{").nth(1).unwrap();
            names(&mut rule.split('}').next().unwrap().split('"').skip(1).step_by(2))
        }
        "kinds" => names(&mut kinds().map(|kind| kind.name).chain(DEPRECATED.iter().map(|row| row.0))),
        "properties" => names(&mut kinds().flat_map(|kind| kind.all()).map(|property| property.name)),
        "choices" => {
            let properties = kinds().flat_map(|kind| kind.all()).flat_map(|property| match property.ty {
                Type::Choice(choices) => choices,
                _ => &[],
            });
            let params = BUILTINS.iter().flat_map(|function| function.params).flat_map(|param| param.words);
            let keys = KEYS.iter().flat_map(|row| row.1).copied();
            names(&mut properties.chain(params).map(|choice| choice.name).chain(keys))
        }
        "functions" => names(&mut BUILTINS.iter().map(|function| function.name)),
        "types" => names(&mut TYPES.iter().map(|row| row.name)),
        "eases" => ease::names().into_iter().collect(),
        "curves" => names(&mut CURVES.iter().copied()),
        "always" => names(&mut ALWAYS.iter().copied()),
        "units" => names(&mut UNITS.iter().map(|row| row.0).filter(|unit| *unit != "%")),
        _ => panic!("no list `{list}`"),
    };
    all.into_iter().collect()
}

/// A list as alternatives of a regular expression.
fn alternatives(list: &str) -> String {
    words(list).join("|")
}

/// A unit and its power; what follows is no letter.
fn unit() -> String {
    format!("(?:{})(?![\\p{{L}}\\p{{N}}_])(?:\\^-?[0-9])?", alternatives("units"))
}

const LISTS: &[&str] =
    &["keywords", "kinds", "properties", "choices", "functions", "types", "eases", "curves", "always", "units"];

#[test]
fn textmate() {
    let mut grammar = read("vscode/syntaxes/kinora.tmLanguage.template.json");
    for list in LISTS {
        grammar = grammar.replace(&format!("{{{{{list}}}}}"), &alternatives(list));
    }
    let in_json = unit().replace('\\', "\\\\");
    grammar = grammar.replace("{{unit}}", &in_json);
    assert!(!grammar.contains("{{"), "a list has no such name");
    let parsed: Value = serde_json::from_str(&grammar).unwrap();
    assert_eq!(parsed["scopeName"], "source.kinora");
    expect("vscode/syntaxes/kinora.tmLanguage.json", &grammar);
}

/// Writes the lists of a file, each word as the file's language has it, in lines of 100 columns.
#[track_caller]
fn fill(path: &str, word: fn(&str) -> String) {
    let mut text = String::new();
    let found = read(path);
    let mut lines = found.lines();
    let mut seen = 0;
    while let Some(line) = lines.next() {
        text += &format!("{line}\n");
        let Some((indent, list)) = line.split_once("begin ").map(|(before, list)| {
            let width = before.len() - before.trim_start().len();
            (" ".repeat(width), list.trim())
        }) else {
            continue;
        };
        if !LISTS.contains(&list) {
            continue;
        }
        seen += 1;
        let mut row = indent.clone();
        for word in words(list).iter().map(|name| word(name)) {
            if row.len() + word.len() >= 100 {
                text += &format!("{}\n", row.trim_end());
                row = indent.clone();
            }
            row += &format!("{word} ");
        }
        text += &format!("{}\n", row.trim_end());
        let end = lines.find(|line| line.trim_end().ends_with(&format!("end {list}")));
        text += &format!("{}\n", end.unwrap_or_else(|| panic!("{path}: `{list}` has no end")));
    }
    assert!(seen > 0, "{path} has no list");
    expect(path, &text);
}

#[test]
fn lists() {
    let quoted = |word: &str| format!("\"{word}\"");
    fill("tree-sitter-kinora/queries/highlights.scm", quoted);
    fill("emacs/kinora-mode.el", quoted);
    fill("sublime/Kinora.sublime-syntax", |word| format!("{word}|"));
    other_queries();
}

/// The names of Helix and Zed for what is coloured, where they are others than Neovim's.
const HELIX: &[(&str, &str)] = &[
    ("boolean", "constant.builtin.boolean"),
    ("comment.documentation", "comment.line.documentation"),
    ("keyword.conditional", "keyword.control.conditional"),
    ("keyword.import", "keyword.control.import"),
    ("keyword.repeat", "keyword.control.repeat"),
    ("keyword.return", "keyword.control.return"),
    ("module", "namespace"),
    ("number", "constant.numeric"),
    ("property", "variable.other.member"),
    ("string.escape", "constant.character.escape"),
];
const ZED: &[(&str, &str)] = &[("comment.documentation", "comment.doc"), ("variable.builtin", "variable.special")];

fn other_queries() {
    let query = read("tree-sitter-kinora/queries/highlights.scm").replacen(
        "; The lists of words between `begin` and `end` are written by lang/tests/editors.rs.",
        "; Written by lang/tests/editors.rs from tree-sitter-kinora/queries/highlights.scm.",
        1,
    );
    let is_name = |letter: char| letter.is_alphanumeric() || "._".contains(letter);
    for (names, path) in [(HELIX, "helix/queries/highlights.scm"), (ZED, "zed/languages/kinora/highlights.scm")] {
        let mut parts = query.split('@');
        let mut text = parts.next().unwrap().to_owned();
        for part in parts {
            let (name, rest) = part.split_at(part.find(|letter| !is_name(letter)).unwrap_or(part.len()));
            let other = names.iter().find(|row| row.0 == name).map_or(name, |row| row.1);
            text += &format!("@{other}{rest}");
        }
        expect(path, &text);
    }
    expect("zed/languages/kinora/brackets.scm", &read("tree-sitter-kinora/queries/brackets.scm"));
}

/// The words that are written above are those of the program.
#[test]
fn words_by_hand() {
    let check = |text: String| {
        let files = Memory::new([]);
        let scene = format!("lang 1\ncamera {{ position: (0, 0, 4) }}\nsky {{ color: #fff }}\n{text}\n");
        let found = eval(&parse(&Source::new(FileId(0), "a.kin", scene.as_str())), &files, &Overrides::default());
        assert!(found.is_ok(), "{text}: {:?}", found.err());
    };
    for (name, words) in KEYS {
        for word in *words {
            let value = if *word == "hermite" { "{ value: 1, in: 0, out: 0 }" } else { "1" };
            let (value, property) = match *name {
                "space" => ("#ffffff", "material: diffuse { color"),
                _ => (value, "material: diffuse { roughness"),
            };
            // `error` asks for keys at both ends of the scene.
            let value = value.replace(": 1,", ": 0.5,");
            check(format!("sphere {{ {property}: keys({name}: {word}) {{ 0s: {value}, 1s: {value} }} }} }}"));
        }
    }
    for curve in ["bezier(0, 0, 1, 1)", "steps(3, jump_end)", "spring(1, 100, 10)"] {
        assert!(CURVES.contains(&curve.split('(').next().unwrap()));
        check(format!("sphere {{ radius: keys {{ 0s: 1, 1s: 2 ease {curve} }} }}"));
    }
    for name in ALWAYS {
        assert!(is_point(name) || ["time", "frame"].contains(name), "{name}");
    }
}

/// A snippet's text as it is put in: `${1:text}` is the text, `${1|a,b|}` its first choice, `$1` the same once more, `$0`
/// nothing.
fn put_in(body: &str) -> String {
    let mut given: BTreeMap<String, &str> = BTreeMap::new();
    let mut text = String::new();
    let mut rest = body;
    while let Some(at) = rest.find('$') {
        text += &rest[..at];
        rest = &rest[at + 1..];
        let whole = rest.strip_prefix('{').map(|inside| inside.split_once('}').unwrap());
        let inside = whole.map_or(rest, |(inside, _)| inside);
        let digits = inside.find(|next: char| !next.is_ascii_digit()).unwrap_or(inside.len());
        let (number, value) = inside.split_at(digits);
        match whole {
            Some((_, behind)) => {
                let value = match value.strip_prefix('|') {
                    Some(choices) => choices.split([',', '|']).next().unwrap(),
                    None => value.trim_start_matches(':'),
                };
                assert!(given.insert(number.into(), value).is_none(), "{number} is given twice in {body}");
                text += value;
                rest = behind;
            }
            None => {
                text += given.get(number).copied().unwrap_or_default();
                assert!(number == "0" || given.contains_key(number), "${number} is nothing in {body}");
                rest = value;
            }
        }
    }
    text + rest
}

/// Every snippet is right: a whole scene, or a part of one.
#[test]
fn snippets() {
    let snippets: Value = serde_json::from_str(&read("vscode/snippets/kinora.json")).unwrap();
    let mut prefixes = BTreeSet::new();
    for (name, snippet) in snippets.as_object().unwrap() {
        assert!(prefixes.insert(snippet["prefix"].as_str().unwrap()), "{name}");
        assert!(!snippet["description"].as_str().unwrap().is_empty());
        let lines: Vec<&str> = snippet["body"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
        let text = put_in(&lines.join("\n").replace('\t', "    "));
        let text = match text.starts_with("lang 1") {
            true => text,
            false => {
                let camera = if text.contains("camera") { "" } else { "camera { position: (0, 0, 4) }\n" };
                let sky = if text.contains("sky {") { "" } else { "sky { color: #ffffff }\n" };
                let imports = text.lines().filter(|line| line.starts_with("import")).collect::<Vec<_>>().join("\n");
                let rest = text.lines().filter(|line| !line.starts_with("import")).collect::<Vec<_>>().join("\n");
                format!(
                    "lang 1\n{imports}\n{camera}{sky}diffuse white {{ }}\nsphere ball {{ material: white }}\n{rest}\n"
                )
            }
        };
        let files = Memory::new([]);
        let tree = parse(&Source::new(FileId(0), "a.kin", text.as_str()));
        let found = match eval(&tree, &files, &Overrides::default()) {
            Ok(evaluated) => evaluated.warnings,
            Err(found) => found,
        };
        // Names are there to be used later.
        let found: Vec<_> = found.iter().filter(|found| found.code != "W0201" && found.code != "W0202").collect();
        assert!(found.is_empty(), "{name}: {found:?}\n{text}");
    }
    assert!(prefixes.len() >= 15);
}

/// The schema of `kinora.toml`: what `levels_of_project` takes.
#[test]
fn project_file() {
    let all = codes::all();
    let warnings = || all.iter().map(|row| row.code).filter(|code| code.starts_with('W')).chain(["warnings"]);
    let level = json!({ "enum": ["allow", "warn", "deny"] });
    let codes = |codes: Vec<&str>| {
        let one = json!({ "enum": codes });
        json!({ "anyOf": [one, { "type": "array", "items": one, "uniqueItems": true }] })
    };
    let mut lints = serde_json::Map::new();
    for row in &all {
        let title = format!("{}.", row.title);
        let levels = if row.code.starts_with('W') { json!(["allow", "warn", "deny"]) } else { json!(["deny"]) };
        lints.insert(row.code.into(), json!({ "enum": levels, "description": title }));
    }
    let of_all = json!({ "enum": level["enum"], "description": "Every warning that is not named itself." });
    lints.insert("warnings".into(), of_all);
    for (word, what) in [("allow", "are not shown"), ("warn", "are shown"), ("deny", "are errors")] {
        let every: Vec<&str> = all.iter().map(|row| row.code).chain(["warnings"]).collect();
        let mut list = codes(if word == "deny" { every } else { warnings().collect() });
        list["description"] = json!(format!("These {what}."));
        lints.insert(word.into(), list);
    }
    let accepts = |text: &str| levels_of_project(&Source::new(FileId(0), "kinora.toml", text)).1.is_empty();
    for row in &all {
        for word in ["allow", "warn", "deny"] {
            let named = lints[row.code]["enum"].as_array().unwrap().contains(&json!(word));
            assert_eq!(accepts(&format!("[lints]\n{} = \"{word}\"", row.code)), named, "{} {word}", row.code);
            let listed = lints[word]["anyOf"][0]["enum"].as_array().unwrap().contains(&json!(row.code));
            assert_eq!(accepts(&format!("[lints]\n{word} = [\"{}\"]", row.code)), listed, "{} {word}", row.code);
        }
    }
    assert!(accepts("") && accepts("[lints]\nwarnings = \"deny\"\nallow = \"W0401\""));
    assert!(!accepts("[lints]\nlevel = \"deny\"") && !accepts("[other]"));
    let schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "kinora.toml",
        "description": "The folder that holds this file is the project: scenes in it read files in it.",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "lints": {
                "description": "How warnings are taken.",
                "type": "object",
                "additionalProperties": false,
                "properties": lints,
            },
        },
    });
    expect("vscode/schemas/kinora.toml.schema.json", &format!("{}\n", serde_json::to_string_pretty(&schema).unwrap()));
}

/// What `kinora check --format short` prints, for the test of the problem matcher.
#[test]
fn short_lines() {
    let text = "lang 1\n\nsphere ball { radius: 1 position: (0, 1, 2) }\nsphere two { raduis: 50cm }\nlet a = 1\n";
    let source = Source::new(FileId(0), "scenes/a.kin", text);
    let tree = parse(&source);
    let found = match eval(&tree, &Memory::new([]), &Overrides::default()) {
        Ok(evaluated) => evaluated.warnings,
        Err(found) => found,
    };
    let lines: Vec<String> =
        found.iter().map(|found| render_short(found, std::slice::from_ref(&source)) + "\n").collect();
    assert!(lines.len() > 1);
    expect("vscode/test/short.txt", &lines.concat());
}
