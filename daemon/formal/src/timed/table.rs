//! States with values of their clocks, as they are found.

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use crate::action::Action;
use crate::memory::{ENTRY, PIECE, listed};
use crate::pack::{pack, unpacked};
use crate::state::State;
use crate::system::System;
use genom_timing::Zone;

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
pub(crate) struct Table {
    states: IndexSet<Box<[u8]>, FxBuildHasher>,
    nodes: Vec<Node>,
    /// Nodes of each state.
    of_state: Vec<Vec<u32>>,
    /// Memory that all takes, about.
    pub(crate) bytes: usize,
    /// A state as bytes, while it is looked up.
    packed: Vec<u8>,
}

impl Table {
    /// Adds a node unless another one has all its values; returns its number.
    pub(super) fn add(&mut self, state: &State, zone: Zone, before: (u32, u16)) -> Option<u32> {
        self.add_with(state, None, zone, before)
    }

    /// The same, of a state with the number of what goes along with it.
    pub(crate) fn add_with(
        &mut self,
        state: &State,
        along: Option<u32>,
        zone: Zone,
        before: (u32, u16),
    ) -> Option<u32> {
        pack(state, &mut self.packed);
        self.packed.extend(along.into_iter().flat_map(u32::to_le_bytes));
        let place = match self.states.get_index_of(self.packed.as_slice()) {
            Some(place) => place,
            None => {
                self.bytes += self.packed.len() + STATE;
                self.of_state.push(Vec::new());
                self.states.insert_full(self.packed.as_slice().into()).0
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

    /// A node by its number, unless another one has all its values.
    pub(crate) fn get(&self, number: u32) -> Option<(State, &Zone)> {
        let node = self.nodes.get(number as usize).filter(|node| !node.covered)?;
        Some((unpacked(self.states.get_index(node.state)?), &node.zone))
    }

    /// The number of what goes along with the state of a node.
    pub(crate) fn along(&self, number: u32) -> Option<u32> {
        let node = self.nodes.get(number as usize)?;
        self.states.get_index(node.state)?.last_chunk().copied().map(u32::from_le_bytes)
    }

    /// Number of nodes, with those that others have all values of.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Number of states, without values of clocks.
    pub(super) fn states(&self) -> usize {
        self.states.len()
    }

    /// The states, in the order in which they were found.
    pub(super) fn all(&self) -> impl Iterator<Item = State> + '_ {
        self.states.iter().map(|bytes| unpacked(bytes))
    }

    /// Number of zones: those that no other one includes.
    pub(super) fn zones(&self) -> usize {
        self.of_state.iter().map(Vec::len).sum()
    }

    /// A run to a node and a step from there: each state, and the step that leaves it.
    pub(crate) fn run_to(
        &self,
        system: &System,
        (node, action): (u32, Action),
    ) -> Vec<(State, Action)> {
        let mut steps = self.way_to(system, node);
        steps.extend(self.state(node).map(|state| (state, action)));
        steps
    }

    fn state(&self, node: u32) -> Option<State> {
        let node = self.nodes.get(node as usize)?;
        self.states.get_index(node.state).map(|bytes| unpacked(bytes))
    }

    /// A run to a node: each state before it, and the step that leaves that.
    pub(crate) fn way_to(&self, system: &System, node: u32) -> Vec<(State, Action)> {
        let (mut steps, mut at) = (Vec::new(), node);
        while at > 0 {
            let Some(node) = self.nodes.get(at as usize) else { break };
            let (before, step) = node.before;
            let Some(from) = self.state(before) else { break };
            if let Some(action) = system.timed(&from).get(usize::from(step)) {
                steps.push((from, *action));
            }
            at = before;
        }
        steps.reverse();
        steps
    }
}
