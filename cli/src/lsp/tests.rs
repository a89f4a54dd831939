//! An editor in memory: it types what people type, and looks at every answer.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value, json};

/// An editor with a server of its own.
struct Editor {
    connection: Connection,
    server: Option<std::thread::JoinHandle<Option<u8>>>,
    next: i32,
    /// What the server said without being asked.
    said: Vec<Notification>,
    utf8: bool,
    greeting: Value,
}

impl Editor {
    fn new(root: &Path, utf8: bool) -> Editor {
        Editor::with(root, utf8, json!({}))
    }

    fn with(root: &Path, utf8: bool, more: Value) -> Editor {
        let (server, connection) = Connection::memory();
        let work = std::thread::Builder::new().stack_size(super::STACK_BYTES);
        let server = work.spawn(move || super::server::serve(&server)).unwrap();
        let mut editor =
            Editor { connection, server: Some(server), next: 0, said: Vec::new(), utf8, greeting: Value::Null };
        let encodings = if utf8 { json!(["utf-8", "utf-16"]) } else { json!(["utf-16"]) };
        let mut capabilities = json!({
            "general": { "positionEncodings": encodings },
            "workspace": { "workspaceEdit": { "documentChanges": true } },
            "textDocument": {
                "completion": { "completionItem": { "snippetSupport": true } },
                "hover": { "contentFormat": ["markdown"] },
                "documentSymbol": { "hierarchicalDocumentSymbolSupport": true },
            },
        });
        for (key, value) in more.as_object().into_iter().flatten() {
            capabilities[key] = value.clone();
        }
        let root = super::uri::of(root).unwrap();
        let params = json!({
            "processId": std::process::id(),
            "rootUri": root.as_str(),
            "workspaceFolders": [{ "uri": root.as_str(), "name": "project" }],
            "capabilities": capabilities,
        });
        editor.greeting = editor.ask("initialize", params).unwrap();
        editor.tell("initialized", json!({}));
        editor
    }

    fn tell(&self, method: &str, params: Value) {
        self.connection.sender.send(Notification { method: method.into(), params }.into()).unwrap();
    }

    fn send(&mut self, method: &str, params: Value) -> RequestId {
        self.next += 1;
        let id = RequestId::from(self.next);
        self.connection.sender.send(Request { id: id.clone(), method: method.into(), params }.into()).unwrap();
        id
    }

    fn ask(&mut self, method: &str, params: Value) -> Result<Value, String> {
        let id = self.send(method, params);
        self.answer_to(&id)
    }

    fn answer_to(&mut self, id: &RequestId) -> Result<Value, String> {
        loop {
            match self.connection.receiver.recv_timeout(Duration::from_secs(120)).unwrap() {
                Message::Response(response) if response.id == *id => {
                    return match response.response_result {
                        Ok(value) => Ok(value),
                        Err(error) => {
                            assert_ne!(error.code, lsp_server::ErrorCode::InternalError as i32, "{}", error.message);
                            Err(error.message)
                        }
                    };
                }
                Message::Response(_) | Message::Request(_) => {}
                Message::Notification(message) => self.said.push(message),
            }
        }
    }

    fn open(&self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "kinora", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn change(&self, uri: &str, version: usize, text: &str) {
        let document = json!({ "uri": uri, "version": version });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [{ "text": text }] }));
    }

    /// Waits until something is said of a text in this version, and gives it.
    fn findings(&mut self, uri: &str, version: i64) -> Vec<Value> {
        let is_it = |message: &Notification| {
            message.method == "textDocument/publishDiagnostics"
                && message.params["uri"] == *uri
                && message.params["version"] == version
        };
        let end = Instant::now() + Duration::from_secs(120);
        loop {
            if let Some(found) = self.said.iter().rev().find(|message| is_it(message)) {
                return found.params["diagnostics"].as_array().unwrap().clone();
            }
            let wait = end.saturating_duration_since(Instant::now());
            if let Message::Notification(message) = self.connection.receiver.recv_timeout(wait).unwrap() {
                self.said.push(message);
            }
        }
    }

    /// A place in a text, as this editor counts.
    fn place(&self, text: &str, offset: usize) -> Value {
        let before = &text[..offset];
        let line = before.matches('\n').count();
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        json!({ "line": line, "character": self.columns(&before[start..]) })
    }

    fn columns(&self, text: &str) -> usize {
        if self.utf8 { text.len() } else { text.encode_utf16().count() }
    }

    /// Whether a place is one of the text.
    fn check(&self, text: &str, place: &Value) {
        let line = place["line"].as_u64().unwrap() as usize;
        let found = text.split('\n').nth(line).unwrap_or_else(|| panic!("line {line} of {text:?}"));
        let found = found.strip_suffix('\r').unwrap_or(found);
        let character = place["character"].as_u64().unwrap() as usize;
        assert!(character <= self.columns(found), "{place} in {found:?}");
    }

    /// Whether every range in an answer lies in the text. Places in other files are left out.
    fn check_all(&self, text: &str, value: &Value) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| self.check_all(text, item)),
            Value::Object(map) if map.contains_key("uri") || map.contains_key("targetUri") => {}
            Value::Object(map) => {
                for (key, value) in map {
                    match (key.as_str(), value) {
                        ("start" | "end" | "position", place) if place.get("line").is_some() => self.check(text, place),
                        (_, value) => self.check_all(text, value),
                    }
                }
            }
            _ => {}
        }
    }

    fn finish(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Ok(Value::Null));
        assert!(self.ask("textDocument/hover", json!({})).is_err());
        self.tell("exit", Value::Null);
        assert_eq!(self.server.take().unwrap().join().unwrap(), Some(0));
    }
}

/// Everything that an editor asks at a place, and of the whole text.
const AT: &[&str] = &["completion", "hover", "definition", "signatureHelp", "documentHighlight", "prepareRename"];
const OF: &[&str] =
    &["documentSymbol", "foldingRange", "documentColor", "documentLink", "semanticTokens/full", "formatting"];

/// Asks for everything at an offset; every place in the answers lies in the text.
fn ask_all(editor: &mut Editor, uri: &str, text: &str, offset: usize) {
    let document = json!({ "uri": uri });
    let position = editor.place(text, offset);
    for method in AT {
        let params = json!({ "textDocument": document, "position": position });
        if let Ok(answer) = editor.ask(&format!("textDocument/{method}"), params) {
            editor.check_all(text, &answer);
        }
    }
    let all = json!({ "start": { "line": 0, "character": 0 }, "end": editor.place(text, text.len()) });
    for method in OF {
        let params = json!({ "textDocument": document, "options": { "tabSize": 4, "insertSpaces": true } });
        let answer = editor.ask(&format!("textDocument/{method}"), params).unwrap();
        match *method {
            "semanticTokens/full" => check_tokens(editor, text, &answer),
            _ => editor.check_all(text, &answer),
        }
    }
    for (method, params) in [
        ("inlayHint", json!({ "textDocument": document, "range": all })),
        ("codeAction", json!({ "textDocument": document, "range": all, "context": { "diagnostics": [] } })),
        ("selectionRange", json!({ "textDocument": document, "positions": [position] })),
        (
            "rangeFormatting",
            json!({ "textDocument": document, "range": all, "options": { "tabSize": 4, "insertSpaces": true } }),
        ),
        (
            "onTypeFormatting",
            json!({ "textDocument": document, "position": position, "ch": "}", "options": { "tabSize": 4, "insertSpaces": true } }),
        ),
        (
            "references",
            json!({ "textDocument": document, "position": position, "context": { "includeDeclaration": true } }),
        ),
        ("rename", json!({ "textDocument": document, "position": position, "newName": "another_name" })),
    ] {
        if let Ok(answer) = editor.ask(&format!("textDocument/{method}"), params) {
            editor.check_all(text, &answer);
        }
    }
}

