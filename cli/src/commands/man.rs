//! `kinora man`: pages for man(1).

use std::path::PathBuf;

use clap_mangen::Man;

use crate::exit::{self, Outcome};
use crate::terminal;

/// Print the manual page of the program, or write those of all commands into a folder.
///
/// Example: kinora man | man -l -
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write kinora.1, kinora-render.1 and so on into this folder instead
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args, program: clap::Command) -> Outcome {
    // Where the manual is made, the terminal's width is nobody's business.
    let program = program.disable_help_subcommand(true).term_width(100);
    let Some(folder) = &args.output else {
        terminal::out(&text(program)?)?;
        return Ok(exit::CLEAN);
    };
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot make `{}`: {error}", folder.display()))?;
    clap_mangen::generate_to(program, folder)
        .map_err(|error| format!("cannot write manual pages to `{}`: {error}", folder.display()))?;
    Ok(exit::CLEAN)
}

fn text(command: clap::Command) -> Result<String, String> {
    let mut bytes = Vec::new();
    Man::new(command).render(&mut bytes).map_err(|error| format!("cannot write a manual page: {error}"))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
