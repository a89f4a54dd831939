//! The file around the JSON: GLB chunks, data URIs, and buffers and images beside it.

use std::sync::Arc;

use serde_json::Value;

use super::{Fault, json};
use crate::files::{FileError, Files, resolve};

/// JSON, and the binary chunk if there is one.
pub struct Parts<'b> {
    /// The document.
    pub root: Value,
    /// `BIN` of a GLB.
    pub chunk: Option<&'b [u8]>,
    /// Whether it is a GLB: only there the first buffer may be the chunk.
    pub binary: bool,
}

const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Takes a `.gltf` or `.glb` apart.
///
/// # Errors
/// E0801, with the byte where a GLB is broken.
pub fn open<'b>(name: &str, bytes: &'b [u8]) -> Result<Parts<'b>, Fault> {
    let glb = bytes.starts_with(b"glTF") || name.to_ascii_lowercase().ends_with(".glb");
    if !glb {
        return Ok(Parts { root: json::parse(bytes)?, chunk: None, binary: false });
    }
    let at = |byte: usize, message: String| {
        Fault::new(&format!("byte {byte}"), message, "export the model again; the file is damaged or cut off")
    };
    let word = |from: usize| {
        let word = bytes.get(from..from + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(word))
    };
    let (Some(magic), Some(version), Some(length)) = (word(0), word(4), word(8)) else {
        return Err(at(bytes.len(), "a GLB begins with 12 bytes, and the file ends before".into()));
    };
    if magic.to_le_bytes() != *b"glTF" {
        return Err(at(0, "a GLB begins with `glTF`".into()));
    }
    if version != 2 {
        return Err(at(4, format!("GLB version {version}; 2 is known")));
    }
    let length = length as usize;
    if length < 20 {
        return Err(at(8, format!("the GLB says that it has {length} bytes, too few for a chunk")));
    }
    if length > bytes.len() {
        return Err(at(8, format!("the GLB says that it has {length} bytes, the file has {}", bytes.len())));
    }
    let (mut root, mut chunk) = (None, None);
    let (mut from, mut count) = (12, 0);
    while from < length {
        let (Some(size), Some(kind)) = (word(from), word(from + 4)) else {
            return Err(at(from, "a chunk begins with 8 bytes, and the file ends before".into()));
        };
        let (start, size) = (from + 8, size as usize);
        if size % 4 != 0 {
            return Err(at(from, format!("a chunk of {size} bytes; they are multiples of 4")));
        }
        let Some(data) = start.checked_add(size).filter(|end| *end <= length).and_then(|end| bytes.get(start..end))
        else {
            return Err(at(from, format!("a chunk of {size} bytes does not fit in the GLB")));
        };
        match (kind, count) {
            (JSON, 0) if data.is_empty() => return Err(at(from, "the JSON chunk is empty".into())),
            (JSON, 0) => root = Some(json::parse(data)?),
            (_, 0) => return Err(at(from, "the first chunk of a GLB is JSON".into())),
            (JSON, _) => return Err(at(from, "a second JSON chunk".into())),
            (BIN, 1) => chunk = Some(data),
            (BIN, _) if chunk.is_some() => return Err(at(from, "a second BIN chunk".into())),
            (BIN, _) => return Err(at(from, "the BIN chunk comes right after the JSON".into())),
            // Chunks of extensions are passed over.
            _ => {}
        }
        (from, count) = (start + size, count + 1);
    }
    match root {
        Some(root) => Ok(Parts { root, chunk, binary: true }),
        None => Err(at(12, "a GLB without a JSON chunk".into())),
    }
}

/// Where the bytes behind a `uri` are.
pub enum Uri {
    /// In the text itself: media type and content.
    Data(String, Vec<u8>),
    /// A file, as a path from the project's root.
    File(String),
    /// Of a scheme that is not followed: nothing is fetched from a network, and nothing from outside the project.
    Elsewhere,
}

