//! The program `kinora`: a text file to pictures and films. One file a command; the crates meet in [`session`].

#[cfg(feature = "physics")]
mod bake;
mod commands;
#[cfg(feature = "render")]
mod encode;
mod exit;
#[cfg(feature = "render")]
mod films;
mod flags;
#[cfg(feature = "render")]
mod frames;
#[cfg(feature = "render")]
mod likeness;
mod lsp;
#[cfg(feature = "render")]
mod memory;
mod paths;
#[cfg(feature = "render")]
mod progress;
mod report;
mod session;
#[cfg(any(feature = "render", feature = "physics"))]
mod stop;
mod terminal;
#[cfg(feature = "viewer")]
mod view;
mod write;
#[cfg(feature = "render")]
mod writing;

use std::ffi::OsString;
use std::panic;
use std::path::Path;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use exit::Outcome;
use terminal::Color;

/// Write a text file, see light; write `time`, get film.
#[cfg_attr(feature = "viewer", doc = "", doc = "`kinora FILE` opens a scene in a window, as `kinora view FILE` does.")]
#[derive(Parser)]
#[command(name = "kinora", version, arg_required_else_help = true, after_help = CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// When to print in colour
    #[arg(long, value_enum, default_value_t, global = true)]
    color: Color,
}

const CODES: &str = "Exit codes: 0 clean, 1 the scene is at fault, 2 the program could not do its work,\n\
    130 stopped by Ctrl-C, 75 stopped early by SIGTERM or a lost device";

#[derive(Subcommand)]
enum Command {
    #[cfg(feature = "render")]
    Render(commands::render::Args),
    #[cfg(feature = "render")]
    Animate(commands::animate::Args),
    #[cfg(feature = "viewer")]
    View(view::Args),
    #[cfg(feature = "physics")]
    Bake(commands::bake::Args),
    Check(commands::check::Args),
    Fmt(commands::fmt::Args),
    Inspect(commands::inspect::Args),
    Params(commands::params::Args),
    Explain(commands::explain::Args),
    Info(commands::info::Args),
    #[cfg(feature = "render")]
    Test(commands::test::Args),
    #[cfg(feature = "render")]
    Diff(commands::diff::Args),
    Migrate(commands::migrate::Args),
    New(commands::new::Args),
    Lsp(lsp::Args),
    Completions(commands::completions::Args),
    Man(commands::man::Args),
}

fn main() -> ExitCode {
    panic::set_hook(Box::new(|info| terminal::err(&internal_error(info))));
    // The hook has said what there is to say.
    ExitCode::from(panic::catch_unwind(start).unwrap_or(exit::FAILED))
}

fn start() -> u8 {
    let mut args: Vec<OsString> = std::env::args_os().collect();
    // Before the arguments are read, as mistakes in them are printed too.
    color_in(&args).unwrap_or_default().apply();
    view_by_default(&mut args);
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => {
            // Nothing can be said where this fails.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(exit::FAILED);
        }
    };
    run(cli.command).unwrap_or_else(|message| {
        terminal::error(&message);
        exit::FAILED
    })
}

fn run(command: Command) -> Outcome {
    match command {
        #[cfg(feature = "render")]
        Command::Render(args) => commands::render::run(&args),
        #[cfg(feature = "render")]
        Command::Animate(args) => commands::animate::run(&args),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(&args),
        #[cfg(feature = "physics")]
        Command::Bake(args) => commands::bake::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Fmt(args) => commands::fmt::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Params(args) => commands::params::run(&args),
        Command::Explain(args) => commands::explain::run(&args),
        Command::Info(args) => commands::info::run(&args),
        #[cfg(feature = "render")]
        Command::Test(args) => commands::test::run(&args),
        #[cfg(feature = "render")]
        Command::Diff(args) => commands::diff::run(&args),
        Command::Migrate(args) => commands::migrate::run(&args),
        Command::New(args) => commands::new::run(&args),
        Command::Lsp(args) => lsp::run(&args),
        Command::Completions(args) => commands::completions::run(&args, Cli::command()),
        Command::Man(args) => commands::man::run(&args, Cli::command()),
    }
}

/// The value of `--color`, wherever it stands.
fn color_in(args: &[OsString]) -> Option<Color> {
    let args: Vec<&str> = args.iter().take_while(|arg| *arg != "--").filter_map(|arg| arg.to_str()).collect();
    let value = args.iter().enumerate().rev().find_map(|(at, arg)| match arg.strip_prefix("--color=") {
        Some(value) => Some(value),
        None if *arg == "--color" => args.get(at + 1).copied(),
        None => None,
    });
    value.and_then(|value| clap::ValueEnum::from_str(value, false).ok())
}

/// `kinora FILE` is `kinora view FILE`: a first word that is no command but looks like a file.
fn view_by_default(args: &mut Vec<OsString>) {
    let mut at = 1;
    while args.get(at).is_some_and(|arg| arg.to_string_lossy().starts_with("--color")) {
        at += if args[at] == "--color" { 2 } else { 1 };
    }
    let Some(first) = args.get(at) else { return };
    let path = Path::new(first);
    let known = Cli::command().get_subcommands().any(|command| first == command.get_name()) || first == "help";
    if cfg!(feature = "viewer") && !known && (path.extension().is_some_and(|ending| ending == "kin") || path.is_file())
    {
        args.insert(at, "view".into());
    }
}

/// What is said instead of Rust's own report.
fn internal_error(info: &panic::PanicHookInfo<'_>) -> String {
    let what = info.payload_as_str().unwrap_or("no message");
    let place = info.location().map_or_else(|| "an unknown place".into(), |at| format!("{}:{}", at.file(), at.line()));
    report::internal(&format!("{what}, at {place}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_file_alone_is_viewed() {
        for (line, expected) in [
            #[cfg(feature = "viewer")]
            ("kinora a.kin", "kinora view a.kin"),
            #[cfg(feature = "viewer")]
            ("kinora --color never a.kin", "kinora --color never view a.kin"),
            #[cfg(feature = "viewer")]
            ("kinora --color=never a.kin", "kinora --color=never view a.kin"),
            ("kinora check a.kin", "kinora check a.kin"),
            ("kinora help", "kinora help"),
            ("kinora redner", "kinora redner"),
            ("kinora", "kinora"),
        ] {
            let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
            let mut args = words(line);
            view_by_default(&mut args);
            assert_eq!(args, words(expected));
        }
    }
}
