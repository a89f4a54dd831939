//! The grammar for editors in `docs/editors/tree-sitter-kinora` against the parser of the language: both find mistakes in
//! the same files.

// The grammar comes as C.
#![allow(unsafe_code)]

use std::path::{Path, PathBuf};

use kinora_lang::parse;
use kinora_lang::source::{FileId, Source};
use tree_sitter::{InputEdit, Language, Parser, Point, Query};

// What build.rs compiled.
#[link(name = "tree_sitter_kinora", kind = "static")]
unsafe extern "C" {
    fn tree_sitter_kinora() -> *const ();
}

fn language() -> Language {
    // SAFETY: the function has this type in every generated parser, and gives a table that lives for ever.
    unsafe { tree_sitter_language::LanguageFn::from_raw(tree_sitter_kinora) }.into()
}

fn parser() -> Parser {
    let mut parser = Parser::new();
    parser.set_language(&language()).unwrap();
    parser
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The files below a folder that end so.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true if path.ends_with("node_modules") => {}
            true => found.extend(files(&path, ending)),
            false if path.extension().is_some_and(|extension| extension == ending) => found.push(path),
            false => {}
        }
    }
    found.sort();
    found
}

/// Every text in the scene language that the repository has, with a name for messages.
fn texts() -> Vec<(String, String)> {
    let root = root();
    let read = |path: PathBuf| {
        let bytes = std::fs::read(&path).unwrap();
        (path.display().to_string(), String::from_utf8_lossy(&bytes).into_owned())
    };
    let folders = ["examples", "lang", "tests", "cli", "renderer", "animator", "docs"];
    let mut texts: Vec<_> = folders.iter().flat_map(|folder| files(&root.join(folder), "kin")).map(read).collect();
    let mut pages = files(&root.join("docs"), "md");
    pages.push(root.join("README.md"));
    for (name, page) in pages.into_iter().map(read) {
        let blocks = page.replace("\r\n", "\n");
        let blocks = blocks.split("\n```").skip(1).step_by(2).filter_map(|block| block.split_once('\n'));
        let blocks = blocks.filter(|(info, _)| info.split(' ').next() == Some("kin"));
        texts.extend(blocks.enumerate().map(|(i, (_, block))| (format!("{name}, block {}", i + 1), block.to_owned())));
    }
    texts
}

/// Whether the two parsers find a text right.
///
/// # Errors
/// They do not say the same. Nesting that is too deep counts as no mistake: the grammar for editors has no limit.
fn is_right(parser: &mut Parser, text: &str) -> Result<bool, String> {
    let tree = parse(&Source::new(FileId(0), "a.kin", text));
    let error = tree.errors().iter().find(|error| error.code != "E0122");
    let nodes = parser.parse(text, None).unwrap();
    match (error, first_error(nodes.root_node())) {
        (Some(error), None) => Err(format!("only the language: {} {:?}\n{text}\n", error.message, error.place())),
        (None, Some(node)) => Err(format!("only the grammar: {node:?}\n{text}\n")),
        (error, _) => Ok(error.is_none()),
    }
}

