//! Heartbeats, orders and formulas of an instance, and what each hears.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_description::model::{
    CodelIx, Direction, Indexed, PortDirection, PortIx, Source, TaskIx,
};

use super::beat::{Beat, Pulse};
use super::broken::{Fact, Seen};
use super::ear::Ear;
use super::formulas::{Formulas, Happened, Shared};
use super::{Beats, Rule, Supervised};
use crate::body::Body;
use crate::clock::nanos;
use genom_monitor::Judge;
use genom_monitor::{Happening, Hearers, Numbers, Places, Sequence};

/// Values that codels write on a port in one call and that are heard of, at most.
const MOST_VALUES: u64 = 2;

/// Who hears what happens.
#[derive(Debug)]
pub(super) struct Hearing {
    numbers: Numbers,
    ears: Hearers<Ear>,
    beats: Box<[Beat]>,
    /// With the rule of each.
    orders: Box<[(usize, Sequence)]>,
    shared: Shared,
    /// For each task, the formulas that its thread alone moves on, by rule.
    own: Indexed<TaskIx, Vec<usize>>,
    /// Ports of each codel that somebody hears of.
    ports: Indexed<CodelIx, Box<[PortIx]>>,
    /// Values of each port that were heard of.
    written: Indexed<PortIx, AtomicU64>,
}

impl Hearing {
    pub(super) fn new(places: Places<'_>, all: &[Supervised]) -> Self {
        let model = places.model;
        let numbers = Numbers::new(model);
        let (mut beats, mut orders, mut shared) = (Vec::new(), Vec::new(), Vec::new());
        let mut own: Indexed<TaskIx, Vec<usize>> = model.tasks.map(|_, _| Vec::new());
        let mut ears: Vec<(Happening, Ear)> = Vec::new();
        let small = |at: usize| u16::try_from(at).unwrap_or(u16::MAX);
        for (rank, one) in all.iter().enumerate() {
            match &one.rule {
                Rule::Beat { of, least, longest, during } => {
                    let at = small(beats.len());
                    let begin = ears.len();
                    let beat = |what: Happening| (what, Ear::Beat(at, Pulse::Beats));
                    match of {
                        Beats::Port(port) => ears.push(beat(Happening::Write(*port))),
                        Beats::Codels(codels) => {
                            ears.extend(codels.iter().map(|ix| beat(Happening::Call(*ix))));
                        }
                    }
                    if let Some(service) = *during {
                        ears.push((Happening::Start(service), Ear::Beat(at, Pulse::Begins)));
                        ears.push((Happening::End(service), Ear::Beat(at, Pulse::Ends)));
                    }
                    let sole = places.of_all(ears[begin..].iter().map(|(what, _)| *what)).is_some();
                    let times = (nanos(*least), nanos(*longest));
                    beats.push(Beat::new(rank, times, during.is_some(), sole));
                }
                Rule::Order(order) => {
                    let (at, hears) = (small(orders.len()), order.hears());
                    let sole = places.of_all(hears.iter().map(|(what, _)| *what)).is_some();
                    let ear = |(what, event)| (what, Ear::Order(at, small(event)));
                    ears.extend(hears.into_iter().map(ear));
                    orders.push((rank, Sequence::new(order.clone(), sole)));
                }
                Rule::Formula(program) => {
                    let hears = program.hears();
                    let task = places.of_all(hears.iter().copied());
                    let at = small(task.map_or(shared.len(), |task| own[task].len()));
                    let ear = |(letter, what)| match task {
                        Some(_) => (what, Ear::Own(at, small(letter))),
                        None => (what, Ear::Shared(at, small(letter))),
                    };
                    ears.extend(hears.into_iter().enumerate().map(ear));
                    match task {
                        Some(task) => own[task].push(rank),
                        None => shared.push((rank, Judge::new(program))),
                    }
                }
                _ => {}
            }
        }
        let is_heard = |port: PortIx| {
            let write = Happening::Write(port);
            ears.iter().any(|(what, _)| *what == write)
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
            ears: Hearers::new(&numbers, &ears),
            beats: beats.into_boxed_slice(),
            orders: orders.into_boxed_slice(),
            shared: Shared::new(shared),
            own,
            ports: model.codels.places().map(ports).collect(),
            written: model.ports.iter().map(|_| AtomicU64::new(0)).collect(),
            numbers,
        }
    }

    /// Whether anybody hears of this.
    pub(super) fn hears(&self, what: Happening) -> bool {
        !self.ears.of(self.numbers.of(what)).is_empty()
    }

    /// Whether anybody hears of a port that this codel may write.
    pub(super) fn awaits_ports_of(&self, codel: CodelIx) -> bool {
        !self.ports[codel].is_empty()
    }

    /// The formulas that the thread of this task alone moves on, at their beginning.
    pub(super) fn own(&self, task: TaskIx, all: &[Supervised]) -> Formulas {
        let judge = |rank: &usize| match &all.get(*rank)?.rule {
            Rule::Formula(program) => Some((*rank, Judge::new(program))),
            _ => None,
        };
        Formulas::new(self.own[task].iter().filter_map(judge).collect())
    }

    /// Something happens; tells what breaks rules. `own` are the formulas of the task in whose thread
    /// it happens, if it is one.
    #[inline]
    pub(super) fn hear(
        &self,
        what: Happening,
        activity: u32,
        date: u64,
        mut own: Option<&mut Formulas>,
        mut tell: impl FnMut(Seen),
    ) {
        let number = self.numbers.of(what);
        let happened = || {
            let number = u32::try_from(number).unwrap_or(u32::MAX);
            Happened { what, number, activity, date }
        };
        let mut is_shared = false;
        for ear in self.ears.of(number) {
            match *ear {
                Ear::Beat(at, pulse) => {
                    let beat = &self.beats[usize::from(at)];
                    if let Some(fact) = beat.hear(pulse, date) {
                        tell(Seen { rule: beat.rule, activity, date, fact });
                    }
                }
                Ear::Order(at, event) => {
                    let (rule, order) = &self.orders[usize::from(at)];
                    if let Err(state) = order.hear(usize::from(event)) {
                        let fact = Fact::Disordered { what, state };
                        tell(Seen { rule: *rule, activity, date, fact });
                    }
                }
                Ear::Own(at, letter) => {
                    if let Some(own) = own.as_deref_mut() {
                        own.hear((at, letter), &happened(), &mut tell);
                    }
                }
                Ear::Shared(..) => is_shared = true,
            }
        }
        if is_shared {
            self.shared.hear(happened(), |number| self.ears.of(number as usize), tell);
        }
    }

    /// A codel of an activity has returned: the ports that it wrote.
    pub(super) fn wrote(
        &self,
        body: &dyn Body,
        codel: CodelIx,
        activity: u32,
        date: u64,
        mut own: Option<&mut Formulas>,
        mut tell: impl FnMut(Seen),
    ) {
        for &port in &self.ports[codel] {
            let now = body.written(port);
            let before = self.written[port].swap(now, Ordering::Relaxed);
            for _ in 0..now.saturating_sub(before).min(MOST_VALUES) {
                let write = Happening::Write(port);
                self.hear(write, activity, date, own.as_deref_mut(), &mut tell);
            }
        }
    }

    /// Takes in what threads left to others; returns what breaks rules.
    pub(super) fn take_left(&self) -> Vec<Seen> {
        let mut seen = Vec::new();
        self.shared.take_left(|number| self.ears.of(number as usize), |one| seen.push(one));
        seen
    }

    /// What happened and found no room.
    pub(super) fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
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
