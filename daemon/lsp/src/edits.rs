//! Edits that an editor requests: renaming, and quick fixes.

use std::collections::HashMap;

use genom_description::diagnostic::fix;
use genom_description::model::Span;
use genom_description::source::SourceMap;
use genom_description_tools::navigate::{Navigator, RenameError};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams, Range, TextEdit, Uri,
    WorkspaceEdit,
};

use crate::{convert, place};

/// Groups edits by file.
#[allow(clippy::mutable_key_type, reason = "the protocol's type: nothing in a URI changes")]
fn workspace(edits: impl IntoIterator<Item = (Uri, TextEdit)>) -> WorkspaceEdit {
    let mut changes: HashMap<Uri, Vec<TextEdit>> = HashMap::new();
    for (uri, edit) in edits {
        let of_file = changes.entry(uri).or_default();
        // A file that is included twice yields each edit twice.
        if !of_file.contains(&edit) {
            of_file.push(edit);
        }
    }
    WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }
}

fn edit(sources: &SourceMap, span: Span, text: &str) -> Option<(Uri, TextEdit)> {
    let location = place::location(sources, span)?;
    Some((location.uri, TextEdit { range: location.range, new_text: text.to_owned() }))
}

/// Renames the symbol at a byte offset.
pub(super) fn rename(
    read: &Navigator,
    file: u32,
    offset: u32,
    to: &str,
) -> Result<WorkspaceEdit, RenameError> {
    let places = read.rename(file, offset, to)?;
    let sources = &read.analysis.sources;
    Ok(workspace(places.into_iter().filter_map(|span| edit(sources, span, to))))
}

/// Quick fixes for diagnostics in a range, where their help contains one.
pub(super) fn actions(
    read: &Navigator,
    file: u32,
    asked: &CodeActionParams,
) -> Vec<CodeActionOrCommand> {
    let sources = &read.analysis.sources;
    let Some(source) = sources.file(file) else { return Vec::new() };
    let of_file = read.analysis.diagnostics.iter().filter(|said| said.span.file == file);
    let here = of_file.filter(|said| overlap(place::range(source, said.span), asked.range));
    let action = |said| {
        let fix = fix(said, sources)?;
        let edit = workspace(edit(sources, fix.span, &fix.text));
        Some(CodeActionOrCommand::CodeAction(CodeAction {
            title: fix.title,
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: Some(vec![convert::diagnostic(said, sources)]),
            edit: Some(edit),
            is_preferred: Some(true),
            ..CodeAction::default()
        }))
    };
    here.filter_map(action).collect()
}

fn overlap(a: Range, b: Range) -> bool {
    a.start <= b.end && b.start <= a.end
}