/// Takes a `uri` apart; `from` is the model's path from the project's root.
///
/// # Errors
/// E0801 for what is no URI; codes of [`FileError`] for a path that leaves the project.
pub fn uri(from: &str, written: &str, pointer: &str) -> Result<Uri, Fault> {
    let broken = |what: &str| Err(Fault::new(pointer, format!("the URI {what}"), "export the model again"));
    if let Some(rest) = written.strip_prefix("data:") {
        let Some((head, content)) = rest.split_once(',') else { return broken("begins with `data:` and has no `,`") };
        let mut parts = head.split(';');
        let media = parts.next().unwrap_or_default().to_ascii_lowercase();
        let mut base64 = false;
        for part in parts {
            match part {
                "base64" if !base64 => base64 = true,
                part if !base64 && part.split_once('=').is_some_and(|(name, _)| !name.is_empty()) => {}
                _ => return broken(&format!("has `;{part}` where `;name=value` or `;base64` is expected")),
            }
        }
        let bytes = match base64 {
            true => decode_base64(content.as_bytes()),
            false => percent_decode(content),
        };
        return match bytes {
            Some(bytes) => Ok(Uri::Data(media, bytes)),
            None => broken("has data that cannot be decoded"),
        };
    }
    if let Some((scheme, _)) = written.split_once(':').filter(|(scheme, _)| !scheme.contains(['/', '?', '#'])) {
        let mut letters = scheme.bytes();
        let named = letters.next().is_some_and(|first| first.is_ascii_alphabetic())
            && letters.all(|letter| letter.is_ascii_alphanumeric() || b"+-.".contains(&letter));
        return if named { Ok(Uri::Elsewhere) } else { broken("has a `:` without a scheme before it") };
    }
    if written.starts_with("//") {
        return Ok(Uri::Elsewhere);
    }
    let Some(path) = percent_decode(written).and_then(|bytes| String::from_utf8(bytes).ok()) else {
        return broken("has a `%` that is not followed by two hexadecimal digits of UTF-8");
    };
    resolve(from, &path).map(Uri::File).map_err(|error| Fault::file(pointer, &error))
}

/// The fault of what lies outside.
pub fn elsewhere(pointer: &str, written: &str) -> Fault {
    let written: String = written.chars().take(60).collect();
    Fault {
        code: "E0704",
        at: pointer.to_string(),
        message: format!("`{written}` is not in the project"),
        help: "copy the file beside the model, and name it in `uri`",
    }
}

/// Reads a file of the project.
pub fn fetch(files: &dyn Files, path: &str, pointer: &str) -> Result<Arc<[u8]>, Fault> {
    files.read(path).map_err(|error: FileError| Fault::file(pointer, &error))
}

fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        at += 1;
        out.push(match byte {
            b'%' => {
                let digits = bytes.get(at..at + 2)?;
                at += 2;
                let digit = |i: usize| char::from(digits[i]).to_digit(16);
                (digit(0)? * 16 + digit(1)?) as u8
            }
            byte => *byte,
        });
    }
    Some(out)
}

/// RFC 4648, padding required, no other characters.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    if !text.len().is_multiple_of(4) {
        return None;
    }
    let digit = |byte: u8| {
        Some(u32::from(match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        }))
    };
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let groups = text.as_chunks::<4>().0;
    for (i, group) in groups.iter().enumerate() {
        let padding = group.iter().rev().take_while(|byte| **byte == b'=').count();
        if padding > 2 || (padding > 0 && i + 1 < groups.len()) {
            return None;
        }
        let mut bits = 0;
        for byte in &group[..4 - padding] {
            bits = bits << 6 | digit(*byte)?;
        }
        bits <<= 6 * padding;
        out.extend_from_slice(&bits.to_be_bytes()[1..4 - padding]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_rfc_4648() {
        for (text, bytes) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg==", "foob")] {
            assert_eq!(decode_base64(text.as_bytes()).as_deref(), Some(bytes.as_bytes()));
        }
        for broken in ["Zg=", "Z===", "Zg==Zg==", "Zm9*"] {
            assert_eq!(decode_base64(broken.as_bytes()), None, "{broken}");
        }
    }

    #[test]
    fn no_uri_leaves_the_project() {
        for away in ["../../x.bin", "%2e%2e/%2e%2e/x.bin", "a/../../../x.bin"] {
            assert!(
                matches!(uri("models/a.gltf", away, "/buffers/0/uri"), Err(fault) if fault.code == "E0703"),
                "{away}"
            );
        }
        for away in ["http://example.com/x.bin", "file:///etc/passwd", "//host/x.bin"] {
            assert!(matches!(uri("models/a.gltf", away, ""), Ok(Uri::Elsewhere)), "{away}");
        }
        assert!(matches!(uri("models/a.gltf", "my%20bin.bin", ""), Ok(Uri::File(path)) if path == "models/my bin.bin"));
    }
}
