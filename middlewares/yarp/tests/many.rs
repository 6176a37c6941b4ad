//! Ports and services of 1 and 50 components on YARP, opened as a library is: all of them work,
//! and closing them leaves no descriptor, no thread and no name behind.

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "test code outside of test functions, which prints its times"
)]

mod world;

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_conformance::process::{resident, used};
use genom_conformance::samples::{number, numbered, state};
use genom_conformance::{World as _, eventually};
use genom_middleware::{
    ActivityId, Address, Middleware, Outcome, Policy, PortSpec, Reading, Replies, ServiceHandler,
    ServiceKind, ServiceType,
};
use genom_plugin::abi::Plugin;
use genom_plugin_host::Library;
use genom_types::Record;
use genom_yarp::Yarp;
use world::Place;

static TABLE: Plugin = genom_plugin::table::<Yarp>("yarp");

fn open(place: &Place) -> Arc<dyn Middleware> {
    let options = serde_json::json!({"server": place.options().server}).to_string();
    let library = Library::built_in(&TABLE).expect("a table");
    library.middleware(&options).expect("it opens")
}

struct Echo;

impl ServiceHandler for Echo {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        replies.finish(Outcome::Success(input));
    }

    fn cancel(&self, _: ActivityId) {}
}

/// An out port, an in port that reads it, a service and a call of it for each component.
fn round(middleware: &Arc<dyn Middleware>, components: u64) -> (usize, usize) {
    let (started, memory, ty) = (Instant::now(), resident(), state());
    let echo = ServiceType::new(ServiceKind::Function, state(), state());
    let mut ends: Vec<_> = (0..components)
        .map(|n| {
            let at = Address::new(format!("component{n}"), "position");
            let service = Address::new(format!("component{n}"), "echo");
            let writer = middleware.publisher(&PortSpec::new(&at, &ty)).unwrap();
            let reader = middleware.subscription(&PortSpec::new(&at, &ty), Policy::Latest);
            let served = middleware.serve(&service, &echo, Arc::new(Echo)).unwrap();
            let client = middleware.client(&service, &echo).unwrap();
            (n, writer, reader.unwrap(), served, client)
        })
        .collect();
    let opened = started.elapsed();
    let mut got = Record::new(&ty);
    for (n, writer, _, _, client) in &mut ends {
        writer.publish(&numbered(*n)).unwrap();
        let answer = client.call(&numbered(*n), Duration::from_secs(60)).unwrap();
        assert!(matches!(answer, Outcome::Success(output) if number(&output) == *n));
    }
    for (n, _, reader, _, _) in &mut ends {
        eventually("its sample arrives", || reader.read(&mut got) == Ok(Reading::New));
        assert_eq!(number(&got), *n);
    }
    let (passed, meanwhile, with) = (started.elapsed(), used(), resident());
    drop(ends);
    println!(
        "{components} components: opened in {opened:?}, a sample and a call each after {passed:?}, \
         closed after {:?}; {meanwhile:?} descriptors and threads, {} kB more meanwhile",
        started.elapsed(),
        with.saturating_sub(memory),
    );
    meanwhile
}

#[test]
fn ports_and_services_of_50_components_work_and_leave_nothing_behind() {
    let place = Place::new();
    // What is made once for the process is made here.
    let (_, with_one) = round(&open(&place), 1);
    let before = used();
    for components in [1, 50] {
        let middleware = open(&place);
        let (_, threads) = round(&middleware, components);
        assert!(threads <= with_one + 2, "{threads} with {components}, {with_one} with one");
        assert_eq!(place.leftovers(), Vec::<String>::new());
        drop(middleware);
        eventually("descriptors and threads are back", || used() == before);
    }
}
