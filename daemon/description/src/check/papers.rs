//! Turns files in the papers' dialects into ordinary components (dialects.md A and B).
//!
//! There, statements at top level belong to the one component of the file, in any order: they are
//! moved into its body, sorted so that declarations precede uses.

use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Dialect, Span};
use crate::syntax::{Body, Export, Name, Path, PropertyKind, Statement};

/// One input file.
#[derive(Default)]
struct File {
    outside: Vec<Export>,
    /// Indices of the components in the statements.
    components: Vec<usize>,
    /// Index of the last statement.
    last: usize,
}

/// Moves statements into the components that they belong to; each component gets its dialect.
pub(super) fn gather(
    statements: Vec<Statement>,
    root_of: &dyn Fn(u32) -> u32,
) -> (Vec<(Statement, Dialect)>, Diagnostics) {
    let mut files: BTreeMap<u32, File> = BTreeMap::new();
    let mut kept: Vec<Option<(Statement, Dialect)>> = Vec::with_capacity(statements.len());
    for statement in statements {
        let rank = kept.len();
        let span = match &statement {
            Statement::Outside(export) => Some(place(export)),
            Statement::Component(body) => Some(body.name.span),
            _ => None,
        };
        if let Some(span) = span {
            let file = files.entry(root_of(span.file)).or_default();
            file.last = rank;
            if matches!(statement, Statement::Component(_)) {
                file.components.push(rank);
            }
            if let Statement::Outside(export) = statement {
                file.outside.push(export);
                kept.push(None);
                continue;
            }
        }
        kept.push(Some((statement, Dialect::Current)));
    }
    let mut diagnostics = Diagnostics::default();
    let mut moved: BTreeMap<usize, Body> = BTreeMap::new();
    for file in files.into_values() {
        fold(file, &mut kept, &mut moved, &mut diagnostics);
    }
    let mut result = Vec::with_capacity(kept.len());
    // A paper's component goes after all statements, because its types may be declared anywhere.
    let mut papers = Vec::new();
    for (rank, statement) in kept.into_iter().enumerate() {
        if let Some(body) = moved.remove(&rank) {
            let dialect = dialect_of(&body);
            papers.push((Statement::Component(body), dialect));
        } else {
            result.extend(statement);
        }
    }
    result.extend(papers);
    (result, diagnostics)
}

fn fold(
    file: File,
    kept: &mut [Option<(Statement, Dialect)>],
    moved: &mut BTreeMap<usize, Body>,
    diagnostics: &mut Diagnostics,
) {
    let mut only = match (&*file.components, kept) {
        ([rank], kept) => kept.get_mut(*rank),
        _ => None,
    };
    let component = only.as_deref_mut().and_then(|slot| match slot {
        Some((Statement::Component(body), _)) if is_paper(body, !file.outside.is_empty()) => {
            Some(body)
        }
        _ => None,
    });
    let Some(body) = component else {
        if let Some(first) = file.outside.first() {
            let message = format!("{} stands outside of a component", describe(first));
            let help = match file.components.len() {
                0 => "add `component NAME {...};`, or put it into one",
                1 => "move it before the `}` of the component",
                _ => "in the papers' syntax a file holds one component",
            };
            diagnostics.push(Diagnostic::error("E0104", place(first), message).help(help));
        }
        return;
    };
    let mut exports: Vec<Export> = std::mem::take(&mut body.exports);
    exports.extend(file.outside);
    exports.sort_by_key(order);
    body.exports = exports;
    let whole = Body { name: body.name.clone(), exports: std::mem::take(&mut body.exports) };
    if let (Some(slot), [rank]) = (only, &*file.components) {
        *slot = None;
        moved.insert(*rank, whole);
    }
}

/// Whether a component is in a paper's dialect: properties with a colon, or statements outside.
fn is_paper(body: &Body, outside: bool) -> bool {
    let colon = |export: &Export| matches!(export, Export::Property(p) if p.colon.is_some());
    let plain = |export: &Export| {
        matches!(export, Export::Property(_) | Export::Idl(_) | Export::Pragma(..))
    };
    body.exports.iter().all(plain) && (outside || body.exports.iter().any(colon))
}

fn dialect_of(body: &Body) -> Dialect {
    let of_2010 = body.exports.iter().any(|export| match export {
        Export::Events(_) => true,
        Export::Property(property) => matches!(property.kind, PropertyKind::IdsType(_)),
        Export::Service(service) => service
            .properties
            .iter()
            .any(|p| matches!(p.kind, PropertyKind::Input(_) | PropertyKind::Output(_))),
        _ => false,
    });
    let of_2011 =
        body.exports.iter().any(|export| matches!(export, Export::Ids(ids) if ids.name.is_some()));
    if of_2010 && !of_2011 { Dialect::Paper2010 } else { Dialect::Paper2011 }
}

/// Sort key by which declarations precede uses.
fn order(export: &Export) -> u8 {
    match export {
        Export::Pragma(..) => 0,
        Export::Idl(_) => 1,
        Export::Property(_) => 2,
        Export::Events(_) => 3,
        Export::Ids(_) => 4,
        Export::Port(_) => 5,
        Export::Task(_) => 6,
        Export::Service(_) => 7,
    }
}

fn place(export: &Export) -> Span {
    match export {
        Export::Port(port) => port.name.span,
        Export::Task(task) => task.name.span,
        Export::Service(service) => service.name.span,
        Export::Ids(ids) => ids.span,
        Export::Events(names) => names.first().map_or(Span::default(), |name| name.span),
        Export::Property(property) => property.keyword.span,
        Export::Pragma(_, span) => *span,
        Export::Idl(_) => Span::default(),
    }
}

fn describe(export: &Export) -> String {
    match export {
        Export::Port(port) => format!("port `{}`", port.name.text),
        Export::Task(task) => format!("task `{}`", task.name.text),
        Export::Service(service) => format!("service `{}`", service.name.text),
        Export::Events(_) => "an event".to_owned(),
        _ => "the ids".to_owned(),
    }
}

/// Parses a word of a pragma as a path.
pub(super) fn path_of(text: &str, span: Span) -> Path {
    let absolute = text.starts_with("::");
    let segments = text
        .trim_start_matches("::")
        .split("::")
        .map(|segment| Name { text: segment.trim().into(), span })
        .collect();
    Path { absolute, segments, span }
}
