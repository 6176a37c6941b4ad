//! Converts diagnostics, completions and outlines to the types of the protocol.

use genom_description::diagnostic::{Diagnostic, Severity};
use genom_description::source::{SourceFile, SourceMap};
use genom_description_tools::navigate::{Completion, CompletionKind, Outline, SymbolKind};
use lsp_types::{
    CompletionItem, CompletionItemKind, DiagnosticRelatedInformation, DiagnosticSeverity,
    DocumentSymbol, Documentation, MarkupContent, MarkupKind, NumberOrString, Range,
    SymbolKind as Shown,
};

use crate::place;

pub(super) fn diagnostic(said: &Diagnostic, sources: &SourceMap) -> lsp_types::Diagnostic {
    let file = sources.file(said.span.file).filter(|file| !file.is_synthetic());
    let mut message = said.message.clone();
    if !said.label.is_empty() {
        message.push_str(&format!("\n{}", said.label));
    }
    if let Some(help) = &said.help {
        message.push_str(&format!("\nhelp: {help}"));
    }
    let notes = said.notes.iter().filter_map(|(span, message)| {
        let location = place::location(sources, *span)?;
        Some(DiagnosticRelatedInformation { location, message: message.clone() })
    });
    let notes: Vec<_> = notes.collect();
    lsp_types::Diagnostic {
        range: file.map_or_else(Range::default, |file| place::range(file, said.span)),
        severity: Some(match said.severity {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
            Severity::Hint => DiagnosticSeverity::HINT,
        }),
        code: Some(NumberOrString::String(said.code.to_owned())),
        source: Some("genom".to_owned()),
        message,
        related_information: (!notes.is_empty()).then_some(notes),
        ..lsp_types::Diagnostic::default()
    }
}

/// What `genomctl verify` would find, by the name of its property.
pub(super) fn hint(hint: &genom_formal::Hint, sources: &SourceMap) -> lsp_types::Diagnostic {
    let at = hint.span.and_then(|span| Some((span, sources.file(span.file)?)));
    let at = at.filter(|(_, file)| !file.is_synthetic());
    lsp_types::Diagnostic {
        range: at.map_or_else(Range::default, |(span, file)| place::range(file, span)),
        severity: Some(DiagnosticSeverity::HINT),
        code: Some(NumberOrString::String(hint.property.to_owned())),
        source: Some("genomctl verify".to_owned()),
        message: hint.what.clone(),
        ..lsp_types::Diagnostic::default()
    }
}

pub(super) fn completion(found: Completion) -> CompletionItem {
    let text = |value| MarkupContent { kind: MarkupKind::PlainText, value };
    CompletionItem {
        kind: Some(match found.kind {
            CompletionKind::Keyword => CompletionItemKind::KEYWORD,
            CompletionKind::Symbol(kind) => item_kind(kind),
        }),
        detail: (!found.detail.is_empty()).then_some(found.detail),
        documentation: found.doc.map(|doc| Documentation::MarkupContent(text(doc))),
        label: found.label,
        ..CompletionItem::default()
    }
}

fn item_kind(kind: SymbolKind) -> CompletionItemKind {
    use SymbolKind as K;
    match kind {
        K::Root | K::Module => CompletionItemKind::MODULE,
        K::Component => CompletionItemKind::CLASS,
        K::Interface => CompletionItemKind::INTERFACE,
        K::Struct | K::Union | K::Typedef | K::Native | K::Exception => CompletionItemKind::STRUCT,
        K::Enum => CompletionItemKind::ENUM,
        K::Enumerator => CompletionItemKind::ENUM_MEMBER,
        K::Constant => CompletionItemKind::CONSTANT,
        K::Member | K::Ids => CompletionItemKind::FIELD,
        K::Task => CompletionItemKind::UNIT,
        K::Port => CompletionItemKind::PROPERTY,
        K::Attribute | K::Function | K::Activity | K::Service => CompletionItemKind::METHOD,
        K::Parameter | K::Local => CompletionItemKind::VARIABLE,
        K::Codel => CompletionItemKind::FUNCTION,
        K::State | K::Event => CompletionItemKind::EVENT,
    }
}

fn shown_kind(kind: SymbolKind) -> Shown {
    use SymbolKind as K;
    match kind {
        K::Root | K::Module => Shown::MODULE,
        K::Component => Shown::CLASS,
        K::Interface => Shown::INTERFACE,
        K::Struct | K::Union | K::Typedef | K::Native | K::Exception => Shown::STRUCT,
        K::Enum => Shown::ENUM,
        K::Enumerator => Shown::ENUM_MEMBER,
        K::Constant => Shown::CONSTANT,
        K::Member => Shown::FIELD,
        K::Ids => Shown::OBJECT,
        K::Task => Shown::NAMESPACE,
        K::Port => Shown::PROPERTY,
        K::Attribute | K::Function | K::Activity | K::Service => Shown::METHOD,
        K::Parameter | K::Local => Shown::VARIABLE,
        K::Codel => Shown::FUNCTION,
        K::State | K::Event => Shown::EVENT,
    }
}

pub(super) fn outline(one: &Outline<'_>, file: &SourceFile) -> DocumentSymbol {
    let children: Vec<_> = one.children.iter().map(|child| outline(child, file)).collect();
    #[allow(deprecated, reason = "the protocol's type has a field that must be given")]
    DocumentSymbol {
        name: one.symbol.name.to_string(),
        detail: None,
        kind: shown_kind(one.symbol.kind),
        tags: None,
        deprecated: None,
        range: place::range(file, one.symbol.extent),
        selection_range: place::range(file, one.symbol.span),
        children: (!children.is_empty()).then_some(children),
    }
}
