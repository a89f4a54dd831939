//! An editor in memory: it types what people type, and looks at every answer.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value, json};

/// An editor with a server of its own.
struct Editor {
    connection: Connection,
    server: Option<std::thread::JoinHandle<Result<Option<u8>, String>>>,
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
        assert_eq!(self.server.take().unwrap().join().unwrap(), Ok(Some(0)));
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
    let mut editor = Editor::new(folder.path(), at % 2 == 0);
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
