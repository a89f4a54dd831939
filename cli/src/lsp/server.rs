//! The loop: one message after the other, and what is wrong with texts once nothing more comes.

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use kinora_lang::assets::cache::Cache;
use kinora_lang::ide::{self, Analysis, Place};
use kinora_lang::source::Source;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use lsp_types as lsp;
use lsp_types::notification::{self as note, Notification as _};
use lsp_types::request::{self as ask, Request as _};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::answers::{self, Shows};
use super::diagnose::{Findings, diagnose};
use super::documents::Document;
use super::position::Encoding;
use super::project::{Open, Project, scenes_below};
use super::{actions, rename, uri};

/// Edits by address.
pub type Changed = Vec<(lsp::Uri, Vec<lsp::TextEdit>)>;

/// How long no text must change before texts are judged: while somebody types, every letter would be.
const QUIET: Duration = Duration::from_millis(40);

/// How often it is looked whether the editor still lives.
const LOOK: Duration = Duration::from_secs(3);

/// So many symbols of a project are listed.
const MOST_SYMBOLS: usize = 1_000;

/// Serves one editor until it says goodbye. The exit code; `None` where the editor's process is gone, while its pipes may
/// still be held by others.
pub fn serve(connection: &Connection) -> Option<u8> {
    let (id, params) = loop {
        let Ok((id, params)) = connection.initialize_start() else { return Some(crate::exit::FINDINGS) };
        let mut params = params;
        uri::mend(&mut params);
        match needed::<lsp::InitializeParams>(params) {
            Ok(params) => break (id, params),
            Err(Refused(code, why)) => {
                let refused = Response::new_err(id, code as i32, format!("cannot read `initialize`: {why}"));
                let _ = connection.sender.send(refused.into());
            }
        }
    };
    let mut server = Server::new(connection, &params);
    let answer = json!({
        "capabilities": server.capabilities(),
        "serverInfo": { "name": "kinora", "version": env!("CARGO_PKG_VERSION") },
    });
    server.send(Response::new_ok(id, answer).into());
    server.run()
}

/// What an editor said it can do.
#[derive(Debug, Default)]
struct Client {
    process: Option<u32>,
    document_changes: bool,
    flat_symbols: bool,
    can_pull: bool,
    refreshes_findings: bool,
    watches: bool,
    refreshes_hints: bool,
    shows: Shows,
}

struct Server<'c> {
    connection: &'c Connection,
    client: Client,
    encoding: Encoding,
    roots: Vec<PathBuf>,
    documents: BTreeMap<String, Document>,
    open: Arc<Open>,
    cache: Arc<Cache>,
    /// Texts that have changed since they were judged.
    dirty: HashSet<String>,
    /// The text that was changed last: most likely what is looked at.
    latest: String,
    /// When that was.
    changed_at: Instant,
    /// What was last said of each text, by the open text that it was found with.
    said: BTreeMap<String, BTreeMap<String, Vec<lsp::Diagnostic>>>,
    queue: VecDeque<Message>,
    /// The editor asks for findings: it is not told of them as well, or it would show them twice.
    pulls: bool,
    closing: bool,
    requests: i32,
}

/// Why a request has no answer.
struct Refused(ErrorCode, String);

type Answer = Result<Value, Refused>;

fn give<T: Serialize>(value: T) -> Answer {
    serde_json::to_value(value).map_err(|error| Refused(ErrorCode::InternalError, error.to_string()))
}