/// Words in their order, each within its line.
fn check_tokens(editor: &Editor, text: &str, answer: &Value) {
    let lines: Vec<&str> = text.split('\n').collect();
    let numbers: Vec<usize> = answer["data"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize).collect();
    let (mut line, mut start, mut end) = (0, 0, 0);
    for token in numbers.chunks_exact(5) {
        (line, start) = if token[0] > 0 { (line + token[0], token[1]) } else { (line, start + token[1]) };
        end = if token[0] > 0 { 0 } else { end };
        assert!(start >= end, "words overlap on line {line} of {text:?}");
        end = start + token[2];
        assert!(end <= editor.columns(lines[line]) && token[2] > 0, "line {line} of {text:?}");
    }
}

fn examples() -> Vec<(PathBuf, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").canonicalize().unwrap();
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "kin")).collect();
    scenes.sort();
    scenes.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

fn uri(path: &Path) -> String {
    super::uri::of(path).unwrap().as_str().to_string()
}

/// Somebody types an example from its first letter to its last. After each letter the editor asks what it asks of a text
/// that is being typed, and now and then for everything.
fn type_example(at: usize) {
    let (path, text) = examples().swap_remove(at);
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().canonicalize().unwrap().join(path.file_name().unwrap());
    let mut editor = Editor::new(folder.path(), at.is_multiple_of(2));
    let uri = uri(&place);
    editor.open(&uri, "");
    for (version, (offset, letter)) in text.char_indices().enumerate() {
        let end = offset + letter.len_utf8();
        let typed = &text[..end];
        let position = editor.place(&text, offset);
        let change = json!({ "range": { "start": position, "end": position }, "text": letter.to_string() });
        let document = json!({ "uri": uri, "version": version + 2 });
        editor.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
        let position = editor.place(typed, end);
        let params = json!({ "textDocument": { "uri": uri }, "position": position });
        let list = editor.ask("textDocument/completion", params.clone()).unwrap();
        editor.check_all(typed, &list);
        let hover = editor.ask("textDocument/hover", params).unwrap();
        editor.check_all(typed, &hover);
        if version % 97 == 0 || end == text.len() {
            ask_all(&mut editor, &uri, typed, end);
        }
    }
    editor.finish();
}

macro_rules! typed {
    ($($name:ident $part:literal),* $(,)?) => { $(
        #[test]
        fn $name() {
            let count = examples().len();
            (0..count).filter(|at| at % 4 == $part).for_each(type_example);
        }
    )* };
}

// In parts, so that they run side by side.
typed!(examples_are_typed_1 0, examples_are_typed_2 1, examples_are_typed_3 2, examples_are_typed_4 3);

/// A project of some files on the disk.
struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    fn new(files: &[(&str, &str)]) -> Files {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Files { folder }
    }

    fn uri(&self, name: &str) -> String {
        uri(&self.folder.path().canonicalize().unwrap().join(name))
    }
}

/// A text with `|` where the cursor is: the text without it, and the offset.
fn cursor(text: &str) -> (String, usize) {
    let at = text.find('|').unwrap();
    (text.replacen('|', "", 1), at)
}

fn at(editor: &Editor, uri: &str, text: &str, offset: usize) -> Value {
    json!({ "textDocument": { "uri": uri }, "position": editor.place(text, offset) })
}

/// Asks at the cursor of a text that is not saved.
fn ask_at(method: &str, text: &str) -> Value {
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), true);
    let (text, offset) = cursor(text);
    let uri = files.uri("scene.kin");
    editor.open(&uri, &text);
    let answer = editor.ask(method, at(&editor, &uri, &text, offset)).unwrap();
    editor.check_all(&text, &answer);
    editor.finish();
    answer
}

fn labels(text: &str) -> Vec<String> {
    let list = ask_at("textDocument/completion", text);
    list.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_string()).collect()
}

#[track_caller]
fn offers(text: &str, wanted: &[&str], unwanted: &[&str]) {
    let found = labels(text);
    for word in wanted {
        assert!(found.iter().any(|label| label == word), "no {word} in {found:?}");
    }
    for word in unwanted {
        assert!(!found.iter().any(|label| label == word), "{word} in {found:?}");
    }
}

#[test]
fn suggestions() {
    offers(
        "lang 1\nsphere ball { radius: 1m, ma| }",
        &["material", "position", "rigid_body", "let"],
        &["radius", "sphere", "fov"],
    );
    offers("lang 1\n|", &["sphere", "camera", "render", "prefab", "import"], &["rigid_body", "radius"]);
    offers("lang 1\nrender { view: | }", &["bvh", "normal"], &["sphere", "time"]);
    offers("lang 1\nmetal gold { }\nsphere ball { material: | }", &["gold", "diffuse", "mix"], &["time", "sin"]);
    offers("lang 1\ncamera main { fov: 4| }", &["deg", "rad"], &["m", "s"]);
    offers(
        "lang 1\nsphere ball { position: keys { 0s: (0, 0, 0) 1s: (1, 0, 0) ease | } }",
        &["in_out_cubic", "linear"],
        &["time"],
    );
    offers(
        "lang 1\nsphere ball { position: keys(interpolate: |) { 0s: (0, 0, 0) } }",
        &["spline", "hermite"],
        &["time"],
    );
    offers(
        "lang 1\nimport \"std/metals\" as metals\nsphere ball { material: metals.| }",
        &["gold", "copper"],
        &["diffuse"],
    );
    offers("lang 1\nimport { | } from \"std/glass\"", &["water", "diamond"], &["gold"]);
    offers("lang 1\nimport \"std/|\"", &["metals", "studio"], &[]);
    offers(
        "lang 1\nprefab tower(height: length, steps = 3) { box { } }\ntower { steps: 2, | }",
        &["height"],
        &["steps", "radius"],
    );
    offers("lang 1\nfn f(width, depth) = w|", &["width", "depth", "sin"], &["f_of"]);
    offers("lang 1\nparam size: | = 1m", &["length", "color"], &["sphere"]);
    offers("lang 1\ncamera near { }\nrender { camera: | }", &["near"], &["sin"]);
    offers("lang 1\nlet a = clamp(1, |)", &["low", "high", "time"], &[]);
    offers("lang 1\nfor i in 0..3 { sphere { radius: | } }", &["i", "time", "keys"], &[]);
    // What goes on with what is written.
    offers("lang 1\nsphere b { position: keys { 0s: (0, 0, 0) 1s: (1, 0, 0) | } }", &["ease", "after"], &[]);
    offers("lang 1\nlet a = keys { 0s: 1 1s: 2 ease in| }", &["in_out_cubic", "ease_in"], &["after"]);
    offers("lang 1\nsphere ball |", &["like"], &["box"]);
    offers("lang 1\nimport \"std/metals\" |", &["as"], &["sphere"]);
    offers("lang 1\nimport { gold } |", &["from"], &["sphere"]);
    offers("lang 1\nparam size = 1 |", &["in"], &[]);
    offers("lang 1\nif true { } |", &["else"], &[]);
    // Names are what they are where they are declared.
    let imported = "lang 1\nimport \"std/studio\" as studio\nimport { gold as aurum } from \"std/metals\"\nimport { studio_light as room } from \"std/studio\"\n";
    offers(&format!("{imported}sphere b {{ material: | }}"), &["aurum", "studio"], &["gold", "room"]);
    offers("lang 1\nsphere a { }\nsphere b like |", &["a"], &["b"]);
    offers("lang 1\ngroup a { sphere b { parent: | } }\nbox c { }", &["c"], &["a", "b"]);
    offers("lang 1\ncamera near { look_at: | }\nbox c { }", &["c"], &["near"]);
    for nothing in ["lang 1\nimport { gold as | } from \"std/metals\"", "lang 1\nimport |"] {
        assert_eq!(labels(nothing), Vec::<String>::new(), "{nothing}");
    }
    for nothing in
        ["lang 1\n// a |comment", "lang 1\nlet a = \"te|xt\"", "lang 1\nsphere b { material: diffuse { color: #f| } }"]
    {
        assert_eq!(labels(nothing), Vec::<String>::new(), "{nothing}");
    }
}

