//! Calls of a function, one after the other.

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use genom_bench::{Figures, clock};
use genom_middleware::{
    ActivityId, Address, Middleware, Outcome, Replies, Served, ServiceHandler, ServiceKind,
    ServiceType,
};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};

use crate::writing::{self, Reader};
use crate::{ours, usage};

/// What the reading process is told, to serve them.
pub(crate) const WORD: &str = "calls";

const RATE: u64 = 1000;

const PATIENCE: Duration = Duration::from_secs(1);

/// Answers with what it was sent.
struct Echo;

impl ServiceHandler for Echo {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        replies.finish(Outcome::Success(input));
    }

    fn cancel(&self, _: ActivityId) {}
}

fn service() -> (Address, ServiceType) {
    let mut table = TypeTable::default();
    let ty = table.add(Kind::Double);
    let member = |name: &str| Member { name: name.to_owned(), ty };
    let members = ["x", "y", "z"].map(member).to_vec();
    let id = table.add(Kind::Struct { name: ScopedName::new(["bench", "place"]), members });
    let ty = DataType::new(&Arc::new(table), id).unwrap();
    (Address::new("bench", "echo"), ServiceType::new(ServiceKind::Function, ty.clone(), ty))
}

pub(crate) fn serve(of: &dyn Middleware) -> Box<dyn Served> {
    let (at, service) = service();
    of.serve(&at, &service, Arc::new(Echo)).unwrap()
}

pub(crate) fn measure(name: &str, seconds: u32) -> Result<(), Box<dyn Error>> {
    let place = tempfile::tempdir()?;
    let middleware = ours::open(name, place.path(), false);
    let mut reader = Reader::start(name, place.path(), WORD)?;
    reader.connected()?;
    let (at, service) = service();
    let mut client = middleware.client(&at, &service)?;
    let input = Record::new(&service.input);
    // The service may not be visible yet.
    while client.call(&input, PATIENCE).is_err() {
        clock::sleep_until(clock::now() + 10_000_000);
    }
    let (_, before) = reader.ask()?;
    let (begun, ours) = (clock::now(), usage::processor());
    let sent = RATE * u64::from(seconds);
    let mut times = Vec::new();
    for round in 0..sent {
        clock::sleep_until(begun + round * 1_000_000_000 / RATE);
        let called = clock::now();
        if matches!(client.call(&input, PATIENCE), Ok(Outcome::Success(_))) {
            times.push((clock::now() - called) as f64);
        }
    }
    let passed = Duration::from_nanos(clock::now() - begun);
    let (_, after) = reader.ask()?;
    let busy = usage::processor().saturating_sub(ours) + after.saturating_sub(before);
    let arrived = times.len() as u64;
    writing::Outcome { sent, arrived, passed, busy }.print(name, "calls", "ours");
    if let Some(figures) = Figures::of(times) {
        println!("{name:>9} {:>18} {:>6} {figures} us, p50 / p99", "", "");
    }
    reader.finish()
}
