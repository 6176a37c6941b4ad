//! The exclusion of the model is that of the runtime, with threads that wait for each other.
//!
//! One thread tells the others what to enter and when to leave, and waits until the effect is seen:
//! that a context has entered, or that it waits. So arrivals are in a known order.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use genom_formal::{Lock, Variant, conflicts as conflicts_of};
use genom_runtime::exclusion::Exclusion;
use genom_runtime::plan::Nodes;

use super::random::Random;

/// Timeout for what must happen.
const LONG: Duration = Duration::from_secs(60);
const CONTEXTS: u16 = 5;
const NODES: u16 = 8;

/// A step: a context arrives at a node, or leaves its node; and the contexts that enter by it.
struct Step {
    context: u16,
    node: Option<u16>,
    entered: BTreeSet<u16>,
}

/// A thread of a context: enters the nodes that it receives, and leaves when it receives `None`.
fn context(
    exclusion: &Exclusion,
    me: u16,
    orders: &Receiver<Option<u16>>,
    entered: &Sender<u16>,
    left: &Sender<u16>,
) {
    let mut permit = None;
    while let Ok(order) = orders.recv() {
        match order {
            Some(node) => {
                permit = Some(exclusion.enter(me.into(), node.into()));
                entered.send(me).unwrap();
            }
            None => {
                drop(permit.take());
                left.send(me).unwrap();
            }
        }
    }
}

/// Lets contexts enter and leave at random; returns the conflicts and the steps.
fn exercise(seed: u64) -> (Vec<(usize, usize)>, Vec<Step>) {
    let mut random = Random(seed);
    let node = |random: &mut Random| random.below(NODES.into());
    let pairs: Vec<(usize, usize)> =
        (0..10).map(|_| (node(&mut random), node(&mut random))).collect();
    let nodes = Nodes::of_pairs(NODES.into(), &pairs);
    let (conflicts, mut lock) = (conflicts_of(&nodes, None), Lock::default());
    let exclusion = Arc::new(Exclusion::new(&nodes, usize::from(CONTEXTS) + 1));
    let ((entered, enters), (left, leaves)) = (channel(), channel());
    let threads = (0..CONTEXTS).map(|me| {
        let (order, orders) = channel();
        let (exclusion, entered, left) = (Arc::clone(&exclusion), entered.clone(), left.clone());
        let run = move || context(&exclusion, me, &orders, &entered, &left);
        (order, std::thread::spawn(run))
    });
    let threads: Vec<_> = threads.collect();
    let mut steps = Vec::new();
    for _ in 0..60 {
        let me = u16::try_from(random.below(CONTEXTS.into())).unwrap();
        if lock.awaited_by(me).is_some() {
            continue;
        }
        let order = &threads[usize::from(me)].0;
        let (mut node, mut expected) = (None, BTreeSet::new());
        if lock.held_by(me).is_some() {
            expected.extend(lock.leave(&conflicts, me));
            order.send(None).unwrap();
            assert_eq!(leaves.recv_timeout(LONG), Ok(me));
        } else {
            // Two contexts never have one node.
            let used = |node: u16| {
                (0..CONTEXTS).any(|c| [lock.held_by(c), lock.awaited_by(c)].contains(&Some(node)))
            };
            let free: Vec<u16> = (0..NODES).filter(|node| !used(*node)).collect();
            let wanted = *random.one(&free);
            node = Some(wanted);
            order.send(node).unwrap();
            if lock.enter(&conflicts, me, wanted) {
                expected.insert(me);
            } else {
                let end = Instant::now() + LONG;
                while !exclusion.is_waiting(me.into()) {
                    assert!(Instant::now() < end, "context {me} does not wait");
                    std::thread::yield_now();
                }
            }
        }
        let entered: BTreeSet<u16> =
            expected.iter().map(|_| enters.recv_timeout(LONG).unwrap()).collect();
        assert_eq!(entered, expected, "seed {seed}");
        steps.push(Step { context: me, node, entered });
    }
    // Nobody has entered whom the model makes wait; then all leave.
    assert!(enters.try_recv().is_err(), "seed {seed}");
    while let Some(me) = (0..CONTEXTS).find(|context| lock.held_by(*context).is_some()) {
        let expected = lock.leave(&conflicts, me).len();
        threads[usize::from(me)].0.send(None).unwrap();
        assert_eq!(leaves.recv_timeout(LONG), Ok(me));
        for _ in 0..expected {
            enters.recv_timeout(LONG).unwrap();
        }
    }
    for (order, thread) in threads {
        drop(order);
        thread.join().unwrap();
    }
    (pairs, steps)
}

/// Whether a model enters the same contexts at each step.
fn follows(pairs: &[(usize, usize)], steps: &[Step], variant: Option<Variant>) -> bool {
    let nodes = Nodes::of_pairs(NODES.into(), pairs);
    let (conflicts, mut lock) = (conflicts_of(&nodes, variant), Lock::default());
    steps.iter().all(|step| {
        let entered: BTreeSet<u16> = match step.node {
            Some(node) => lock
                .enter(&conflicts, step.context, node)
                .then_some(step.context)
                .into_iter()
                .collect(),
            None => lock.leave(&conflicts, step.context).into_iter().collect(),
        };
        entered == step.entered
    })
}

#[test]
fn contexts_enter_as_the_model_says_and_not_as_one_without_order_of_arrival() {
    let mut refused = 0;
    for seed in 0..40 {
        let (pairs, steps) = exercise(seed);
        assert!(follows(&pairs, &steps, None), "seed {seed}");
        refused += usize::from(!follows(&pairs, &steps, Some(Variant::UnfairLock)));
    }
    assert!(refused > 0, "the unfair model follows all runs");
}
