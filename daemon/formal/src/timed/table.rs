//! States with values of their clocks, as they are found.

use crate::action::Action;
use crate::pack::{pack, unpacked};
use crate::state::State;
use crate::system::System;
use genom_timing::Zone;

/// States with values of their clocks: none that another one includes.
#[derive(Debug, Default)]
pub(crate) struct Table {
    known: genom_timing::Table,
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
        self.known.add(&self.packed, zone, before)
    }

    /// A node by its number, unless another one has all its values.
    pub(crate) fn get(&self, number: u32) -> Option<(State, &Zone)> {
        let zone = self.known.zone(number)?;
        Some((self.state(number)?, zone))
    }

    /// The number of what goes along with the state of a node.
    pub(crate) fn along(&self, number: u32) -> Option<u32> {
        self.known.state(number)?.last_chunk().copied().map(u32::from_le_bytes)
    }

    /// Number of nodes, with those that others have all values of.
    pub(crate) fn len(&self) -> usize {
        self.known.len()
    }

    /// Memory that all takes, about.
    pub(crate) fn bytes(&self) -> usize {
        self.known.bytes
    }

    /// The states, in the order in which they were found.
    pub(super) fn all(&self) -> impl ExactSizeIterator<Item = State> + '_ {
        self.known.states().map(unpacked)
    }

    /// Number of zones: those that no other one includes.
    pub(super) fn zones(&self) -> usize {
        self.known.zones()
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

    /// The state of a node.
    pub(crate) fn state(&self, node: u32) -> Option<State> {
        self.known.state(node).map(unpacked)
    }

    /// A run to a node: each state before it, and the step that leaves that.
    pub(crate) fn way_to(&self, system: &System, node: u32) -> Vec<(State, Action)> {
        let step = |node: &u32| {
            let (before, step) = self.known.before(*node)?;
            let from = self.state(before)?;
            let action = *system.timed(&from).get(usize::from(step))?;
            Some((from, action))
        };
        self.nodes_to(node).iter().skip(1).filter_map(step).collect()
    }

    /// The nodes of a run to a node, from the first one on.
    pub(crate) fn nodes_to(&self, node: u32) -> Vec<u32> {
        let before = |at: &u32| self.known.before(*at).filter(|_| *at > 0).map(|(at, _)| at);
        let mut nodes: Vec<u32> = std::iter::successors(Some(node), before).collect();
        nodes.reverse();
        nodes
    }
}