#[test]
fn suggestions_are_snippets_with_units_and_say_more_when_asked() {
    let list = ask_at("textDocument/completion", "lang 1\nsphere ball { rad| }");
    let radius = list.as_array().unwrap().iter().find(|item| item["label"] == "radius").unwrap().clone();
    assert_eq!(radius["textEdit"]["newText"], "radius: ${1:1m}");
    assert_eq!(
        radius["textEdit"]["range"],
        json!({ "start": { "line": 1, "character": 14 }, "end": { "line": 1, "character": 17 } })
    );
    assert_eq!(radius["detail"], "length = 1m");
    let mut editor = Editor::new(Path::new("/"), false);
    let full = editor.ask("completionItem/resolve", radius).unwrap();
    assert!(full["documentation"]["value"].as_str().unwrap().contains("**sphere.radius**"), "{full}");
    editor.finish();
}

#[test]
fn suggestions_from_another_file() {
    let lib = "lang 1\nprefab tower(height: length, steps = 3) { box { size: (1m, height, 1m) } }\nmetal gold { }\nlet _private = 1\nfn twice(x: length, times = 2) -> length = x * times\nsphere ball { }\ncamera near { }\nimport { water } from \"std/glass\"\n";
    let files = Files::new(&[("kinora.toml", ""), ("lib.kin", lib)]);
    let mut editor = Editor::new(files.folder.path(), false);
    let uri = files.uri("scene.kin");
    editor.open(&uri, "");
    let head =
        "lang 1\nimport \"lib.kin\" as lib\nimport { tower as spire, twice as double, ball, near } from \"lib.kin\"\n";
    let cases: &[(&str, &[&str], &[&str])] = &[
        ("|", &["spire { height: $1 }", "lib"], &["double"]),
        ("lib.|", &["tower { height: $1 }"], &["gold", "sphere", "_private", "water"]),
        ("lib.to|", &["tower { height: $1 }"], &["box"]),
        ("lib.tower { | }", &["height: $1", "steps: ${1:3}"], &["radius"]),
        ("spire { steps: 2, | }", &["height: $1"], &["steps: ${1:3}"]),
        ("let a = lib.|", &["twice(${1:x})", "ball"], &["tower", "_private"]),
        ("let a = dou|", &["double(${1:x})"], &["twice(${1:x})"]),
        ("let a = double(|)", &["times: ", "x: "], &[]),
        ("let a = lib.twice(x: 1m, |)", &["times: "], &["x: "]),
        ("sphere b { material: lib.| }", &["gold"], &["ball", "near", "tower"]),
        ("render { camera: | }", &["near", "lib"], &["ball"]),
        ("render { camera: lib.| }", &["near"], &["ball", "gold"]),
        ("sphere b like |", &["ball"], &["near", "b"]),
        ("import { | } from \"lib.kin\"", &["tower", "gold"], &["_private", "water"]),
    ];
    for (version, (case, wanted, unwanted)) in cases.iter().enumerate() {
        let (text, offset) = cursor(&format!("{head}{case}"));
        editor.change(&uri, version + 2, &text);
        let list = editor.ask("textDocument/completion", at(&editor, &uri, &text, offset)).unwrap();
        let found: Vec<&str> =
            list.as_array().unwrap().iter().map(|item| item["textEdit"]["newText"].as_str().unwrap()).collect();
        for word in *wanted {
            assert!(found.contains(word), "no {word} in {found:?} of {case}");
        }
        for word in *unwanted {
            assert!(
                !found.iter().any(|text| text.split([' ', '(']).next() == word.split([' ', '(']).next())
                    || word.contains(": "),
                "{word} in {found:?} of {case}"
            );
        }
    }
    editor.finish();
}

/// What a suggestion makes of a text with the cursor in it.
#[track_caller]
fn taken(text: &str, label: &str, expected: &str) {
    let list = ask_at("textDocument/completion", text);
    let item = list.as_array().unwrap().iter().find(|item| item["label"] == label);
    let item = item.unwrap_or_else(|| panic!("no {label} in {text:?}"));
    let (text, _) = cursor(text);
    let start = text.rfind('\n').unwrap() + 1;
    let at = |place: &Value| start + place["character"].as_u64().unwrap() as usize;
    let range = &item["textEdit"]["range"];
    let mut result = text.clone();
    result.replace_range(at(&range["start"])..at(&range["end"]), item["textEdit"]["newText"].as_str().unwrap());
    assert_eq!(&result[start..], expected);
}

#[test]
fn suggestions_take_the_place_of_the_word_they_complete() {
    taken("lang 1\nsphere b { radius: 5| }", "cm", "sphere b { radius: 5cm }");
    taken("lang 1\nsphere b { radius: 5c| }", "cm", "sphere b { radius: 5cm }");
    taken("lang 1\nsphere b { radius: 5c|m }", "mm", "sphere b { radius: 5mm }");
    taken("lang 1\nsphere b { ra|dus: 1m }", "radius", "sphere b { radius: 1m }");
    taken("lang 1\nlet ü = 1\nlet b = |ü + 1", "time", "let b = timeü + 1");
    taken("lang 1\nlet b = si|m(1)", "sin", "let b = sin(${1:angle})(1)");
    taken("lang 1\nimport \"std/m|ets\"", "metals", "import \"std/metals\"");
    taken("lang 1\nimport \"std/m|", "metals", "import \"std/metals");
}

#[track_caller]
fn hovers(text: &str, wanted: &[&str]) {
    let answer = ask_at("textDocument/hover", text);
    let found = answer["contents"]["value"].as_str().unwrap_or_default();
    for part in wanted {
        assert!(found.contains(part), "no {part:?} in {found:?} of {text:?}");
    }
}

