//! Bits of nodes, and the masks of conflicting nodes.
//!
//! A node with conflicts has a bit of its own. Those without share one bit per context, which only
//! the exclusion of everything checks; async nodes without port or remote have one of their own,
//! which only a standstill checks.

use super::node::{EVERYTHING, IDLE, STANDSTILL};
use crate::plan::Nodes;

/// Set while a context waits: the fast path is closed.
pub(super) const WAITERS: u64 = 1 << 63;
/// Set while everything is excluded.
pub(super) const ALL: u64 = 1 << 62;
/// Set while all stand still.
pub(super) const STILL: u64 = 1 << 61;
/// Bits of a word that are left for nodes and contexts.
const USABLE: usize = 61;

#[derive(Debug)]
pub(super) struct Masks {
    words: usize,
    /// Word and bit of each node; `Shared` nodes use the bit of their context.
    places: Box<[Place]>,
    /// For each node, if one word is enough: bits that must be clear, and the bit to set
    /// ([`OF_CONTEXT`] for [`Place::Shared`]).
    quick: Box<[(u64, u64)]>,
    /// Word and bit of each context.
    contexts: Box<[(usize, u64)]>,
    /// For each node, `words` masks: bits that must be clear.
    needs: Box<[u64]>,
    /// Bits that must be clear to exclude everything, if one word is enough.
    everything: u64,
}

/// Stands for the bit of the context.
const OF_CONTEXT: u64 = u64::MAX;

#[derive(Clone, Copy, Debug)]
enum Place {
    Own { word: usize, bit: u64, global: bool },
    Shared,
}

impl Masks {
    pub(super) fn new(nodes: &Nodes, contexts: usize) -> Self {
        let place = |rank: usize| (rank / USABLE, 1u64 << (rank % USABLE));
        let mut next = contexts;
        let mut places = Vec::with_capacity(nodes.len());
        for node in 0..nodes.len() {
            let alone = nodes.conflicts(node).iter().all(|other| *other == node);
            let global = nodes.is_global(node);
            places.push(match (alone, global) {
                (true, true) => Place::Shared,
                // Two nodes that never run at once and have the same conflicts can share a bit.
                _ => match nodes.twin(node).and_then(|twin| places.get(twin)) {
                    Some(Place::Own { word, bit, global: its }) if *its == global => {
                        Place::Own { word: *word, bit: *bit, global }
                    }
                    _ => {
                        let (word, bit) = place(next);
                        next += 1;
                        Place::Own { word, bit, global }
                    }
                },
            });
        }
        let words = next.div_ceil(USABLE).max(1);
        let contexts: Box<[(usize, u64)]> = (0..contexts).map(place).collect();
        let mut needs = vec![0; words * nodes.len()];
        let mut everything = vec![0; words];
        everything[0] = ALL | STILL;
        for &(word, bit) in &contexts {
            everything[word] |= bit;
        }
        for (node, need) in needs.chunks_mut(words).enumerate() {
            if let Place::Own { word, bit, global: true } = places[node] {
                everything[word] |= bit;
            }
            need[0] |= if nodes.is_global(node) { ALL | STILL } else { STILL };
            for &other in nodes.conflicts(node) {
                if let Some(Place::Own { word, bit, .. }) = places.get(other) {
                    need[*word] |= bit;
                }
            }
        }
        let quick = |(node, place): (usize, &Place)| match place {
            Place::Own { bit, .. } => (needs[node * words] | WAITERS, *bit),
            Place::Shared => (needs[node * words] | WAITERS, OF_CONTEXT),
        };
        let quick = places.iter().enumerate().map(quick);
        let quick = if words == 1 { quick.collect() } else { Box::default() };
        Self {
            words,
            quick,
            places: places.into(),
            contexts,
            needs: needs.into(),
            everything: everything[0],
        }
    }

    /// Number of words for all bits.
    pub(super) fn words(&self) -> usize {
        self.words
    }

    /// The bit set while `context` runs `node`.
    pub(super) fn bit(&self, context: usize, node: u32) -> u64 {
        self.fast(context, node).map_or(0, |(_, bit)| bit)
    }

    /// The bits that must be clear and the bit to set, if one word is enough.
    #[inline]
    pub(super) fn fast(&self, context: usize, node: u32) -> Option<(u64, u64)> {
        let &(need, bit) = self.quick.get(node as usize)?;
        Some((need, if bit == OF_CONTEXT { self.contexts[context].1 } else { bit }))
    }

    /// The bits that must be clear for `node` to run, if one word is enough.
    pub(super) fn need(&self, node: u32) -> u64 {
        match node {
            EVERYTHING => return self.everything,
            STANDSTILL => return !WAITERS,
            _ => {}
        }
        self.quick.get(node as usize).map_or(0, |(need, _)| need & !WAITERS)
    }

    /// Whether two nodes exclude each other.
    pub(super) fn conflict(&self, a: u32, b: u32) -> bool {
        if a == STANDSTILL || b == STANDSTILL {
            return a != IDLE && b != IDLE;
        }
        if a == EVERYTHING || b == EVERYTHING {
            return self.is_global(a) && self.is_global(b);
        }
        match self.places.get(b as usize) {
            Some(Place::Own { word, bit, .. }) => {
                self.needs[a as usize * self.words + word] & bit != 0
            }
            _ => false,
        }
    }

    pub(super) fn is_global(&self, node: u32) -> bool {
        matches!(node, EVERYTHING | STANDSTILL)
            || match self.places.get(node as usize) {
                Some(Place::Own { global, .. }) => *global,
                Some(Place::Shared) => true,
                None => false,
            }
    }
}
