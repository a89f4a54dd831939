//! `kinora info`: what a bug report should say first.

#[cfg(feature = "render")]
mod probe;

use serde::{Deserialize, Serialize};

use crate::exit::{self, Outcome};
use crate::terminal;

/// Show the version, the devices and what would render; test every device.
///
/// Example: kinora info --json
#[derive(Debug, clap::Args)]
pub struct Args {
    /// As JSON
    #[arg(long)]
    json: bool,
    /// Test the devices of one API, for the program itself
    #[arg(long, hide = true)]
    probe: Option<String>,
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
    /// Whether a GPU's shaders check every access to memory.
    gpu_checks: bool,
    /// Of the CPU backend.
    #[serde(skip_serializing_if = "Option::is_none")]
    self_test: Option<SelfTest>,
    adapters: Vec<Adapter>,
    /// Drivers that did not even say what devices they have.
    problems: Vec<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Adapter {
    name: String,
    api: String,
    driver: String,
    software: bool,
    /// The kernel can run on it.
    usable: bool,
    limits: Limits,
    self_test: SelfTest,
}

/// What a device allows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Limits {
    /// The largest array of a scene.
    array_bytes: u64,
    /// In one shader.
    storage_buffers: u64,
    /// Of a dispatch, along each axis.
    workgroups: u64,
    /// Of a workgroup.
    invocations: u64,
}

/// A small picture with a known answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct SelfTest {
    ok: bool,
    /// How far the picture is off; 0 is perfect.
    #[serde(skip_serializing_if = "Option::is_none")]
    off: Option<f64>,
    seconds: f64,
    /// Why there is no picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

pub fn run(args: &Args) -> Outcome {
    #[cfg(feature = "render")]
    if let Some(api) = &args.probe {
        return probe::run(api, crate::flags::gpu_checks()).map(|()| exit::CLEAN);
    }
    let info = info();
    terminal::out(&if args.json { terminal::json(&info) } else { text(&info) })?;
    Ok(exit::CLEAN)
}

fn info() -> Info {
    #[cfg_attr(not(feature = "render"), expect(unused_mut, reason = "there are no devices to add"))]
    let mut info = Info {
        version: env!("CARGO_PKG_VERSION"),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        features: features(),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        backend: None,
        gpu_checks: false,
        self_test: None,
        adapters: Vec::new(),
        problems: Vec::new(),
    };
    #[cfg(feature = "render")]
    add_devices(&mut info);
    info
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
fn add_devices(info: &mut Info) {
    use kinora_renderer::{Choice, Options, gpu::Api, open};

    let cpu = open(Choice::Cpu, Options::default());
    info.self_test = Some(probe::test(cpu.map_err(|error| error.to_string())));
    info.gpu_checks = crate::flags::gpu_checks();
    // Most of the time they wait for a compiler: all at once.
    let apis = Api::ALL.into_iter().filter(|api| api.is_built_in());
    let probes: Vec<_> = apis.map(probe::Probe::start).collect();
    for probe in probes {
        match probe.map(probe::Probe::finish) {
            Ok((adapters, problem)) => {
                info.adapters.extend(adapters);
                info.problems.extend(problem);
            }
            Err(problem) => info.problems.push(problem),
        }
    }
    let hardware = info.adapters.iter().any(|adapter| adapter.usable && !adapter.software);
    info.backend = Some(if hardware { "gpu" } else { "cpu" });
}

fn text(info: &Info) -> String {
    let mut text = format!("kinora {} · {}\n", info.version, info.system);
    text += &format!("features  {}\n", if info.features.is_empty() { "none".into() } else { info.features.join(", ") });
    text += &format!("threads   {}\n", info.threads);
    if let Some(backend) = info.backend {
        text += &format!("backend   {backend} (what `--backend auto` takes)\n");
        let checks = if info.gpu_checks { "on" } else { "off" };
        text += &format!("checks    {checks} in the shaders of GPUs (KINORA_GPU_CHECKS=1 or 0 turns them on or off)\n");
    }
    if let Some(test) = &info.self_test {
        text += &format!("cpu       {}\n", outcome(test));
    }
    for adapter in &info.adapters {
        let kind = if adapter.software { "software" } else { "hardware" };
        let Limits { array_bytes, storage_buffers, workgroups, invocations } = adapter.limits;
        let mib = array_bytes >> 20;
        text += &format!("adapter   {} ({kind})\n", adapter.name);
        text += &format!("          {} · {}\n", adapter.api, adapter.driver);
        text += &format!("          arrays up to {mib} MiB, {storage_buffers} of them in a shader; ");
        text += &format!("{workgroups} workgroups of {invocations}\n");
        text += &format!("          {}\n", outcome(&adapter.self_test));
    }
    for problem in &info.problems {
        text += &format!("adapter   {problem}\n");
    }
    if info.adapters.is_empty() && cfg!(feature = "render") {
        text += "adapter   none\n";
    }
    text
}

fn outcome(test: &SelfTest) -> String {
    let word = if test.ok { "ok" } else { "failed" };
    match (&test.error, test.off) {
        (Some(error), _) => format!("self-test {word}: {error}"),
        (None, Some(off)) => format!("self-test {word}: off by {:.2} %, {:.1} s", 100.0 * off, test.seconds),
        (None, None) => format!("self-test {word}: not run"),
    }
}
