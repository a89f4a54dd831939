//! `kinora completions`: what a shell needs to complete the command line.

use clap_complete::Shell;
use clap_complete_nushell::Nushell;

use crate::exit::{self, Outcome};
use crate::terminal;

/// Print what a shell needs to complete commands and flags.
///
/// Example: kinora completions bash > ~/.local/share/bash-completion/completions/kinora
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    shell: Name,
}

/// Shells that completions are written for.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Name {
    Bash,
    Zsh,
    Fish,
    #[value(name = "powershell")]
    PowerShell,
    Nushell,
}

pub fn run(args: &Args, mut program: clap::Command) -> Outcome {
    let mut bytes = Vec::new();
    let mut write = |shell| clap_complete::generate(shell, &mut program, "kinora", &mut bytes);
    match args.shell {
        Name::Bash => write(Shell::Bash),
        Name::Zsh => write(Shell::Zsh),
        Name::Fish => write(Shell::Fish),
        Name::PowerShell => write(Shell::PowerShell),
        Name::Nushell => clap_complete::generate(Nushell, &mut program, "kinora", &mut bytes),
    }
    terminal::out(&String::from_utf8_lossy(&bytes))?;
    Ok(exit::CLEAN)
}
