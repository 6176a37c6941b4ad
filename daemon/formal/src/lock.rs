//! Mutual exclusion of codels and data transfers (R5; genom3.md 4.5, 7.10).

use genom_runtime::plan::Nodes;

use crate::variant::Variant;

/// Which nodes must not be executed at the same time.
#[derive(Clone, Debug)]
pub struct Conflicts {
    rows: Vec<Box<[bool]>>,
    fair: bool,
}

impl Conflicts {
    /// The conflicts of a plan's nodes.
    #[must_use]
    pub fn new(nodes: &Nodes, variant: Option<Variant>) -> Self {
        let row = |node: usize| {
            let mut row = vec![false; nodes.len()];
            for &other in nodes.conflicts(node) {
                row[other] = true;
            }
            row.into_boxed_slice()
        };
        let fair = variant != Some(Variant::UnfairLock);
        Self { rows: (0..nodes.len()).map(row).collect(), fair }
    }

    /// Whether two nodes exclude each other.
    #[must_use]
    pub fn between(&self, a: u16, b: u16) -> bool {
        self.rows.get(usize::from(a)).and_then(|row| row.get(usize::from(b))) == Some(&true)
    }
}

/// Who executes a node, and who waits for one. A context has at most one node in all.
#[derive(Debug, Default, PartialEq, Eq, Hash)]
pub struct Lock {
    /// Contexts and the nodes that they execute, in the order of contexts.
    pub(crate) held: Vec<(u16, u16)>,
    /// Contexts and the nodes that they wait for, in order of arrival.
    pub(crate) queue: Vec<(u16, u16)>,
}

impl Lock {
    /// A context arrives at a node; returns whether it enters at once.
    pub fn enter(&mut self, conflicts: &Conflicts, context: u16, node: u16) -> bool {
        let free = self.is_free(conflicts, node, self.queue.len());
        if free {
            self.hold(context, node);
        } else {
            self.queue.push((context, node));
        }
        free
    }

    /// A context leaves its node. Those that wait are looked at in order of arrival; returns the
    /// contexts that enter.
    pub fn leave(&mut self, conflicts: &Conflicts, context: u16) -> Vec<u16> {
        self.held.retain(|(holder, _)| *holder != context);
        let (mut at, mut entered) = (0, Vec::new());
        while let Some(&(waiter, node)) = self.queue.get(at) {
            if self.is_free(conflicts, node, at) {
                self.queue.remove(at);
                self.hold(waiter, node);
                entered.push(waiter);
            } else {
                at += 1;
            }
        }
        entered
    }

    /// The node that a context executes.
    #[must_use]
    pub fn held_by(&self, context: u16) -> Option<u16> {
        let at = self.held.binary_search_by_key(&context, |(holder, _)| *holder).ok()?;
        Some(self.held[at].1)
    }

    /// The node that a context waits for.
    #[must_use]
    pub fn awaited_by(&self, context: u16) -> Option<u16> {
        self.queue.iter().find(|(waiter, _)| *waiter == context).map(|(_, node)| *node)
    }

    /// Contexts and the nodes that they execute.
    pub fn holders(&self) -> impl Iterator<Item = (u16, u16)> {
        self.held.iter().copied()
    }

    /// Whether nobody executes a conflicting node, nor waits for one among the first `ahead`.
    fn is_free(&self, conflicts: &Conflicts, node: u16, ahead: usize) -> bool {
        let ahead = if conflicts.fair { &self.queue[..ahead] } else { &[] };
        let mut others = self.held.iter().chain(ahead);
        others.all(|(_, other)| !conflicts.between(node, *other))
    }

    fn hold(&mut self, context: u16, node: u16) {
        let at = self.held.partition_point(|(holder, _)| *holder < context);
        self.held.insert(at, (context, node));
    }
}