#[test]
fn what_stands_here() {
    hovers(
        "lang 1\nsphere ball { rad|ius: 2 * 25cm }",
        &["**sphere.radius**", "length", "`1m`", "above 0", "time", "= `0.5m` · a length"],
    );
    hovers("lang 1\nsph|ere ball { }", &["**sphere**", "a shape"]);
    hovers(
        "lang 1\n/// How wide.\nlet width = 2m / 4\nbox b { size: (wid|th, 1, 1) }",
        &["let width = 2m / 4", "How wide.", "= `0.5m`"],
    );
    hovers(
        "lang 1\nrender { duration: 2s }\ncamera main { }\nsky { color: #fff }\nlet up = 3m * (time / 1s)\nsphere b { position: (0, u|p, 0) }",
        &["`0m` at 0s", "`6m` at 2s"],
    );
    // What is pointed at, not what it is part of.
    hovers("lang 1\nlet size = 2m\nfn half(x) = x| / 2\nsphere b { radius: half(size) }", &["`2m` · a length"]);
    hovers("lang 1\nlet a = 2m * sin|(90deg) + 3m", &["`1` · a number"]);
    hovers(
        "lang 1\nprefab lamp(r: length) { sphere { radius: r| * 2 } }\nlamp { r: 1m }\nlamp { r: 3m }",
        &["`1m` the first time, then others"],
    );
    hovers("lang 1\nlet n|  = 3", &["let n = 3", "`3` · a number"]);
    hovers("lang 1\nsphere b { rad|ius: 50cm }", &["sphere.radius", "`0.5m` · a length"]);
    hovers("lang 1\nparam size: length = 0.5m in 0.1m..2m\nlet a = si|ze * 2", &["in 0.1m..2m", "`0.5m` · a length"]);
    hovers("lang 1\nsphere b { radius: 2m }\nlet a = b.rad|ius * 2", &["**sphere.radius**", "`2m` · a length"]);
    hovers("lang 1\nlet v = (1m, 2m, 3m)\nlet a = v.|y", &["**y** of `v`", "`2m` · a length"]);
    hovers("lang 1\nimport \"std/metals\" as met|als", &["import \"std/metals\" as metals"]);
    hovers("lang 1\nimport \"std/metals\" as metals\nsphere b { material: met|als.gold }", &["as metals"]);
    hovers("lang 1\nfn half(x) = x / 2\nlet a = ha|lf(3)", &["fn half(x) = x / 2", "`1.5`"]);
    hovers("lang 1\nlet a = cla|mp(5, 0, 1)", &["clamp(x, low, high)", "= `1`"]);
    hovers("lang 1\nlet a = 9|0deg", &["an angle", "90deg"]);
    hovers("lang 1\nlet a = 5|0cm", &["a length", "0.5m"]);
    hovers(
        "lang 1\nsphere b { material: diffuse { color: #ff|8000 } }",
        &["255, 128, 0 of 255", "linear(1.0000, 0.2159, 0.0000)"],
    );
    hovers("lang 1\nrender { view: b|vh }", &["**render.view**", "bvh"]);
    hovers("lang 1\nfor i in 0..3 { sphere { radius: (i| + 1) * 1m } }", &["for i in 0..3"]);
    hovers("lang 1\nsphere b { radius: ti|me * 1m/s }", &["seconds since"]);
    hovers("lang 1\nimport { gold } from \"std/metals\"\nsphere b { material: go|ld }", &["gold", "in `std/metals`"]);
}

#[test]
fn names_lead_to_their_declarations() {
    let files = Files::new(&[
        ("kinora.toml", ""),
        (
            "lib/shapes.kin",
            "lang 1\n/// A tower.\nprefab tower(height: length = 2m) { box { size: (1m, height, 1m) } }\nmetal gold { }\n",
        ),
        (
            "scenes/other.kin",
            "lang 1\nimport \"../lib/shapes.kin\" as shapes\ncamera main { }\nsky { }\nshapes.tower { height: 1m }\n",
        ),
    ]);
    let text = "lang 1\nimport { tower, gold as aurum } from \"../lib/shapes.kin\"\ncamera main { }\nsky { }\ntower { height: 3m }\nsphere ball { material: aurum }\n";
    let (scene, lib, other) = (files.uri("scenes/a.kin"), files.uri("lib/shapes.kin"), files.uri("scenes/other.kin"));
    for utf8 in [false, true] {
        let mut editor = Editor::new(files.folder.path(), utf8);
        editor.open(&scene, text);
        let mut leads = |word: &str, nth: usize, to: &str, line: u64, character: u64| {
            let offset = text.match_indices(word).nth(nth).unwrap().0 + 1;
            let params = at(&editor, &scene, text, offset);
            let found = editor.ask("textDocument/definition", params).unwrap();
            assert_eq!(found["uri"], *to, "{word}");
            assert_eq!(found["range"]["start"], json!({ "line": line, "character": character }), "{word}");
        };
        leads("tower", 1, &lib, 2, 7);
        leads("tower", 0, &lib, 2, 7);
        leads("height", 0, &lib, 2, 13);
        leads("aurum", 1, &lib, 3, 6);
        leads("../lib", 0, &lib, 0, 0);
        // From the file that declares it, all files of the project, open or not.
        let mut params = at(&editor, &scene, text, text.rfind("tower").unwrap() + 2);
        params["context"] = json!({ "includeDeclaration": false });
        let found = editor.ask("textDocument/references", params).unwrap();
        let found: Vec<String> = found
            .as_array()
            .unwrap()
            .iter()
            .map(|place| {
                let uri = place["uri"].as_str().unwrap();
                format!(
                    "{}:{}:{}",
                    uri.rsplit('/').next().unwrap(),
                    place["range"]["start"]["line"],
                    place["range"]["start"]["character"]
                )
            })
            .collect();
        assert_eq!(found, ["a.kin:1:9", "a.kin:4:0", "other.kin:4:7"]);
        let symbols = editor.ask("workspace/symbol", json!({ "query": "twr" })).unwrap();
        assert_eq!(symbols[0]["name"], "tower");
        assert_eq!(symbols[0]["location"]["uri"], *lib);
        let _ = &other;
        editor.finish();
    }
}

/// A workspace edit carried out on these texts.
fn carried_out(editor: &Editor, edit: &Value, texts: &mut [(String, String)]) {
    for change in edit["documentChanges"].as_array().unwrap() {
        let uri = change["textDocument"]["uri"].as_str().unwrap();
        let (_, text) = texts.iter_mut().find(|(own, _)| own == uri).unwrap();
        *text = edited(editor, text, &change["edits"]);
    }
}

/// Edits carried out on a text, as an editor does it.
fn edited(editor: &Editor, text: &str, edits: &Value) -> String {
    let offset = |place: &Value| {
        let line = place["line"].as_u64().unwrap() as usize;
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        let mut left = place["character"].as_u64().unwrap() as usize;
        let mut at = start;
        for letter in text[start..].chars() {
            if left == 0 {
                break;
            }
            left -= if editor.utf8 { letter.len_utf8() } else { letter.len_utf16() };
            at += letter.len_utf8();
        }
        at
    };
    let mut spans: Vec<(usize, usize, &str)> = edits
        .as_array()
        .unwrap()
        .iter()
        .map(|edit| {
            let range = &edit["range"];
            (offset(&range["start"]), offset(&range["end"]), edit["newText"].as_str().unwrap())
        })
        .collect();
    spans.sort();
    let mut result = text.to_string();
    for (start, end, new) in spans.into_iter().rev() {
        result.replace_range(start..end, new);
    }
    result
}

