//! A picture as Mermaid, which documents on GitHub and GitLab show.

use std::fmt::Write as _;

use super::colour;
use super::system::{System, words};

/// The system as a flowchart.
#[must_use]
pub fn mermaid(system: &System) -> String {
    let mut out = "flowchart LR\n".to_owned();
    for (number, (group, nodes)) in system.groups().into_iter().enumerate() {
        let title = group.title();
        if let Some(title) = &title {
            let _ = writeln!(out, "  subgraph g{number}[\"{}\"]", text(title));
        }
        for index in nodes {
            let node = &system.nodes[index];
            let note = node.note.as_ref().map_or_else(String::new, |note| format!(" ({note})"));
            let (open, close) = if node.foreign { ("([", "])") } else { ("[", "]") };
            let label = text(&format!("{}{note}", node.name));
            let _ = writeln!(out, "    n{index}{open}\"{label}\"{close}");
        }
        if title.is_some() {
            out.push_str("  end\n");
        }
    }
    for edge in &system.edges {
        let arrow = if edge.service { "-.->" } else { "-->" };
        let label = text(&words(system, edge));
        let _ = writeln!(out, "  n{} {arrow}|\"{label}\"| n{}", edge.from.0, edge.to.0);
    }
    for (number, edge) in system.edges.iter().enumerate() {
        let colour = colour::of(edge.backend.as_deref());
        let _ = writeln!(out, "  linkStyle {number} stroke:{colour}");
    }
    for backend in system.backends() {
        let _ = writeln!(out, "  %% {} is {}", colour::of(Some(backend)), backend);
    }
    out
}

/// A text within quotes: Mermaid takes `#CODE;` for a character.
fn text(of: &str) -> String {
    let mut out = String::new();
    for c in of.chars() {
        match c {
            '"' | '#' | '<' | '>' | '&' | '\\' | '`' => {
                let _ = write!(out, "#{};", u32::from(c));
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use expect_test::expect;

    use super::super::system::tests::example;
    use super::*;

    #[test]
    fn a_system_is_drawn_with_cells_colours_and_rates() {
        let mut system = example();
        system.nodes[2].name = "/a\"]; click n0 <b>".to_owned();
        expect![[r##"
            flowchart LR
                n0["demo"]
              subgraph g1["cell right"]
                n1["arm (down)"]
              end
                n2(["/a#34;]; click n0 #60;b#62;"])
              n0 -->|"position → goal, 200 Hz"| n1
              n2 -->|"scan"| n1
              n1 -.->|"move → goto"| n0
              linkStyle 0 stroke:#1a7f37
              linkStyle 1 stroke:#bc4c00
              linkStyle 2 stroke:#1a7f37
              %% #bc4c00 is ros2
              %% #1a7f37 is shm
        "##]]
        .assert_eq(&mermaid(&system));
    }
}
