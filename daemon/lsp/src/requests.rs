//! Requests of the editor, and their replies.

use genom_description::source::SourceFile;
use genom_description_tools::navigate::Navigator;
use genom_description_tools::{FormatError, format_text};
use lsp_server::Request;
use lsp_types::{
    CodeActionParams, CompletionParams, DocumentFormattingParams, DocumentSymbolParams,
    GotoDefinitionParams, Hover, HoverContents, HoverParams, MarkupContent, MarkupKind, Position,
    Range, ReferenceParams, RenameParams, SemanticTokensParams, TextDocumentPositionParams,
    TextEdit, Uri,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::workspace::Workspace;
use crate::{colours, convert, edits, place};

/// Why a request failed.
pub(super) enum Refusal {
    /// There is no such method.
    Unknown(String),
    /// The parameters are not valid.
    Parameters(String),
    /// The operation is not possible, for this reason.
    Failed(String),
}

impl Refusal {
    fn failed(why: impl std::fmt::Display) -> Self {
        Self::Failed(why.to_string())
    }
}

/// A request about a position in an open text.
struct At<'a> {
    read: &'a Navigator,
    rank: u32,
    file: &'a SourceFile,
    offset: u32,
}

pub(super) fn answer(workspace: &Workspace, request: Request) -> Result<Value, Refusal> {
    match request.method.as_str() {
        "textDocument/hover" => {
            let asked: HoverParams = parameters(request)?;
            let at = at(workspace, &asked.text_document_position_params);
            value(at.and_then(|at| hover(&at)))
        }
        "textDocument/definition" => {
            let asked: GotoDefinitionParams = parameters(request)?;
            let at = at(workspace, &asked.text_document_position_params);
            value(at.and_then(|at| {
                let span = at.read.definition(at.rank, at.offset)?;
                place::location(&at.read.analysis.sources, span)
            }))
        }
        "textDocument/references" => {
            let asked: ReferenceParams = parameters(request)?;
            let at = at(workspace, &asked.text_document_position);
            value(at.map(|at| {
                let spans = at.read.references(at.rank, at.offset).into_iter();
                let sources = &at.read.analysis.sources;
                spans.filter_map(|span| place::location(sources, span)).collect::<Vec<_>>()
            }))
        }
        "textDocument/completion" => {
            let asked: CompletionParams = parameters(request)?;
            let at = at(workspace, &asked.text_document_position);
            value(at.map(|at| {
                let found = at.read.complete(at.rank, at.offset).into_iter();
                found.map(convert::completion).collect::<Vec<_>>()
            }))
        }
        "textDocument/documentSymbol" => {
            let asked: DocumentSymbolParams = parameters(request)?;
            let text = open(workspace, &asked.text_document.uri);
            value(text.map(|(read, rank, file)| {
                let outline = read.outline(rank);
                outline.iter().map(|one| convert::outline(one, file)).collect::<Vec<_>>()
            }))
        }
        "textDocument/formatting" => {
            let asked: DocumentFormattingParams = parameters(request)?;
            let text = open(workspace, &asked.text_document.uri);
            let edits = text.map(|(_, _, file)| format(file));
            value(edits.transpose().map_err(Refusal::failed)?)
        }
        "textDocument/prepareRename" => {
            let asked: TextDocumentPositionParams = parameters(request)?;
            let at = at(workspace, &asked);
            let span = at.map(|at| at.read.renamed_at(at.rank, at.offset).map(|span| (at, span)));
            let span = span.transpose().map_err(Refusal::failed)?;
            value(span.map(|(at, span)| place::range(at.file, span)))
        }
        "textDocument/rename" => {
            let asked: RenameParams = parameters(request)?;
            let at = at(workspace, &asked.text_document_position);
            let edit = at.map(|at| edits::rename(at.read, at.rank, at.offset, &asked.new_name));
            value(edit.transpose().map_err(Refusal::failed)?)
        }
        "textDocument/codeAction" => {
            let asked: CodeActionParams = parameters(request)?;
            let text = open(workspace, &asked.text_document.uri);
            value(text.map(|(read, rank, _)| edits::actions(read, rank, &asked)))
        }
        "textDocument/semanticTokens/full" => {
            let asked: SemanticTokensParams = parameters(request)?;
            let text = open(workspace, &asked.text_document.uri);
            value(text.map(|(read, rank, file)| colours::tokens(read, rank, file)))
        }
        other => Err(Refusal::Unknown(other.to_owned())),
    }
}

fn parameters<P: DeserializeOwned>(request: Request) -> Result<P, Refusal> {
    serde_json::from_value(request.params).map_err(|error| Refusal::Parameters(error.to_string()))
}

fn value(answer: impl Serialize) -> Result<Value, Refusal> {
    serde_json::to_value(answer).map_err(Refusal::failed)
}

fn open<'a>(workspace: &'a Workspace, uri: &Uri) -> Option<(&'a Navigator, u32, &'a SourceFile)> {
    let (read, rank) = workspace.find(uri)?;
    Some((read, rank, read.analysis.sources.file(rank)?))
}

fn at<'a>(workspace: &'a Workspace, asked: &TextDocumentPositionParams) -> Option<At<'a>> {
    let (read, rank, file) = open(workspace, &asked.text_document.uri)?;
    Some(At { read, rank, file, offset: place::offset(file, asked.position) })
}

fn hover(at: &At<'_>) -> Option<Hover> {
    let (span, value) = at.read.hover(at.rank, at.offset)?;
    let contents = HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value });
    Some(Hover { contents, range: Some(place::range(at.file, span)) })
}

/// The edit that formats a text. It covers only lines that change, so that marks of the editor
/// elsewhere stay in place.
fn format(file: &SourceFile) -> Result<Vec<TextEdit>, FormatError> {
    let before: &str = file.text();
    let after = format_text(before)?;
    if after == before {
        return Ok(Vec::new());
    }
    let old: Vec<&str> = before.split_inclusive('\n').collect();
    let new: Vec<&str> = after.split_inclusive('\n').collect();
    let first = old.iter().zip(&new).take_while(|(old, new)| old == new).count();
    let (old, new) = (old.get(first..).unwrap_or_default(), new.get(first..).unwrap_or_default());
    let last = old.iter().rev().zip(new.iter().rev()).take_while(|(old, new)| old == new).count();
    let changed: usize =
        old.get(..old.len() - last).unwrap_or_default().iter().map(|line| line.len()).sum();
    let start = before.len() - old.iter().map(|line| line.len()).sum::<usize>();
    let place =
        |at: usize| -> Position { place::position(file, u32::try_from(at).unwrap_or(u32::MAX)) };
    let new_text = new.get(..new.len() - last).unwrap_or_default().concat();
    Ok(vec![TextEdit { range: Range::new(place(start), place(start + changed)), new_text }])
}
