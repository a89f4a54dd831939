//! `kinora lsp`: the language for editors, by the language server protocol.
//!
//! One message after the other, in their order: [`server`] has the loop, [`documents`] what is open, [`answers`] and its
//! neighbours turn what `kinora_lang::ide` says into the protocol's types. Offsets in bytes become lines and columns in
//! [`position`] alone.

mod actions;
mod answers;
mod diagnose;
mod documents;
mod position;
mod project;
mod rename;
mod server;
mod stdio;
#[cfg(test)]
mod tests;
mod uri;

use crate::exit::{self, Outcome};

/// Serve editors: the language server protocol on standard input and output.
///
/// Editors start it by themselves; see docs/editors.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What editors add that know other ways; there is no other
    #[arg(long, hide = true)]
    stdio: bool,
}

/// A stack for texts that are nested as deeply as the language allows.
const STACK_BYTES: usize = 256 << 20;

pub fn run(_: &Args) -> Outcome {
    let (connection, threads) = stdio::connect().map_err(|error| format!("no thread: {error}"))?;
    let work = std::thread::Builder::new().name("lsp".into()).stack_size(STACK_BYTES);
    let served = work.spawn(move || server::serve(&connection)).map_err(|error| format!("no thread: {error}"))?;
    let code = served.join().map_err(|_| "the server stopped".to_string())?;
    // The last answers are written before the program ends; of an editor that is gone, nothing more is read.
    if code.is_some() {
        threads.join().map_err(|error| format!("cannot speak with the editor: {error}"))?;
    }
    Ok(code.unwrap_or(exit::FINDINGS))
}