#[test]
fn renamed_across_files() {
    let lib = "lang 1\n/// 😀 A tower.\nprefab tower(height: length = 2m) { box { size: (1m, height, 1m) } }\nmetal gold { }\n";
    let other = "lang 1\nimport \"shapes.kin\" as shapes\ncamera main { }\nsky { }\nshapes.tower { height: 1m }\nbox tower { }\n";
    let text = "lang 1\nimport { tower, gold as aurum } from \"shapes.kin\"\ncamera main { }\nsky { }\n/* 😀 */ tower { height: 3m }\nsphere ball { material: aurum }\nsphere spire { }\n";
    let files = Files::new(&[("kinora.toml", ""), ("shapes.kin", lib), ("other.kin", other), ("a.kin", text)]);
    for utf8 in [false, true] {
        let mut editor = Editor::new(files.folder.path(), utf8);
        let scene = files.uri("a.kin");
        editor.open(&scene, text);
        let mut rename = |word: &str, new: &str| {
            let offset = text.rfind(word).unwrap() + 1;
            let mut params = at(&editor, &scene, text, offset);
            let prepared = editor.ask("textDocument/prepareRename", params.clone()).unwrap();
            assert_eq!(prepared["placeholder"], *word);
            params["newName"] = json!(new);
            let edit = editor.ask("textDocument/rename", params)?;
            let mut texts: Vec<(String, String)> = [("a.kin", text), ("other.kin", other), ("shapes.kin", lib)]
                .map(|(name, text)| (files.uri(name), text.to_string()))
                .into();
            carried_out(&editor, &edit, &mut texts);
            Ok::<_, String>(texts.map_texts())
        };
        let [scene_now, other_now, lib_now] = rename("tower", "minaret").unwrap();
        assert!(
            scene_now.contains("import { minaret, gold") && scene_now.contains("minaret { height: 3m }"),
            "{scene_now}"
        );
        assert!(other_now.contains("shapes.minaret { height") && other_now.contains("box tower { }"), "{other_now}");
        assert!(lib_now.contains("prefab minaret(height"), "{lib_now}");
        let [scene_now, other_now, lib_now] = rename("height", "tall").unwrap();
        assert!(scene_now.contains("tower { tall: 3m }") && other_now.contains("tower { tall: 1m }"));
        assert!(lib_now.contains("tower(tall: length = 2m) { box { size: (1m, tall, 1m) } }"), "{lib_now}");
        // A name that an import gives is changed where it is given.
        let [scene_now, other_now, lib_now] = rename("aurum", "or").unwrap();
        assert!(scene_now.contains("gold as or }") && scene_now.contains("material: or }"), "{scene_now}");
        assert_eq!((other_now.as_str(), lib_now.as_str()), (other, lib));
        for (word, new) in
            [("tower", "sphere"), ("tower", "1st"), ("tower", "let"), ("ball", "spire"), ("tower", "gold")]
        {
            assert!(rename(word, new).is_err(), "{word} to {new}");
        }
        let kind = at(&editor, &scene, text, text.find("sphere").unwrap() + 1);
        assert!(editor.ask("textDocument/prepareRename", kind).is_err());
        editor.finish();
    }
}

trait MapTexts {
    fn map_texts(self) -> [String; 3];
}

impl MapTexts for Vec<(String, String)> {
    fn map_texts(self) -> [String; 3] {
        let texts: Vec<String> = self.into_iter().map(|(_, text)| text).collect();
        texts.try_into().unwrap()
    }
}

#[test]
fn files_that_move_are_found_again() {
    let text =
        "lang 1\nimport \"../lib/shapes.kin\" as s\nmesh m { file: \"/meshes/a.obj\" }\nmesh n { file: \"b.obj\" }\n";
    let files = Files::new(&[
        ("kinora.toml", ""),
        ("lib/shapes.kin", "lang 1\nmetal gold { }\n"),
        ("scenes/a.kin", text),
        ("scenes/b.obj", ""),
    ]);
    let mut editor = Editor::new(files.folder.path(), false);
    let scene = files.uri("scenes/a.kin");
    let mut moved = |from: &str, to: &str| {
        let renamed = json!({ "oldUri": files.uri(from), "newUri": files.uri(to) });
        let edit = editor.ask("workspace/willRenameFiles", json!({ "files": [renamed] })).unwrap();
        let mut texts = vec![(scene.clone(), text.to_string())];
        carried_out(&editor, &edit, &mut texts);
        texts.remove(0).1
    };
    assert!(moved("lib/shapes.kin", "lib/forms.kin").contains("\"../lib/forms.kin\""));
    assert!(moved("lib", "parts").contains("\"../parts/shapes.kin\""));
    assert!(moved("meshes", "models").contains("\"/models/a.obj\""));
    let now = moved("scenes/a.kin", "a.kin");
    assert!(
        now.contains("import \"lib/shapes.kin\"")
            && now.contains("\"/meshes/a.obj\"")
            && now.contains("\"scenes/b.obj\""),
        "{now}"
    );
    assert_eq!(moved("scenes", "films"), text);
    editor.finish();
}

#[test]
fn findings_come_and_go_with_the_text() {
    let files = Files::new(&[("kinora.toml", ""), ("lib.kin", "lang 1\nmetal gold { }\n")]);
    let mut editor = Editor::new(files.folder.path(), false);
    let uri = files.uri("scene.kin");
    let scene = |more: &str| {
        format!(
            "lang 1\nimport {{ gold }} from \"lib.kin\"\ncamera main {{ position: (0, 0, 4) }}\nsky {{ color: #fff }}\n{more}"
        )
    };
    let text = scene("/* 😀 */ sphere ball { raduis: 1, material: gold }\n");
    editor.open(&uri, &text);
    let found = editor.findings(&uri, 1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (&found[0]["code"], &found[0]["severity"], &found[0]["source"]),
        (&json!("E0201"), &json!(1), &json!("kinora"))
    );
    let start = editor.place(&text, text.find("raduis").unwrap());
    assert_eq!(found[0]["range"]["start"], start);
    assert!(found[0]["message"].as_str().unwrap().contains("unknown property `raduis`"));
    assert!(found[0]["codeDescription"]["href"].as_str().unwrap().contains("E0201"));
    // The fix that belongs to it.
    let range = found[0]["range"].clone();
    let params = json!({ "textDocument": { "uri": uri }, "range": range, "context": { "diagnostics": found } });
    let actions = editor.ask("textDocument/codeAction", params).unwrap();
    assert_eq!((&actions[0]["kind"], &actions[0]["isPreferred"]), (&json!("quickfix"), &json!(true)));
    let mut texts = vec![(uri.clone(), text.clone())];
    carried_out(&editor, &actions[0]["edit"], &mut texts);
    assert_eq!(texts[0].1, text.replace("raduis", "radius"));
    assert_eq!(actions[0]["edit"]["documentChanges"][0]["textDocument"]["version"], 1);
    let params = json!({ "textDocument": { "uri": uri }, "range": range, "context": { "diagnostics": [], "only": ["source.fixAll"] } });
    let all = editor.ask("textDocument/codeAction", params).unwrap();
    assert_eq!(all.as_array().unwrap().len(), 1);
    editor.change(&uri, 2, &texts[0].1);
    assert_eq!(editor.findings(&uri, 2), Vec::<Value>::new());
    // What is open counts, saved or not: the import loses its name.
    let lib = files.uri("lib.kin");
    editor.said.clear();
    editor.open(&lib, "lang 1\nmetal silver { }\n");
    let found = editor.findings(&uri, 2);
    assert_eq!(found[0]["code"], "E0706");
    editor.said.clear();
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": lib } }));
    assert_eq!(editor.findings(&uri, 2), Vec::<Value>::new());
    // A warning can be allowed.
    let text = scene("let unused = 3\nsphere ball { material: gold }\n");
    editor.change(&uri, 3, &text);
    let found = editor.findings(&uri, 3);
    assert_eq!(
        (&found[0]["code"], &found[0]["severity"], &found[0]["tags"]),
        (&json!("W0201"), &json!(2), &json!([1]))
    );
    let params =
        json!({ "textDocument": { "uri": uri }, "range": found[0]["range"], "context": { "diagnostics": [] } });
    let actions = editor.ask("textDocument/codeAction", params).unwrap();
    let allow =
        actions.as_array().unwrap().iter().find(|action| action["title"] == "allow W0201 here").unwrap().clone();
    let mut texts = vec![(uri.clone(), text)];
    carried_out(&editor, &allow["edit"], &mut texts);
    editor.change(&uri, 4, &texts[0].1);
    assert_eq!(editor.findings(&uri, 4), Vec::<Value>::new());
    // Closed, nothing is wrong with it any more.
    editor.said.clear();
    editor.change(&uri, 5, "lang 1\nsphere {");
    assert_ne!(editor.findings(&uri, 5), Vec::<Value>::new());
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": uri } }));
    let _ = editor.ask("workspace/symbol", json!({ "query": "" })).unwrap();
    let last = editor.said.iter().rev().find(|message| message.params["uri"] == *uri).unwrap();
    assert_eq!(last.params["diagnostics"], json!([]));
    editor.finish();
}

