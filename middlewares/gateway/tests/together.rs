//! What processes tell of their components reaches the middleware of a gateway together.

#![allow(clippy::unwrap_used, reason = "test code, also outside of test functions")]

use std::collections::BTreeSet;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_gateway::{Proxy, Reach, Server};
use genom_middleware::{Capabilities, Diagnosis, Health, Middleware, Part};

/// Only a failing test waits so long.
const PATIENCE: Duration = Duration::from_secs(50);

/// Has no ports, and hears how components fare.
struct Hears(Mutex<Sender<Vec<String>>>);

genom_conformance::portless!(Hears);

impl Middleware for Hears {
    fn name(&self) -> &'static str {
        "hears"
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities::NETWORK
    }

    fn takes_reports(&self) -> bool {
        true
    }

    fn diagnose(&self, parts: &[Diagnosis]) {
        let names = parts.iter().map(|part| part.instance.clone()).collect();
        let _ = self.0.lock().unwrap().send(names);
    }
}

fn told(instance: &str) -> Diagnosis {
    Diagnosis {
        instance: instance.to_owned(),
        of: Part::Task("main".to_owned()),
        health: Health::Good,
        message: "in time".to_owned(),
        values: Vec::new(),
    }
}

#[test]
fn what_processes_tell_at_about_the_same_time_is_one_message_and_each_status_is_told_once() {
    let place = tempfile::tempdir().unwrap();
    let reach = Reach::new(place.path());
    let door = reach.door("hears");
    std::fs::create_dir_all(door.parent().unwrap()).unwrap();
    let (sender, messages) = channel();
    let _gateway = Server::listen(&door, Arc::new(Hears(Mutex::new(sender)))).unwrap();
    let proxies: Vec<_> =
        (0..8).map(|_| Proxy::open("hears", Reach::new(place.path())).unwrap()).collect();
    let mut round = 0;
    // Where the machine is busy, they may not be told at about the same time.
    loop {
        round += 1;
        let mut left: BTreeSet<String> = BTreeSet::new();
        for (number, proxy) in proxies.iter().enumerate() {
            let name = format!("d{number}-{round}");
            proxy.diagnose(&[told(&name)]);
            left.insert(name);
        }
        let mut most = 0;
        while !left.is_empty() {
            let names = messages.recv_timeout(PATIENCE).unwrap();
            most = most.max(names.len());
            assert!(names.iter().all(|name| left.remove(name)), "{names:?}: one is told twice");
        }
        if most == proxies.len() {
            return;
        }
    }
}
