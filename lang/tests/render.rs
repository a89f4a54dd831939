//! What people and programs see of a diagnostic.

use kinora_lang::diagnostic::{Applicability, Diagnostic, Style, render, render_short, to_json};
use kinora_lang::parse;
use kinora_lang::source::{FileId, Source, Span};

fn source(text: &str) -> Source {
    Source::new(FileId(0), "scenes/test.kin", text)
}

fn full(text: &str) -> String {
    let source = source(text);
    let errors = parse(&source).errors().to_vec();
    errors.iter().map(|found| render(found, std::slice::from_ref(&source), Style::default()) + "\n").collect()
}

#[test]
fn broken() {
    insta::assert_snapshot!(full(include_str!("scenes/broken.kin")));
}

#[test]
fn odd_places() {
    let texts = [
        "box b { size: (1, 2, 3)",
        "let a =",
        "let a = \"é😀\tx",
        "sphere a {\r\n\tradius 0.5\r\n\tcolor = #fff\r\n}\r\n",
        "sphere a {\n    radius: 1\n\n\n\n\n\n\n\nsphere b { radius: 2 }\n",
    ];
    insta::assert_snapshot!(texts.map(full).join("----\n"));
}

#[test]
fn short() {
    let source = source("sphere a {\n  é: “1”\n}\n");
    let errors = parse(&source).errors().to_vec();
    let lines: Vec<String> = errors.iter().map(|found| render_short(found, std::slice::from_ref(&source))).collect();
    assert_eq!(lines, ["scenes/test.kin:2:6: error[E0121]: `“` is not a quote"]);
    let nowhere = Diagnostic::new("W0402", "no light reaches the scene");
    assert_eq!(render_short(&nowhere, &[]), "warning[W0402]: no light reaches the scene");
}

#[test]
fn json() {
    let source = source("sphere a {\n  /* é😀 */ radius 0.5\n}\n");
    let text = to_json(parse(&source).errors(), std::slice::from_ref(&source), &[]);
    insta::assert_snapshot!(text);
}

/// Spans that do not fit the text, from a diagnostic of another version of it.
#[test]
fn spans_are_clamped() {
    for text in ["", "é", "a\r\n", "é\n\n", "\t😀\r\n\tx", "\n"] {
        let source = source(text);
        for start in 0..9 {
            for end in [start, start + 1, start + 3, u32::MAX] {
                let file = FileId(0);
                let found = Diagnostic::new("E0101", "message")
                    .primary(file, Span::new(start, end), "here")
                    .label(file, Span::at(end), "there")
                    .label(FileId(9), Span::at(0), "nowhere")
                    .note("a fact")
                    .help("an action")
                    .fix(Applicability::Safe, "a fix", file, Span::new(start, end), "x\ny");
                for (color, unicode, width) in [(false, false, 100), (true, true, 0), (true, false, 20)] {
                    let shown = render(&found, std::slice::from_ref(&source), Style { color, unicode, width });
                    assert!(shown.contains("message") && shown.ends_with('\n'), "{shown}");
                    assert_eq!(shown.contains('\u{1B}'), color);
                }
                assert!(to_json(&[found], std::slice::from_ref(&source), &[]).starts_with('['));
            }
        }
    }
}
