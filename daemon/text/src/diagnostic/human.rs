//! Diagnostics as text for people: under the source line, or one line each.

use std::fmt::Write;
use std::ops::Range;

use annotate_snippets::{
    Annotation, AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet,
};

use super::{Diagnostic, Severity, ordered};
use crate::source::Span;
use crate::source::{SourceFile, SourceMap};

/// Marks on lines further apart are drawn in separate pictures.
const NEAR: u32 = 6;
/// Bytes of source drawn in one picture; of a longer stretch only the position is printed.
const MAX_DRAWN: usize = 4096;

/// One line per diagnostic, as editors and build tools read it:
/// `file:line:column: error: message [E0206]`.
#[must_use]
pub fn short(diagnostics: &[Diagnostic], sources: &SourceMap) -> String {
    let mut out = String::new();
    for diagnostic in ordered(diagnostics, sources) {
        let place = sources.location(diagnostic.span);
        let severity = severity_name(diagnostic.severity);
        let (path, line, column) = (place.path.display(), place.line, place.column);
        let Diagnostic { message, code, .. } = diagnostic;
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{path}:{line}:{column}: {severity}: {message} [{code}]");
    }
    out
}

/// Source lines with the diagnostics drawn under them.
#[must_use]
pub fn human(diagnostics: &[Diagnostic], sources: &SourceMap, color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut out = String::new();
    for diagnostic in ordered(diagnostics, sources) {
        if !out.is_empty() {
            out.push('\n');
        }
        out.push_str(&renderer.render(&[group(diagnostic, sources)]));
        out.push('\n');
    }
    out
}

pub(super) fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Hint => "hint",
    }
}

/// A position and the text to write under it.
struct Mark<'d> {
    span: Span,
    text: &'d str,
    primary: bool,
}

fn group<'d>(diagnostic: &'d Diagnostic, sources: &'d SourceMap) -> Group<'d> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Hint => Level::HELP.with_name(severity_name(Severity::Hint)),
    };
    let title = level.primary_title(diagnostic.message.as_str()).id(diagnostic.code);
    let expansion = sources.expansion(diagnostic.span);
    let mut marks = vec![Mark { span: diagnostic.span, text: &diagnostic.label, primary: true }];
    marks.extend(diagnostic.notes.iter().map(|(span, text)| Mark {
        span: *span,
        text,
        primary: false,
    }));
    let mut elements = pictures(&marks, sources);
    if let Some(found) = expansion {
        let definition = found.definition;
        let ours = sources.file(definition.file).is_none_or(SourceFile::is_synthetic);
        let origin = if ours {
            "predefined".to_owned()
        } else {
            format!("defined at {}", place(sources, definition))
        };
        let text = format!("in the expansion of macro `{}`, {origin}", found.name);
        elements.push(Level::NOTE.message(text).into());
    }
    let chain: Vec<_> =
        sources.include_chain(diagnostic.span).map(|at| place(sources, at)).collect();
    if !chain.is_empty() {
        let text = format!("in file included from {}", chain.join("\nincluded from "));
        elements.push(Level::NOTE.message(text).into());
    }
    if let Some(help) = &diagnostic.help {
        elements.push(Level::HELP.message(help.as_str()).into());
    }
    title.elements(elements)
}

fn place(sources: &SourceMap, span: Span) -> String {
    let place = sources.location(span);
    format!("{}:{}", place.path.display(), place.line)
}

/// The source around the marks, those near each other in one picture.
fn pictures<'d>(marks: &[Mark<'d>], sources: &'d SourceMap) -> Vec<Element<'d>> {
    let mut elements: Vec<Element<'d>> = Vec::new();
    let mut left: Vec<&Mark<'d>> = marks.iter().collect();
    while !left.is_empty() {
        let first = left.remove(0);
        let Some(file) = sources.file(first.span.file) else { continue };
        let mut lines = lines_of(file, first.span);
        let mut together = vec![first];
        // Marks are few: when a mark joins two others, all are drawn with the first.
        left.retain(|mark| {
            let other = lines_of(file, mark.span);
            let near = mark.span.file == first.span.file
                && other.start <= lines.end + NEAR
                && lines.start <= other.end + NEAR;
            if near {
                lines = lines.start.min(other.start)..lines.end.max(other.end);
                together.push(mark);
            }
            !near
        });
        elements.push(picture(file, first.span.file, &lines, &together, sources));
        let hidden = together.iter().skip(1).filter(|_| drawn(file, &lines).is_none());
        elements.extend(hidden.map(|mark| {
            Level::NOTE.message(format!("{}: {}", place(sources, mark.span), mark.text)).into()
        }));
    }
    elements
}

/// The source text of some lines, unless it is too long to draw.
fn drawn<'d>(file: &'d SourceFile, lines: &Range<u32>) -> Option<(&'d str, u32)> {
    let start = file.line_start(lines.start);
    let end = file.line_start(lines.end + 1);
    let text = file.text().get(start as usize..end as usize)?;
    (text.len() <= MAX_DRAWN).then_some((text, start))
}

fn picture<'d>(
    file: &'d SourceFile,
    rank: u32,
    lines: &Range<u32>,
    marks: &[&Mark<'d>],
    sources: &'d SourceMap,
) -> Element<'d> {
    let first = marks.first().map_or_else(Span::default, |mark| mark.span);
    let Some((text, start)) = drawn(file, lines) else {
        let place = sources.location(first);
        return Origin::path(place.path.to_string_lossy())
            .line(place.line as usize)
            .char_column(place.column as usize)
            .into();
    };
    let top = sources.location(Span { file: rank, start, end: start });
    let annotations = marks.iter().map(|mark| annotation(mark, start, text));
    Snippet::source(text)
        .path(top.path.to_string_lossy())
        .line_start(top.line as usize)
        .fold(true)
        .annotations(annotations)
        .into()
}

fn annotation<'d>(mark: &Mark<'d>, start: u32, text: &str) -> Annotation<'d> {
    let at = |offset: u32| (offset.saturating_sub(start) as usize).min(text.len());
    let kind = if mark.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
    let label = Some(mark.text).filter(|text| !text.is_empty());
    kind.span(at(mark.span.start)..at(mark.span.end)).label(label)
}

/// First and last line of a span, from 1.
fn lines_of(file: &SourceFile, span: Span) -> Range<u32> {
    let first = file.line_column(span.start).0;
    let last = file.line_column(span.end.saturating_sub(1).max(span.start)).0;
    first..last
}
