//! The longest chain of nodes that wait for each other, if each context has a processor.

use std::collections::HashMap;

/// Tasks that a chain is looked for in all orders of.
const MOST_TASKS: u16 = 32;
/// Requests at the same time: chains do not look at who was in them already.
const MOST_WORKERS: usize = 3;
/// Beginnings of chains that are looked at.
const MOST: usize = 50_000;

/// What a context may execute while another one waits for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ahead {
    /// Who executes it.
    pub context: u16,
    /// What it executes.
    pub node: u16,
    /// For how long, in nanoseconds.
    pub time: u64,
}

/// Where a chain goes on: at a node, with the tasks that are in it already, and as many workers as
/// may still be.
type At = (u16, u32, usize);

/// Chains: what a node waits for ends last of all that are ahead of it, and waited before for one
/// that was ahead in turn. Each task is in a chain once, and as many workers as there are requests
/// at the same time.
pub struct Chains<'a> {
    rivals: &'a [Vec<(u16, u16)>],
    tasks: u16,
    time: &'a dyn Fn(u16, u16) -> u64,
    /// The longest chain from there, and its first link.
    known: HashMap<At, (u64, Option<(u16, u16)>)>,
}

impl<'a> Chains<'a> {
    /// With the contexts and their nodes that conflict with each node, of which the first so many are
    /// tasks; and for how long each is executed by each.
    #[must_use]
    pub fn new(
        rivals: &'a [Vec<(u16, u16)>],
        tasks: u16,
        time: &'a dyn Fn(u16, u16) -> u64,
    ) -> Self {
        Self { rivals, tasks, time, known: HashMap::new() }
    }

    /// The longest chain ahead of a node of this context; `None` if there are too many to look at.
    #[must_use]
    pub fn longest(mut self, (own, node): (u16, u16), workers: usize) -> Option<Vec<Ahead>> {
        if own >= MOST_TASKS || self.tasks > MOST_TASKS || workers > MOST_WORKERS {
            return None;
        }
        let mut at = (node, 1 << own, workers);
        self.look(at)?;
        let mut chain = Vec::new();
        while let Some((_, Some((context, node)))) = self.known.get(&at) {
            let (context, node) = (*context, *node);
            let time = (self.time)(context, node);
            if time > 0 {
                chain.push(Ahead { context, node, time });
            }
            at = self.next(at, context, node)?;
        }
        Some(chain)
    }

    fn look(&mut self, at: At) -> Option<u64> {
        if let Some((time, _)) = self.known.get(&at) {
            return Some(*time);
        }
        if self.known.len() > MOST {
            return None;
        }
        let mut best = (0, None);
        let rivals = self.rivals;
        for (context, node) in rivals.get(usize::from(at.0)).into_iter().flatten() {
            let Some(next) = self.next(at, *context, *node) else { continue };
            let time = (self.time)(*context, *node).saturating_add(self.look(next)?);
            if time > best.0 {
                best = (time, Some((*context, *node)));
            }
        }
        self.known.insert(at, best);
        Some(best.0)
    }

    /// The chain with another link, if that may be.
    fn next(&self, (_, tasks, workers): At, context: u16, node: u16) -> Option<At> {
        if context < self.tasks {
            let bit = 1u32 << context;
            (tasks & bit == 0).then_some((node, tasks | bit, workers))
        } else {
            (workers > 0).then(|| (node, tasks, workers - 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_task_is_in_a_chain_once_and_as_many_workers_as_there_are_requests() {
        // Node 0 of task 0 conflicts with 1 of task 1, that with 2 of task 2 and 3 of a worker.
        let rivals =
            vec![vec![(1, 1)], vec![(0, 0), (2, 2), (3, 3)], vec![(1, 1)], vec![(1, 1), (4, 4)]];
        let time = |_: u16, node: u16| u64::from(node);
        let chain = |workers: usize| {
            let chain = Chains::new(&rivals, 3, &time).longest((0, 0), workers).unwrap();
            chain.iter().map(|one| one.node).collect::<Vec<_>>()
        };
        assert_eq!(chain(0), [1, 2]);
        assert_eq!(chain(1), [1, 3]);
        assert_eq!(chain(2), [1, 3, 4]);
        assert!(Chains::new(&rivals, 3, &time).longest((0, 0), 4).is_none());
    }
}