#[test]
fn parts_of_the_program_keep_their_names() {
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), false);
    let (uri, text) = (files.uri("scene.kin"), "lang 1\nimport { gold } from \"std/metals\"\n");
    editor.open(&uri, text);
    let params = at(&editor, &uri, text, text.find("gold").unwrap());
    assert!(editor.ask("textDocument/prepareRename", params.clone()).is_err());
    let place = editor.ask("textDocument/definition", params).unwrap();
    let there = place["uri"].as_str().unwrap();
    let path = super::uri::path(&there.parse().unwrap()).unwrap();
    editor.open(there, &std::fs::read_to_string(path).unwrap());
    let params = json!({ "textDocument": { "uri": there }, "position": place["range"]["start"], "newName": "aurum" });
    assert!(editor.ask("textDocument/prepareRename", params.clone()).is_err());
    assert!(editor.ask("textDocument/rename", params).is_err());
    editor.finish();
}

#[test]
#[cfg(unix)]
fn a_file_behind_a_link_has_one_name() {
    let files = Files::new(&[("kinora.toml", ""), ("real/lib.kin", "lang 1\nmetal gold { }\n")]);
    let root = files.folder.path().canonicalize().unwrap();
    std::os::unix::fs::symlink(root.join("real"), root.join("link")).unwrap();
    let mut editor = Editor::new(files.folder.path(), false);
    let scene = files.uri("scene.kin");
    let (link, real) = (files.uri("link/lib.kin"), files.uri("real/lib.kin"));
    editor.open(&link, "lang 1\nmetal gold { colour: #fff }\n");
    editor.open(&scene, "lang 1\nimport { gold } from \"real/lib.kin\"\ncamera c { }\nsky { color: #fff }\nsphere b { material: gold }\n");
    editor.findings(&scene, 1);
    assert_eq!(editor.findings(&link, 1)[0]["code"], "E0201");
    editor.change(&link, 2, "lang 1\nmetal silver { }\n");
    let end = Instant::now() + Duration::from_secs(60);
    let is_it = |message: &&Notification| message.params["uri"] == *scene;
    while editor.said.iter().rev().find(is_it).unwrap().params["diagnostics"][0]["code"] != "E0706" {
        assert!(Instant::now() < end);
        let _ = editor.ask("workspace/symbol", json!({ "query": "" }));
    }
    assert!(editor.said.iter().all(|message| message.params["uri"] != *real));
    editor.finish();
}

/// What is looked at is judged first, and what does not read it not at all.
#[test]
fn many_texts_are_open() {
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), false);
    let uris: Vec<String> = (0..40).map(|at| files.uri(&format!("{at:02}.kin"))).collect();
    uris.iter().for_each(|uri| editor.open(uri, "lang 1\ncamera c { }\nsky { color: #fff }\n"));
    for uri in &uris {
        editor.findings(uri, 1);
    }
    editor.said.clear();
    editor.change(&uris[39], 2, "lang 1\ncamera c { }\nsky { colour: #fff }\n");
    assert_eq!(editor.findings(&uris[39], 2)[0]["code"], "E0201");
    std::thread::sleep(Duration::from_millis(300));
    let _ = editor.ask("workspace/symbol", json!({ "query": "" }));
    assert_eq!(editor.said.len(), 1, "{:?}", editor.said);
    editor.finish();
}

#[test]
fn findings_in_an_imported_file_are_said_there() {
    let files = Files::new(&[("kinora.toml", ""), ("lib.kin", "lang 1\nmetal gold { colour: #fff }\n")]);
    let mut editor = Editor::new(files.folder.path(), false);
    let uri = files.uri("scene.kin");
    editor.open(
        &uri,
        "lang 1\nimport { gold } from \"lib.kin\"\ncamera main { }\nsky { }\nsphere b { material: gold }\n",
    );
    editor.findings(&uri, 1);
    let lib = files.uri("lib.kin");
    let is_it = |message: &&Notification| message.params["uri"] == *lib;
    let of_lib = loop {
        match editor.said.iter().rev().find(is_it) {
            Some(found) => break found.params.clone(),
            None => {
                let _ = editor.ask("workspace/symbol", json!({ "query": "" }));
            }
        }
    };
    assert_eq!(of_lib["diagnostics"][0]["code"], "E0201");
    editor.finish();
}

#[test]
fn findings_can_be_asked_for() {
    let files = Files::new(&[("kinora.toml", "")]);
    let more = json!({ "textDocument": { "diagnostic": {} } });
    let mut editor = Editor::with(files.folder.path(), false, more);
    assert!(editor.greeting["capabilities"]["diagnosticProvider"].is_object());
    let uri = files.uri("scene.kin");
    editor.open(&uri, "lang 1\nsphere b { raduis: 1 }\ncamera c { }\nsky { }\n");
    let report = editor.ask("textDocument/diagnostic", json!({ "textDocument": { "uri": uri } })).unwrap();
    assert_eq!((&report["kind"], &report["items"][0]["code"]), (&json!("full"), &json!("E0201")));
    // Who asks is not told as well.
    std::thread::sleep(Duration::from_millis(200));
    let _ = editor.ask("workspace/symbol", json!({ "query": "" })).unwrap();
    assert!(editor.said.iter().all(|message| message.params["diagnostics"] == json!([])), "{:?}", editor.said);
    editor.finish();
}

#[test]
fn laid_out_as_fmt_does() {
    let text =
        "lang 1\nsphere  ball{radius :50cm ;\n  material: diffuse{color:#FFF}}\n// 😀 stays\nlet  a=1\nlet b = 2\n";
    let files = Files::new(&[("kinora.toml", "")]);
    for utf8 in [false, true] {
        let mut editor = Editor::new(files.folder.path(), utf8);
        let uri = files.uri("scene.kin");
        editor.open(&uri, text);
        let options = json!({ "tabSize": 4, "insertSpaces": true });
        let edits = editor
            .ask("textDocument/formatting", json!({ "textDocument": { "uri": uri }, "options": options }))
            .unwrap();
        let tree = kinora_lang::parse(&kinora_lang::source::Source::new(Default::default(), "scene.kin", text));
        let expected = kinora_lang::format::format(&tree).unwrap();
        assert_eq!(edited(&editor, text, &edits), expected);
        // Lines that stay are not touched.
        let last = edits.as_array().unwrap().last().unwrap();
        assert_eq!(last["range"]["end"], json!({ "line": 5, "character": 0 }));
        // One line alone.
        let range = json!({ "start": { "line": 4, "character": 0 }, "end": { "line": 4, "character": 3 } });
        let params = json!({ "textDocument": { "uri": uri }, "range": range, "options": options });
        let edits = editor.ask("textDocument/rangeFormatting", params).unwrap();
        assert_eq!(edited(&editor, text, &edits), text.replace("let  a=1", "let a = 1"));
        // A text with mistakes stays; a brace that was just typed finds its column.
        let broken = "lang 1\ngroup g {\n    sphere b {\n        radius: 1m\n        }\n";
        editor.change(&uri, 2, broken);
        let edits = editor
            .ask("textDocument/formatting", json!({ "textDocument": { "uri": uri }, "options": options }))
            .unwrap();
        assert_eq!(edits, json!([]));
        let mut params = at(&editor, &uri, broken, broken.rfind('}').unwrap() + 1);
        params["ch"] = json!("}");
        params["options"] = options;
        let edits = editor.ask("textDocument/onTypeFormatting", params).unwrap();
        assert_eq!(edited(&editor, broken, &edits), broken.replace("        }", "    }"));
        editor.finish();
    }
}

