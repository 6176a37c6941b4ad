//! Where the parts of a picture are: in columns from writers to readers, and in one band for each
//! cell.
//!
//! Columns are longest paths; connections that close a circle are left out of account. Within its
//! column of its band, a node is moved towards what it is connected to (the mean of their places),
//! in a few rounds. No crate for it was found that has cells and takes a time that is bounded by a
//! polynomial: `layout-rs` looks for cycles along all paths.

use super::system::System;

/// Sizes, in pixels.
pub(crate) const ROW: f64 = 18.0;
pub(crate) const HEAD: f64 = 24.0;
pub(crate) const TITLE: f64 = 20.0;
pub(crate) const MARGIN: f64 = 16.0;
const BETWEEN_COLUMNS: f64 = 110.0;
const BETWEEN_NODES: f64 = 18.0;
const BETWEEN_SIDES: f64 = 24.0;
const LETTER: f64 = 7.3;
const NARROWEST: f64 = 90.0;
/// Rounds in which nodes are moved.
const ROUNDS: usize = 8;

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Area {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// The places of all parts.
#[derive(Debug)]
pub(crate) struct Layout {
    /// By index of the node.
    pub(crate) nodes: Vec<Area>,
    /// Titles and frames of cells.
    pub(crate) frames: Vec<(String, Area)>,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// Width of a text, approximately.
#[allow(clippy::cast_precision_loss, reason = "texts are short")]
pub(crate) fn width(text: &str) -> f64 {
    text.chars().count() as f64 * LETTER
}

impl Layout {
    pub(crate) fn of(system: &System) -> Self {
        let columns = columns(system);
        let mut nodes: Vec<Area> = system.nodes.iter().map(size).collect();
        let last = columns.iter().copied().max().unwrap_or_default();
        let mut at = MARGIN * 2.0;
        for column in 0..=last {
            let here = || (0..nodes.len()).filter(|&node| columns[node] == column);
            let widest = here().map(|node| nodes[node].width).fold(0.0, f64::max);
            for node in here().collect::<Vec<_>>() {
                nodes[node].x = at;
                nodes[node].width = widest;
            }
            at += widest + BETWEEN_COLUMNS;
        }
        let (mut frames, mut top) = (Vec::new(), MARGIN);
        for (group, members) in system.groups() {
            let title = group.title();
            let begin = top + if title.is_some() { TITLE + MARGIN / 2.0 } else { 0.0 };
            let mut stacks: Vec<Vec<usize>> = vec![Vec::new(); last + 1];
            members.iter().for_each(|&node| stacks[columns[node]].push(node));
            stacks.iter().for_each(|stack| pile(&mut nodes, stack, begin));
            for _ in 0..ROUNDS {
                for stack in &mut stacks {
                    let wanted: Vec<_> =
                        stack.iter().map(|&node| pull(system, &nodes, node)).collect();
                    let mut order: Vec<_> = stack.iter().copied().zip(wanted).collect();
                    order.sort_by(|(_, one), (_, other)| one.total_cmp(other));
                    *stack = order.into_iter().map(|(node, _)| node).collect();
                    pile(&mut nodes, stack, begin);
                }
            }
            let areas: Vec<Area> = members.iter().map(|&node| nodes[node]).collect();
            let of = |edge: fn(&Area) -> f64| areas.iter().map(edge);
            let bottom = of(|area| area.y + area.height).fold(begin, f64::max);
            if let Some(title) = title {
                let left = of(|area| area.x).fold(f64::INFINITY, f64::min) - MARGIN;
                let right = of(|area| area.x + area.width).fold(left + width(&title), f64::max);
                let area = Area {
                    x: left,
                    y: top,
                    width: right + MARGIN - left,
                    height: bottom + MARGIN - top,
                };
                frames.push((title, area));
                top = bottom + 2.0 * MARGIN + BETWEEN_NODES;
            } else {
                top = bottom + BETWEEN_NODES + MARGIN;
            }
        }
        let right = nodes.iter().map(|area| area.x + area.width).fold(0.0, f64::max);
        Self { nodes, frames, width: right + 2.0 * MARGIN, height: top }
    }

    /// Where a connection leaves a node: beside the name of its port.
    pub(crate) fn right_of(&self, (node, row): (usize, usize)) -> (f64, f64) {
        let area = self.nodes[node];
        (area.x + area.width, area.y + middle(row))
    }

    /// Where a connection enters a node.
    pub(crate) fn left_of(&self, (node, row): (usize, usize)) -> (f64, f64) {
        let area = self.nodes[node];
        (area.x, area.y + middle(row))
    }
}

/// Middle of a row, from the top of its node.
#[allow(clippy::cast_precision_loss, reason = "nodes have few rows")]
pub(crate) fn middle(row: usize) -> f64 {
    HEAD + ROW * (row as f64 + 0.5)
}

#[allow(clippy::cast_precision_loss, reason = "nodes have few rows")]
fn size(node: &super::system::Node) -> Area {
    let rows = node.left.len().max(node.right.len());
    let widest = |side: &[String]| side.iter().map(|name| width(name)).fold(0.0, f64::max);
    let sides = widest(&node.left) + widest(&node.right) + BETWEEN_SIDES;
    let note = node.note.as_deref().map_or(0.0, |note| width(note) + LETTER);
    Area {
        width: sides.max(width(&node.name) * 1.15 + note + BETWEEN_SIDES).max(NARROWEST),
        height: HEAD + ROW * rows as f64 + 6.0,
        ..Area::default()
    }
}

/// One below the other.
fn pile(nodes: &mut [Area], stack: &[usize], top: f64) {
    let mut at = top;
    for &node in stack {
        nodes[node].y = at;
        at += nodes[node].height + BETWEEN_NODES;
    }
}

/// The height to which a node is pulled: the mean of what it is connected to, or where it is.
#[allow(clippy::cast_precision_loss, reason = "nodes have few connections")]
fn pull(system: &System, nodes: &[Area], node: usize) -> f64 {
    let others = system.edges.iter().filter_map(|edge| match (edge.from.0, edge.to.0) {
        (from, to) if from == to => None,
        (from, to) if from == node => Some(nodes[to].y + middle(edge.to.1) - middle(edge.from.1)),
        (from, to) if to == node => Some(nodes[from].y + middle(edge.from.1) - middle(edge.to.1)),
        _ => None,
    });
    let (sum, count) = others.fold((0.0, 0_usize), |(sum, count), y| (sum + y, count + 1));
    if count == 0 { nodes[node].y } else { sum / count as f64 }
}

/// The column of each node: right of all that it reads, without the connections that close a circle.
fn columns(system: &System) -> Vec<usize> {
    let count = system.nodes.len();
    let mut after = vec![Vec::new(); count];
    for edge in system.edges.iter().filter(|edge| edge.from.0 != edge.to.0) {
        after[edge.from.0].push(edge.to.0);
    }
    // A walk into the depth: in the reverse of the order in which it leaves nodes, all connections
    // lead forward but those that close a circle.
    let (mut entered, mut left) = (vec![false; count], Vec::new());
    for start in 0..count {
        let mut path = Vec::new();
        if !std::mem::replace(&mut entered[start], true) {
            path.push((start, 0));
        }
        while let Some((node, next)) = path.last_mut() {
            match after[*node].get(*next) {
                Some(&to) => {
                    *next += 1;
                    if !std::mem::replace(&mut entered[to], true) {
                        path.push((to, 0));
                    }
                }
                None => {
                    left.push(*node);
                    path.pop();
                }
            }
        }
    }
    let mut rank = vec![0; count];
    left.iter().rev().enumerate().for_each(|(place, &node)| rank[node] = place);
    let mut columns = vec![0; count];
    for &node in left.iter().rev() {
        for &to in after[node].iter().filter(|&&to| rank[to] > rank[node]) {
            columns[to] = columns[to].max(columns[node] + 1);
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::super::system::tests::example;
    use super::super::system::{Edge, Node};
    use super::*;

    fn apart(one: &Area, other: &Area) -> bool {
        one.x + one.width <= other.x
            || other.x + other.width <= one.x
            || one.y + one.height <= other.y
            || other.y + other.height <= one.y
    }

    /// A hundred components in five cells, with four hundred connections at random.
    fn large() -> System {
        let mut state = 7_u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % below
        };
        let node = |number: usize| Node {
            name: format!("component_{number}"),
            cell: (!number.is_multiple_of(6)).then(|| format!("c{}", number % 6)),
            left: (0..4).map(|port| format!("in_{port}")).collect(),
            right: (0..4).map(|port| format!("out_{port}")).collect(),
            ..Node::default()
        };
        let nodes: Vec<_> = (0..100).map(node).collect();
        let edge = |_| Edge {
            from: (random(100), random(4)),
            to: (random(100), random(4)),
            backend: None,
            service: false,
            rate: None,
        };
        System { edges: (0..400).map(edge).collect(), nodes }
    }

    #[test]
    fn nothing_covers_anything_and_cells_hold_their_own_only() {
        for system in [example(), large(), System::default()] {
            let layout = Layout::of(&system);
            for (index, area) in layout.nodes.iter().enumerate() {
                assert!(area.x >= 0.0 && area.y >= 0.0 && area.x + area.width <= layout.width);
                assert!(area.y + area.height <= layout.height);
                for other in &layout.nodes[..index] {
                    assert!(apart(area, other), "{area:?} {other:?}");
                }
                let own = system.nodes[index].cell.as_ref().map(|cell| format!("cell {cell}"));
                for (title, frame) in &layout.frames {
                    assert_eq!(!apart(area, frame), own.as_ref() == Some(title), "{title}");
                }
            }
        }
    }

    #[test]
    fn readers_are_right_of_writers_except_in_circles() {
        let system = example();
        let columns = columns(&system);
        // arm reads demo and the scan; its call back to demo closes a circle.
        assert_eq!(columns, [0, 1, 0]);
    }
}
