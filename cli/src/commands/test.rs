//! `kinora test`: whether scenes still give the pictures that they say they give.

use std::path::{Path, PathBuf};
use std::time::Instant;

use kinora_lang::claims::{Claim, claims};
use kinora_lang::diagnostic::Diagnostic;
use kinora_lang::files::{FileError, Files, Folder};
use kinora_lang::source::{FileId, Source};
use kinora_renderer::{Renderer, Request};
use serde::Serialize;

use super::render::{End, draw, stamp};
use crate::encode::{self, Bits, Format, Layers, Target};
use crate::exit::{self, Outcome};
use crate::flags::{BackendName, FileFlags};
use crate::likeness::{Difference, MOST_BYTES, Picture, Shown, page};
use crate::progress::{Progress, Told};
use crate::report::{self, Suite, TestCase};
use crate::session::{self, Changes, Loaded};
use crate::stop::Stop;
use crate::terminal;

/// Render scenes and compare them with the reference pictures that they name.
///
/// A scene names one in a comment: // test: cornell.png, samples 64, flip < 0.02
///
/// Ends with 0 if all are right, with 1 if any is not, and with 2 if there is nothing to test or it cannot be done.
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
    /// Print what came of each on stdout, as an array of JSON
    #[arg(long)]
    json: bool,
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
#[derive(Default, Serialize)]
struct Case {
    /// From the current folder where it lies below that.
    scene: String,
    line: u32,
    /// As the scene names it.
    reference: String,
    verdict: Verdict,
    /// What came of it, in one line.
    said: String,
    flip: Option<f64>,
    error: Option<f64>,
    seconds: f64,
    /// What there is to say beyond that line.
    #[serde(skip)]
    more: String,
    /// All that the scene says.
    #[serde(skip)]
    asked: String,
    #[serde(skip)]
    pictures: Pictures,
}

/// As PNGs, where a page shows them.
#[derive(Default)]
struct Pictures {
    reference: Option<Vec<u8>>,
    picture: Option<Vec<u8>>,
    difference: Option<Vec<u8>>,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Verdict {
    Right,
    Blessed,
    Changed,
    Missing,
    /// There is nothing to compare.
    #[default]
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
    /// The scene is at fault: in one line, and what there is to say beyond it.
    Scene(String, String),
    /// Nothing more is to be done: this is how it ends.
    Over(Outcome),
}

/// As a fault of the scene.
fn at_fault(why: String) -> Fault {
    Fault::Scene(why, String::new())
}

/// As what ends everything.
fn over(why: String) -> Fault {
    Fault::Over(Err(why))
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
    run(&Args { files, bless: true, html: None, junit: None, json: false, quiet: true, backend, threads })
}

/// A claim or what is wrong with it, of a scene whose text this is.
struct Test<'a> {
    scene: &'a Path,
    folder: &'a Folder,
    source: &'a Source,
    claim: Result<Claim, Box<Diagnostic>>,
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
    let scenes = files.iter().map(|file| scene(file)).collect::<Result<Vec<_>, String>>()?;
    let tests = files.iter().zip(&scenes).flat_map(|(scene, (folder, source))| {
        claims(source).into_iter().map(move |claim| Test { scene, folder, source, claim })
    });
    let tests: Vec<Test<'_>> = tests.collect();
    if tests.is_empty() && !args.files.allow_empty {
        return Err(
            "no scene here names a reference: write `// test: picture.png` into one, and `kinora test --bless` \
                    makes the picture"
                .into(),
        );
    }
    let mut renderer = Renderer::new(args.backend.open(args.threads).map_err(|error| error.to_string())?);
    let mut cases = Vec::new();
    for test in &tests {
        let begun = Instant::now();
        let progress = Progress::new(args.quiet, Told::Auto, None);
        let case = match &test.claim {
            Ok(claim) => judge(test, claim, args, &mut renderer, &progress, &stop),
            Err(found) => {
                let line = found.place().map_or(1, |(_, span)| test.source.position(span.start).line);
                let mut source = test.source.clone();
                source.name = test.scene.to_string_lossy().into();
                let more = report::plain(found, &[source]);
                Ok(Case { line, said: found.message.clone(), more, ..Case::default() })
            }
        };
        progress.end(String::new);
        let case = match case {
            Ok(case) => Case {
                scene: report::from_here(&test.scene.to_string_lossy()),
                seconds: begun.elapsed().as_secs_f64(),
                ..case
            },
            Err(outcome) => return outcome,
        };
        if !args.quiet || !case.verdict.is_right() {
            terminal::err(&case.told());
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
        target.write(report::xml("kinora test", &suites(&cases)).as_bytes())?;
    }
    if args.json {
        terminal::out(&(serde_json::to_string_pretty(&cases).unwrap_or_default() + "\n"))?;
    }
    if report::on_github() {
        annotate(&cases, &summary, args.json)?;
    }
    let right = cases.iter().all(|case| case.verdict.is_right());
    let open = count(Verdict::Missing) + count(Verdict::Changed) > 0;
    if let Some(target) = html {
        let shown: Vec<Shown> = cases.into_iter().map(Case::shown).collect();
        target.write(page("Pictures of scenes", &summary, &shown).as_bytes())?;
    }
    if !args.quiet {
        terminal::err(&format!("{summary}\n"));
        if open {
            terminal::err("if they are as they should be, `kinora test --bless` takes them as the references\n");
        }
    }
    Ok(if right { exit::CLEAN } else { exit::FINDINGS })
}

/// A scene's project and its text, named from there.
fn scene(path: &Path) -> Result<(Folder, Source), String> {
    let (folder, name) = session::project(path)?;
    let text = std::fs::read(path).map_err(|error| format!("cannot read `{}`: {error}", path.display()))?;
    let source = Source::new(FileId::default(), name, String::from_utf8_lossy(&text));
    Ok((folder, source))
}

impl Case {
    fn new(claim: &Claim, verdict: Verdict, said: String) -> Case {
        let Claim { line, file, text, .. } = claim.clone();
        Case { line, reference: file, asked: text, verdict, said, ..Case::default() }
    }