impl<'c> Server<'c> {
    fn new(connection: &'c Connection, params: &lsp::InitializeParams) -> Server<'c> {
        let capabilities = &params.capabilities;
        let general = capabilities.general.as_ref();
        let encoding = Encoding::choose(general.and_then(|general| general.position_encodings.as_deref()));
        let workspace = capabilities.workspace.as_ref();
        let text = capabilities.text_document.as_ref();
        let item = text.and_then(|text| text.completion.as_ref()?.completion_item.as_ref());
        let markdown = text
            .and_then(|text| text.hover.as_ref()?.content_format.as_ref())
            .is_some_and(|formats| formats.contains(&lsp::MarkupKind::Markdown));
        let client = Client {
            process: params.process_id,
            document_changes: workspace.and_then(|w| w.workspace_edit.as_ref()?.document_changes).unwrap_or(false),
            flat_symbols: !text
                .and_then(|text| text.document_symbol.as_ref()?.hierarchical_document_symbol_support)
                .unwrap_or(false),
            can_pull: text.is_some_and(|text| text.diagnostic.is_some()),
            refreshes_findings: workspace.and_then(|w| w.diagnostic.as_ref()?.refresh_support).unwrap_or(false),
            watches: workspace.and_then(|w| w.did_change_watched_files.as_ref()?.dynamic_registration).unwrap_or(false),
            refreshes_hints: workspace.and_then(|w| w.inlay_hint.as_ref()?.refresh_support).unwrap_or(false),
            shows: Shows { snippets: item.and_then(|item| item.snippet_support).unwrap_or(false), markdown },
        };
        let folders = params.workspace_folders.iter().flatten().filter_map(|folder| uri::path(&folder.uri));
        #[allow(deprecated)] // Some editors know no folders yet.
        let old = params.root_uri.as_ref().and_then(uri::path);
        let mut roots: Vec<PathBuf> = folders.collect();
        if roots.is_empty() {
            roots.extend(old);
        }
        Server {
            connection,
            client,
            encoding,
            roots,
            documents: BTreeMap::new(),
            open: Arc::default(),
            cache: Arc::default(),
            dirty: HashSet::new(),
            latest: String::new(),
            changed_at: Instant::now(),
            said: BTreeMap::new(),
            queue: VecDeque::new(),
            pulls: false,
            closing: false,
            requests: 0,
        }
    }

    fn capabilities(&self) -> Value {
        let legend = json!({
            "tokenTypes": ide::TokenKind::ALL.iter().map(|row| row.1).collect::<Vec<_>>(),
            "tokenModifiers": ide::Modifier::ALL.iter().map(|row| row.1).collect::<Vec<_>>(),
        });
        let renames = json!({ "filters": [
            { "scheme": "file", "pattern": { "glob": "**/*", "matches": "file" } },
            { "scheme": "file", "pattern": { "glob": "**/*", "matches": "folder" } },
        ] });
        let mut offered = json!({
            "positionEncoding": self.encoding.kind(),
            "textDocumentSync": { "openClose": true, "change": lsp::TextDocumentSyncKind::INCREMENTAL, "save": true },
            "completionProvider": { "triggerCharacters": [".", ":", "\"", "/", "#", "("], "resolveProvider": true },
            "hoverProvider": true,
            "signatureHelpProvider": { "triggerCharacters": ["(", ","], "retriggerCharacters": [":"] },
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "documentSymbolProvider": true,
            "workspaceSymbolProvider": true,
            "codeActionProvider": { "codeActionKinds": ["quickfix", actions::FIX_ALL] },
            "colorProvider": true,
            "documentFormattingProvider": true,
            "documentRangeFormattingProvider": true,
            "documentOnTypeFormattingProvider": { "firstTriggerCharacter": "}" },
            "renameProvider": { "prepareProvider": true },
            "documentLinkProvider": { "resolveProvider": false },
            "foldingRangeProvider": true,
            "selectionRangeProvider": true,
            "inlayHintProvider": { "resolveProvider": false },
            "semanticTokensProvider": { "legend": legend, "full": true, "range": true },
            "workspace": {
                "workspaceFolders": { "supported": true, "changeNotifications": true },
                "fileOperations": { "willRename": renames },
            },
        });
        if self.client.can_pull {
            offered["diagnosticProvider"] = json!({ "interFileDependencies": true, "workspaceDiagnostics": false });
        }
        offered
    }

    /// Asks to be told of files that change beside the editor.
    fn watch_files(&mut self) {
        if !self.client.watches {
            return;
        }
        let globs = ["**/*.kin", "**/kinora.toml", "**/*.{obj,mtl,ply,stl,gltf,glb,bin,png,jpg,jpeg,webp,exr,hdr}"];
        let watchers: Vec<Value> = globs.iter().map(|glob| json!({ "globPattern": glob })).collect();
        let registration = json!({
            "id": "files",
            "method": note::DidChangeWatchedFiles::METHOD,
            "registerOptions": { "watchers": watchers },
        });
        self.ask(ask::RegisterCapability::METHOD, json!({ "registrations": [registration] }));
    }

    fn ask(&mut self, method: &str, params: Value) {
        self.requests += 1;
        self.send(Request { id: self.requests.into(), method: method.into(), params }.into());
    }

    fn send(&self, message: Message) {
        // An editor that is gone is seen when the next message is read.
        let _ = self.connection.sender.send(message);
    }

    fn run(&mut self) -> Option<u8> {
        loop {
            match self.next()? {
                Message::Notification(message) if message.method == note::Exit::METHOD => {
                    return Some(if self.closing { crate::exit::CLEAN } else { crate::exit::FINDINGS });
                }
                Message::Notification(message) => {
                    let method = message.method.clone();
                    // What was said in the panic stands on stderr.
                    if catch_unwind(AssertUnwindSafe(|| self.notified(message))).is_err() {
                        crate::terminal::err(&format!("{method} was not understood\n"));
                    }
                }
                Message::Request(request) => {
                    let answer = self.answer(request);
                    self.send(answer.into());
                }
                Message::Response(_) => {}
            }
        }
    }

    /// The next message; meanwhile, texts are judged. `None` where the editor's process is gone.
    fn next(&mut self) -> Option<Message> {
        loop {
            self.drain();
            if let Some(message) = self.queue.pop_front() {
                return Some(message);
            }
            let wait = match self.dirty.contains(&self.latest) {
                true => QUIET.saturating_sub(self.changed_at.elapsed()),
                false if self.dirty.is_empty() => LOOK,
                false => Duration::ZERO,
            };
            match self.connection.receiver.recv_timeout(wait) {
                Ok(message) => self.queue.push_back(message),
                // Without a word, it counts as one that does not say goodbye.
                Err(error) if error.is_disconnected() => {
                    self.queue.push_back(Notification::new(note::Exit::METHOD.into(), ()).into());
                }
                Err(_) if self.dirty.is_empty() => {
                    if self.client.process.is_some_and(|process| !lives(process)) {
                        return None;
                    }
                }
                Err(_) => self.judge_one(),
            }
        }
    }

    /// Takes what has come, and takes back the requests that are not wanted any more.
    fn drain(&mut self) {
        while let Ok(message) = self.connection.receiver.try_recv() {
            let cancelled = match &message {
                Message::Notification(message) if message.method == note::Cancel::METHOD => {
                    message.params.get("id").cloned()
                }
                _ => None,
            };
            let Some(cancelled) = cancelled else {
                self.queue.push_back(message);
                continue;
            };
            let Ok(id) = serde_json::from_value::<RequestId>(cancelled) else { continue };
            let is_it = |message: &Message| matches!(message, Message::Request(request) if request.id == id);
            if let Some(at) = self.queue.iter().position(is_it) {
                self.queue.remove(at);
                let message = "cancelled".to_string();
                self.send(Response::new_err(id, ErrorCode::RequestCanceled as i32, message).into());
            }
        }
    }

    fn notified(&mut self, message: Notification) {
        let Notification { method, mut params } = message;
        uri::mend(&mut params);
        match method.as_str() {
            note::Initialized::METHOD => self.watch_files(),
            note::DidOpenTextDocument::METHOD => {
                let Some(params) = read::<lsp::DidOpenTextDocumentParams>(params) else { return };
                let lsp::TextDocumentItem { uri, version, text, .. } = params.text_document;
                let path = self.path_of(&uri);
                (self.latest, self.changed_at) = (uri.as_str().to_string(), Instant::now());
                self.documents.insert(self.latest.clone(), Document::new(uri, path, version, &text));
                self.all_changed();
            }
            note::DidChangeTextDocument::METHOD => {
                let Some(params) = read::<lsp::DidChangeTextDocumentParams>(params) else { return };
                let encoding = self.encoding;
                let Some(document) = self.documents.get_mut(params.text_document.uri.as_str()) else { return };
                document.change(params.text_document.version, params.content_changes, encoding);
                self.changed(params.text_document.uri.as_str());
            }
            note::DidCloseTextDocument::METHOD => {
                let Some(params) = read::<lsp::DidCloseTextDocumentParams>(params) else { return };
                let uri = params.text_document.uri.as_str().to_string();
                self.documents.remove(&uri);
                self.dirty.remove(&uri);
                let was_said = self.said.remove(&uri).unwrap_or_default();
                was_said.keys().for_each(|file| self.publish(file));
                self.publish(&uri);
                self.all_changed();
            }
            note::DidSaveTextDocument::METHOD | note::DidChangeWatchedFiles::METHOD => {
                self.all_changed();
                if self.pulls && self.client.refreshes_findings {
                    self.ask(ask::WorkspaceDiagnosticRefresh::METHOD, Value::Null);
                }
            }
            note::DidChangeWorkspaceFolders::METHOD => {
                let Some(params) = read::<lsp::DidChangeWorkspaceFoldersParams>(params) else { return };
                let removed: Vec<PathBuf> =
                    params.event.removed.iter().filter_map(|folder| uri::path(&folder.uri)).collect();
                self.roots.retain(|root| !removed.contains(root));
                self.roots.extend(params.event.added.iter().filter_map(|folder| uri::path(&folder.uri)));
            }
            _ => {}
        }
    }

    /// Where a text is, or would be.
    fn path_of(&self, uri: &lsp::Uri) -> PathBuf {
        uri::path(uri).unwrap_or_else(|| {
            let folder = self.roots.first().cloned().or_else(|| std::env::current_dir().ok()).unwrap_or_default();
            let name: String =
                uri.as_str().chars().filter(|letter| letter.is_alphanumeric() || "-_".contains(*letter)).collect();
            folder.join(format!("{name}.kin"))
        })
    }

    /// A text that is open is not what it was: neither is what is known of those that import it.
    fn changed(&mut self, uri: &str) {
        let Some(document) = self.documents.get(uri) else { return };
        Arc::make_mut(&mut self.open).insert(document.path.clone(), document.source.text.as_bytes().into());
        let address = Some(document.uri.clone());
        for (other, document) in &mut self.documents {
            let reads = |found: &Arc<Findings>| found.sources.iter().any(|(_, read)| *read == address);
            if other == uri || document.findings.as_ref().is_none_or(reads) {
                document.forget();
                self.dirty.insert(other.clone());
            }
        }
        (self.latest, self.changed_at) = (uri.to_string(), Instant::now());
    }

    /// Texts are open that were not, or files are not what they were.
    fn all_changed(&mut self) {
        let open =
            self.documents.values().map(|document| (document.path.clone(), document.source.text.as_bytes().into()));
        self.open = Arc::new(open.collect());
        for document in self.documents.values_mut() {
            document.forget();
        }
        self.dirty.extend(self.documents.keys().cloned());
    }

    /// Says what is wrong with one of the texts that have changed.
    fn judge_one(&mut self) {
        let uri = match self.dirty.take(&self.latest) {
            Some(latest) => latest,
            None => {
                let Some(next) = self.dirty.iter().min().cloned() else { return };
                self.dirty.remove(&next);
                next
            }
        };
        if self.pulls {
            return;
        }
        let judged = catch_unwind(AssertUnwindSafe(|| {
            let encoding = self.encoding;
            let findings = self.findings(&uri)?;
            let own = &self.documents.get(&uri)?.uri;
            Some(findings.by_file(own, encoding))
        }));
        let Ok(Some(by_file)) = judged else { return };
        let now: BTreeMap<String, Vec<lsp::Diagnostic>> =
            by_file.into_iter().map(|(file, found)| (file.as_str().to_string(), found)).collect();
        let before = self.said.insert(uri, now.clone()).unwrap_or_default();
        let mut files: Vec<&String> = now.keys().chain(before.keys()).collect();
        files.sort();
        files.dedup();
        files.into_iter().for_each(|file| self.publish(file));
        if self.dirty.is_empty() && self.client.refreshes_hints {
            self.ask(ask::InlayHintRefreshRequest::METHOD, Value::Null);
        }
    }

    /// From now on the editor asks for findings; those that it was told of are taken back.
    fn pull(&mut self) {
        if !std::mem::replace(&mut self.pulls, true) {
            let files: HashSet<String> =
                std::mem::take(&mut self.said).into_values().flat_map(BTreeMap::into_keys).collect();
            files.iter().for_each(|file| self.publish(file));
        }
    }

    /// Sends what is known to be wrong with a file, whichever text it was found with.
    fn publish(&self, file: &str) {
        let Ok(uri) = file.parse() else { return };
        let mut found: Vec<lsp::Diagnostic> = Vec::new();
        // Its own findings first; those of the scenes that import it, where they say something else.
        let own = self.said.get(file).and_then(|files| files.get(file));
        let others = self.said.iter().filter(|(text, _)| *text != file).filter_map(|(_, files)| files.get(file));
        for one in own.into_iter().chain(others).flatten() {
            let same = |other: &lsp::Diagnostic| other.range == one.range && other.code == one.code;
            if !found.iter().any(same) {
                found.push(one.clone());
            }
        }
        let version = self.documents.get(file).map(|document| document.version);
        let params = lsp::PublishDiagnosticsParams { uri, diagnostics: found, version };
        self.send(Notification::new(note::PublishDiagnostics::METHOD.into(), params).into());
    }

    fn document(&self, uri: &lsp::Uri) -> Result<&Document, Refused> {
        let unknown = || Refused(ErrorCode::InvalidParams, format!("`{}` is not open", uri.as_str()));
        self.documents.get(uri.as_str()).ok_or_else(unknown)
    }

    fn project(&self, path: &Path) -> Project {
        Project::of(path, &self.open)
    }

    /// What the names of a text mean, and the project that it is in.
    fn analysis(&mut self, uri: &lsp::Uri) -> Result<(Analysis, Project), Refused> {
        let project = self.project(&self.document(uri)?.path);
        let document = self.documents.get_mut(uri.as_str());
        let Some(document) = document else { return Err(Refused(ErrorCode::InvalidParams, "not open".into())) };
        let made = || Analysis::new(project.name(), &document.source.text, project.files());
        let analysis = document.analysis.get_or_insert_with(made).clone();
        Ok((analysis, project))
    }

    /// What is wrong with a text.
    fn findings(&mut self, uri: &str) -> Option<Arc<Findings>> {
        if self.documents.get(uri)?.findings.is_none() {
            let mut found = diagnose(&self.documents.get(uri)?.path, &self.open, &self.cache);
            // As the editor calls them: a link may lead to them.
            for (_, address) in &mut found.sources {
                let Some(path) = address.as_ref().and_then(uri::path) else { continue };
                if let Some(open) = self.documents.values().find(|document| document.path == path) {
                    *address = Some(open.uri.clone());
                }
            }
            let document = self.documents.get_mut(uri)?;
            document.clock = found.clock.or(document.clock);
            document.findings = Some(Arc::new(found));
        }
        self.documents.get(uri)?.findings.clone()
    }

    fn clock(&mut self, uri: &lsp::Uri) -> Option<(f64, f64)> {
        self.findings(uri.as_str());
        self.documents.get(uri.as_str())?.clock
    }

    fn answer(&mut self, request: Request) -> Response {
        let Request { id, method, mut params } = request;
        uri::mend(&mut params);
        if self.closing {
            return Response::new_err(id, ErrorCode::InvalidRequest as i32, "the server is closing".into());
        }
        let answered = catch_unwind(AssertUnwindSafe(|| self.answer_to(&method, params)));
        match answered {
            Ok(Ok(value)) => Response::new_ok(id, value),
            Ok(Err(Refused(code, message))) => Response::new_err(id, code as i32, message),
            Err(_) => {
                let message = format!("`{method}` met a bug in the tool");
                Response::new_err(id, ErrorCode::InternalError as i32, message)
            }
        }
    }

    fn answer_to(&mut self, method: &str, params: Value) -> Answer {
        let (encoding, shows) = (self.encoding, self.client.shows);
        match method {
            ask::Initialize::METHOD => {
                Err(Refused(ErrorCode::InvalidRequest, "`initialize` comes once, before everything else".into()))
            }
            ask::Shutdown::METHOD => {
                self.closing = true;
                Ok(Value::Null)
            }
            ask::Completion::METHOD => {
                let params: lsp::CompletionParams = needed(params)?;
                let (analysis, project, offset) = self.at(&params.text_document_position)?;
                give(answers::completions(&analysis, &project, offset, encoding, shows))
            }
            ask::ResolveCompletionItem::METHOD => give(answers::resolve(needed(params)?, shows)),
            ask::HoverRequest::METHOD => {
                let params: lsp::HoverParams = needed(params)?;
                let at = params.text_document_position_params;
                let (analysis, _, offset) = self.at(&at)?;
                let clock = &mut || self.clock(&at.text_document.uri);
                give(answers::hover(&analysis, offset, clock, encoding, shows))
            }
            ask::SignatureHelpRequest::METHOD => {
                let params: lsp::SignatureHelpParams = needed(params)?;
                let (analysis, _, offset) = self.at(&params.text_document_position_params)?;
                give(answers::signature(&analysis, offset, shows))
            }
            ask::GotoDefinition::METHOD => {
                let params: lsp::GotoDefinitionParams = needed(params)?;
                let (analysis, project, offset) = self.at(&params.text_document_position_params)?;
                give(self.definition(&analysis, &project, offset))
            }
            ask::References::METHOD => {
                let params: lsp::ReferenceParams = needed(params)?;
                let (analysis, project, offset) = self.at(&params.text_document_position)?;
                let Some((_, declared)) = analysis.definition(offset) else { return Ok(Value::Null) };
                let mut places = project.references(&self.open, &declared, false);
                places.retain(|place| params.context.include_declaration || *place != declared);
                give(self.locations(&project, &places))
            }
            ask::DocumentHighlightRequest::METHOD => {
                let params: lsp::DocumentHighlightParams = needed(params)?;
                let (analysis, _, offset) = self.at(&params.text_document_position_params)?;
                let Some((_, declared)) = analysis.definition(offset) else { return Ok(Value::Null) };
                let source = &analysis.tree.source;
                let own = analysis.references(&declared, false).into_iter().filter(|place| place.file == source.name);
                let highlight = |place: Place| lsp::DocumentHighlight {
                    range: encoding.range(source, place.span),
                    kind: Some(match place == declared {
                        true => lsp::DocumentHighlightKind::WRITE,
                        false => lsp::DocumentHighlightKind::READ,
                    }),
                };
                give(own.map(highlight).collect::<Vec<_>>())
            }
            ask::PrepareRenameRequest::METHOD => {
                let params: lsp::TextDocumentPositionParams = needed(params)?;
                let (analysis, project, offset) = self.at(&params)?;
                let found =
                    rename::prepare(&analysis, &project, offset).map_err(|why| Refused(ErrorCode::RequestFailed, why));
                let (span, _) = found?;
                let source = &analysis.tree.source;
                give(json!({ "range": encoding.range(source, span), "placeholder": source.slice(span) }))
            }
            ask::Rename::METHOD => {
                let params: lsp::RenameParams = needed(params)?;
                let (analysis, project, offset) = self.at(&params.text_document_position)?;
                let refused = |why| Refused(ErrorCode::RequestFailed, why);
                let (_, declared) = rename::prepare(&analysis, &project, offset).map_err(refused)?;
                let places = rename::rename(&project, &self.open, &declared, &params.new_name).map_err(refused)?;
                let edits = places.iter().filter_map(|(file, spans)| {
                    let source = project.source(file)?;
                    let edit = |span: &_| lsp::TextEdit {
                        range: encoding.range(&source, *span),
                        new_text: params.new_name.clone(),
                    };
                    Some((self.uri_in(&project, file)?, spans.iter().map(edit).collect()))
                });
                give(self.workspace_edit(edits.collect()))
            }
            ask::DocumentSymbolRequest::METHOD => {
                let params: lsp::DocumentSymbolParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                let entries = ide::outline(&analysis.tree.file().items);
                let source = &analysis.tree.source;
                match self.client.flat_symbols {
                    true => give(answers::flat_outline(source, &params.text_document.uri, &entries, encoding)),
                    false => give(answers::outline(source, entries, encoding)),
                }
            }
            ask::WorkspaceSymbolRequest::METHOD => {
                let params: lsp::WorkspaceSymbolParams = needed(params)?;
                give(self.symbols(&params.query))
            }
            ask::SemanticTokensFullRequest::METHOD => {
                let params: lsp::SemanticTokensParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::tokens(&analysis, None, encoding))
            }
            ask::SemanticTokensRangeRequest::METHOD => {
                let params: lsp::SemanticTokensRangeParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                let within = encoding.span(&analysis.tree.source, params.range);
                give(answers::tokens(&analysis, Some(within), encoding))
            }
            ask::DocumentColor::METHOD => {
                let params: lsp::DocumentColorParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::colors(&analysis.tree.source, ide::colors(&analysis.tree), encoding))
            }
            ask::ColorPresentationRequest::METHOD => {
                let params: lsp::ColorPresentationParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::spellings(&analysis.tree.source, &params, encoding))
            }
            ask::Formatting::METHOD => {
                let params: lsp::DocumentFormattingParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::formatting(&analysis, None, false, encoding))
            }
            ask::RangeFormatting::METHOD => {
                let params: lsp::DocumentRangeFormattingParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                let within = encoding.span(&analysis.tree.source, params.range);
                // Whoever chooses lines asks for what is whole among them.
                give(answers::formatting(&analysis, Some(within), true, encoding))
            }
            ask::OnTypeFormatting::METHOD => {
                let params: lsp::DocumentOnTypeFormattingParams = needed(params)?;
                let (analysis, _, offset) = self.at(&params.text_document_position)?;
                give(answers::close_brace(&analysis, offset, encoding))
            }
            ask::FoldingRangeRequest::METHOD => {
                let params: lsp::FoldingRangeParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::folds(&analysis.tree.source, ide::folds(&analysis.tree)))
            }
            ask::SelectionRangeRequest::METHOD => {
                let params: lsp::SelectionRangeParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                give(answers::selections(&analysis, &params.positions, encoding))
            }
            ask::InlayHintRequest::METHOD => {
                let params: lsp::InlayHintParams = needed(params)?;
                let (analysis, _) = self.analysis(&params.text_document.uri)?;
                let within = encoding.span(&analysis.tree.source, params.range);
                let clock = &mut || self.clock(&params.text_document.uri);
                give(answers::hints(&analysis, within, clock, encoding))
            }
            ask::CodeActionRequest::METHOD => {
                let params: lsp::CodeActionParams = needed(params)?;
                let uri = params.text_document.uri;
                let Some(findings) = self.findings(uri.as_str()) else { return Ok(Value::Null) };
                let source = self.document(&uri)?.source.clone();
                let within = encoding.span(&source, params.range);
                let only = params.context.only.as_deref();
                let changed = |edits: Changed| self.workspace_edit(edits);
                give(actions::actions(&findings, (&source, &uri), within, only, encoding, &changed))
            }
            ask::DocumentLinkRequest::METHOD => {
                let params: lsp::DocumentLinkParams = needed(params)?;
                let (analysis, project) = self.analysis(&params.text_document.uri)?;
                give(answers::links(&analysis, &project, encoding))
            }
            ask::DocumentDiagnosticRequest::METHOD => {
                let params: lsp::DocumentDiagnosticParams = needed(params)?;
                let uri = params.text_document.uri;
                self.pull();
                let Some(findings) = self.findings(uri.as_str()) else {
                    return Err(Refused(ErrorCode::InvalidParams, format!("`{}` is not open", uri.as_str())));
                };
                let mut by_file = findings.by_file(&uri, encoding).into_iter();
                let own = by_file.next().map(|(_, found)| found).unwrap_or_default();
                let related: serde_json::Map<String, Value> = by_file
                    .map(|(file, found)| (file.as_str().to_string(), json!({ "kind": "full", "items": found })))
                    .collect();
                Ok(json!({ "kind": "full", "items": own, "relatedDocuments": related }))
            }
            ask::WillRenameFiles::METHOD => {
                let params: lsp::RenameFilesParams = needed(params)?;
                give(self.moved(&params.files))
            }
            _ => Err(Refused(ErrorCode::MethodNotFound, format!("`{method}` is not known here"))),
        }
    }

    fn at(&mut self, at: &lsp::TextDocumentPositionParams) -> Result<(Analysis, Project, u32), Refused> {
        let (analysis, project) = self.analysis(&at.text_document.uri)?;
        let offset = self.encoding.offset(&analysis.tree.source, at.position);
        Ok((analysis, project, offset))
    }

    /// The address of a file of a project, as the editor calls it if it is open.
    fn uri_in(&self, project: &Project, file: &str) -> Option<lsp::Uri> {
        let path = project.path(file)?;
        let open = self.documents.values().find(|document| document.path == path);
        open.map(|document| document.uri.clone()).or_else(|| uri::of(&path))
    }

    fn definition(&self, analysis: &Analysis, project: &Project, offset: u32) -> Option<lsp::Location> {
        // A path leads to its file.
        let holds = |named: &ide::PathAt| named.span.start <= offset && offset <= named.span.end;
        if let Some(named) = ide::paths(&analysis.tree).into_iter().find(holds) {
            let uri = self.uri_in(project, &named.path)?;
            return Some(lsp::Location { uri, range: lsp::Range::default() });
        }
        let (_, place) = analysis.definition(offset)?;
        self.locations(project, std::slice::from_ref(&place)).pop()
    }

    fn locations(&self, project: &Project, places: &[Place]) -> Vec<lsp::Location> {
        let mut source: Option<(Arc<str>, Source, lsp::Uri)> = None;
        let mut found = Vec::new();
        for place in places {
            if source.as_ref().is_none_or(|(file, ..)| *file != place.file) {
                let next = project.source(&place.file).zip(self.uri_in(project, &place.file));
                source = next.map(|(source, uri)| (place.file.clone(), source, uri));
            }
            if let Some((_, source, uri)) = &source {
                found.push(lsp::Location { uri: uri.clone(), range: self.encoding.range(source, place.span) });
            }
        }
        found
    }

    /// Edits as this editor takes them: with the versions of open texts, where it knows that.
    fn workspace_edit(&self, edits: Changed) -> lsp::WorkspaceEdit {
        if self.client.document_changes {
            let edit = |(uri, edits): (lsp::Uri, Vec<lsp::TextEdit>)| {
                let version = self.documents.get(uri.as_str()).map(|document| document.version);
                let text_document = lsp::OptionalVersionedTextDocumentIdentifier { uri, version };
                lsp::TextDocumentEdit { text_document, edits: edits.into_iter().map(lsp::OneOf::Left).collect() }
            };
            let edits = lsp::DocumentChanges::Edits(edits.into_iter().map(edit).collect());
            return lsp::WorkspaceEdit { document_changes: Some(edits), ..lsp::WorkspaceEdit::default() };
        }
        // An address is no more than its text here.
        #[allow(clippy::mutable_key_type)]
        let changes = edits.into_iter().collect();
        lsp::WorkspaceEdit { changes: Some(changes), ..lsp::WorkspaceEdit::default() }
    }

    /// What is declared in the projects and fits a query: its letters, in their order.
    fn symbols(&self, query: &str) -> Vec<lsp::SymbolInformation> {
        let mut paths: Vec<PathBuf> = self.roots.iter().flat_map(|root| scenes_below(root)).collect();
        paths.extend(self.open.keys().cloned());
        paths.sort();
        paths.dedup();
        let fits = |name: &str| {
            let mut letters = name.chars().flat_map(char::to_lowercase);
            query.chars().flat_map(char::to_lowercase).all(|wanted| letters.any(|letter| letter == wanted))
        };
        let mut found = Vec::new();
        for path in paths {
            let project = self.project(&path);
            let Some(source) = project.source(project.name()) else { continue };
            let Some(uri) = self.uri_in(&project, project.name()) else { continue };
            let tree = kinora_lang::parse(&source);
            let all = answers::flat_outline(&source, &uri, &ide::outline(&tree.file().items), self.encoding);
            found.extend(all.into_iter().filter(|symbol| fits(&symbol.name)));
            if found.len() >= MOST_SYMBOLS {
                found.truncate(MOST_SYMBOLS);
                break;
            }
        }
        found
    }

    /// The edits that keep paths right when files move.
    fn moved(&self, files: &[lsp::FileRename]) -> lsp::WorkspaceEdit {
        let parse = |text: &str| text.parse::<lsp::Uri>().ok().as_ref().and_then(uri::path);
        let moves: Vec<(PathBuf, PathBuf)> =
            files.iter().filter_map(|file| Some((parse(&file.old_uri)?, parse(&file.new_uri)?))).collect();
        let mut edits: Changed = Vec::new();
        let mut seen: HashSet<PathBuf> = HashSet::new();
        for (from, _) in &moves {
            let project = self.project(from);
            let root = project.root().to_path_buf();
            let now = |file: &str| {
                let path = root.join(file);
                let moved = moves.iter().find_map(|(from, to)| match path.strip_prefix(from) {
                    Ok(rest) if rest.as_os_str().is_empty() => Some(to.clone()),
                    Ok(rest) => Some(to.join(rest)),
                    Err(_) => None,
                });
                let below = moved.as_deref().and_then(|moved| moved.strip_prefix(&root).ok()?.to_str());
                below.map_or_else(|| file.to_string(), |below| below.replace('\\', "/"))
            };
            for file in project.scenes(&self.open) {
                if !seen.insert(root.join(&file)) {
                    continue;
                }
                let Some(source) = project.source(&file) else { continue };
                let tree = kinora_lang::parse(&source);
                let changed = ide::moved(&tree, &now);
                if let Some(uri) = self.uri_in(&project, &file).filter(|_| !changed.is_empty()) {
                    let edit = |(span, new_text)| lsp::TextEdit { range: self.encoding.range(&source, span), new_text };
                    edits.push((uri, changed.into_iter().map(edit).collect()));
                }
            }
        }
        self.workspace_edit(edits)
    }
}

fn read<T: DeserializeOwned>(params: Value) -> Option<T> {
    serde_json::from_value(params).ok()
}

fn needed<T: DeserializeOwned>(params: Value) -> Result<T, Refused> {
    serde_json::from_value(params).map_err(|error| Refused(ErrorCode::InvalidParams, error.to_string()))
}

/// Whether a process is still there.
#[cfg(unix)]
fn lives(process: u32) -> bool {
    let id = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    // One that must not be asked is there, too.
    id.is_none_or(|id| rustix::process::test_kill_process(id) != Err(rustix::io::Errno::SRCH))
}

#[cfg(not(unix))]
fn lives(_: u32) -> bool {
    true
}
