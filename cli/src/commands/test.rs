//! `kinora test`: whether scenes still give the pictures that they say they give.

use std::path::{Path, PathBuf};
use std::time::Instant;

use kinora_renderer::{Renderer, Request};

use super::render::{End, draw, stamp};
use crate::encode::{self, Bits, Format, Layers, Target};
use crate::exit::{self, Outcome};
use crate::flags::{BackendName, FileFlags};
use crate::likeness::{Claim, Difference, Misread, Picture, Shown, claims, page};
use crate::progress::{Progress, Told};
use crate::report::escaped;
use crate::session::{self, Changes, Loaded};
use crate::stop::Stop;
use crate::terminal;

/// Render scenes and compare them with the reference pictures that they name.
///
/// A scene names one in a comment: // test: cornell.png, samples 64, flip < 0.02
///
/// Example: kinora test scenes --html report.html
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: FileFlags,
    /// Write the references that are missing or differ anew
    #[arg(long)]
    bless: bool,
    /// Write a page that shows all pictures, and where they differ
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Write a report in JUnit's XML
    #[arg(long, value_name = "FILE.xml")]
    junit: Option<PathBuf>,
    /// Show no progress, and nothing of what is right
    #[arg(long, short)]
    quiet: bool,
    /// What does the work
    #[arg(long, value_enum, default_value_t)]
    backend: BackendName,
    /// Threads of the CPU backend; 0 is one a core
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
}

/// What came of one claim.
struct Case {
    scene: String,
    /// The reference, as the scene names it.
    name: String,
    line: usize,
    seconds: f64,
    verdict: Verdict,
    shown: Shown,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Right,
    Blessed,
    Changed,
    Missing,
    Faulty,
}

impl Verdict {
    fn is_right(self) -> bool {
        matches!(self, Verdict::Right | Verdict::Blessed)
    }

    fn word(self) -> &'static str {
        match self {
            Verdict::Right => "right",
            Verdict::Blessed => "blessed",
            Verdict::Changed => "changed",
            Verdict::Missing => "missing",
            Verdict::Faulty => "faulty",
        }
    }
}

/// Why there is no picture.
enum Fault {
    /// The scene is at fault, in these words.
    Scene(String),
    /// Nothing more is to be done: this is how it ends.
    Over(Outcome),
}

/// Makes the references of one scene, on the CPU, without a word.
///
/// # Errors
/// As of the command.
pub fn bless(scene: &Path) -> Outcome {
    let files = FileFlags {
        paths: vec![scene.to_path_buf()],
        exclude: Vec::new(),
        force_exclude: false,
        no_ignore: true,
        allow_empty: false,
    };
    let (backend, threads) = (BackendName::Cpu, 0);
    run(&Args { files, bless: true, html: None, junit: None, quiet: true, backend, threads })
}

