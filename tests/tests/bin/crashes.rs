//! Ends a daemon at every system call that touches shared memory, and prints what came of each:
//! `crashes [EVERY]` takes every EVERY-th call only.
//!
//! `crashes --peer ROLE PREFIX ROOT` is the peer that knows nothing but iceoryx2: `flow` writes
//! to itself, `follow` reads the position of the demo.

#![forbid(unsafe_code)]
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a program of the tests"
)]

use std::process::ExitCode;
use std::time::Duration;

use genom_tests::crash::{Phase, Plan, Stage};
use iceoryx2::prelude::*;

/// What the description of the demo calls `::demo::state`.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("demo::state")]
#[repr(C)]
struct State {
    position: f64,
    velocity: f64,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["--peer", "flow", prefix, root] => flow(&node(prefix, root)),
        ["--peer", "follow", prefix, root] => follow(&node(prefix, root)),
        [] => return table(1),
        [every] if every.parse().is_ok_and(|every: usize| every > 0) => {
            return table(every.parse().unwrap());
        }
        _ => {
            println!("usage: crashes [EVERY]");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn node(prefix: &str, root: &str) -> Node<ipc::Service> {
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
    config.global.set_root_path(&Path::new(root.as_bytes()).unwrap());
    // This peer cleans nothing up: it is there to be undisturbed.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap()
}

/// Writes numbers to itself, and reads each from an old and from a new connection.
fn flow(node: &Node<ipc::Service>) {
    let name = ServiceName::new("peer/flow").unwrap();
    let service = || {
        let builder = node.service_builder(&name).publish_subscribe::<u64>();
        builder.history_size(1).subscriber_max_buffer_size(16).open_or_create().unwrap()
    };
    let (mine, opened) = (service(), service());
    let writer = mine.publisher_builder().create().unwrap();
    let reader = mine.subscriber_builder().create().unwrap();
    println!("ready {} {}", node.id().value(), writer.id().value());
    let (mut lost, mut number) = (0, 0_u64);
    while node.wait(Duration::from_millis(1)).is_ok() {
        number += 1;
        let late = service().subscriber_builder().create().unwrap();
        writer.send_copy(number).unwrap();
        for reader in [&reader, &late] {
            let got = std::iter::from_fn(|| reader.receive().unwrap().map(|sample| *sample)).last();
            lost += u64::from(got != Some(number));
        }
        if number.is_multiple_of(50) {
            println!("lost {lost}");
        }
    }
    drop(opened);
}

/// Reads the demo's port as soon as it is there, and never lets it go.
fn follow(node: &Node<ipc::Service>) {
    let name = ServiceName::new("demo/position").unwrap();
    println!("ready {}", node.id().value());
    let mut reader = None;
    while node.wait(Duration::from_millis(1)).is_ok() {
        if reader.is_none()
            && let Ok(port) = node.service_builder(&name).publish_subscribe::<State>().open()
            && let Ok(subscriber) = port.subscriber_builder().create()
        {
            println!("following");
            reader = Some((subscriber, port));
        }
        if let Some((reader, _)) = &reader {
            while reader.receive().is_ok_and(|sample| sample.is_some()) {}
        }
    }
}

fn table(every: usize) -> ExitCode {
    let mut stage = Stage::new(&std::env::current_exe().unwrap());
    let (mut points, mut fine, mut slowest) = (0, 0, Duration::ZERO);
    for phase in Phase::ALL {
        let calls = stage.calls(phase).len();
        for call in (0..=calls).step_by(every) {
            let outcome = stage.run(Plan { phase, call, followed: (call / every) % 2 == 1 });
            println!("{outcome}");
            points += 1;
            fine += usize::from(outcome.is_fine());
            slowest = slowest.max(outcome.ready.unwrap_or_default());
        }
    }
    let left = stage.end();
    println!(
        "{fine} of {points} fine; slowest successor {} ms; left at the end: {left:?}",
        slowest.as_millis()
    );
    if fine == points && left.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
