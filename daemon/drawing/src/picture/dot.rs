//! A picture as Graphviz's language.

use std::fmt::Write as _;

use super::colour;
use super::system::{System, words};

/// The system as a directed graph, one cluster a cell.
#[must_use]
pub fn dot(system: &System) -> String {
    let mut out = "digraph system {\n  rankdir = LR;\n  node [shape = box];\n".to_owned();
    for (number, (group, nodes)) in system.groups().into_iter().enumerate() {
        let title = group.title();
        if let Some(title) = &title {
            let _ = writeln!(out, "  subgraph cluster_{number} {{\n    label = {};", text(title));
        }
        for index in nodes {
            let node = &system.nodes[index];
            let note = node.note.as_ref().map_or_else(String::new, |note| format!("\n{note}"));
            let style = if node.foreign { ", style = dashed" } else { "" };
            let label = text(&format!("{}{note}", node.name));
            let _ = writeln!(out, "    n{index} [label = {label}{style}];");
        }
        if title.is_some() {
            out.push_str("  }\n");
        }
    }
    for edge in &system.edges {
        let style = if edge.service { ", style = dashed" } else { "" };
        let (colour, label) = (colour::of(edge.backend.as_deref()), text(&words(system, edge)));
        let _ = writeln!(
            out,
            "  n{} -> n{} [label = {label}, color = \"{colour}\"{style}];",
            edge.from.0, edge.to.0
        );
    }
    out.push_str("}\n");
    out
}

/// A quoted text.
fn text(of: &str) -> String {
    let mut out = "\"".to_owned();
    for c in of.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use expect_test::expect;

    use super::super::system::tests::example;
    use super::*;

    #[test]
    fn a_system_is_drawn_with_cells_and_colours() {
        let mut system = example();
        system.nodes[2].name = "/a\"\\b".to_owned();
        expect![[r##"
            digraph system {
              rankdir = LR;
              node [shape = box];
                n0 [label = "demo"];
              subgraph cluster_1 {
                label = "cell right";
                n1 [label = "arm\ndown"];
              }
                n2 [label = "/a\"\\b", style = dashed];
              n0 -> n1 [label = "position → goal, 200 Hz", color = "#1a7f37"];
              n2 -> n1 [label = "scan", color = "#bc4c00"];
              n1 -> n0 [label = "move → goto", color = "#1a7f37", style = dashed];
            }
        "##]]
        .assert_eq(&dot(&system));
    }
}
