//! Addresses of files, as editors write them, and paths.

use std::path::{Path, PathBuf};

use lsp_types::Uri;
use percent_encoding::{AsciiSet, CONTROLS, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};

/// What stays as it is in an address.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'_').remove(b'.').remove(b'~');

/// The path of a `file:` address; the folder made canonical, as far as it is there.
pub fn path(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.as_str().strip_prefix("file://")?;
    let rest = rest.split(['?', '#']).next().unwrap_or(rest);
    let start = rest.find('/')?;
    let decoded = percent_decode_str(&rest[start..]).decode_utf8().ok()?;
    let text = match cfg!(windows) {
        // `/c:/scenes`
        true => decoded.strip_prefix('/').filter(|rest| rest.get(1..2) == Some(":")).unwrap_or(&decoded),
        false => &*decoded,
    };
    if text.contains('\0') {
        return None;
    }
    let path = PathBuf::from(text);
    Some(canonical(&path).unwrap_or(path))
}

/// Writes the addresses among the parameters of a message as they should be written: some clients forget to encode what
/// stands for itself in no address, and would not be understood at all.
pub fn mend(params: &mut serde_json::Value) {
    match params {
        serde_json::Value::Array(items) => items.iter_mut().for_each(mend),
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                match value {
                    serde_json::Value::String(text) if key.ends_with("uri") || key.ends_with("Uri") => {
                        if text.parse::<Uri>().is_err() {
                            *text = utf8_percent_encode(text, UNWRITABLE).to_string();
                        }
                    }
                    value => mend(value),
                }
            }
        }
        _ => {}
    }
}

/// What stands in no address.
const UNWRITABLE: &AsciiSet = &CONTROLS
    .add(b' ')
    .add(b'"')
    .add(b'<')
    .add(b'>')
    .add(b'[')
    .add(b']')
    .add(b'\\')
    .add(b'^')
    .add(b'`')
    .add(b'{')
    .add(b'|')
    .add(b'}');

/// The path with its folder as the disk has it; the file itself need not be there, and may be a link.
fn canonical(path: &Path) -> Option<PathBuf> {
    Some(path.parent()?.canonicalize().ok()?.join(path.file_name()?))
}

/// The address of a path.
pub fn of(path: &Path) -> Option<Uri> {
    let text = path.to_str()?.replace('\\', "/");
    let text = text.strip_prefix("//?/").unwrap_or(&text);
    let slash = if text.starts_with('/') { "" } else { "/" };
    format!("file://{slash}{}", utf8_percent_encode(text, ENCODED)).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn there_and_back() {
        for text in ["/nowhere/a.kin", "/nowhere/with space/ü#?%.kin"] {
            let uri = of(Path::new(text)).unwrap();
            assert_eq!(path(&uri).unwrap(), Path::new(text), "{}", uri.as_str());
        }
        let other: Uri = "file:///nowhere/c%3A/a%20b.kin".parse().unwrap();
        assert_eq!(path(&other).unwrap(), Path::new("/nowhere/c:/a b.kin"));
        assert_eq!(path(&"untitled:Untitled-1".parse().unwrap()), None);
    }
}
