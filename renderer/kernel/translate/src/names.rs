//! Rust identifiers for WGSL names: WGSL lets a local shadow anything and use Rust's keywords, Rust does not.

use std::collections::HashSet;

/// The keywords of Rust that WGSL does not keep for itself.
const KEYWORDS: &[&str] = &["box", "dyn", "gen", "in"];

/// `name`, with an underscore after it where Rust keeps the word for itself.
pub fn plain(name: &str) -> String {
    if KEYWORDS.contains(&name) { format!("{name}_") } else { name.to_owned() }
}

/// The names taken in one scope.
#[derive(Clone, Default)]
pub struct Names(HashSet<String>);

impl Names {
    /// `name`, or `name_1`, `name_2` … where it is taken.
    pub fn unique(&mut self, name: &str) -> String {
        let plain = plain(name);
        let mut candidate = plain.clone();
        let mut count = 0;
        while !self.0.insert(candidate.clone()) {
            count += 1;
            candidate = format!("{plain}_{count}");
        }
        candidate
    }
}