#[test]
fn lines_beside_those_that_are_laid_out_stay() {
    let files = Files::new(&[("kinora.toml", "")]);
    for (path, text) in examples() {
        let mut editor = Editor::new(files.folder.path(), true);
        let uri = files.uri("scene.kin");
        let messy: String = text
            .split_inclusive('\n')
            .enumerate()
            .map(|(i, line)| match i % 5 {
                0 => format!("   {line}"),
                1 => format!("{}\n\n\n", line.trim_end()),
                2 => format!("\t{}   \n", line.trim()),
                _ => line.to_string(),
            })
            .collect();
        editor.open(&uri, &messy);
        let options = json!({ "tabSize": 4, "insertSpaces": true });
        let document = json!({ "uri": uri });
        let tree =
            |text: &str| kinora_lang::parse(&kinora_lang::source::Source::new(Default::default(), "a.kin", text));
        let expected = kinora_lang::format::format(&tree(&messy)).unwrap();
        let edits =
            editor.ask("textDocument/formatting", json!({ "textDocument": document, "options": options })).unwrap();
        assert_eq!(edited(&editor, &messy, &edits), expected, "{}", path.display());
        let lines: Vec<&str> = messy.split('\n').collect();
        for first in (0..lines.len()).step_by(7) {
            let last = (first + 4).min(lines.len() - 1);
            let range = json!({ "start": { "line": first, "character": 0 }, "end": { "line": last, "character": 1 } });
            let params = json!({ "textDocument": document, "range": range, "options": options });
            let edits = editor.ask("textDocument/rangeFormatting", params).unwrap();
            for edit in edits.as_array().unwrap() {
                let (start, end) = (&edit["range"]["start"], &edit["range"]["end"]);
                let ends = end["line"].as_u64().unwrap() as usize;
                assert!(start["line"].as_u64().unwrap() as usize >= first, "{edit}");
                assert!(ends <= last || ends == last + 1 && end["character"] == 0, "{edit}");
            }
            let part = edited(&editor, &messy, &edits);
            assert_eq!(kinora_lang::format::format(&tree(&part)).unwrap(), expected, "{} {first}", path.display());
        }
        editor.finish();
    }
}

#[test]
fn texts_whose_folder_is_not_there() {
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), true);
    let (scene, lib) = ("file:///no/such/folder/a.kin", "file:///no/such/folder/lib.kin");
    let text = "lang 1\nimport { gold } from \"lib.kin\"\ncamera c { look_at: b }\nsky { color: #fff }\nsphere b { material: gold }\n";
    editor.open(lib, "lang 1\nmetal gold { }\n");
    editor.open(scene, text);
    assert_eq!(editor.findings(scene, 1), Vec::<Value>::new());
    let params = at(&editor, scene, text, text.rfind("gold").unwrap() + 1);
    let found = editor.ask("textDocument/definition", params.clone()).unwrap();
    assert_eq!((&found["uri"], &found["range"]["start"]["line"]), (&json!(lib), &json!(1)));
    let mut params = params;
    params["newName"] = json!("silver");
    let edit = editor.ask("textDocument/rename", params).unwrap();
    assert_eq!(edit["documentChanges"].as_array().unwrap().len(), 2, "{edit}");
    editor.finish();
}

#[test]
fn editors_that_say_things_in_another_way() {
    let files = Files::new(&[("kinora.toml", ""), ("a b/lib.kin", "lang 1\nmetal gold { }\n")]);
    let root = files.folder.path().canonicalize().unwrap();
    let (server, connection) = Connection::memory();
    let server = std::thread::spawn(move || super::server::serve(&server));
    let mut editor =
        Editor { connection, server: Some(server), next: 0, said: Vec::new(), utf8: false, greeting: Value::Null };
    // Before everything else, and what is no greeting.
    assert!(editor.ask("textDocument/hover", json!({})).is_err());
    editor.tell("textDocument/didOpen", json!({}));
    assert!(editor.ask("initialize", json!([])).is_err());
    // An address as no address is written, and no `initialized`.
    let folder = format!("file://{}/a b", root.display());
    editor.greeting =
        editor.ask("initialize", json!({ "processId": null, "rootUri": folder, "capabilities": {} })).unwrap();
    assert!(editor.ask("initialize", json!({ "capabilities": {} })).is_err());
    let text = "lang 1\nimport { gold } from \"lib.kin\"\nsphere b { material: gold }\n";
    let uri = format!("{folder}/scene ü.kin");
    editor.open(&uri, text);
    let params = at(&editor, &uri, text, text.rfind("gold").unwrap() + 1);
    let found = editor.ask("textDocument/definition", params).unwrap();
    assert!(found["uri"].as_str().unwrap().ends_with("/a%20b/lib.kin"), "{found}");
    editor.finish();
}

#[test]
fn calls_say_what_they_take() {
    let help = ask_at("textDocument/signatureHelp", "lang 1\nlet a = clamp(1, m|)");
    assert_eq!(help["signatures"][0]["label"], "clamp(x: number, low: number, high: number) -> the same");
    assert_eq!(help["signatures"][0]["activeParameter"], 1);
    let help = ask_at(
        "textDocument/signatureHelp",
        "lang 1\n/// Twice.\nfn twice(x: length, times = 2) -> length = x * times\nlet a = twice(times: 3|)",
    );
    assert_eq!(help["signatures"][0]["label"], "twice(x: length, times = 2) -> length");
    assert_eq!(help["signatures"][0]["activeParameter"], 1);
    let help = ask_at("textDocument/signatureHelp", "lang 1\nlet a = min(max(1, 2), |)");
    assert!(help["signatures"][0]["label"].as_str().unwrap().starts_with("min("));
    assert_eq!(ask_at("textDocument/signatureHelp", "lang 1\nlet a = clamp(1, 2, 3)|"), Value::Null);
}

