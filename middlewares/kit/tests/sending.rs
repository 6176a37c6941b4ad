//! A sending thread: what it sends, what jobs it does, and what continues when one line blocks.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use genom_kit::lines::{Line, Lines};
use genom_kit::sender::{self, Duty};

/// Limit after which a test counts as hanging.
const LONG: Duration = Duration::from_secs(60);

/// Sends the numbers it is given, and blocks at some of them.
struct Port {
    name: &'static str,
    numbers: Receiver<u32>,
    sent: Sender<(&'static str, u32)>,
    /// Numbers from this one on block until the receiver is signalled.
    gate: Option<(u32, Receiver<()>)>,
}

impl Line for Port {
    fn send(&mut self) -> bool {
        let Ok(number) = self.numbers.try_recv() else { return false };
        if let Some((first, open)) = &self.gate
            && number >= *first
        {
            let _ = open.recv();
        }
        let _ = self.sent.send((self.name, number));
        true
    }
}

#[derive(Default)]
struct Nothing(Vec<u32>);

impl Duty for Nothing {
    type Line = Port;
}

struct End {
    line: usize,
    numbers: Sender<u32>,
}

struct Bench {
    sender: sender::Sender<Nothing>,
    sent: Sender<(&'static str, u32)>,
    arrived: Receiver<(&'static str, u32)>,
}

impl Bench {
    fn new() -> Self {
        let (sent, arrived) = channel();
        let sender = sender::Sender::start("test", false, Nothing::default()).unwrap();
        Self { sender, sent, arrived }
    }

    fn port(&self, name: &'static str, gate: Option<(u32, Receiver<()>)>) -> End {
        let (numbers, given) = channel();
        let port = Port { name, numbers: given, sent: self.sent.clone(), gate };
        End { line: self.sender.orders().add(port), numbers }
    }

    fn write(&self, end: &End, number: u32) {
        end.numbers.send(number).unwrap();
        self.sender.orders().mark(end.line);
    }

    #[track_caller]
    fn arrives(&self, name: &'static str, number: u32) {
        assert_eq!(self.arrived.recv_timeout(LONG), Ok((name, number)));
    }
}

#[test]
fn messages_of_a_line_are_sent_in_order_and_a_line_that_goes_sends_its_last() {
    let bench = Bench::new();
    let port = bench.port("one", None);
    for n in 0..1000 {
        bench.write(&port, n);
    }
    (0..1000).for_each(|n| bench.arrives("one", n));
    port.numbers.send(7).unwrap();
    // The line is not marked, and yet what is left is sent.
    bench.sender.orders().remove(port.line, |_, line| drop(line));
    bench.arrives("one", 7);
    // Its number is reused.
    assert_eq!(bench.port("two", None).line, port.line);
}

#[test]
fn jobs_are_done_in_order_and_before_the_end() {
    let bench = Bench::new();
    let (told, heard) = channel();
    for n in 0..100 {
        let told = told.clone();
        bench.sender.orders().submit(move |seen: &mut Nothing, _: &Lines<Port>| {
            seen.0.push(n);
            told.send(seen.0.len()).unwrap();
        });
    }
    let orders = bench.sender.orders().clone();
    drop(bench);
    assert_eq!(heard.iter().take(100).collect::<Vec<_>>(), (1..=100).collect::<Vec<_>>());
    // The thread has ended: the job is dropped, and nobody waits for it.
    orders.finish(|_, _| panic!("there is no thread any more"));
}

#[test]
fn lines_that_wait_hold_up_no_other_and_go_on_in_order() {
    let bench = Bench::new();
    let free = bench.port("free", None);
    let gates = ["first", "second"].map(|name| {
        let (open, gate) = channel();
        (name, bench.port(name, Some((2, gate))), open)
    });
    bench.write(&free, 0);
    bench.arrives("free", 0);
    for (name, port, _) in &gates {
        bench.write(port, 1);
        bench.arrives(name, 1);
        // The sending thread, or the one that relieves it, blocks on this one.
        bench.write(port, 2);
        bench.write(port, 3);
        for n in 1..20 {
            bench.write(&free, n);
            bench.arrives("free", n);
        }
    }
    for (name, port, open) in &gates {
        bench.write(port, 4);
        (0..3).for_each(|_| open.send(()).unwrap());
        (2..5).for_each(|n| bench.arrives(name, n));
        bench.write(&free, 99);
        bench.arrives("free", 99);
    }
}

#[test]
fn a_job_that_waits_holds_up_no_line() {
    let bench = Bench::new();
    let port = bench.port("one", None);
    let (open, gate) = channel::<()>();
    let (begun, begins) = channel();
    bench.sender.orders().submit(move |_, _| {
        begun.send(()).unwrap();
        let _ = gate.recv();
    });
    begins.recv_timeout(LONG).unwrap();
    for n in 0..20 {
        bench.write(&port, n);
        bench.arrives("one", n);
    }
    let _job = bench.sender.orders().clone();
    drop(open);
    bench.sender.orders().finish(|_, _| ());
}
