//! States, as bytes, with values of their clocks, as they are found.

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use crate::memory::{ENTRY, PIECE, listed};
use crate::zone::Zone;

/// Bytes that are taken for each node, with its place among those that a search has still to look
/// at, and for each state, whose list of nodes begins with four.
const NODE: usize =
    listed::<Node>() + listed::<u32>() + PIECE + 2 * listed::<((u64, u64), u32)>() + 2;
const STATE: usize = ENTRY + listed::<Vec<u32>>() + 4 * size_of::<u32>() + PIECE;

/// A state with values of its clocks.
#[derive(Debug)]
struct Node {
    /// The state, by place in the table.
    state: usize,
    zone: Zone,
    /// The node before it, and the number of the step between them.
    before: (u32, u16),
    /// Another node has all its values and more.
    covered: bool,
}

/// States with values of their clocks: none that another one includes.
#[derive(Debug, Default)]
pub struct Table {
    states: IndexSet<Box<[u8]>, FxBuildHasher>,
    nodes: Vec<Node>,
    /// Nodes of each state.
    of_state: Vec<Vec<u32>>,
    /// Memory that all takes, about.
    pub bytes: usize,
}

impl Table {
    /// Adds a node unless another one has all its values; returns its number.
    pub fn add(&mut self, state: &[u8], zone: Zone, before: (u32, u16)) -> Option<u32> {
        let place = match self.states.get_index_of(state) {
            Some(place) => place,
            None => {
                self.bytes += state.len() + STATE;
                self.of_state.push(Vec::new());
                self.states.insert_full(state.into()).0
            }
        };
        let nodes = &mut self.nodes;
        let known = &mut self.of_state[place];
        if known.iter().any(|node| nodes[*node as usize].zone.includes(&zone)) {
            return None;
        }
        known.retain(|node| {
            let node = &mut nodes[*node as usize];
            node.covered = zone.includes(&node.zone);
            !node.covered
        });
        let number = u32::try_from(nodes.len()).unwrap_or(u32::MAX);
        known.push(number);
        self.bytes += zone.bytes() + NODE;
        nodes.push(Node { state: place, zone, before, covered: false });
        Some(number)
    }

    /// The values of a node by its number, unless another one has all of them.
    #[must_use]
    pub fn zone(&self, number: u32) -> Option<&Zone> {
        self.nodes.get(number as usize).filter(|node| !node.covered).map(|node| &node.zone)
    }

    /// The state of a node.
    #[must_use]
    pub fn state(&self, number: u32) -> Option<&[u8]> {
        let node = self.nodes.get(number as usize)?;
        self.states.get_index(node.state).map(|state| &**state)
    }

    /// The node before one, and the number of the step between them.
    #[must_use]
    pub fn before(&self, number: u32) -> Option<(u32, u16)> {
        self.nodes.get(number as usize).map(|node| node.before)
    }

    /// Number of nodes, with those that others have all values of.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The states, in the order in which they were found.
    pub fn states(&self) -> impl ExactSizeIterator<Item = &[u8]> {
        self.states.iter().map(|state| &**state)
    }

    /// Number of zones: those that no other one includes.
    #[must_use]
    pub fn zones(&self) -> usize {
        self.of_state.iter().map(Vec::len).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_another_one_includes_is_not_kept() {
        let upto = |most: i64| {
            let mut zone = Zone::point(&[0]);
            zone.up();
            assert!(zone.at_most(1, most));
            zone
        };
        let mut table = Table::default();
        assert_eq!(table.add(b"a", upto(2), (0, 0)), Some(0));
        assert_eq!(table.add(b"a", upto(1), (0, 1)), None);
        assert_eq!(table.add(b"b", upto(1), (0, 2)), Some(1));
        assert_eq!(table.add(b"a", upto(3), (1, 3)), Some(2));
        assert!(table.zone(0).is_none() && table.zone(2).is_some());
        assert_eq!((table.state(2), table.before(2)), (Some(&b"a"[..]), Some((1, 3))));
        assert_eq!((table.len(), table.states().len(), table.zones()), (3, 2, 2));
    }
}
