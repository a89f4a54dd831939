//! `kinora man`: pages for man(1).

use std::path::PathBuf;

use clap_mangen::Man;

use crate::exit::{self, Outcome};
use crate::terminal;
use crate::write;

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
    let mut program = program.disable_help_subcommand(true).term_width(100);
    program.build();
    let Some(folder) = &args.output else {
        terminal::out(&text(&page(&program))?)?;
        return Ok(exit::CLEAN);
    };
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot make `{}`: {error}", folder.display()))?;
    for command in std::iter::once(&program).chain(program.get_subcommands()) {
        let page = page(command);
        write::create(&folder.join(page.get_filename()), &text(&page)?)?;
    }
    Ok(exit::CLEAN)
}

/// The page of a command. It has no date, so that it is the same whenever it is made, but a place for one: without that,
/// what follows would stand there.
fn page(command: &clap::Command) -> Man {
    let source = concat!("kinora ", env!("CARGO_PKG_VERSION"));
    Man::new(command.clone()).date(" ").source(source).manual("Kinora")
}

fn text(page: &Man) -> Result<String, String> {
    let mut bytes = Vec::new();
    page.render(&mut bytes).map_err(|error| format!("cannot write a manual page: {error}"))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
