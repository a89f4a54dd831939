//! Scenes that carry their expected diagnostics: see `support`.

mod support;

use kinora_lang::diagnostic::codes;
use kinora_lang::parse;
use kinora_lang::source::{FileId, Source, decode};

/// Codes of the parser that a text alone cannot have, or that are tested elsewhere.
const ELSEWHERE: &[&str] = &["E0119"];

#[test]
fn syntax() {
    let found = support::run("syntax", |case| {
        let (name, text) = case.files.first().unwrap();
        let source = Source::new(FileId(0), name.as_str(), text.as_str());
        (parse(&source).errors().to_vec(), vec![source])
    });
    for row in codes::all().iter().filter(|row| row.code.starts_with("E01") && !ELSEWHERE.contains(&row.code)) {
        assert!(found.iter().any(|code| code == row.code), "no case for {}", row.code);
    }
    for code in found {
        assert!(codes::find(&code).is_some(), "{code} has no row");
    }
}

#[test]
fn bytes_that_are_no_text() {
    let check = |bytes: &[u8], message: &str, offset: u32| {
        let (_, error) = decode(FileId(0), "a.kin", bytes);
        let error = error.unwrap();
        assert_eq!((error.code, error.message.as_str()), ("E0119", message));
        assert_eq!(error.place().map(|(_, span)| span.start), Some(offset));
    };
    check(b"sphere \xE9", "file is not valid UTF-8", 7);
    check(b"\xFF\xFEs\0p\0", "file is UTF-16, not UTF-8", 0);
    check(b"\xFE\xFF\0s\0p\0", "file is UTF-16, not UTF-8", 0);
    assert!(decode(FileId(0), "a.kin", "sphère".as_bytes()).1.is_none());
}
