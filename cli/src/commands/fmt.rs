//! `kinora fmt`: the one way a scene is laid out.

use kinora_lang::format::{format, format_partial};

use super::rewrite::{RewriteFlags, rewrite};
use crate::exit::Outcome;

/// Lay scenes out in the one way there is: every comment stays, and the picture is the same.
///
/// Example: kinora fmt examples --check
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: RewriteFlags,
    /// Lay out what is whole in files with mistakes too; without it such files stay as they are
    #[arg(long)]
    partial: bool,
}

pub fn run(args: &Args) -> Outcome {
    rewrite(&args.files, |_, tree| match format(tree) {
        Err(_) if args.partial && !tree.errors().is_empty() => Ok(format_partial(tree)),
        laid_out => laid_out,
    })
}
