//! Asks an API for its devices and tests each, in a process of its own: a driver that crashes or hangs takes the process
//! with it and not the report. The process writes JSON, a [`Line`] a line.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use kinora_renderer::gpu::{self, Api, Gpu};
use kinora_renderer::{Backend, SELF_TEST_TOLERANCE, self_test};
use serde::{Deserialize, Serialize};

use super::{Adapter, Limits, SelfTest};
use crate::terminal;

/// What all devices of an API may take together: several times what a slow one needs to compile the kernel.
const PATIENCE: Duration = Duration::from_secs(30);

#[derive(Serialize, Deserialize)]
enum Line {
    /// All adapters, before the first is tested.
    Adapters(Vec<Adapter>),
    /// The next one was tested.
    Tested(SelfTest),
}

/// The name by which a probe of `api` is asked for.
pub fn name_of(api: Api) -> &'static str {
    match api {
        Api::Vulkan => "vulkan",
        Api::Metal => "metal",
        Api::Dx12 => "dx12",
        Api::Gl => "gl",
    }
}

/// The probe's side.
///
/// # Errors
/// Nobody reads what it says.
pub fn run(name: &str, checks: bool) -> Result<(), String> {
    let say = |line: &Line| terminal::out(&(serde_json::to_string(line).unwrap_or_default() + "\n"));
    let Some(api) = Api::ALL.into_iter().find(|api| name_of(*api) == name) else {
        return Err(format!("there is no API `{name}`"));
    };
    let adapters = gpu::adapters_of(api);
    say(&Line::Adapters(adapters.iter().map(describe).collect()))?;
    for adapter in &adapters {
        let backend = Gpu::open(adapter, checks).map(|gpu| Box::new(gpu) as Box<dyn Backend>);
        say(&Line::Tested(test(backend.map_err(|error| error.to_string()))))?;
    }
    Ok(())
}

/// Tests a backend.
pub fn test(backend: Result<Box<dyn Backend>, String>) -> SelfTest {
    let start = Instant::now();
    let result = backend.and_then(|backend| self_test(backend).map_err(|error| error.to_string()));
    let seconds = (start.elapsed().as_secs_f64() * 1e3).round() / 1e3;
    match result {
        // Not a number is no pass.
        Ok(off) if off < SELF_TEST_TOLERANCE => SelfTest { ok: true, off: Some(off), seconds, error: None },
        Ok(off) => SelfTest { ok: false, off: Some(off), seconds, error: None },
        Err(error) => SelfTest { ok: false, off: None, seconds, error: Some(error) },
    }
}

fn describe(adapter: &gpu::Adapter) -> Adapter {
    let demands = adapter.demands();
    let allowed = |what: &str| demands.iter().find(|demand| demand.what.contains(what)).map_or(0, |d| d.allowed);
    Adapter {
        name: adapter.name().to_owned(),
        api: adapter.api.to_string(),
        driver: adapter.driver(),
        software: adapter.is_software(),
        usable: adapter.check().is_ok(),
        limits: Limits {
            array_bytes: adapter.max_array_bytes(),
            storage_buffers: allowed("storage buffers"),
            workgroups: adapter.max_workgroups().into(),
            invocations: allowed("invocations"),
        },
        self_test: SelfTest::default(),
    }
}

/// A probe that runs.
pub struct Probe {
    api: Api,
    child: Child,
    lines: Receiver<String>,
}

impl Probe {
    /// Starts a probe of `api`.
    ///
    /// # Errors
    /// The program cannot be started again.
    pub fn start(api: Api) -> Result<Self, String> {
        let failed = |error: std::io::Error| format!("{api}: cannot start a process: {error}");
        let program = std::env::current_exe().map_err(failed)?;
        let mut command = Command::new(program);
        // What drivers have to say on stderr is no part of the report.
        command.args(["info", "--probe", name_of(api)]).stdin(Stdio::null()).stderr(Stdio::null());
        let mut child = command.stdout(Stdio::piped()).spawn().map_err(failed)?;
        let (sender, lines) = channel();
        if let Some(out) = child.stdout.take() {
            std::thread::spawn(move || {
                for line in BufReader::new(out).lines().map_while(Result::ok) {
                    if sender.send(line).is_err() {
                        break;
                    }
                }
            });
        }
        Ok(Self { api, child, lines })
    }

