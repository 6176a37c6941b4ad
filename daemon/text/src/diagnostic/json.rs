//! Diagnostics as one JSON document, for editors and scripts.

use serde_json::{Value, json};

use super::human::severity_name;
use super::{Diagnostic, Rest, Severity, ordered};
use crate::source::SourceMap;
use crate::source::Span;

/// One document: `{"errors": n, "warnings": n, "diagnostics": [...]}`. The counts include
/// diagnostics that are not in the list; `"left_out"` is their number.
///
/// Lines and columns count from 1, columns in characters; an end is one past the last character.
#[must_use]
pub fn json(diagnostics: &[Diagnostic], rest: Rest, sources: &SourceMap) -> String {
    let ordered = ordered(diagnostics, sources);
    let count = |severity| ordered.iter().filter(|d| d.severity == severity).count();
    let mut document = json!({
        "errors": count(Severity::Error) + rest.errors,
        "warnings": count(Severity::Warning) + rest.warnings,
        "diagnostics": ordered.iter().map(|d| one(d, sources)).collect::<Vec<_>>(),
    });
    if let Value::Object(document) = &mut document
        && !rest.is_empty()
    {
        document.insert("left_out".to_owned(), json!(rest.errors + rest.warnings + rest.hints));
    }
    format!("{document:#}\n")
}

fn one(diagnostic: &Diagnostic, sources: &SourceMap) -> Value {
    let mut value = json!({
        "code": diagnostic.code,
        "severity": severity_name(diagnostic.severity),
        "message": diagnostic.message,
    });
    let mut add = |key: &str, part: Value| {
        if let Value::Object(object) = &mut value {
            object.insert(key.to_owned(), part);
        }
    };
    let place = place(diagnostic.span, sources);
    for key in ["file", "line", "column", "end_line", "end_column"] {
        add(key, place.get(key).cloned().unwrap_or_default());
    }
    if !diagnostic.label.is_empty() {
        add("label", json!(diagnostic.label));
    }
    let notes = diagnostic.notes.iter().map(|(span, text)| with_message(*span, text, sources));
    add("notes", notes.collect());
    let chain = sources.include_chain(diagnostic.span);
    add("included_from", chain.map(|span| self::place(span, sources)).collect());
    if let Some(expansion) = sources.expansion(diagnostic.span) {
        let mut defined = self::place(expansion.definition, sources);
        if let Value::Object(object) = &mut defined {
            object.insert("name".to_owned(), json!(expansion.name));
        }
        add("macro", defined);
    }
    add("help", json!(diagnostic.help));
    value
}

fn with_message(span: Span, text: &str, sources: &SourceMap) -> Value {
    let mut value = place(span, sources);
    if let Value::Object(object) = &mut value {
        object.insert("message".to_owned(), json!(text));
    }
    value
}

fn place(span: Span, sources: &SourceMap) -> Value {
    let (start, end) = (sources.location(span), sources.end_location(span));
    json!({
        "file": start.path.to_string_lossy(),
        "line": start.line,
        "column": start.column,
        "end_line": end.line,
        "end_column": end.column,
    })
}
