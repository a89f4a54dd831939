//! `kinora bake`: where bodies are, computed and kept.

use serde::Serialize;

use crate::bake::Baking;
use crate::exit::{self, Outcome};
use crate::flags::SceneFlags;
use crate::session;
use crate::stop::Stop;
use crate::terminal;

/// Run the simulation of a scene's bodies and keep the result.
///
/// Pictures and films do so by themselves; what is kept is used again until the bodies change. What was stopped goes on
/// where it was.
///
/// Example: kinora bake dominoes.kin
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// Take the bake as it is kept; one that is not there or not right is an error
    #[arg(long)]
    frozen_bake: bool,
    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
    /// Print what it took on stdout, as one line of JSON
    #[arg(long)]
    json: bool,
}

/// What it took.
#[derive(Serialize)]
struct Statistics {
    bodies: usize,
    steps: u64,
    /// Whether it was there already.
    kept: bool,
    /// What it depends on: the same for the same bodies.
    key: String,
    file: String,
    bake_s: f64,
}

pub fn run(args: &Args) -> Outcome {
    let stop = Stop::listen().map_err(|error| format!("cannot listen for Ctrl-C: {error}"))?;
    let changes = session::Changes { frozen_bake: args.frozen_bake, ..args.scene.changes() };
    let mut loaded = session::load(&args.scene.file, &changes)?;
    loaded.report();
    if loaded.scene.is_none() {
        return Ok(loaded.fault_code());
    }
    let baked = match loaded.bake(&Baking { quiet: args.quiet, stop: &|| stop.asked(), told: &|_| () }) {
        Ok(Some(baked)) => baked,
        Ok(None) => {
            if !args.quiet {
                terminal::err("there is nothing to bake: no body is moved by forces\n");
            }
            return Ok(exit::CLEAN);
        }
        Err(end) => return Ok(end.finish(&loaded)),
    };
    if let Some(why) = baked.bake.not_kept {
        return Err(why);
    }
    let bake = baked.bake;
    let file = baked.path.display().to_string();
    if args.json {
        let (bodies, steps, kept, key) = (bake.bodies, bake.steps, bake.kept, bake.key);
        let line = Statistics { bodies, steps, kept, key, file, bake_s: baked.time.as_secs_f64() };
        // Strings and numbers always serialise.
        terminal::out(&(serde_json::to_string(&line).unwrap_or_default() + "\n"))?;
    } else if !args.quiet {
        let bodies = if bake.bodies == 1 { "body" } else { "bodies" };
        let what = if bake.kept { "was there".into() } else { format!("{:.1} s", baked.time.as_secs_f64()) };
        terminal::err(&format!("{file}: {} {bodies}, {} steps, {what}\n", bake.bodies, bake.steps));
    }
    Ok(exit::CLEAN)
}
