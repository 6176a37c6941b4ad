//! The reading process: counts what arrives, and serves calls.

use std::error::Error;
use std::io::{self, BufRead as _, Write as _};
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use genom_bench::pair::Receive;
use genom_bench::{FloorError, bare, clock, octets};
use genom_middleware::{Address, Middleware, Policy};

use crate::ends::reader;
use crate::{FLOWS, Flow, Way, calls, ours, usage};

/// Nanoseconds from one look for samples to the next, like a task of 1 kHz.
pub(crate) const PERIOD: u64 = 1_000_000;

/// How many looks what is still on its way when the writer is ready may take.
const STRAGGLERS: u32 = 500;

/// Unread samples that a port keeps.
const KEPT: usize = 8;

pub(crate) fn topic(number: usize) -> Address {
    Address::new("bench", format!("topic{number}"))
}

fn ports(of: &dyn Middleware, flow: &Flow) -> Vec<Box<dyn Receive>> {
    let value = octets::sequence(flow.bytes);
    let one = |number| reader(of, &topic(number), value.clone(), Policy::Ring(KEPT));
    (0..flow.topics).map(one).collect()
}

fn tell(line: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")?;
    out.flush()
}

fn questions() -> Receiver<()> {
    let (asked, questions) = channel();
    thread::spawn(move || io::stdin().lock().lines().try_for_each(|_| asked.send(())));
    questions
}

/// Counts until it is asked, or the writer is gone; then whatever comes in [`STRAGGLERS`].
fn count(ends: &mut [Box<dyn Receive>], asked: &Receiver<()>) -> Result<Option<u64>, FloorError> {
    let mut samples = 0;
    let mut left = None;
    loop {
        for end in &mut *ends {
            while end.arrived()? {
                samples += 1;
            }
        }
        match (asked.try_recv(), left) {
            (Err(TryRecvError::Disconnected), None) => return Ok(None),
            (Ok(()), None) => left = Some(STRAGGLERS),
            (_, Some(0)) => return Ok(Some(samples)),
            (_, Some(more)) => left = Some(more - 1),
            _ => {}
        }
        clock::sleep_until(clock::now() + PERIOD);
    }
}

/// Tells how many samples of which the first of each topic arrived, then how many of each round.
fn flow(ends: &mut [Box<dyn Receive>]) -> Result<(), Box<dyn Error>> {
    let asked = questions();
    let mut missing: Vec<&mut Box<dyn Receive>> = ends.iter_mut().collect();
    while !missing.is_empty() {
        missing.retain_mut(|end| !end.arrived().unwrap());
        clock::sleep_until(clock::now() + PERIOD);
    }
    tell("connected")?;
    while let Some(samples) = count(ends, &asked)? {
        tell(&format!("{samples} {}", usage::processor().as_millis()))?;
    }
    Ok(())
}

pub(crate) fn serve(name: &str, place: &Path, what: &str) -> Result<(), Box<dyn Error>> {
    if what == calls::WORD {
        let middleware = ours::open(name, place, true);
        let _served = calls::serve(&*middleware);
        tell("connected")?;
        let asked = questions();
        while asked.recv().is_ok() {
            tell(&format!("0 {}", usage::processor().as_millis()))?;
        }
        return Ok(());
    }
    let (way, number) = what.split_once(' ').ok_or("which way and flow?")?;
    let flow_of = FLOWS.get(number.parse::<usize>()?).ok_or("no such flow")?;
    if way == Way::Ports.word() {
        let middleware = ours::open(name, place, true);
        return flow(&mut ports(&*middleware, flow_of));
    }
    let bare = bare::open(ours::carrier(name), place, true)?.ok_or("no such middleware")?;
    // Topics of bare middlewares are named by the sizes of their values.
    let ends = (0..flow_of.topics).map(|topic| bare.reader(flow_of.bytes + topic));
    flow(&mut ends.collect::<Result<Vec<_>, _>>()?)
}
