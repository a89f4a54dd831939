//! `kinora check`: what it writes for other programs, how warnings are taken, and what it puts right.

mod common;

use common::{Folder, HELLO, Ran};
use serde_json::Value;

const BROKEN: &str = "lang 1\ncamera main { position: (0, 1, 4), look_at: (0, 0, 0) }\nsky { color: #fff }
let unused = 1\nsphere ball { raduis: 1 }\nbox crate { size: (1,\n  1, \"é\" ) }\n";

fn run(folder: &Folder, line: &str, set: &[(&str, &str)]) -> Ran {
    let mut command = folder.command(line);
    command.envs(set.iter().copied());
    Ran::from(line, command.output().unwrap())
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// As much of JSON Schema as the schema uses.
fn mismatch(schema: &Value, root: &Value, value: &Value, at: &str) -> Option<String> {
    if let Some(reference) = schema["$ref"].as_str() {
        return mismatch(&root["$defs"][reference.strip_prefix("#/$defs/").unwrap()], root, value, at);
    }
    let wrong = |what: String| Some(format!("{at}: {value} is not {what}"));
    let is = |name: &str| match name {
        "array" => value.is_array(),
        "object" => value.is_object(),
        "string" => value.is_string(),
        "integer" => value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("unknown type {other}"),
    };
    let types: Vec<&str> = match &schema["type"] {
        Value::String(name) => vec![name],
        Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    };
    if !types.is_empty() && !types.iter().any(|name| is(name)) {
        return wrong(format!("{types:?}"));
    }
    if schema["const"].is_u64() && *value != schema["const"] {
        return wrong(schema["const"].to_string());
    }
    if schema["enum"].as_array().is_some_and(|values| !values.contains(value)) {
        return wrong(schema["enum"].to_string());
    }
    if schema["minimum"].as_u64() > value.as_u64() && value.is_u64() {
        return wrong(format!("at least {}", schema["minimum"]));
    }
    for item in value.as_array().into_iter().flatten() {
        if let Some(wrong) = mismatch(&schema["items"], root, item, at) {
            return Some(wrong);
        }
    }
    let fields = value.as_object()?;
    if let Some(name) = schema["required"].as_array()?.iter().find(|name| !fields.contains_key(name.as_str().unwrap()))
    {
        return wrong(format!("complete: no {name}"));
    }
    fields.iter().find_map(|(name, value)| match &schema["properties"][name] {
        Value::Null => wrong(format!("free of {name}")),
        schema => mismatch(schema, root, value, &format!("{at}.{name}")),
    })
}

#[test]
fn json_is_as_its_schema_says() {
    let schema = json(include_str!("../../docs/check.schema.json"));
    let folder = Folder::new();
    folder.write("a/b.kin", BROKEN);
    let ran = run(&folder, "check a --format json", &[]).check(1, &["checked 1 file"]);
    let records = json(&ran.out);
    assert_eq!(mismatch(&schema, &schema, &records, "records"), None);
    let found = records.as_array().unwrap().iter().find(|found| found["code"] == "E0201").unwrap();
    assert_eq!((&found["file"], &found["path"]), (&"b.kin".into(), &"a/b.kin".into()));
    assert_eq!((&found["span"]["line"], &found["span"]["col"]), (&5.into(), &15.into()));
    assert_eq!(found["fixes"][0]["edits"][0]["insert"], "radius");
    assert!(found["url"].as_str().unwrap().ends_with("/docs/diagnostics/E0201.md"));
    // The judge itself can say no.
    let mut spoilt = records.clone();
    spoilt[0]["span"]["line"] = 0.into();
    assert!(mismatch(&schema, &schema, &spoilt, "records").is_some());
    spoilt[0]["more"] = 1.into();
    assert!(mismatch(&schema, &schema, &spoilt, "records").is_some());

    let lines = run(&folder, "check a --format jsonl", &[]).check(1, &[]).out;
    let lines: Vec<Value> = lines.lines().map(json).collect();
    assert_eq!(Value::from(lines), records);
}

#[test]
fn sarif() {
    let folder = Folder::new();
    folder.write("a b/c.kin", BROKEN);
    let line = "check . --format sarif -o out.sarif";
    run(&folder, line, &[]).check(1, &["checked 1 file"]);
    let first = folder.read("out.sarif");
    let log = json(std::str::from_utf8(&first).unwrap());
    assert_eq!(log["version"], "2.1.0");
    let run_of = &log["runs"][0];
    assert_eq!(run_of["columnKind"], "unicodeCodePoints");
    let rules = run_of["tool"]["driver"]["rules"].as_array().unwrap();
    for rule in rules {
        assert!(rule["helpUri"].as_str().unwrap().starts_with("https://"), "{rule}");
        assert!(!rule["shortDescription"]["text"].as_str().unwrap().is_empty());
        assert!(matches!(rule["defaultConfiguration"]["level"].as_str(), Some("error" | "warning")));
    }
    let results = run_of["results"].as_array().unwrap();
    // Errors first.
    assert_eq!((&results[0]["level"], &results.last().unwrap()["level"]), (&"error".into(), &"warning".into()));
    for result in results {
        let rule = result["ruleIndex"].as_u64().unwrap() as usize;
        assert_eq!(rules[rule]["id"], result["ruleId"]);
        let place = &result["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uri"], "a%20b/c.kin");
        assert_eq!(place["artifactLocation"]["uriBaseId"], "%SRCROOT%");
        assert!(place["region"]["startLine"].as_u64().unwrap() >= 1);
        assert!(!result["partialFingerprints"]["primaryLocationLineHash"].as_str().unwrap().is_empty());
    }
    let misspelt = results.iter().find(|result| result["ruleId"] == "E0201").unwrap();
    let replaced = &misspelt["fixes"][0]["artifactChanges"][0]["replacements"][0];
    assert_eq!(replaced["insertedContent"]["text"], "radius");
    assert_eq!(replaced["deletedRegion"]["startColumn"], 15);
    // Twice the same, and lines above change no fingerprint.
    run(&folder, line, &[]).check(1, &[]);
    assert_eq!(folder.read("out.sarif"), first);
    folder.write("a b/c.kin", &BROKEN.replace("let unused", "\n\nlet unused"));
    run(&folder, line, &[]).check(1, &[]);
    let moved = json(std::str::from_utf8(&folder.read("out.sarif")).unwrap());
    for (old, new) in results.iter().zip(moved["runs"][0]["results"].as_array().unwrap()) {
        assert_eq!(old["partialFingerprints"], new["partialFingerprints"]);
    }
}

#[test]
fn annotations_and_the_summary_of_a_step() {
    let folder = Folder::new();
    folder.write("b.kin", BROKEN);
    let summary = folder.path("summary.md");
    let set = [("GITHUB_ACTIONS", "true"), ("GITHUB_STEP_SUMMARY", summary.to_str().unwrap())];
    let ran = run(&folder, "check b.kin", &set).check(1, &["error[E0201]"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    let expected = "::error title=kinora (E0201),file=b.kin,line=5,col=15,endLine=5,endColumn=21::unknown property";
    assert!(lines.iter().any(|line| line.starts_with(expected)), "{lines:?}");
    assert!(lines.last().unwrap().starts_with("::warning title=kinora (W0201),file=b.kin,line=4,"), "{lines:?}");
    let summary = String::from_utf8(folder.read("summary.md")).unwrap();
    assert!(summary.contains("| error[E0201] | b.kin:5:15 |"), "{summary}");
    // Whoever asks for a format gets that one.
    assert_eq!(run(&folder, "check b.kin --format short", &set).check(1, &["b.kin:5:15"]).out, "");
}

#[test]
fn reports_of_gitlab_and_junit() {
    let folder = Folder::new();
    folder.write("b.kin", BROKEN);
    folder.write("fine.kin", HELLO);
    let report = json(&run(&folder, "check . --format gitlab", &[]).check(1, &[]).out);
    let found = report.as_array().unwrap().iter().find(|found| found["check_name"] == "E0201").unwrap();
    assert_eq!((&found["severity"], &found["location"]["path"]), (&"major".into(), &"b.kin".into()));
    assert_eq!(found["location"]["lines"]["begin"], 5);
    let mut prints: Vec<&str> = report.as_array().unwrap().iter().map(|f| f["fingerprint"].as_str().unwrap()).collect();
    prints.sort_unstable();
    prints.dedup();
    assert_eq!(prints.len(), report.as_array().unwrap().len());

    let xml = run(&folder, "check . --format junit", &[]).check(1, &[]).out;
    assert!(xml.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites "), "{xml}");
    assert!(xml.contains("<testsuite name=\"fine.kin\" tests=\"1\" failures=\"0\""), "{xml}");
    assert!(xml.contains("<failure type=\"E0201\" message=\"unknown property `raduis` on `sphere`\">"), "{xml}");
    assert_eq!(xml.matches("<testsuite ").count(), 2);
    assert_eq!(xml.matches('<').count(), xml.matches('>').count());
}

const WARNS: &str = "lang 1\ncamera main { position: (0, 1, 4), look_at: (0, 0, 0) }\nsky { color: #fff }
let size = 1\nsphere ball { }\n";

#[test]
fn levels_of_warnings() {
    let folder = Folder::new();
    folder.write("a.kin", WARNS);
    let check =
        |line: &str, code: i32, pieces: &[&str]| run(&folder, &format!("check a.kin {line}"), &[]).check(code, pieces);
    check("", 0, &["warning[W0201]", "1 warning"]);
    check("--deny warnings", 1, &["error[W0201]", "1 error"]);
    check("--deny w0201", 1, &["error[W0201]"]);
    check("--deny warnings --allow W0401,W0201", 0, &["no mistakes"]);
    check("--allow W0201 --deny W0201", 1, &["error[W0201]"]);
    check("--deny W0201 --allow W0201", 0, &["no mistakes"]);
    check("--deny W0402", 0, &["warning[W0201]"]);
    check("--allow W0281", 2, &["there is no code `W0281`; did you mean"]);
    check("--allow E0201", 2, &["`E0201` is an error and stays one"]);
    check("--statistics --quiet", 0, &["     1  W0201  "]);
    assert!(!check("--quiet", 0, &[]).err.contains("checked"));

    folder.write("kinora.toml", "[lints]\nW0201 = \"deny\"\n");
    check("", 1, &["error[W0201]"]);
    check("--warn W0201", 0, &["warning[W0201]"]);
    folder.write("kinora.toml", "[lints]\nallow = [\"W0201\"]\nwarnings = \"deny\"\n");
    check("", 0, &["no mistakes"]);
    folder.write("kinora.toml", "[lints]\nW0201 = \"off\"\n");
    check("", 1, &["error[E0713]: no level `off`", "kinora.toml:2:9"]);
    folder.write("kinora.toml", "[lint]\n");
    check("", 0, &["warning[W0714]", "kinora.toml:1:2", "did you mean `lints`?"]);
}

#[test]
fn allowances_in_the_scene() {
    let folder = Folder::new();
    folder.write("a.kin", &WARNS.replace("let size", "// allow(W0201): later\nlet size"));
    run(&folder, "check a.kin --deny warnings", &[]).check(0, &["no mistakes"]);
    folder.write("a.kin", &WARNS.replace("sphere ball", "// allow(W0201)\nsphere ball"));
    run(&folder, "check a.kin", &[]).check(0, &["warning[W0201]", "warning[W0903]"]);
    run(&folder, "check a.kin --fix=maybe", &[]).check(0, &["fixed"]);
    assert!(!String::from_utf8(folder.read("a.kin")).unwrap().contains("allow"));
}

#[test]
fn fixes_are_written() {
    let folder = Folder::new();
    let uses = "lang 1\nimport { ball } from \"lib/ball.kin\"\ncamera main { position: (0, 0, 4) }\nsky { color: #fff }\nball { szie: 1 }\n";
    let lib = "lang 1\nprefab ball(size: length) { sphere { raduis: size } }\r\n";
    folder.write("kinora.toml", "");
    folder.write("scenes/a.kin", &uses.replace("lib/", "../lib/"));
    folder.write("lib/ball.kin", lib);
    run(&folder, "check scenes", &[]).check(1, &["fixable with --fix"]);
    assert_eq!(folder.read("lib/ball.kin"), lib.as_bytes());
    run(&folder, "check scenes --fix", &[]).check(0, &["no mistakes", "2 fixed"]);
    assert_eq!(folder.read("lib/ball.kin"), lib.replace("raduis", "radius").as_bytes());
    assert!(String::from_utf8(folder.read("scenes/a.kin")).unwrap().contains("ball { size: 1 }"));
    assert_eq!(folder.names("lib"), ["ball.kin"]);
    run(&folder, "check - --fix", &[]).check(2, &["standard input"]);

    // What is only likely waits for the word.
    let maybe = HELLO.replace("fov: 40deg", "fov: 40");
    folder.write("b.kin", &maybe);
    run(&folder, "check b.kin --fix", &[]).check(1, &["E0304", "1 with --fix=maybe"]);
    assert_eq!(folder.read("b.kin"), maybe.as_bytes());
    run(&folder, "check b.kin --fix=maybe", &[]).check(0, &["no mistakes", "1 fixed"]);
    assert_eq!(folder.read("b.kin"), HELLO.as_bytes());
}

#[cfg(unix)]
#[test]
fn what_is_fixed_keeps_its_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("radius", "raduis"));
    std::fs::set_permissions(folder.path("a.kin"), std::fs::Permissions::from_mode(0o640)).unwrap();
    run(&folder, "check a.kin --fix", &[]).check(0, &[]);
    assert_eq!(std::fs::metadata(folder.path("a.kin")).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn which_files_are_looked_at() {
    let folder = Folder::new();
    for name in ["a/x.kin", "a/old/y.kin", "a/out/z.kin"] {
        folder.write(name, HELLO);
    }
    folder.write("a/.gitignore", "out/\n");
    for (line, count) in [
        ("check a", "checked 2 files"),
        ("check a --no-ignore", "checked 3 files"),
        ("check a --exclude old", "checked 1 file "),
        ("check a --exclude a/old/** --exclude x.kin --allow-empty", "checked 0 files"),
        ("check a/x.kin --exclude x.kin", "checked 1 file "),
        ("check a/x.kin --exclude x.kin --force-exclude --allow-empty", "checked 0 files"),
        ("check a/out/z.kin", "checked 1 file "),
    ] {
        run(&folder, line, &[]).check(0, &[count]);
    }
    run(&folder, "check a/x.kin --exclude x.kin --force-exclude", &[]).check(2, &["nothing is left"]);
}

#[test]
fn frames_and_assets() {
    let folder = Folder::new();
    // Wrong in the middle alone.
    folder.write("a.kin", &HELLO.replace("radius: 50cm", "radius: 0.9m - 1m * sin(turn(time / 4s))"));
    for (line, code) in [("", 1), ("--frames all", 1), ("--frames ends", 0), ("--frames 3", 1)] {
        run(&folder, &format!("check a.kin {line}"), &[]).check(code, &[]);
    }
    run(&folder, "check a.kin --frames 1", &[]).check(2, &["`all`, `ends` or a number"]);
    folder.write("b.kin", &HELLO.replace("sphere ball {", "mesh m { file: \"none.obj\" }\nsphere ball {"));
    run(&folder, "check b.kin", &[]).check(1, &["E0701"]);
    run(&folder, "check b.kin --no-assets", &[]).check(0, &["no mistakes"]);
}

#[test]
fn values_from_the_command_line() {
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("lang 1", "lang 1\nparam r: length = 1 in 0m..2m").replace("50cm", "r - 1m"));
    run(&folder, "check a.kin -D r=1.5", &[]).check(0, &[]);
    run(&folder, "check a.kin -D r=0.5", &[]).check(1, &["E0401", "-0.5m"]);
    run(&folder, "check a.kin -D r=3", &[]).check(1, &["E0413"]);
    run(&folder, "check a.kin -D r=1.5 --set ball.radius=0", &[]).check(1, &["E0401"]);
}

#[test]
fn many_findings() {
    let folder = Folder::new();
    let many: String = (0..70).map(|i| format!("sphere s{i} {{ raduis: 1 }}\n")).collect();
    folder.write("a.kin", &(BROKEN.to_string() + &many));
    let count = |line: &str| {
        let ran = run(&folder, &format!("check a.kin --format short {line}"), &[]).check(1, &[]);
        ran.err.lines().filter(|line| line.starts_with("a.kin:")).count()
    };
    assert_eq!((count(""), count("--max-diagnostics 7"), count("--max-diagnostics 1000")), (50, 7, 73));
    let out = folder.path("found.txt");
    run(&folder, "check a.kin --color always -o found.txt", &[]).check(1, &["checked"]);
    assert!(
        std::fs::read_to_string(out).unwrap().starts_with("error[E0301]") || !folder.read("found.txt").contains(&0x1b)
    );
}