#[test]
fn hints_colours_and_the_rest() {
    let text = "lang 1\nimport \"std/metals\" as metals\nimport \"std/glass\" as glass\n\n// One\n// two.\nlet half = 3m / 2\nlet red = mix(#ff0000, half, 0.5)\nsphere ball {\n    radius: clamp(half, 1m, 2m)\n    position: keys {\n        0s: (0, 0, 0)\n        1s: (1, 0, 0) ease out_bounce\n    }\n    material: diffuse { color: linear(0.5, 0.25, 1) }\n}\n";
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), true);
    let uri = files.uri("scene.kin");
    editor.open(&uri, text);
    let document = json!({ "uri": uri });
    let all = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints = editor.ask("textDocument/inlayHint", json!({ "textDocument": document, "range": all })).unwrap();
    let shown: Vec<&str> = hints.as_array().unwrap().iter().map(|hint| hint["label"].as_str().unwrap()).collect();
    assert!(shown.contains(&"= 1.5m") && shown.contains(&"low:") && shown.contains(&"high:"), "{shown:?}");
    assert_eq!(shown.iter().filter(|hint| hint.contains('▁')).count(), 1, "{shown:?}");
    let colors = editor.ask("textDocument/documentColor", json!({ "textDocument": document })).unwrap();
    assert_eq!(colors.as_array().unwrap().len(), 2);
    assert_eq!(colors[0]["color"], json!({ "red": 1.0, "green": 0.0, "blue": 0.0, "alpha": 1.0 }));
    let params = json!({ "textDocument": document, "color": colors[1]["color"], "range": colors[1]["range"] });
    let spelled = editor.ask("textDocument/colorPresentation", params).unwrap();
    assert_eq!(spelled[0]["label"], "linear(0.5, 0.25, 1)");
    assert_eq!(spelled[1]["label"], "#bc89ff");
    // Whatever is offered can be read.
    for spelling in spelled.as_array().unwrap() {
        let text = format!("lang 1\nlet _a = {}\n", spelling["label"].as_str().unwrap());
        editor.change(&uri, 2, &text);
        let colors = editor.ask("textDocument/documentColor", json!({ "textDocument": document })).unwrap();
        assert_eq!(colors.as_array().unwrap().len(), 1, "{text}");
        let found = editor.findings(&uri, 2);
        assert!(found.iter().all(|found| found["code"] != "E0210"), "{text}: {found:?}");
        editor.said.clear();
    }
    editor.change(&uri, 3, text);
    let folds = editor.ask("textDocument/foldingRange", json!({ "textDocument": document })).unwrap();
    let lines: Vec<(u64, u64)> = folds
        .as_array()
        .unwrap()
        .iter()
        .map(|fold| (fold["startLine"].as_u64().unwrap(), fold["endLine"].as_u64().unwrap()))
        .collect();
    assert_eq!(lines, [(1, 2), (4, 5), (8, 14), (10, 12)]);
    let symbols = editor.ask("textDocument/documentSymbol", json!({ "textDocument": document })).unwrap();
    let names: Vec<&str> = symbols.as_array().unwrap().iter().map(|symbol| symbol["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["metals", "glass", "half", "red", "ball"]);
    assert_eq!(symbols[4]["children"][0]["name"], "position");
    let positions = json!([editor.place(text, text.find("half, 1m").unwrap() + 1)]);
    let selection =
        editor.ask("textDocument/selectionRange", json!({ "textDocument": document, "positions": positions })).unwrap();
    let mut sizes = Vec::new();
    let mut around = &selection[0];
    while around.is_object() {
        sizes.push(around["range"].clone());
        around = &around["parent"];
    }
    assert!(sizes.len() >= 6, "{sizes:?}");
    let links = editor.ask("textDocument/documentLink", json!({ "textDocument": document })).unwrap();
    assert!(links[0]["target"].as_str().unwrap().ends_with("/std/metals.kin"), "{links}");
    let highlights =
        editor.ask("textDocument/documentHighlight", at(&editor, &uri, text, text.find("half").unwrap())).unwrap();
    assert_eq!(highlights.as_array().unwrap().len(), 3);
    editor.finish();
}

#[test]
fn words_have_their_kinds() {
    let text = "lang 1\nlet r = 2m\nsphere ball { radius: r, material: diffuse { } }\n";
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), true);
    let uri = files.uri("scene.kin");
    editor.open(&uri, text);
    let answer = editor.ask("textDocument/semanticTokens/full", json!({ "textDocument": { "uri": uri } })).unwrap();
    let legend = &editor.greeting["capabilities"]["semanticTokensProvider"]["legend"];
    let numbers: Vec<usize> = answer["data"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize).collect();
    let (mut line, mut start) = (0, 0);
    let mut found = Vec::new();
    for token in numbers.chunks_exact(5) {
        (line, start) = if token[0] > 0 { (line + token[0], token[1]) } else { (line, start + token[1]) };
        let word = &text.lines().nth(line).unwrap()[start..start + token[2]];
        found.push(format!("{word} {}", legend["tokenTypes"][token[3]].as_str().unwrap()));
    }
    let expected = "lang keyword,1 number,let keyword,r variable,2 number,m number,sphere class,ball variable,radius property,r variable,material property,diffuse class";
    assert_eq!(found.join(","), expected);
    editor.finish();
}

#[test]
fn a_strange_editor_is_answered() {
    let files = Files::new(&[("kinora.toml", ""), ("a.kin", "lang 1\n")]);
    let mut editor = Editor::new(files.folder.path(), false);
    let uri = files.uri("a.kin");
    // Texts that are not open, places that are not there, requests that nobody knows, parameters that are none.
    let position = json!({ "line": 4_000_000_000_u32, "character": 4_000_000_000_u32 });
    assert!(editor.ask("textDocument/hover", json!({ "textDocument": { "uri": uri }, "position": position })).is_err());
    editor.open(&uri, "lang 1\r\nsphere 😀 {\r\n");
    editor.open("untitled:Untitled-1", "lang 1\nsphere b { rad");
    for uri in [uri.as_str(), "untitled:Untitled-1"] {
        for method in AT {
            let params = json!({ "textDocument": { "uri": uri }, "position": position });
            let _ = editor.ask(&format!("textDocument/{method}"), params);
        }
        let upside_down = json!({ "start": position, "end": { "line": 0, "character": 1 } });
        let document = json!({ "uri": uri, "version": 2 });
        let change = json!({ "range": upside_down, "text": "x" });
        editor.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
        for version in 3..5 {
            let inside = json!({ "start": { "line": 1, "character": 8 }, "end": { "line": 1, "character": 8 } });
            let document = json!({ "uri": uri, "version": version });
            let change = json!({ "range": inside, "text": "\u{301}" });
            editor.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
        }
        let _ = editor.ask(
            "textDocument/completion",
            json!({ "textDocument": { "uri": uri }, "position": { "line": 1, "character": 9 } }),
        );
    }
    assert!(editor.ask("textDocument/noSuchThing", json!({})).is_err());
    assert!(editor.ask("textDocument/completion", json!({ "textDocument": 3 })).is_err());
    editor.tell("textDocument/didChange", json!({ "textDocument": [] }));
    editor.tell("$/unknown", json!(null));
    // A request that is taken back while others wait.
    let first = editor.send("workspace/symbol", json!({ "query": "" }));
    let second = editor.send("workspace/symbol", json!({ "query": "" }));
    editor.tell("$/cancelRequest", json!({ "id": second.clone() }));
    editor.answer_to(&first).unwrap();
    editor.finish();
}

/// Texts as people leave them between two thoughts: pieces of scenes cut, doubled and put together anew.
#[test]
fn broken_texts() {
    let pieces = "sphere ball { } | radius: | 50cm | , | ( | ) | { | } | [ | ] | keys { 0s: 1 | ease in_ | \"a | // c | /* | #ff | like | import { a } from | \"b.kin\" as | metals. | . | for i in | 0..3 | if | else | let x = | fn f(a, | prefab p( | : | = | param q: length | in 0..1 | 😀 | é | \r\n | \n | \t | -> | mix(a, | material: diffuse | color: | lang 1 | 1e999 | 5parsec | node( | steps(3,";
    let pieces: Vec<&str> = pieces.split(" | ").collect();
    let files = Files::new(&[("kinora.toml", "")]);
    let mut editor = Editor::new(files.folder.path(), true);
    let uri = files.uri("scene.kin");
    editor.open(&uri, "");
    let mut state = 7_u32;
    let mut random = |below: usize| {
        // Numerical Recipes' generator: what is wanted is the same texts each time.
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    for version in 2..120 {
        let count = 1 + random(24);
        let text: String =
            (0..count).flat_map(|_| [pieces[random(pieces.len())], [" ", "", "\n"][random(3)]]).collect();
        editor.change(&uri, version, &text);
        let offsets: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
        for _ in 0..2 {
            ask_all(&mut editor, &uri, &text, offsets[random(offsets.len())]);
        }
    }
    editor.finish();
}
