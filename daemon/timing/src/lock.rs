//! Mutual exclusion of codels and data transfers (genom3.md 4.5, 7.10).

/// Which nodes must not be executed at the same time.
#[derive(Clone, Debug)]
pub struct Conflicts {
    rows: Vec<Box<[bool]>>,
    fair: bool,
}

impl Conflicts {
    /// With a row for each node: which others it excludes. Unless it is fair, who waits is passed by
    /// those that arrive later.
    #[must_use]
    pub fn new(rows: Vec<Box<[bool]>>, fair: bool) -> Self {
        Self { rows, fair }
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
    pub held: Vec<(u16, u16)>,
    /// Contexts and the nodes that they wait for, in order of arrival.
    pub queue: Vec<(u16, u16)>,
}

impl Clone for Lock {
    fn clone(&self) -> Self {
        Self { held: self.held.clone(), queue: self.queue.clone() }
    }

    /// Into the lists that are there.
    fn clone_from(&mut self, source: &Self) {
        self.held.clone_from(&source.held);
        self.queue.clone_from(&source.queue);
    }
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

    /// When the node ends that a context executes or waits for, if each that is executed ends when
    /// `ends` says, and those that wait begin when all that are ahead of them have left, or now, and
    /// take so long as `most` says; `None` if it has no node.
    pub fn ends(
        &self,
        conflicts: &Conflicts,
        (context, now): (u16, u64),
        ends: impl Fn(u16, u16) -> u64,
        most: impl Fn(u16) -> u64,
    ) -> Option<u64> {
        if let Some(node) = self.held_by(context) {
            return Some(ends(context, node));
        }
        let held = self.held.iter().map(|(context, node)| (*node, ends(*context, *node)));
        let mut ahead: Vec<(u16, u64)> = held.collect();
        for (waiter, node) in &self.queue {
            let kept = ahead.iter().filter(|(other, _)| conflicts.between(*node, *other));
            let begins = kept.map(|(_, ends)| *ends).max().unwrap_or(now);
            let ends = begins.saturating_add(most(*node));
            if *waiter == context {
                return Some(ends);
            }
            ahead.push((*node, ends));
        }
        None
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_waits_ends_after_all_that_are_ahead_and_conflict() {
        // Node 1 conflicts with 0 and 2.
        let row = |others: &[usize]| (0..3).map(|other| others.contains(&other)).collect();
        let conflicts = Conflicts::new(vec![row(&[1]), row(&[0, 2]), row(&[1])], true);
        let mut lock = Lock::default();
        assert!(lock.enter(&conflicts, 0, 0));
        assert!(!lock.enter(&conflicts, 1, 1) && !lock.enter(&conflicts, 2, 2));
        let ends =
            |context| lock.ends(&conflicts, (context, 3), |_, _| 10, |node| 100 * u64::from(node));
        assert_eq!([ends(0), ends(1), ends(2), ends(3)], [Some(10), Some(110), Some(310), None]);
    }
}
