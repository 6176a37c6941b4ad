//! Files of UPPAAL (flat system 1.6).

use std::fmt::Write as _;

/// A location.
#[derive(Default)]
pub(crate) struct Place<'t> {
    pub(crate) id: &'t str,
    pub(crate) name: &'t str,
    pub(crate) invariant: &'t str,
    /// `urgent`, `committed`, or nothing.
    pub(crate) kind: &'t str,
}

/// An edge: its labels, of which those that are empty are left out.
#[derive(Default)]
pub(crate) struct Edge<'t> {
    pub(crate) from: &'t str,
    pub(crate) to: &'t str,
    pub(crate) select: &'t str,
    pub(crate) guard: &'t str,
    pub(crate) sync: &'t str,
    pub(crate) assign: &'t str,
    pub(crate) comment: &'t str,
}

/// A text between tags.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The beginning of a file with a comment.
pub(crate) fn head(comment: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System \
         1.6//EN' 'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>\n<!-- {comment} \
         -->\n<nta>\n"
    )
}

fn labels(text: &mut String, labels: &[(&str, &str)]) {
    for (kind, label) in labels.iter().filter(|(_, label)| !label.is_empty()) {
        let _ = write!(text, "<label kind=\"{kind}\">{}</label>", escaped(label));
    }
}

pub(crate) fn place(text: &mut String, place: &Place<'_>) {
    let _ = write!(text, "<location id=\"{}\">", place.id);
    if !place.name.is_empty() {
        let _ = write!(text, "<name>{}</name>", place.name);
    }
    labels(text, &[("invariant", place.invariant)]);
    if !place.kind.is_empty() {
        let _ = write!(text, "<{}/>", place.kind);
    }
    text.push_str("</location>\n");
}

pub(crate) fn edge(text: &mut String, edge: &Edge<'_>) {
    let (from, to) = (edge.from, edge.to);
    let _ = write!(text, "<transition><source ref=\"{from}\"/><target ref=\"{to}\"/>");
    let all = [
        ("select", edge.select),
        ("guard", edge.guard),
        ("synchronisation", edge.sync),
        ("assignment", edge.assign),
        ("comments", edge.comment),
    ];
    labels(text, &all);
    text.push_str("</transition>\n");
}

/// What is asked of the model.
pub(crate) fn query(text: &mut String, formula: &str, comment: &str) {
    let (formula, comment) = (escaped(formula), escaped(comment));
    let _ =
        writeln!(text, "<query><formula>{formula}</formula><comment>{comment}</comment></query>");
}
