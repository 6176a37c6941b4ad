//! Peers that use only iceoryx2 and the C types of ports. They run in a separate process of the
//! test program, because a peer must be another process.

use std::time::Duration;

use iceoryx2::prelude::*;

/// The type `::demo::state` of the demo's description.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("demo::state")]
#[repr(C)]
struct State {
    position: f64,
    velocity: f64,
}

/// Plays `ROLE PREFIX ROOT [GOAL]` until SIGTERM. Returns false if there is no such role.
///
/// - `flow` writes to itself, reopens its port again and again, and prints what it lost;
/// - `follow` reads the position of the demo as soon as it exists, and keeps the port open;
/// - `arrive` reads the existing position until it is GOAL and no longer changes.
#[must_use]
pub fn play(arguments: &[&str]) -> bool {
    match arguments {
        ["flow", prefix, root] => flow(&node(prefix, root)),
        ["follow", prefix, root] => follow(&node(prefix, root)),
        ["arrive", prefix, root, goal] => arrive(&node(prefix, root), goal.parse().unwrap()),
        _ => return false,
    }
    true
}

fn node(prefix: &str, root: &str) -> Node<ipc::Service> {
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
    config.global.set_root_path(&Path::new(root.as_bytes()).unwrap());
    // It must not clean up after others, so that it only shows whether it is disturbed.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap()
}

/// Numbers, each read through an old and through a new connection.
fn flow(node: &Node<ipc::Service>) {
    let name = ServiceName::new("peer/flow").unwrap();
    let service = || {
        let builder = node.service_builder(&name).publish_subscribe::<u64>();
        builder.history_size(1).subscriber_max_buffer_size(16).open_or_create().unwrap()
    };
    let (mine, opened) = (service(), service());
    let writer = mine.publisher_builder().create().unwrap();
    let reader = mine.subscriber_builder().create().unwrap();
    say(&format!("ready {} {}", node.id().value(), writer.id().value()));
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
            say(&format!("lost {lost}"));
        }
    }
    drop(opened);
}

fn follow(node: &Node<ipc::Service>) {
    let name = ServiceName::new("demo/position").unwrap();
    say(&format!("ready {}", node.id().value()));
    let mut reader = None;
    while node.wait(Duration::from_millis(1)).is_ok() {
        if reader.is_none()
            && let Ok(port) = node.service_builder(&name).publish_subscribe::<State>().open()
            && let Ok(subscriber) = port.subscriber_builder().create()
        {
            say("following");
            reader = Some((subscriber, port));
        }
        if let Some((reader, _)) = &reader {
            while reader.receive().is_ok_and(|sample| sample.is_some()) {}
        }
    }
}

fn arrive(node: &Node<ipc::Service>, goal: f64) {
    let name = ServiceName::new("demo/position").unwrap();
    let port = node.service_builder(&name).publish_subscribe::<State>().open().unwrap();
    let reader = port.subscriber_builder().create().unwrap();
    say(&format!("ready {}", node.id().value()));
    let mut samples = 0;
    while node.wait(Duration::from_millis(1)).is_ok() {
        while let Some(sample) = reader.receive().unwrap() {
            samples += 1;
            if sample.position == goal && sample.velocity == 0.0 {
                return say(&format!("arrived after {samples} samples"));
            }
        }
    }
}

/// Prints a line, by which it informs the test.
#[allow(clippy::print_stdout, reason = "a program of the tests")]
fn say(line: &str) {
    println!("{line}");
}
