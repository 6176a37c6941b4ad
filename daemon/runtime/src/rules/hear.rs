//! Heartbeats, orders and formulas of an instance, and what each hears.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_description::model::{
    CodelIx, Component, Direction, Indexed, PortDirection, PortIx, Source,
};

use super::beat::{Beat, Pulse};
use super::broken::{Fact, Seen};
use super::traced::{Happened, Hears, Monitor, Traced};
use super::{Beats, Rule, Supervised};
use crate::body::Body;
use crate::clock::nanos;
use genom_monitor::Judge;
use genom_monitor::{Happening, Hearers, Numbers};

/// Values that codels write on a port in one call and that are heard of, at most.
const MOST_VALUES: u64 = 2;

/// Who hears what happens.
#[derive(Debug)]
pub(super) struct Hearing {
    numbers: Numbers,
    beats: Box<[Beat]>,
    /// Heartbeats by index, and what they hear.
    pulses: Hearers<(u16, Pulse)>,
    traced: Traced,
    traces: Hearers<Hears>,
    /// Ports of each codel that somebody hears of.
    ports: Indexed<CodelIx, Box<[PortIx]>>,
    /// Values of each port that were heard of.
    written: Indexed<PortIx, AtomicU64>,
}

impl Hearing {
    pub(super) fn new(model: &Component, all: &[Supervised]) -> Self {
        let numbers = Numbers::new(model);
        let (mut beats, mut pulses) = (Vec::new(), Vec::new());
        let (mut monitors, mut traces) = (Vec::new(), Vec::new());
        let small = |at: usize| u16::try_from(at).unwrap_or(u16::MAX);
        for (rank, one) in all.iter().enumerate() {
            match &one.rule {
                Rule::Beat { of, least, longest, during } => {
                    let at = small(beats.len());
                    beats.push(Beat::new(rank, nanos(*least), nanos(*longest), during.is_some()));
                    match of {
                        Beats::Port(port) => {
                            pulses.push((Happening::Write(*port), (at, Pulse::Beats)));
                        }
                        Beats::Codels(codels) => {
                            let calls = codels.iter().map(|ix| Happening::Call(*ix));
                            pulses.extend(calls.map(|call| (call, (at, Pulse::Beats))));
                        }
                    }
                    if let Some(service) = *during {
                        pulses.push((Happening::Start(service), (at, Pulse::Begins)));
                        pulses.push((Happening::End(service), (at, Pulse::Ends)));
                    }
                }
                Rule::Order(order) => {
                    let monitor = small(monitors.len());
                    let hears = order.hears().into_iter();
                    traces
                        .extend(hears.map(|(what, letter)| {
                            (what, Hears { monitor, letter: small(letter) })
                        }));
                    monitors.push((rank, Monitor::Order { order: order.clone(), state: 0 }));
                }
                Rule::Formula(program) => {
                    let monitor = small(monitors.len());
                    let hears = program.hears().into_iter().enumerate();
                    traces
                        .extend(hears.map(|(letter, what)| {
                            (what, Hears { monitor, letter: small(letter) })
                        }));
                    monitors.push((rank, Monitor::Formula(Judge::new(program))));
                }
                _ => {}
            }
        }
        let is_heard = |port: PortIx| {
            let write = Happening::Write(port);
            let heard = traces.iter().map(|(what, _)| *what);
            heard.chain(pulses.iter().map(|(what, _)| *what)).any(|what| what == write)
        };
        let ports = |ix: CodelIx| {
            let written = model.codels[ix].parameters.iter().filter_map(|one| match one.source {
                Source::Port(port) if one.direction != Direction::In => Some(port),
                _ => None,
            });
            let out = |port: &PortIx| model.ports[*port].direction == PortDirection::Out;
            written.filter(out).filter(|port| is_heard(*port)).collect()
        };
        Self {
            beats: beats.into_boxed_slice(),
            pulses: Hearers::new(&numbers, &pulses),
            traced: Traced::new(monitors),
            traces: Hearers::new(&numbers, &traces),
            ports: model.codels.places().map(ports).collect(),
            written: model.ports.iter().map(|_| AtomicU64::new(0)).collect(),
            numbers,
        }
    }

    /// Whether anybody hears of this.
    pub(super) fn hears(&self, what: Happening) -> bool {
        let number = self.numbers.of(what);
        !self.pulses.of(number).is_empty() || !self.traces.of(number).is_empty()
    }

    /// Whether anybody hears of a port that this codel may write.
    pub(super) fn awaits_ports_of(&self, codel: CodelIx) -> bool {
        !self.ports[codel].is_empty()
    }

    /// Something happens; tells what breaks rules.
    #[inline]
    pub(super) fn hear(
        &self,
        what: Happening,
        activity: u32,
        date: u64,
        mut tell: impl FnMut(Seen),
    ) {
        let number = self.numbers.of(what);
        for (at, pulse) in self.pulses.of(number) {
            let beat = &self.beats[usize::from(*at)];
            if let Some(fact) = beat.hear(*pulse, date) {
                tell(Seen { rule: beat.rule, activity, date, fact });
            }
        }
        if !self.traces.of(number).is_empty() {
            let number = u32::try_from(number).unwrap_or(u32::MAX);
            let happened = Happened { what, number, activity, date };
            self.traced.hear(happened, |number| self.traces.of(number as usize), tell);
        }
    }

    /// A codel of an activity has returned: the ports that it wrote.
    pub(super) fn wrote(
        &self,
        body: &dyn Body,
        codel: CodelIx,
        activity: u32,
        date: u64,
        mut tell: impl FnMut(Seen),
    ) {
        for &port in &self.ports[codel] {
            let now = body.written(port);
            let before = self.written[port].swap(now, Ordering::Relaxed);
            for _ in 0..now.saturating_sub(before).min(MOST_VALUES) {
                self.hear(Happening::Write(port), activity, date, &mut tell);
            }
        }
    }

    /// Takes in what threads left to others; returns what breaks rules.
    pub(super) fn take_left(&self) -> Vec<Seen> {
        let mut seen = Vec::new();
        self.traced.take_left(|number| self.traces.of(number as usize), |one| seen.push(one));
        seen
    }

    /// What happened and found no room.
    pub(super) fn lost(&self) -> u64 {
        self.traced.lost.load(Ordering::Relaxed)
    }

    /// From this date on heartbeats are waited for that depend on no activity.
    pub(super) fn begin(&self, now: u64) {
        self.beats.iter().for_each(|beat| beat.awaits_always(now));
    }

    /// Heartbeats that did not come in time until this date, by rule.
    pub(super) fn late(&self, now: u64) -> Vec<(usize, Fact)> {
        let late = self.beats.iter().filter_map(|beat| Some((beat.rule, beat.look(now)?)));
        late.collect()
    }

    /// When the next one will be too late.
    pub(super) fn due(&self) -> Option<u64> {
        self.beats.iter().filter_map(Beat::due).min()
    }
}
