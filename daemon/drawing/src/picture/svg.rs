//! A picture as SVG, for documents and browsers.

use std::fmt::Write as _;

use super::colour;
use super::layout::{Area, HEAD, Layout, MARGIN, TITLE, middle, width};
use super::system::{Edge, Node, System, hertz, words};
use crate::xml::escaped;

/// How it looks, on white and on black: colours of text and frames follow the reader's choice.
const STYLE: &str = "
  svg { background: #ffffff; color: #1f2328; }
  text { font: 12px ui-monospace, monospace; fill: currentColor; dominant-baseline: central; }
  .name { font-weight: bold; }
  .note, .title { fill: #6e7781; }
  .bad { fill: #d1242f; }
  .node { fill: #f6f8fa; stroke: #57606a; }
  .foreign { stroke-dasharray: 5 3; }
  .cell { fill: none; stroke: #6e7781; stroke-dasharray: 2 3; }
  .edge { fill: none; stroke-width: 1.6; }
  .service { stroke-dasharray: 6 4; }
  .rate { font-size: 11px; paint-order: stroke; stroke: #ffffff; stroke-width: 4px; }
  @media (prefers-color-scheme: dark) {
    svg { background: #0d1117; color: #e6edf3; }
    .node { fill: #161b22; }
    .rate { stroke: #0d1117; }
  }
";

/// Height of the line that says which colour is which middleware.
const LEGEND: f64 = 28.0;

/// The system as a drawing.
#[must_use]
pub fn svg(system: &System) -> String {
    let layout = Layout::of(system);
    let backends = system.backends();
    let legend: f64 = backends.iter().map(|name| width(name) + 44.0).sum();
    let wide = layout.width.max(legend + 2.0 * MARGIN);
    let high = layout.height + LEGEND;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide:.0}\" height=\"{high:.0}\" \
         viewBox=\"0 0 {wide:.0} {high:.0}\" role=\"img\">\n<title>Components, their ports and \
         connections</title>\n<style>{STYLE}</style>\n"
    );
    // One head of arrows a colour.
    let mut colours: Vec<_> =
        system.edges.iter().map(|edge| colour::of(edge.backend.as_deref())).collect();
    colours.sort_unstable();
    colours.dedup();
    out.push_str("<defs>\n");
    for colour in colours {
        let _ = writeln!(
            out,
            "<marker id=\"head{}\" markerWidth=\"9\" markerHeight=\"8\" refX=\"8\" refY=\"4\" \
             orient=\"auto\" markerUnits=\"userSpaceOnUse\"><path d=\"M0 0 L9 4 L0 8 Z\" \
             fill=\"{colour}\"/></marker>",
            &colour[1..]
        );
    }
    out.push_str("</defs>\n");
    for (title, area) in &layout.frames {
        rectangle(&mut out, "cell", *area, 8);
        let (x, y) = (area.x + MARGIN / 2.0, area.y + TITLE / 2.0 + 2.0);
        write_text(&mut out, "title", x, y, "start", title);
    }
    let ends = |edge: &Edge| (layout.right_of(edge.from), layout.left_of(edge.to));
    for edge in &system.edges {
        draw(&mut out, system, edge, ends(edge));
    }
    for (node, area) in system.nodes.iter().zip(&layout.nodes) {
        draw_node(&mut out, node, *area);
    }
    // Above nodes, so that each can be read.
    for edge in &system.edges {
        let Some(rate) = edge.rate else { continue };
        let ((x1, y1), (x2, y2)) = ends(edge);
        let (x, y) = ((x1 + x2) / 2.0, (y1 + y2) / 2.0);
        write_text(&mut out, "rate", x, y, "middle", &hertz(rate));
    }
    let (mut x, y) = (MARGIN, layout.height + LEGEND / 2.0);
    for backend in backends {
        let colour = colour::of(Some(backend));
        let _ =
            writeln!(out, "<path class=\"edge\" stroke=\"{colour}\" d=\"M{x:.1} {y:.1} h20\"/>");
        write_text(&mut out, "note", x + 26.0, y, "start", backend);
        x += width(backend) + 44.0;
    }
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, system: &System, edge: &Edge, ((x1, y1), (x2, y2)): Ends) {
    let colour = colour::of(edge.backend.as_deref());
    // Back to a column on the left: the curve leaves to the right and comes from the left.
    let bend = ((x2 - x1) / 2.0).abs().clamp(40.0, 160.0);
    let class = if edge.service { "edge service" } else { "edge" };
    let (from, to) = (&system.nodes[edge.from.0].name, &system.nodes[edge.to.0].name);
    let backend = edge.backend.as_deref().map_or_else(String::new, |on| format!(" ({on})"));
    let told = format!("{from} to {to}: {}{backend}", words(system, edge));
    let _ = writeln!(
        out,
        "<path class=\"{class}\" stroke=\"{colour}\" marker-end=\"url(#head{})\" d=\"M{x1:.1} \
         {y1:.1} C{:.1} {y1:.1} {:.1} {y2:.1} {x2:.1} {y2:.1}\"><title>{}</title></path>",
        &colour[1..],
        x1 + bend,
        x2 - bend,
        escaped(&told)
    );
}

type Ends = ((f64, f64), (f64, f64));

fn draw_node(out: &mut String, node: &Node, area: Area) {
    let class = if node.foreign { "node foreign" } else { "node" };
    rectangle(out, class, area, 5);
    let (left, right) = (area.x + 8.0, area.x + area.width - 8.0);
    let head = area.y + HEAD / 2.0;
    write_text(out, "name", left, head, "start", &node.name);
    if let Some(note) = &node.note {
        write_text(out, "bad", right, head, "end", note);
    }
    for (row, name) in node.left.iter().enumerate() {
        write_text(out, "port", left, area.y + middle(row), "start", name);
    }
    for (row, name) in node.right.iter().enumerate() {
        write_text(out, "port", right, area.y + middle(row), "end", name);
    }
}

fn rectangle(out: &mut String, class: &str, area: Area, round: u8) {
    let Area { x, y, width, height } = area;
    let _ = writeln!(
        out,
        "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" \
         height=\"{height:.1}\" rx=\"{round}\"/>"
    );
}

fn write_text(out: &mut String, class: &str, x: f64, y: f64, anchor: &str, text: &str) {
    let _ = writeln!(
        out,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
        escaped(text)
    );
}

#[cfg(test)]
mod tests {
    use super::super::system::tests::example;
    use super::*;

    #[test]
    fn a_system_is_drawn_with_all_its_names() {
        let drawn = svg(&example());
        for name in ["demo", "arm", "down", "position", "goal", "/front/scan", "cell right"] {
            assert!(drawn.contains(&format!(">{name}</text>")), "{name}: {drawn}");
        }
        assert!(drawn.contains(">200 Hz</text>"), "{drawn}");
        assert!(drawn.contains("<title>demo to arm: position → goal, 200 Hz (shm)</title>"));
        assert_eq!(drawn.matches("class=\"edge\" stroke=\"#1a7f37\"").count(), 2, "and legend");
        assert_eq!(drawn.matches("edge service").count(), 1);
    }

    #[test]
    fn names_are_text_and_nothing_else() {
        let mut system = example();
        system.nodes[2].name = "</text><script>alert(1)</script>&\u{1}\"".to_owned();
        let drawn = svg(&system);
        assert!(!drawn.contains("<script"), "{drawn}");
        assert!(drawn.contains("&lt;/text&gt;&lt;script&gt;"), "{drawn}");
        assert!(!drawn.contains('\u{1}'));
    }
}
