//! genom3.md 4.5 and 7.10: conflicting nodes never overlap, and every node gets its turn.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use genom_description::model::Node;
use genom_runtime::Plan;
use genom_runtime::exclusion::Exclusion;
use genom_runtime::plan::Nodes;
use proptest::prelude::*;

/// Fails the test when `work` does not end in time.
#[track_caller]
fn within<R: Send + 'static>(seconds: u64, work: impl FnOnce() -> R + Send + 'static) -> R {
    let (done, ended) = mpsc::channel();
    let thread = std::thread::spawn(move || done.send(work()));
    match ended.recv_timeout(Duration::from_secs(seconds)) {
        Ok(result) => {
            let _ = thread.join();
            result
        }
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("still not done after {seconds} s"),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("failed"),
    }
}

/// The nodes that run now, as reported by each thread; counts overlaps of conflicting ones.
struct Checker {
    nodes: Nodes,
    inside: Vec<AtomicBool>,
    everything: AtomicBool,
    overlaps: AtomicUsize,
    entered: Vec<AtomicU64>,
}

impl Checker {
    fn new(nodes: Nodes) -> Self {
        Self {
            inside: (0..nodes.len()).map(|_| AtomicBool::new(false)).collect(),
            entered: (0..nodes.len()).map(|_| AtomicU64::new(0)).collect(),
            everything: AtomicBool::new(false),
            overlaps: AtomicUsize::new(0),
            nodes,
        }
    }

    /// Called while the node is held.
    fn run(&self, node: usize, spin: u32) {
        if self.inside[node].swap(true, Ordering::SeqCst) {
            self.overlaps.fetch_add(1, Ordering::SeqCst);
        }
        let look = || {
            let others = self.nodes.conflicts(node).iter().filter(|other| **other != node);
            let overlap = others.filter(|other| self.inside[**other].load(Ordering::SeqCst));
            let all = self.everything.load(Ordering::SeqCst) && self.nodes.is_global(node);
            self.overlaps.fetch_add(overlap.count() + usize::from(all), Ordering::SeqCst);
        };
        look();
        (0..spin).for_each(|_| std::hint::spin_loop());
        if spin.is_multiple_of(3) {
            // Yields the processor inside, as a preempted thread does.
            std::thread::yield_now();
        }
        look();
        self.entered[node].fetch_add(1, Ordering::SeqCst);
        self.inside[node].store(false, Ordering::SeqCst);
    }

    fn run_all(&self) {
        self.everything.store(true, Ordering::SeqCst);
        let running = (0..self.nodes.len()).filter(|node| {
            self.nodes.is_global(*node) && self.inside[*node].load(Ordering::SeqCst)
        });
        self.overlaps.fetch_add(running.count(), Ordering::SeqCst);
        std::thread::yield_now();
        self.everything.store(false, Ordering::SeqCst);
    }
}

/// Contexts that each enter their own nodes over and over.
fn exercise(nodes: Nodes, contexts: usize, rounds: u32, with_all: bool) -> Arc<Checker> {
    let exclusion = Arc::new(Exclusion::new(&nodes, contexts + 1));
    let checker = Arc::new(Checker::new(nodes));
    let mut threads = Vec::new();
    for context in 0..contexts {
        let (exclusion, checker) = (Arc::clone(&exclusion), Arc::clone(&checker));
        threads.push(std::thread::spawn(move || {
            let mine: Vec<usize> =
                (0..checker.nodes.len()).filter(|node| node % contexts == context).collect();
            for round in 0..rounds {
                for &node in &mine {
                    let _permit = exclusion.enter(context, node);
                    checker.run(node, (round * 7 + u32::try_from(node).unwrap() * 13) % 50);
                }
            }
        }));
    }
    if with_all {
        let (exclusion, checker) = (Arc::clone(&exclusion), Arc::clone(&checker));
        threads.push(std::thread::spawn(move || {
            for _ in 0..rounds / 4 {
                let _permit = exclusion.enter_all(contexts, None);
                checker.run_all();
            }
        }));
    }
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    checker
}

#[track_caller]
fn check(nodes: Nodes, contexts: usize, rounds: u32, with_all: bool) {
    let checker = within(60, move || exercise(nodes, contexts, rounds, with_all));
    assert_eq!(checker.overlaps.load(Ordering::SeqCst), 0);
    for entered in &checker.entered {
        assert_eq!(entered.load(Ordering::SeqCst), u64::from(rounds));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..Default::default() })]

    // genom3.md 7.10. Each case has thousands of entries, in an order that the scheduler
    // determines.
    #[test]
    fn conflicting_nodes_never_overlap_and_every_node_gets_its_turns(
        count in 2usize..24,
        seeds in proptest::collection::vec((0usize..24, 0usize..24), 0..60),
        contexts in 2usize..6,
        with_all: bool,
        many: bool,
    ) {
        // With many more nodes, contexts announce nodes instead of setting bits.
        let count = if many { count + 70 } else { count };
        let chain = (24..count.max(25) - 1).map(|node| (node, node + 1));
        let pairs: Vec<(usize, usize)> =
            seeds.iter().map(|(a, b)| (a % count, b % count)).chain(chain).collect();
        check(Nodes::of_pairs(count, &pairs), contexts, if many { 25 } else { 100 }, with_all);
    }
}