    /// For a terminal.
    fn told(&self) -> String {
        let color = if self.verdict.is_right() { "32" } else { "1;31" };
        let Case { scene, line, reference, said, more, .. } = self;
        let reference = if reference.is_empty() { String::new() } else { format!("{reference}: ") };
        let mut text = format!("\x1b[{color}m{:>7}\x1b[0m {scene}:{line}: {reference}{said}\n", self.verdict.word());
        if !more.is_empty() {
            text += &format!("{}\n", more.trim_end());
        }
        text
    }

    /// For a page.
    fn shown(self) -> Shown {
        let Case { scene, line, reference, verdict, said, more, asked, pictures, .. } = self;
        let quoted =
            if scene.contains([' ', '&', '<', '>', '(', ')']) { format!("\"{scene}\"") } else { scene.clone() };
        let bless = !verdict.is_right() && pictures.picture.is_some();
        let Pictures { reference: before, picture, difference } = pictures;
        Shown {
            title: if reference.is_empty() { format!("{scene}:{line}") } else { format!("{scene}: {reference}") },
            right: verdict.is_right(),
            word: verdict.word(),
            said,
            more,
            asked,
            bless: bless.then(|| format!("kinora test {quoted} --bless")),
            reference: before,
            picture,
            difference,
        }
    }
}

/// What the reference is.
enum Reference {
    There(Picture),
    Missing,
    /// There is a file, but it is no picture.
    Unreadable(String),
}

fn reference(test: &Test<'_>, claim: &Claim) -> Result<Reference, Fault> {
    match test.folder.read_at_most(&claim.path, MOST_BYTES) {
        Ok(bytes) => {
            Ok(Picture::decode(Path::new(&claim.path), &bytes).map_or_else(Reference::Unreadable, Reference::There))
        }
        Err(FileError::Missing { .. }) => Ok(Reference::Missing),
        Err(error) => Err(at_fault(error.message())),
    }
}

/// A verdict, or how everything ends.
fn judge(
    test: &Test<'_>,
    claim: &Claim,
    args: &Args,
    renderer: &mut Renderer,
    progress: &Progress,
    stop: &Stop,
) -> Result<Case, Outcome> {
    compare(test, claim, args, renderer, progress, stop).or_else(|fault| match fault {
        Fault::Scene(said, more) => Ok(Case { more, ..Case::new(claim, Verdict::Faulty, said) }),
        Fault::Over(outcome) => Err(outcome),
    })
}

fn compare(
    test: &Test<'_>,
    claim: &Claim,
    args: &Args,
    renderer: &mut Renderer,
    progress: &Progress,
    stop: &Stop,
) -> Result<Case, Fault> {
    let path = Path::new(&claim.path);
    let format = Format::of(path, Bits::Eight, Layers::default()).map_err(at_fault)?;
    let bytes = picture(test.scene, claim, format, renderer, progress, stop)?;
    let picture = Picture::decode(path, &bytes).map_err(at_fault)?;
    let reference = reference(test, claim)?;
    let mut found = None;
    let (mut verdict, mut said) = match &reference {
        Reference::Missing => (Verdict::Missing, "there is no reference".to_string()),
        Reference::Unreadable(why) => (Verdict::Faulty, format!("the reference cannot be read: {why}")),
        Reference::There(reference) => match Difference::between(reference, &picture) {
            Err(why) => (Verdict::Changed, why),
            Ok(difference) => {
                let (said, right) = within(claim, &difference);
                found = Some(difference);
                (if right { Verdict::Right } else { Verdict::Changed }, said)
            }
        },
    };
    if args.bless && verdict != Verdict::Right {
        place(test.folder.root(), path)?.write(&bytes).map_err(over)?;
        (verdict, said) = (Verdict::Blessed, format!("{said}; written"));
    }
    let mut case = Case::new(claim, verdict, said);
    (case.flip, case.error) = found.as_ref().map(|found| (found.flip, found.error)).unzip();
    if args.html.is_some() {
        let before = match &reference {
            Reference::There(reference) => Some(reference.png().map_err(over)?),
            _ => None,
        };
        let difference = found.map(|found| found.png()).transpose().map_err(over)?;
        case.pictures = Pictures { reference: before, picture: Some(picture.png().map_err(over)?), difference };
    }
    Ok(case)
}

/// The numbers beside their limits, and whether they keep to them.
fn within(claim: &Claim, found: &Difference) -> (String, bool) {
    let below = |name: &str, value: f64, limit: Option<f64>| {
        limit.map(|limit| {
            let right = value < limit;
            (format!("{name} {value:.4} {} {limit}", if right { "<" } else { "≥" }), right)
        })
    };
    let told = [below("flip", found.flip, claim.flip), below("error", found.error, claim.error)];
    let (told, right): (Vec<String>, Vec<bool>) = told.into_iter().flatten().unzip();
    (told.join(", "), right.into_iter().all(|right| right))
}

/// Where a reference goes: in the project, also where links lead out of it. Folders that are not there are made.
fn place(root: &Path, path: &Path) -> Result<Target, Fault> {
    let whole = root.join(path);
    let folder = whole.parent().unwrap_or(root);
    let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(root);
    if !there.canonicalize().is_ok_and(|there| there.starts_with(root)) {
        return Err(at_fault(FileError::Link { path: path.display().to_string() }.message()));
    }
    std::fs::create_dir_all(folder).map_err(|error| over(format!("cannot make `{}`: {error}", folder.display())))?;
    Target::new(&whole).map_err(over)
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
    let Claim { samples, size, seed, camera, params, .. } = claim.clone();
    let changes = Changes { samples, size, seed, camera, params, ..Changes::default() };
    let mut loaded = session::load(path, &changes).map_err(over)?;
    match loaded.with_bodies(true, &|| stop.asked()) {
        Ok(None) => {}
        Ok(Some(exit::FINDINGS)) => return Err(at_fault("its bodies cannot be computed".into())),
        Ok(Some(code)) => return Err(Fault::Over(Ok(code))),
        Err(error) => return Err(over(error)),
    }
    let Some(scene) = loaded.scene.clone() else { return Err(mistakes(&loaded)) };
    format.check(&scene.render).map_err(at_fault)?;
    let shutter = scene.clock.shutter_of(claim.frame);
    let world = loaded
        .sample_moving(shutter, false)
        .map_err(|found| Fault::Scene(found.message.clone(), loaded.plain(&found)))?;
    let film = draw(renderer, &world, &Request::default(), progress, stop).map_err(|end| match end {
        End::Stopped(code) => Fault::Over(Ok(code)),
        end => Fault::Over(end.finish(&loaded)),
    })?;
    let stamp = stamp(path, &scene, claim.frame as f64, &world, &film, renderer);
    encode::encode(&film, &world, format, &stamp).map_err(over)
}

fn mistakes(loaded: &Loaded) -> Fault {
    let errors: Vec<String> =
        loaded.diagnostics.iter().filter(|found| found.is_error()).map(|found| loaded.plain(found)).collect();
    match errors.as_slice() {
        [] => at_fault("there is no scene to show".into()),
        errors => Fault::Scene("the scene has mistakes".into(), errors.join("\n")),
    }
}

/// The cases for JUnit: a suite a scene.
fn suites(cases: &[Case]) -> Vec<Suite> {
    let mut suites: Vec<Suite> = Vec::new();
    for case in cases {
        let line = format!("line {}", case.line);
        let text = if case.more.is_empty() { &case.said } else { &case.more };
        let test = TestCase {
            name: if case.reference.is_empty() { line } else { case.reference.clone() },
            line: Some(case.line),
            seconds: Some(case.seconds),
            fault: (!case.verdict.is_right()).then(|| report::Fault {
                // What keeps a picture from being compared is no difference of pictures.
                is_error: case.verdict == Verdict::Faulty,
                kind: case.verdict.word().into(),
                message: case.said.clone(),
                text: text.clone(),
            }),
        };
        match suites.last_mut().filter(|suite| suite.file == case.scene) {
            Some(suite) => suite.cases.push(test),
            None => suites.push(Suite { file: case.scene.clone(), cases: vec![test], out: String::new() }),
        }
    }
    suites
}

/// For GitHub: beside each line in the pull request what came of it, unless standard output is taken, and all of it on
/// the page of the step.
fn annotate(cases: &[Case], summary: &str, taken: bool) -> Result<(), String> {
    let wrong = || cases.iter().filter(|case| !case.verdict.is_right());
    let mut rows = Vec::new();
    for Case { scene, line, reference, verdict, said, .. } in wrong() {
        let name = if reference.is_empty() { "test" } else { reference };
        let message = format!("{name} is {}: {said}", verdict.word());
        if !taken {
            let place = format!(",line={line}");
            terminal::out(&(report::annotation("error", "kinora test", scene, &place, &message) + "\n"))?;
        }
        rows.push([verdict.word().to_string(), format!("{scene}:{line}"), format!("{name}: {said}")]);
    }
    report::summarise(summary, &rows)
}
