//! The language server: handles the messages of one editor, one at a time.
//!
//! It keeps the texts that are open in the editor and queries them through
//! `genom_description_tools::navigate`. A changed text is read again when typing pauses, or earlier
//! if a request needs it.

#![forbid(unsafe_code)]

mod colours;
mod convert;
mod edits;
mod place;
mod requests;
mod workspace;

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use genom_description::Options;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument,
    DidSaveTextDocument, Notification as _,
};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeActionProviderCapability, CompletionOptions,
    DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    HoverProviderCapability, InitializeParams, OneOf, RenameOptions, SemanticTokensFullOptions,
    SemanticTokensOptions, ServerCapabilities, TextDocumentSyncCapability, TextDocumentSyncKind,
    TextDocumentSyncOptions, WorkDoneProgressOptions,
};
use serde::Deserialize;
use serde_json::json;

use self::workspace::Workspace;

/// Time without changes after which a text is read again.
const PAUSE: Duration = Duration::from_millis(150);

/// Options that an editor may set when it starts the server.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Settings {
    include: Vec<PathBuf>,
    defines: Vec<String>,
}

/// Serves one editor on standard input and output until it shuts down.
///
/// # Errors
/// The editor is gone, or its first messages are not those of an editor.
pub fn serve(options: Options) -> io::Result<()> {
    let (connection, threads) = Connection::stdio();
    let (id, parameters) = connection.initialize_start().map_err(io::Error::other)?;
    let options = with_settings(options, &parameters);
    let reply = json!({
        "capabilities": capabilities(),
        "serverInfo": { "name": "genomctl", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, reply).map_err(io::Error::other)?;
    Server { connection: &connection, workspace: Workspace::new(options), due: None }.run()?;
    // The writing thread ends when all senders are dropped.
    drop(connection);
    threads.join()
}

fn capabilities() -> ServerCapabilities {
    let words = |signs: &[&str]| signs.iter().map(|&sign| sign.to_owned()).collect();
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Options(TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::FULL),
            save: Some(true.into()),
            ..TextDocumentSyncOptions::default()
        })),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
            code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]),
            ..CodeActionOptions::default()
        })),
        semantic_tokens_provider: Some(
            SemanticTokensOptions {
                legend: colours::legend(),
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            }
            .into(),
        ),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(words(&[".", ":", "<"])),
            ..CompletionOptions::default()
        }),
        ..ServerCapabilities::default()
    }
}

/// The options of the command line, completed with those of the editor; relative directories are
/// relative to the editor's folder.
fn with_settings(mut options: Options, parameters: &serde_json::Value) -> Options {
    let Ok(parameters) = InitializeParams::deserialize(parameters) else { return options };
    let settings = parameters.initialization_options.unwrap_or_default();
    let settings = Settings::deserialize(settings).unwrap_or_default();
    let folder = parameters.workspace_folders.into_iter().flatten().next();
    let folder = folder.and_then(|folder| place::path_of(&folder.uri)).unwrap_or_default();
    let include = settings.include.iter().map(|directory| Path::join(&folder, directory));
    options.preprocess.include_dirs.extend(include);
    options.preprocess.defines.extend(settings.defines);
    options
}

struct Server<'a> {
    connection: &'a Connection,
    workspace: Workspace,
    /// When to read changed texts again.
    due: Option<Instant>,
}

impl Server<'_> {
    fn run(mut self) -> io::Result<()> {
        loop {
            let message = match self.due {
                None => self.connection.receiver.recv().ok(),
                Some(due) => match self.connection.receiver.recv_deadline(due) {
                    Ok(message) => Some(message),
                    Err(error) if error.is_timeout() => {
                        self.refresh()?;
                        continue;
                    }
                    Err(_) => None,
                },
            };
            match message {
                // The editor closed the connection.
                None => return Ok(()),
                Some(Message::Request(request)) => {
                    if self.connection.handle_shutdown(&request).map_err(io::Error::other)? {
                        return Ok(());
                    }
                    self.refresh()?;
                    let reply = self.answer(request);
                    self.send(reply.into())?;
                }
                Some(Message::Notification(told)) if told.method == "exit" => {
                    return Err(io::Error::other("the editor left without a shutdown"));
                }
                Some(Message::Notification(told)) => self.hear(told)?,
                // The server makes no requests.
                Some(Message::Response(_)) => {}
            }
        }
    }

    fn answer(&self, request: Request) -> Response {
        let id = request.id.clone();
        match requests::answer(&self.workspace, request) {
            Ok(result) => Response::new_ok(id, result),
            Err(requests::Refusal::Unknown(method)) => {
                let message = format!("{method} is not served");
                Response::new_err(id, ErrorCode::MethodNotFound as i32, message)
            }
            Err(requests::Refusal::Parameters(why)) => {
                Response::new_err(id, ErrorCode::InvalidParams as i32, why)
            }
            Err(requests::Refusal::Failed(why)) => {
                Response::new_err(id, ErrorCode::RequestFailed as i32, why)
            }
        }
    }

    fn hear(&mut self, told: Notification) -> io::Result<()> {
        match told.method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Ok(it) = DidOpenTextDocumentParams::deserialize(told.params) {
                    let it = it.text_document;
                    self.workspace.set(&it.uri, it.version, it.text);
                    self.refresh()?;
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Ok(it) = DidChangeTextDocumentParams::deserialize(told.params)
                    && let Some(change) = it.content_changes.into_iter().next_back()
                {
                    let document = it.text_document;
                    self.workspace.set(&document.uri, document.version, change.text);
                    self.due = Some(Instant::now() + PAUSE);
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Ok(it) = DidCloseTextDocumentParams::deserialize(told.params) {
                    self.workspace.close(&it.text_document.uri);
                    self.refresh()?;
                }
            }
            DidSaveTextDocument::METHOD | DidChangeWatchedFiles::METHOD => {
                self.workspace.forget();
                self.refresh()?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Reads changed texts, and publishes their diagnostics.
    fn refresh(&mut self) -> io::Result<()> {
        self.due = None;
        for parameters in self.workspace.refresh() {
            let method = "textDocument/publishDiagnostics".to_owned();
            self.send(Notification::new(method, parameters).into())?;
        }
        Ok(())
    }

    fn send(&self, message: Message) -> io::Result<()> {
        self.connection.sender.send(message).map_err(io::Error::other)
    }
}
