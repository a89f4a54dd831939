//! The standard library: files that are part of this program, imported by paths that start with `std/`.
//!
//! ```text
//! import { studio_light, cyclorama } from "std/studio"
//! import "std/metals" as metals
//! ```

/// Path and text of each file.
pub const FILES: &[(&str, &str)] = &[
    ("std/cornell", include_str!("../std/cornell.kin")),
    ("std/glass", include_str!("../std/glass.kin")),
    ("std/metals", include_str!("../std/metals.kin")),
    ("std/shapes", include_str!("../std/shapes.kin")),
    ("std/studio", include_str!("../std/studio.kin")),
];

/// Whether a path means a part of the library. A file of the project has its ending, so a folder `std` of its own is
/// not in the way.
pub fn is_path(path: &str) -> bool {
    path.starts_with("std/") && !path.ends_with(".kin")
}

/// The part that declares a name at its top level.
pub fn declares(name: &str) -> Option<&'static str> {
    let declares = |line: &str| line.starts_with(char::is_alphabetic) && line.split_whitespace().nth(1) == Some(name);
    FILES.iter().find(|(_, text)| text.lines().any(declares)).map(|file| file.0)
}

/// The text of a part.
pub fn find(path: &str) -> Option<&'static str> {
    FILES.iter().find(|file| file.0 == path).map(|file| file.1)
}