#[test]
fn more_nodes_than_bits_of_a_word_exclude_each_other_as_well() {
    let pairs: Vec<(usize, usize)> =
        (0..150).flat_map(|a| [(a, (a + 1) % 150), (a, (a * 7 + 3) % 150)]).collect();
    check(Nodes::of_pairs(150, &pairs), 4, 20, true);
}

#[test]
fn a_context_that_never_pauses_does_not_starve_another() {
    // Two conflicting nodes; one thread holds its own nearly all the time.
    let nodes = Nodes::of_pairs(2, &[(0, 1)]);
    within(60, move || {
        let exclusion = Arc::new(Exclusion::new(&nodes, 2));
        let stop = Arc::new(AtomicBool::new(false));
        let (began, begins) = mpsc::channel();
        let greedy = {
            let (exclusion, stop) = (Arc::clone(&exclusion), Arc::clone(&stop));
            std::thread::spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let _permit = exclusion.enter(0, 0);
                    let _ = began.send(());
                    (0..200).for_each(|_| std::hint::spin_loop());
                }
            })
        };
        begins.recv().unwrap();
        for _ in 0..1000 {
            drop(exclusion.enter(1, 1));
        }
        stop.store(true, Ordering::Relaxed);
        greedy.join().unwrap();
    });
}

#[test]
fn those_that_conflict_are_served_in_order_of_arrival() {
    // All nodes conflict; 0 is held while 1, 2 and 3 arrive one after the other.
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let nodes = Nodes::of_pairs(4, &pairs);
    let order = within(60, move || {
        let exclusion = Arc::new(Exclusion::new(&nodes, 4));
        let held = exclusion.enter(0, 0);
        let (sender, order) = mpsc::channel();
        let mut threads = Vec::new();
        for context in 1..4 {
            let (theirs, sender) = (Arc::clone(&exclusion), sender.clone());
            threads.push(std::thread::spawn(move || {
                let permit = theirs.enter(context, context);
                assert!(permit.waited());
                sender.send(context).unwrap();
            }));
            while !exclusion.is_waiting(context) {
                std::thread::yield_now();
            }
        }
        drop(held);
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        order.try_iter().collect::<Vec<_>>()
    });
    assert_eq!(order, [1, 2, 3]);
}

#[test]
fn those_that_conflict_with_nobody_pass_while_others_wait() {
    let nodes = Nodes::of_pairs(3, &[(0, 1)]);
    within(60, move || {
        let exclusion = Arc::new(Exclusion::new(&nodes, 3));
        let held = exclusion.enter(0, 0);
        let waiting = {
            let exclusion = Arc::clone(&exclusion);
            std::thread::spawn(move || drop(exclusion.enter(1, 1)))
        };
        while !exclusion.is_waiting(1) {
            std::thread::yield_now();
        }
        // Would hang if it queued behind context 1.
        assert!(!exclusion.enter(2, 2).waited());
        drop(held);
        waiting.join().unwrap();
    });
}

#[test]
fn the_example_of_4_5_gives_the_table_printed_there() {
    let plan = support::plan(
        "component m {
           ids { long a, b; };
           attribute set_a(in a);
           attribute get_a(out a);
           function f1() { codel c1(in a, out b); };
           function f2() { codel c2(in b, out a); };
           task t { codel<start> c3(in a) yield main; codel<main> c4(in b) yield stop;
                    codel<stop> c5() yield ether; };
           activity a1() { task t; codel<start> c6(in a, out b) yield main;
                           codel<main> c7(in b, out a) yield ether; };
         };",
    );
    let expected = [
        ("c1", "c4 c6 c7"),
        ("c2", "c3 c6 c7"),
        ("c3", "set_a c2"),
        ("c4", "c1"),
        ("c5", ""),
        ("c6", "set_a c1 c2"),
        ("c7", "set_a get_a c1 c2"),
        ("set_a", "c3 c6 c7"),
        ("get_a", "c7"),
    ];
    // The model assumes one control context, whose nodes do not exclude each other.
    let control = ["c1", "c2", "set_a", "get_a"];
    for (node, with) in expected {
        let both_control = |other: &str| control.contains(&node) && control.contains(&other);
        let mut found: Vec<String> =
            with_names(&plan, node).into_iter().filter(|other| !both_control(other)).collect();
        let mut wanted: Vec<&str> = with.split_whitespace().collect();
        found.sort();
        wanted.sort_unstable();
        assert_eq!(found, wanted, "{node}");
    }
    // Requests are served in parallel here, so these are excluded as well.
    assert!(with_names(&plan, "c1").contains(&"c2".to_owned()));
    assert!(with_names(&plan, "set_a").contains(&"get_a".to_owned()));
    assert!(with_names(&plan, "c1").contains(&"set_a".to_owned()));
    // No conflict: `f1` reads what `get_a` reads.
    assert!(!with_names(&plan, "c1").contains(&"get_a".to_owned()));
}

/// Names of the nodes that conflict with a codel or an attribute, except itself.
fn with_names(plan: &Plan, node: &str) -> Vec<String> {
    let model = plan.component();
    let name = |rank: usize| match model.node(rank) {
        Node::Codel(codel) => model.codels[codel].name.clone(),
        Node::Transfer(service) => model.services[service].name.clone(),
    };
    let rank = (0..plan.nodes().len()).find(|rank| name(*rank) == node).unwrap();
    let others = plan.nodes().conflicts(rank).iter().filter(|other| **other != rank);
    others.map(|other| name(*other)).collect()
}
