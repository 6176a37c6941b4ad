//! Participants whose lease expired and that are back.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{
    Address, Discovery, EndpointKind, Policy, PortSpec, Ports, Publisher, Subscription,
};
use genom_ros2::{Options, Ros2, ServiceMapping};
use world::Domain;

/// Joins with a lease of three seconds, while participants announce themselves every ten.
fn impatient(domain: &Domain) -> Arc<Ros2> {
    Ros2::open(&Options { silence: Duration::from_secs(3), ..domain.options() }).unwrap()
}

/// Makes everybody announce themselves now, as they do for each new participant.
fn wake(domain: &Domain) {
    drop(domain.open());
}

fn sees(ros2: &Ros2, address: &str) -> bool {
    let ends = ros2.discover().unwrap();
    ends.iter().any(|end| end.kind == EndpointKind::Publisher && end.address == address)
}

/// Two daemons, each with an out port that the other reads.
struct Pair {
    domain: Domain,
    daemons: [Arc<Ros2>; 2],
    ends: [(Box<dyn Publisher>, Box<dyn Subscription>); 2],
    written: u64,
}

impl Pair {
    fn new(open: [fn(&Domain) -> Arc<Ros2>; 2]) -> Self {
        let domain = Domain::new(ServiceMapping::Enhanced);
        let daemons = open.map(|open| open(&domain));
        let (ty, [first, second]) = (state(), &daemons);
        let end = |from: &Ros2, to: &Ros2, name: &str| {
            let at = Address::new(name, "it");
            let publisher = from.publisher(&PortSpec::new(&at, &ty)).unwrap();
            (publisher, to.subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap())
        };
        let ends = [end(first, second, "first"), end(second, first, "second")];
        let mut pair = Self { domain, daemons, ends, written: 0 };
        pair.flows("at first", |_| {});
        pair
    }

    /// Checks that what is written from now on is read, in both directions.
    fn flows(&mut self, when: &str, mut meanwhile: impl FnMut(&Domain)) {
        let Self { domain, ends, written, .. } = self;
        for (publisher, subscription) in ends {
            let (mut record, before) = (numbered(0), *written);
            eventually(&format!("a sample arrives {when}"), || {
                meanwhile(domain);
                *written += 1;
                publisher.publish(&numbered(*written)).unwrap();
                // The record is unchanged if nothing is read.
                let _ = subscription.read(&mut record);
                number(&record) > before
            });
        }
    }

    fn flows_again(&mut self) {
        // At most one new participant per second, to limit the load.
        let mut woken: Option<Instant> = None;
        self.flows("again", |domain| {
            if woken.is_none_or(|woken| woken.elapsed() > Duration::from_secs(1)) {
                wake(domain);
                woken = Some(Instant::now());
            }
        });
    }

    /// Checks that one daemon sees what the other opens from now on.
    fn finds(&self, by: usize, of: usize) {
        let _publisher =
            self.daemons[of].publisher(&PortSpec::new(&Address::new("later", "it"), &state()));
        eventually("an end that is new is seen", || {
            wake(&self.domain);
            sees(&self.daemons[by], "later/it")
        });
    }
}

fn patient(domain: &Domain) -> Arc<Ros2> {
    domain.open()
}

#[test]
fn ports_flow_again_after_their_daemons_lost_each_other() {
    let mut pair = Pair::new([impatient, impatient]);
    for _ in 0..2 {
        let [first, second] = &pair.daemons;
        let lost = || !sees(second, "first/it") && !sees(first, "second/it");
        eventually("they lose each other", lost);
        pair.flows_again();
    }
    pair.finds(1, 0);
}

#[test]
fn ports_flow_again_after_one_daemon_alone_lost_the_other() {
    let mut pair = Pair::new([patient, impatient]);
    eventually("one loses the other", || !sees(&pair.daemons[1], "first/it"));
    pair.flows_again();
    pair.finds(1, 0);
}
