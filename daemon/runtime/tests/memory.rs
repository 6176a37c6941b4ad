//! genom3.md 7.9, 7.10: what a codel writes to memory is visible to the next one that conflicts
//! with it.
//!
//! The memory is not atomic, and only the exclusion orders the accesses: a wrong memory order in
//! the lock is a data race here, which ThreadSanitizer and Miri report (`docs/proofs.md`). Other
//! errors show in the counts.

#![allow(clippy::unwrap_used)]

use std::cell::UnsafeCell;
use std::sync::Arc;

use genom_runtime::exclusion::Exclusion;
use genom_runtime::plan::Nodes;

/// Rounds of each context; Miri is about a thousand times slower.
const ROUNDS: u64 = if cfg!(miri) { 2 } else { 400 };

/// Memory that a pair of nodes shares: words that are equal whenever no node is running.
struct Cell {
    pair: (usize, usize),
    words: UnsafeCell<[u64; 4]>,
}

struct Memory(Vec<Cell>);

// SAFETY: a cell is accessed only under a permit of one of its nodes, or of everything, and these
// exclude each other, which is what is tested here.
unsafe impl Sync for Memory {}

impl Memory {
    /// A cell for each node, and one for each pair of conflicting nodes.
    fn new(nodes: &Nodes) -> Self {
        let pairs = (0..nodes.len())
            .flat_map(|a| nodes.conflicts(a).iter().map(move |b| (a, *b)))
            .filter(|(a, b)| a <= b);
        Self(pairs.map(|pair| Cell { pair, words: UnsafeCell::new([0; 4]) }).collect())
    }

    /// Counts in the cells selected by `touches`. The caller holds the permit for them.
    fn count(&self, touches: impl Fn((usize, usize)) -> bool) {
        for cell in self.0.iter().filter(|cell| touches(cell.pair)) {
            // SAFETY: as above; the reference does not leave this loop.
            let words = unsafe { &mut *cell.words.get() };
            assert!(words.iter().all(|word| *word == words[0]), "{:?} is torn", cell.pair);
            words.iter_mut().for_each(|word| *word += 1);
        }
    }
}

/// Runs contexts that enter their nodes in turn, and one that excludes everything.
#[track_caller]
fn check(nodes: &Nodes, contexts: usize) {
    let exclusion = Exclusion::new(nodes, contexts + 1);
    let memory = Memory::new(nodes);
    std::thread::scope(|scope| {
        for context in 0..contexts {
            let (exclusion, memory) = (&exclusion, &memory);
            scope.spawn(move || {
                for _ in 0..ROUNDS {
                    for node in (context..nodes.len()).step_by(contexts) {
                        let _permit = exclusion.enter(context, node);
                        memory.count(|(a, b)| a == node || b == node);
                    }
                }
            });
        }
        scope.spawn(|| {
            for _ in 0..ROUNDS.div_ceil(4) {
                let _permit = exclusion.enter_all(contexts, None);
                memory.count(|_| true);
            }
        });
    });
    for cell in memory.0 {
        let nodes = if cell.pair.0 == cell.pair.1 { 1 } else { 2 };
        assert_eq!(
            cell.words.into_inner(),
            [nodes * ROUNDS + ROUNDS.div_ceil(4); 4],
            "{:?}",
            cell.pair
        );
    }
}

#[test]
fn what_a_codel_writes_is_seen_by_the_next_that_conflicts() {
    // One word of bits: 0 and 1 conflict with 2 and 3, and all with the last.
    let pairs = [(0, 2), (0, 3), (1, 2), (1, 3), (0, 4), (1, 4), (2, 4), (3, 4)];
    check(&Nodes::of_pairs(5, &pairs), 3);
}

#[test]
fn what_a_codel_writes_is_seen_in_components_of_many_codels() {
    // More nodes than a word has bits, so that contexts announce their nodes.
    let pairs = (0..70).step_by(2).map(|a| (a, a + 1));
    // Miri takes long to build a relation.
    let more = (0..70).filter(|_| !cfg!(miri)).map(|a| (a, (a + 35) % 70));
    let pairs: Vec<(usize, usize)> = pairs.chain(more).collect();
    check(&Nodes::of_pairs(70, &pairs), 3);
}

#[test]
fn memory_handed_on_by_the_exclusion_alone_outlives_its_writers() {
    // Values that own memory: each node frees what the previous one allocated.
    struct Text(UnsafeCell<String>);
    // SAFETY: both contexts access it only under permits of conflicting nodes.
    unsafe impl Sync for Text {}
    let nodes = Nodes::of_pairs(2, &[(0, 1)]);
    let exclusion = Exclusion::new(&nodes, 2);
    let text = Arc::new(Text(UnsafeCell::new(String::new())));
    std::thread::scope(|scope| {
        for context in 0..2 {
            let (exclusion, text) = (&exclusion, Arc::clone(&text));
            scope.spawn(move || {
                for round in 0..ROUNDS {
                    let _permit = exclusion.enter(context, context);
                    // SAFETY: as above.
                    let text = unsafe { &mut *text.0.get() };
                    assert!(text.is_empty() || text.starts_with("round"));
                    *text = format!("round {round} of {context}");
                }
            });
        }
    });
}
