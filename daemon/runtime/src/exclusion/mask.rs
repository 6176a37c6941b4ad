//! Bits of nodes, and the masks that say who is in whose way.
//!
//! A node with conflicts has a bit of its own. Those without share one bit per context, which
//! only the exclusion of everything looks at; async ones that nothing can disturb have none.

use super::EVERYTHING;
use crate::plan::Nodes;

/// In the first word: somebody waits, so the fast path is closed.
pub(super) const WAITERS: u64 = 1 << 63;
/// In the first word: everything is excluded.
pub(super) const ALL: u64 = 1 << 62;
/// Bits of the first word for nodes and contexts; later words have as many, for simplicity.
const USABLE: usize = 62;

#[derive(Debug)]
pub(super) struct Masks {
    words: usize,
    /// By node: word and bit; `Shared` nodes take their context's.
    places: Box<[Place]>,
    /// By node, when one word holds all: what must be clear, and what to set (nothing for
    /// [`Place::None`], [`OF_CONTEXT`] for [`Place::Shared`]).
    quick: Box<[(u64, u64)]>,
    /// Word and bit of each context.
    contexts: Box<[(usize, u64)]>,
    /// By node, `words` each: what must not be set.
    needs: Box<[u64]>,
    /// What must not be set when everything is excluded.
    everything: Box<[u64]>,
}

/// Stands for the bit of the context.
const OF_CONTEXT: u64 = u64::MAX;

#[derive(Clone, Copy, Debug)]
enum Place {
    Own { word: usize, bit: u64, global: bool },
    Shared,
    None,
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
                (true, false) => Place::None,
                // Two that never run at once and exclude the same need one bit.
                (false, _) => match nodes.twin(node).and_then(|twin| places.get(twin)) {
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
        everything[0] = ALL;
        for &(word, bit) in &contexts {
            everything[word] |= bit;
        }
        for (node, need) in needs.chunks_mut(words).enumerate() {
            if let Place::Own { word, bit, global: true } = places[node] {
                everything[word] |= bit;
            }
            if nodes.is_global(node) {
                need[0] |= ALL;
            }
            for &other in nodes.conflicts(node) {
                if let Some(Place::Own { word, bit, .. }) = places.get(other) {
                    need[*word] |= bit;
                }
            }
        }
        let quick = |(node, place): (usize, &Place)| match place {
            Place::Own { bit, .. } => (needs[node * words] | WAITERS, *bit),
            Place::Shared => (needs[node * words] | WAITERS, OF_CONTEXT),
            Place::None => (0, 0),
        };
        let quick = places.iter().enumerate().map(quick);
        let quick = if words == 1 { quick.collect() } else { Box::default() };
        Self {
            words,
            quick,
            places: places.into(),
            contexts,
            needs: needs.into(),
            everything: everything.into(),
        }
    }

    pub(super) fn words(&self) -> usize {
        self.words
    }

    /// Word and bit that say that `context` runs `node`; no bit for nodes nobody waits for.
    #[inline]
    pub(super) fn bit(&self, context: usize, node: u32) -> (usize, u64) {
        match self.places.get(node as usize) {
            Some(Place::Own { word, bit, .. }) => (*word, *bit),
            Some(Place::Shared) => self.contexts[context],
            Some(Place::None) | None => (0, 0),
        }
    }

    /// What must be clear and what to set, when all fits in one word; nothing to set for nodes
    /// that nobody waits for.
    #[inline]
    pub(super) fn fast(&self, context: usize, node: u32) -> Option<(u64, u64)> {
        let &(need, bit) = self.quick.get(node as usize)?;
        Some((need, if bit == OF_CONTEXT { self.contexts[context].1 } else { bit }))
    }

    /// By word: what must be clear for `node` to run.
    pub(super) fn need(&self, node: u32) -> impl Iterator<Item = u64> + '_ {
        let from = node as usize * self.words;
        let need = if node == EVERYTHING {
            &self.everything[..]
        } else {
            self.needs.get(from..from + self.words).unwrap_or_default()
        };
        need.iter().copied()
    }

    /// Whether two nodes exclude each other.
    pub(super) fn conflict(&self, a: u32, b: u32) -> bool {
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

    fn is_global(&self, node: u32) -> bool {
        node == EVERYTHING
            || match self.places.get(node as usize) {
                Some(Place::Own { global, .. }) => *global,
                Some(Place::Shared) => true,
                Some(Place::None) | None => false,
            }
    }
}