pub fn run(args: &Args) -> Outcome {
    let files = args.files.find()?;
    if files.iter().any(|file| file == Path::new("-")) {
        return Err("a scene from standard input has no place for its references: give it a name".into());
    }
    let [html, junit] = [&args.html, &args.junit].map(|path| path.as_deref().map(Target::new).transpose());
    let (html, junit) = (html?, junit?);
    let stop = Stop::listen().map_err(|error| format!("cannot listen for Ctrl-C: {error}"))?;
    let start = Instant::now();
    let mut all = Vec::new();
    for file in &files {
        let text = std::fs::read(file).map_err(|error| format!("cannot read `{}`: {error}", file.display()))?;
        all.extend(claims(&String::from_utf8_lossy(&text)).into_iter().map(|claim| (file.as_path(), claim)));
    }
    if all.is_empty() && !args.files.allow_empty {
        return Err(
            "no scene here names a reference: write `// test: picture.png` into one, and `kinora test --bless` \
                    makes the picture"
                .into(),
        );
    }
    let mut renderer = Renderer::new(args.backend.open(args.threads).map_err(|error| error.to_string())?);
    let mut cases = Vec::new();
    for (scene, claim) in all {
        let begun = Instant::now();
        let progress = Progress::new(args.quiet, Told::Auto, None);
        let case = match claim {
            Ok(claim) => match judge(scene, &claim, args, &mut renderer, &progress, &stop) {
                Ok(case) => case,
                Err(Fault::Over(outcome)) => {
                    progress.end(String::new);
                    return outcome;
                }
                Err(Fault::Scene(why)) => Case::new(scene, &claim.file, claim.line, Verdict::Faulty, why),
            },
            Err(Misread { line, why }) => Case::new(scene, "", line, Verdict::Faulty, why),
        };
        progress.end(String::new);
        let case = Case { seconds: begun.elapsed().as_secs_f64(), ..case };
        if !args.quiet || !case.verdict.is_right() {
            terminal::err(&case.line());
        }
        cases.push(case);
    }
    let count = |verdict| cases.iter().filter(|case| case.verdict == verdict).count();
    let kinds = [Verdict::Right, Verdict::Blessed, Verdict::Changed, Verdict::Missing, Verdict::Faulty];
    let counts: Vec<String> = kinds
        .into_iter()
        .filter(|kind| count(*kind) > 0)
        .map(|kind| format!("{} {}", count(kind), kind.word()))
        .collect();
    let summary = format!(
        "tested {} picture{} in {:.1} s: {}",
        cases.len(),
        if cases.len() == 1 { "" } else { "s" },
        start.elapsed().as_secs_f64(),
        if counts.is_empty() { "nothing to do".to_string() } else { counts.join(", ") }
    );
    if let Some(target) = junit {
        target.write(xml(&cases).as_bytes())?;
    }
    let right = cases.iter().all(|case| case.verdict.is_right());
    let missing = count(Verdict::Missing) > 0;
    if let Some(target) = html {
        let shown: Vec<Shown> = cases.into_iter().map(|case| case.shown).collect();
        target.write(page("Pictures of scenes", &summary, &shown).as_bytes())?;
    }
    if !args.quiet {
        terminal::err(&format!("{summary}\n"));
        if missing {
            terminal::err("`kinora test --bless` writes what is missing\n");
        }
    }
    Ok(if right { exit::CLEAN } else { exit::FINDINGS })
}

impl Case {
    fn new(scene: &Path, name: &str, line: usize, verdict: Verdict, said: String) -> Case {
        let scene = scene.display().to_string();
        let title = if name.is_empty() { format!("{scene}:{line}") } else { format!("{scene}: {name}") };
        let right = verdict.is_right();
        let shown = Shown { title, right, verdict: said, reference: None, picture: None, difference: None };
        Case { scene, name: name.into(), line, seconds: 0.0, verdict, shown }
    }

    fn line(&self) -> String {
        let color = if self.verdict.is_right() { "32" } else { "1;31" };
        let Case { scene, name, line, shown, .. } = self;
        format!("\x1b[{color}m{:>7}\x1b[0m {scene}:{line}: {name}: {}\n", self.verdict.word(), shown.verdict)
            .replace(": : ", ": ")
    }
}

fn judge(
    scene: &Path,
    claim: &Claim,
    args: &Args,
    renderer: &mut Renderer,
    progress: &Progress,
    stop: &Stop,
) -> Result<Case, Fault> {
    let path = scene.parent().unwrap_or(Path::new("")).join(&claim.file);
    let format = Format::of(&path, Bits::Eight, Layers::default()).map_err(Fault::Scene)?;
    let bytes = picture(scene, claim, format, renderer, progress, stop)?;
    let picture = Picture::decode(&path, &bytes).map_err(Fault::Scene)?;
    let there = path.try_exists().unwrap_or(false);
    let reference = match there {
        true => Some(Picture::read(&path).map_err(Fault::Scene)?),
        false => None,
    };
    let found = reference.as_ref().map(|reference| Difference::between(reference, &picture));
    let numbers = |found: &Difference| {
        let below = |name: &str, value: f64, limit: Option<f64>| {
            limit.map(|limit| {
                (format!("{name} {value:.4} {} {limit}", if value < limit { "<" } else { "≥" }), value < limit)
            })
        };
        let told = [below("flip", found.flip, claim.flip), below("error", found.error, claim.error)];
        let told: Vec<(String, bool)> = told.into_iter().flatten().collect();
        let right = told.iter().all(|(_, right)| *right);
        (told.into_iter().map(|(text, _)| text).collect::<Vec<_>>().join(", "), right)
    };
    let (mut verdict, mut said) = match &found {
        None => (Verdict::Missing, "there is no reference".to_string()),
        Some(Err(why)) => (Verdict::Changed, why.clone()),
        Some(Ok(found)) => match numbers(found) {
            (said, true) => (Verdict::Right, said),
            (said, false) => (Verdict::Changed, said),
        },
    };
    if args.bless && verdict != Verdict::Right {
        let target = Target::new(&path).map_err(|error| Fault::Over(Err(error)))?;
        target.write(&bytes).map_err(|error| Fault::Over(Err(error)))?;
        (verdict, said) = (Verdict::Blessed, format!("{said}; written"));
    }
    let mut case = Case::new(scene, &claim.file, claim.line, verdict, said);
    let shown = |picture: &Picture| picture.png().map_err(|error| Fault::Over(Err(error)));
    if args.html.is_some() {
        case.shown.picture = Some(shown(&picture)?);
        case.shown.reference = reference.as_ref().map(shown).transpose()?;
        let map = found.and_then(Result::ok).map(|found| found.png());
        case.shown.difference = map.transpose().map_err(|error| Fault::Over(Err(error)))?;
    }
    Ok(case)
}

