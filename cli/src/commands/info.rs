//! `kinora info`: what a bug report should say first.

use serde::Serialize;

use crate::exit::{self, Outcome};
use crate::terminal;

/// Show the version, the devices and what would render.
///
/// Example: kinora info --json
#[derive(Debug, clap::Args)]
pub struct Args {
    /// As JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Info {
    version: &'static str,
    system: String,
    features: Vec<&'static str>,
    threads: usize,
    /// What `--backend auto` takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    backend: Option<&'static str>,
    adapters: Vec<Adapter>,
}

#[derive(Serialize)]
struct Adapter {
    name: String,
    api: String,
    driver: String,
    software: bool,
    max_buffer_bytes: u64,
    usable: bool,
}

pub fn run(args: &Args) -> Outcome {
    let adapters = adapters();
    let info = Info {
        version: env!("CARGO_PKG_VERSION"),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        features: features(),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        backend: backend(&adapters),
        adapters,
    };
    terminal::out(&if args.json { terminal::json(&info) } else { text(&info) })?;
    Ok(exit::CLEAN)
}

fn features() -> Vec<&'static str> {
    let all = [
        ("render", cfg!(feature = "render")),
        ("physics", cfg!(feature = "physics")),
        ("viewer", cfg!(feature = "viewer")),
    ];
    all.into_iter().filter(|(_, there)| *there).map(|(name, _)| name).collect()
}

#[cfg(feature = "render")]
fn adapters() -> Vec<Adapter> {
    let adapter = |found: kinora_renderer::gpu::AdapterReport| Adapter {
        name: found.name,
        api: found.api,
        driver: found.driver,
        software: found.software,
        max_buffer_bytes: found.max_buffer_bytes,
        usable: found.usable,
    };
    kinora_renderer::gpu::adapters().into_iter().map(adapter).collect()
}

#[cfg(not(feature = "render"))]
fn adapters() -> Vec<Adapter> {
    Vec::new()
}

fn backend(adapters: &[Adapter]) -> Option<&'static str> {
    let hardware = adapters.iter().any(|adapter| adapter.usable && !adapter.software);
    cfg!(feature = "render").then_some(if hardware { "gpu" } else { "cpu" })
}

fn text(info: &Info) -> String {
    let mut text = format!("kinora {} · {}\n", info.version, info.system);
    text += &format!("features  {}\n", if info.features.is_empty() { "none".into() } else { info.features.join(", ") });
    text += &format!("threads   {}\n", info.threads);
    if let Some(backend) = info.backend {
        text += &format!("backend   {backend} (what `--backend auto` takes)\n");
    }
    for adapter in &info.adapters {
        let kind = if adapter.software { "software" } else { "hardware" };
        let usable = if adapter.usable { "" } else { ", cannot run the kernel" };
        let mib = adapter.max_buffer_bytes >> 20;
        text += &format!("adapter   {} ({kind}{usable})\n", adapter.name);
        text += &format!("          {} · {} · arrays up to {mib} MiB\n", adapter.api, adapter.driver);
    }
    if info.adapters.is_empty() && cfg!(feature = "render") {
        text += "adapter   none\n";
    }
    text
}
