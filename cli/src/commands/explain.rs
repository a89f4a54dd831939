//! `kinora explain`: the long text behind a code.

use kinora_lang::diagnostic::codes::{self, Row};
use kinora_lang::diagnostic::{no_code, severity};
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
    severity: &'static str,
    title: &'static str,
    text: &'static str,
    bad: &'static str,
    good: &'static str,
    url: String,
}

pub fn run(args: &Args) -> Outcome {
    let rows = match &args.code {
        Some(code) => vec![codes::find(code).ok_or_else(|| no_code(code))?],
        None => codes::all(),
    };
    let record = |row: &Row| {
        let Row { code, title, text, bad, good } = *row;
        Record { code, severity: severity(code).name(), title, text, bad, good, url: codes::url(code) }
    };
    let records: Vec<Record> = rows.iter().map(record).collect();
    let text = match (args.json, records.as_slice()) {
        (false, _) => rows.iter().map(codes::page).collect::<Vec<_>>().join("\n"),
        (true, [one]) if !args.all => terminal::json(one),
        (true, all) => terminal::json(&all),
    };
    terminal::out(&text)?;
    Ok(exit::CLEAN)
}
