//! A peer that knows iceoryx2 and the C type of a port, and nothing of genomd: it follows
//! `demo/position` in shared memory until the axis is where it is expected.
//!
//! `typed-reader PREFIX ROOT GOAL`

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use std::time::Duration;

use iceoryx2::prelude::*;

/// What the description of the demo calls `::demo::state`.
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("demo::state")]
#[repr(C)]
struct State {
    position: f64,
    velocity: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [prefix, root, goal] = arguments.as_slice() else {
        println!("usage: PREFIX ROOT GOAL");
        return;
    };
    let goal: f64 = goal.parse().unwrap();
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
    config.global.set_root_path(&Path::new(root.as_bytes()).unwrap());
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap();
    let name = ServiceName::new("demo/position").unwrap();
    let port = node.service_builder(&name).publish_subscribe::<State>().open().unwrap();
    let reader = port.subscriber_builder().create().unwrap();
    println!("ready");
    let mut samples = 0;
    loop {
        while let Some(sample) = reader.receive().unwrap() {
            samples += 1;
            if sample.position == goal && sample.velocity == 0.0 {
                println!("arrived after {samples} samples");
                return;
            }
        }
        node.wait(Duration::from_millis(1)).unwrap();
    }
}
