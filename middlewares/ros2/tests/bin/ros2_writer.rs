//! Writes demo/position on ROS 2 until it is killed: the peer of tests.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "part of a test")]

use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use genom_middleware::conformance::samples::{numbered, state};
use genom_middleware::{Address, Middleware};
use genom_ros2::{Options, Ros2};

/// Called with the domain: writes 9 once. With `flow`: numbers from 1, every millisecond, and in
/// the end says how many of them never left. Ends with its standard input.
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let domain = arguments[0].parse().unwrap();
    let ros2 = Ros2::open(&Options { domain, ..Options::default() }).unwrap();
    let mut writer = ros2.publisher(&Address::new("demo", "position"), &state()).unwrap();
    let end = || _ = std::io::stdin().read_to_end(&mut Vec::new());
    if arguments.len() == 1 {
        writer.publish(&numbered(9)).unwrap();
        return end();
    }
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            end();
            ended.store(true, Ordering::Relaxed);
        });
        let mut number = 0;
        while !ended.load(Ordering::Relaxed) {
            number += 1;
            writer.publish(&numbered(number)).unwrap();
            thread::park_timeout(Duration::from_millis(1));
        }
        println!("{} of {number} never left", writer.dropped());
    });
}