fn first_error(node: tree_sitter::Node<'_>) -> Option<tree_sitter::Node<'_>> {
    if !node.has_error() {
        return None;
    }
    (0..node.child_count()).find_map(|i| first_error(node.child(i)?)).or(Some(node))
}

#[test]
fn the_same_texts_are_right() {
    let mut parser = parser();
    let (mut right, mut differ) = (0, Vec::new());
    for (name, text) in texts() {
        // The file, and each of its items alone: in files that are full of mistakes many items have none.
        let tree = parse(&Source::new(FileId(0), "a.kin", text.as_str()));
        let items = tree.root().nodes().map(|item| item.text());
        for text in items.chain([text.as_str()]) {
            match is_right(&mut parser, text) {
                Ok(is_right) => right += usize::from(is_right),
                Err(found) => differ.push(format!("{name}: {found}")),
            }
        }
    }
    assert!(differ.is_empty(), "{} differ:\n{}", differ.len(), differ[..differ.len().min(10)].join("\n"));
    assert!(right > 2000, "{right}");
}

/// A generator of numbers, the same at each run.
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// Tokens left out, doubled, swapped and put in from elsewhere, spaces among them.
#[test]
fn the_same_changed_texts_are_right() {
    let mut parser = parser();
    let mut chance = Chance(1);
    let texts: Vec<(String, String)> =
        texts().into_iter().filter(|(name, text)| text.len() < 20_000 && !name.contains("limits")).collect();
    let trees: Vec<_> = texts.iter().map(|(_, text)| parse(&Source::new(FileId(0), "a.kin", text.as_str()))).collect();
    let tokens: Vec<Vec<&str>> =
        trees.iter().map(|tree| tree.root().tokens().map(|token| token.text()).collect()).collect();
    let all: Vec<&str> = tokens.iter().flatten().copied().collect();
    let (mut right, mut all_texts, mut differ) = (0, 0, Vec::new());
    for tokens in &tokens {
        for _ in 0..ROUNDS {
            // A stretch, so that what is right is not drowned in what is not.
            let start = chance.below(tokens.len() + 1);
            let end = (start + 5 + chance.below(60)).min(tokens.len());
            let mut some = tokens[start..end].to_vec();
            for _ in 0..=chance.below(2) {
                if some.is_empty() {
                    break;
                }
                let at = chance.below(some.len());
                match chance.below(5) {
                    0 => drop(some.remove(at)),
                    1 => some.insert(at, some[at]),
                    2 => some.insert(at, all[chance.below(all.len())]),
                    3 => some[at] = all[chance.below(all.len())],
                    _ => some.insert(at, MORE[chance.below(MORE.len())]),
                }
            }
            let text = some.concat();
            all_texts += 1;
            match is_right(&mut parser, &text) {
                Ok(is_right) => right += usize::from(is_right),
                Err(found) => differ.push(found),
            }
        }
    }
    differ.sort_by_key(String::len);
    assert!(differ.is_empty(), "{} differ:\n{}", differ.len(), differ[..differ.len().min(10)].join("\n"));
    assert!((all_texts / 20..all_texts / 2).contains(&right), "{right} of {all_texts} are right");
}

/// Changes of each text.
const ROUNDS: usize = 100;

/// What is rare in the texts.
const MORE: &[&str] = &[
    " ",
    "\n",
    "\r\n",
    "// c\n",
    "/* c */",
    "/* c\n */",
    "/*",
    "*/",
    "\"",
    "\\",
    "\"\\u{D800}\"",
    "\"\\q\"",
    "#",
    "#12345",
    ".",
    "..",
    "1.",
    "1.x",
    "3m/s",
    "3m/steps",
    "30degrees",
    "1e3",
    "1_0",
    "%",
    "m",
    "ease",
    "after",
    "in",
    "as",
    "from",
    "like",
    "else",
    "if",
    "for",
    "let",
    "fn",
    "->",
    "keys",
    "return",
    "true",
    "<",
    ">",
    "<=",
    "==",
    "=",
    "!",
    "-",
    "^",
    "&&",
    "||",
    ":",
    ",",
    ";",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\u{202E}",
    "\u{7}",
    "é",
    "a: 1",
    "\na: 1\n",
    "in: 1",
    "\nlike: 1",
    "x { }",
];

/// After an edit the tree is the one that the whole text gives, where that is right.
#[test]
fn edits() {
    let mut parser = parser();
    let mut chance = Chance(2);
    let mut seen = 0;
    for (name, text) in texts() {
        if text.len() > 20_000 || parser.parse(&text, None).unwrap().root_node().has_error() {
            continue;
        }
        let tree = parse(&Source::new(FileId(0), "a.kin", text.as_str()));
        let tokens: Vec<_> = tree.root().tokens().collect();
        for _ in 0..10 {
            // A token is taken out, parsed without, and put in again.
            let token = tokens[chance.below(tokens.len())];
            let (start, end) = (token.span().start as usize, token.span().end as usize);
            let without = format!("{}{}", &text[..start], &text[end..]);
            let point = |text: &str, at: usize| {
                let line = text[..at].rfind('\n').map_or(0, |at| at + 1);
                Point { row: text[..at].matches('\n').count(), column: at - line }
            };
            let mut old = parser.parse(&text, None).unwrap();
            let (at, behind) = (point(&text, start), point(&text, end));
            old.edit(&InputEdit {
                start_byte: start,
                old_end_byte: end,
                new_end_byte: start,
                start_position: at,
                old_end_position: behind,
                new_end_position: at,
            });
            let mut old = parser.parse(&without, Some(&old)).unwrap();
            let fresh = parser.parse(&without, None).unwrap();
            if !fresh.root_node().has_error() {
                assert_eq!(old.root_node().to_sexp(), fresh.root_node().to_sexp(), "{name}: {:?}", token.text());
            }
            old.edit(&InputEdit {
                start_byte: start,
                old_end_byte: start,
                new_end_byte: end,
                start_position: at,
                old_end_position: at,
                new_end_position: behind,
            });
            let again = parser.parse(&text, Some(&old)).unwrap();
            let fresh = parser.parse(&text, None).unwrap();
            assert_eq!(again.root_node().to_sexp(), fresh.root_node().to_sexp(), "{name}: {:?}", token.text());
            seen += 1;
        }
    }
    assert!(seen > 1000, "{seen}");
}

/// Every query is one of this grammar.
#[test]
fn queries() {
    let found = files(&root().join("docs/editors"), "scm");
    assert!(!found.is_empty());
    for path in found {
        let text = std::fs::read_to_string(&path).unwrap();
        if let Err(error) = Query::new(&language(), &text) {
            panic!("{}: {error}", path.display());
        }
    }
}
