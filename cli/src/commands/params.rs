//! `kinora params`: what `-D` can change.

use crate::exit::{self, Outcome};
use crate::flags::SceneFlags;
use crate::{session, terminal};

/// List a scene's parameters: what -D can change, and between which values.
///
/// Example: kinora params cornell.kin --json
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// As JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let loaded = session::load(&args.scene.file, &args.scene.changes())?;
    loaded.report();
    if loaded.scene.is_none() {
        return Ok(loaded.fault_code());
    }
    if args.json {
        terminal::out(&terminal::json(&loaded.params))?;
        return Ok(exit::CLEAN);
    }
    let mut text = String::new();
    for param in &loaded.params {
        let range = param.range.as_ref().map_or_else(String::new, |[from, to]| format!(" in {from}..{to}"));
        text += &format!("{}: {} = {}{range}\n", param.name, param.ty, param.default);
        for line in param.doc.iter().flat_map(|doc| doc.lines()) {
            text += &format!("    {line}\n");
        }
    }
    terminal::out(&text)?;
    Ok(exit::CLEAN)
}
