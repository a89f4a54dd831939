//! `kinora explain`: the long text behind a code.

use kinora_lang::diagnostic::codes::{self, Row};
use serde::Serialize;

use crate::exit::{self, Outcome};
use crate::terminal;

/// Explain the code of an error or a warning, with an example that gets it and one that does not.
///
/// Example: kinora explain E0201
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The code, as it stands in the message: E0201
    #[arg(required_unless_present = "all")]
    code: Option<String>,
    /// Explain every code
    #[arg(long, conflicts_with = "code")]
    all: bool,
    /// As JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Record {
    code: &'static str,
    title: &'static str,
    text: &'static str,
    bad: &'static str,
    good: &'static str,
}

pub fn run(args: &Args) -> Outcome {
    let rows = match &args.code {
        Some(code) => vec![codes::find(code).ok_or_else(|| unknown(code))?],
        None => codes::all(),
    };
    let record = |row: &Row| Record { code: row.code, title: row.title, text: row.text, bad: row.bad, good: row.good };
    let records: Vec<Record> = rows.iter().map(record).collect();
    let text = match (args.json, records.as_slice()) {
        (false, _) => rows.iter().map(codes::explain).collect::<Vec<_>>().join("\n"),
        (true, [one]) if !args.all => terminal::json(one),
        (true, all) => terminal::json(&all),
    };
    terminal::out(&text)?;
    Ok(exit::CLEAN)
}

/// The codes that differ in one place, or that begin like it.
fn unknown(code: &str) -> String {
    let upper = code.trim().to_ascii_uppercase();
    let rows = codes::all();
    let near = |row: &&Row| {
        let same = row.code.chars().zip(upper.chars()).filter(|(a, b)| a == b).count();
        let begins = upper.len() > 2 && row.code.starts_with(&upper);
        begins || same + 1 == row.code.len().max(upper.chars().count()) || row.code.get(1..) == Some(&*upper)
    };
    let near: Vec<&str> = rows.iter().filter(near).map(|row| row.code).take(3).collect();
    match near.as_slice() {
        [] => format!("there is no code `{code}`; `kinora explain --all` lists them"),
        near => format!("there is no code `{code}`; did you mean {}?", near.join(", ")),
    }
}