/// What the scene gives, as the bytes of a file.
fn picture(
    path: &Path,
    claim: &Claim,
    format: Format,
    renderer: &mut Renderer,
    progress: &Progress,
    stop: &Stop,
) -> Result<Vec<u8>, Fault> {
    let over = |error: String| Fault::Over(Err(error));
    let Claim { samples, size, seed, camera, params, .. } = claim.clone();
    let changes = Changes { samples, size, seed, camera, params, ..Changes::default() };
    let mut loaded = session::load(path, &changes).map_err(over)?;
    match loaded.with_bodies(true, &|| stop.asked()) {
        Ok(None) => {}
        Ok(Some(exit::FINDINGS)) => return Err(Fault::Scene("its bodies cannot be computed".into())),
        Ok(Some(code)) => return Err(Fault::Over(Ok(code))),
        Err(error) => return Err(over(error)),
    }
    let Some(scene) = loaded.scene.clone() else { return Err(Fault::Scene(errors(&loaded))) };
    format.check(&scene.render).map_err(Fault::Scene)?;
    let shutter = scene.clock.shutter_of(claim.frame);
    let world = loaded.sample_moving(shutter, false).map_err(|found| Fault::Scene(loaded.plain(&found)))?;
    let film = draw(renderer, &world, &Request::default(), progress, stop).map_err(|end| match end {
        End::Stopped(code) => Fault::Over(Ok(code)),
        end => Fault::Over(end.finish(&loaded)),
    })?;
    let stamp = stamp(path, &scene, claim.frame as f64, &world, &film, renderer);
    encode::encode(&film, &world, format, &stamp).map_err(over)
}

fn errors(loaded: &Loaded) -> String {
    let errors: Vec<String> =
        loaded.diagnostics.iter().filter(|found| found.is_error()).map(|found| loaded.plain(found)).collect();
    match errors.as_slice() {
        [] => "there is no scene to show".into(),
        errors => format!("the scene has mistakes\n{}", errors.join("\n")),
    }
}

/// The cases as JUnit's XML: a suite a scene.
fn xml(cases: &[Case]) -> String {
    let failures = |cases: &[&Case]| cases.iter().filter(|case| !case.verdict.is_right()).count();
    let mut scenes: Vec<&str> = cases.iter().map(|case| &*case.scene).collect();
    scenes.dedup();
    let suite = |scene: &&str| {
        let own: Vec<&Case> = cases.iter().filter(|case| case.scene == **scene).collect();
        let mut text = format!(
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\">\n",
            escaped(scene),
            own.len(),
            failures(&own)
        );
        for case in own {
            let name = if case.name.is_empty() { format!("line {}", case.line) } else { case.name.clone() };
            text += &format!(
                "    <testcase name=\"{}\" classname=\"{}\" time=\"{:.3}\"",
                escaped(&name),
                escaped(scene),
                case.seconds
            );
            if case.verdict.is_right() {
                text += "/>\n";
            } else {
                let (first, said) = (case.shown.verdict.lines().next().unwrap_or(""), &case.shown.verdict);
                text += &format!(
                    ">\n      <failure type=\"{}\" message=\"{}\">{}</failure>\n    </testcase>\n",
                    case.verdict.word(),
                    escaped(first),
                    escaped(said)
                );
            }
        }
        text + "  </testsuite>\n"
    };
    let all: Vec<&Case> = cases.iter().collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"kinora test\" tests=\"{}\" failures=\"{}\" \
         errors=\"0\">\n{}</testsuites>\n",
        cases.len(),
        failures(&all),
        scenes.iter().map(suite).collect::<String>()
    )
}