    /// Waits for it: the adapters, and what kept it from saying more.
    pub fn finish(mut self) -> (Vec<Adapter>, Option<String>) {
        let (adapters, tested, late) = collect(&self.lines, Instant::now() + PATIENCE);
        if late {
            // It may have ended just now.
            let _ = self.child.kill();
        }
        let status = self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
        let stopped = match late {
            true => format!("no answer within {} s", PATIENCE.as_secs()),
            false => format!("the driver ended the process ({status})"),
        };
        conclude(self.api, adapters, tested, &stopped)
    }
}

// What a probe said before it ended, or until the deadline: then the last is true.
fn collect(lines: &Receiver<String>, deadline: Instant) -> (Option<Vec<Adapter>>, Vec<SelfTest>, bool) {
    let (mut adapters, mut tested) = (None, Vec::new());
    loop {
        match lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(Line::Adapters(found)) => adapters = Some(found),
                Ok(Line::Tested(test)) => tested.push(test),
                // A driver writes to stdout.
                Err(_) => {}
            },
            Err(RecvTimeoutError::Disconnected) => return (adapters, tested, false),
            Err(RecvTimeoutError::Timeout) => return (adapters, tested, true),
        }
    }
}

// Puts the tests to their adapters; `stopped` is why some may be missing.
fn conclude(
    api: Api,
    adapters: Option<Vec<Adapter>>,
    tested: Vec<SelfTest>,
    stopped: &str,
) -> (Vec<Adapter>, Option<String>) {
    let Some(mut adapters) = adapters else {
        return (Vec::new(), Some(format!("{api}: {stopped} while it was asked for its devices")));
    };
    let mut tested = tested.into_iter();
    // Only the one that was being tested is to blame.
    let mut reason = stopped.to_owned();
    for adapter in &mut adapters {
        adapter.self_test = tested.next().unwrap_or_else(|| {
            let error = Some(std::mem::replace(&mut reason, "not tested".into()));
            SelfTest { ok: false, off: None, seconds: 0.0, error }
        });
    }
    (adapters, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str) -> Adapter {
        Adapter { name: name.into(), ..Adapter::default() }
    }

    // What the report says about each adapter, and about the API.
    fn check(said: &[&str], late: bool, expected: &[(&str, bool, &str)], problem: bool) {
        let (sender, lines) = channel();
        said.iter().for_each(|line| sender.send((*line).to_owned()).unwrap());
        // A driver that hangs keeps its end open.
        let sender = late.then_some(sender);
        let (adapters, tested, timed_out) = collect(&lines, Instant::now() + Duration::from_millis(50));
        assert_eq!(timed_out, late);
        drop(sender);
        let (adapters, found) = conclude(Api::Vulkan, adapters, tested, "it stopped");
        let got: Vec<_> = adapters
            .iter()
            .map(|a| (a.name.as_str(), a.self_test.ok, a.self_test.error.as_deref().unwrap_or_default()))
            .collect();
        assert_eq!((got.as_slice(), found.is_some()), (expected, problem), "{said:?}");
    }

    #[test]
    fn drivers_that_misbehave() {
        let line = |line: &Line| serde_json::to_string(line).unwrap();
        let two = line(&Line::Adapters(vec![adapter("a"), adapter("b")]));
        let good = line(&Line::Tested(SelfTest { ok: true, ..SelfTest::default() }));
        let bad = line(&Line::Tested(SelfTest { error: Some("lost".into()), ..SelfTest::default() }));
        check(&[&two, &good, &bad], false, &[("a", true, ""), ("b", false, "lost")], false);
        check(&[&two, "MESA: hello", &good], false, &[("a", true, ""), ("b", false, "it stopped")], false);
        check(&[&two], false, &[("a", false, "it stopped"), ("b", false, "not tested")], false);
        check(&[&two, &good], true, &[("a", true, ""), ("b", false, "it stopped")], false);
        check(&[], false, &[], true);
        check(&[], true, &[], true);
        check(&[&line(&Line::Adapters(vec![]))], false, &[], false);
    }
}
