//! Heartbeats, orders and formulas of an instance, and what each hears.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_description::model::{
    CodelIx, Direction, Indexed, PortDirection, PortIx, Source, TaskIx,
};

use super::broken::{Fact, Seen};
use super::ear::{Ear, Judges};
use super::formulas::{Formulas, Happened, Shared};
use super::{Beats, Rule, Supervised};
use crate::body::Body;
use crate::clock::nanos;
use genom_monitor::{Beat, Happening, Hearers, Judge, Numbers, Places, Pulse, Sequence};

/// Values that codels write on a port in one call and that are heard of, at most.
const MOST_VALUES: u64 = 2;

/// Who hears of something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heard {
    /// Formulas of the task in whose thread it happens.
    pub(crate) own: bool,
    pub(crate) others: bool,
}

impl Heard {
    /// Whether anybody does.
    pub(crate) fn is_heard(self) -> bool {
        self.own || self.others
    }
}

/// Who hears what happens.
#[derive(Debug)]
pub(super) struct Hearing {
    numbers: Numbers,
    ears: Hearers<Ear>,
    /// Formulas of the task in whose thread something happens.
    own: Hearers<Judges>,
    /// Formulas that several threads move on.
    others: Hearers<Judges>,
    /// With the rule of each.
    beats: Box<[(usize, Beat)]>,
    orders: Box<[(usize, Sequence)]>,
    shared: Shared,
    /// For each task, the formulas that its thread alone moves on, with the rule of each, at their
    /// beginning.
    tasks: Indexed<TaskIx, Vec<(usize, Judge)>>,
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
        let mut tasks: Indexed<TaskIx, Vec<(usize, Judge)>> = model.tasks.map(|_, _| Vec::new());
        let mut ears: Vec<(Happening, Ear)> = Vec::new();
        let (mut own, mut others) = (Vec::new(), Vec::new());
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
                    beats.push((rank, Beat::new(times, during.is_some(), sole)));
                }
                Rule::Order(order) => {
                    let (at, hears) = (small(orders.len()), order.hears());
                    let sole = places.of_all(hears.iter().map(|(what, _)| *what)).is_some();
                    let ear = |(what, event)| (what, Ear::Order(at, small(event)));
                    ears.extend(hears.into_iter().map(ear));
                    orders.push((rank, Sequence::new(order.clone(), sole)));
                }
                Rule::Formula(program) => {
                    let (hears, judge) = (program.hears(), Judge::new(program));
                    let task = places.of_all(hears.iter().copied());
                    let (judges, ears) = match task {
                        Some(task) => (&mut tasks[task], &mut own),
                        None => (&mut shared, &mut others),
                    };
                    let at = small(judges.len());
                    let letters = judge.letters().iter().cloned();
                    let ear = |(what, letter)| (what, Judges { at, letter });
                    ears.extend(hears.into_iter().zip(letters).map(ear));
                    judges.push((rank, judge));
                }
                _ => {}
            }
        }
        let is_heard = |port: PortIx| {
            let write = Happening::Write(port);
            let formulas = own.iter().chain(&others).map(|(what, _)| what);
            ears.iter().map(|(what, _)| what).chain(formulas).any(|what| *what == write)
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
            own: Hearers::new(&numbers, &own),
            others: Hearers::new(&numbers, &others),
            shared: Shared::new(shared),
            tasks,
            ports: model.codels.places().map(ports).collect(),
            written: model.ports.iter().map(|_| AtomicU64::new(0)).collect(),
            numbers,
        }
    }

    /// Who hears of this.
    pub(super) fn hears(&self, what: Happening) -> Heard {
        let number = self.numbers.of(what);
        let others = self.ears.of(number).is_empty() && self.others.of(number).is_empty();
        Heard { own: !self.own.of(number).is_empty(), others: !others }
    }

    /// Whether anybody hears of a port that this codel may write.
    pub(super) fn awaits_ports_of(&self, codel: CodelIx) -> bool {
        !self.ports[codel].is_empty()
    }

    /// The formulas that the thread of this task alone moves on, at their beginning.
    pub(super) fn own(&self, task: TaskIx) -> Formulas {
        Formulas::new(self.tasks[task].clone())
    }

    /// Something happens; tells what breaks formulas of the task in whose thread it does.
    #[inline]
    pub(super) fn hear_own(
        &self,
        what: (Happening, u32, u64),
        own: &mut Formulas,
        tell: impl FnMut(Seen),
    ) {
        own.hear(what, self.own.of(self.numbers.of(what.0)), tell);
    }

    /// The same of all other rules.
    #[inline]
    pub(super) fn hear(
        &self,
        (what, activity, date): (Happening, u32, u64),
        mut tell: impl FnMut(Seen),
    ) {
        let number = self.numbers.of(what);
        for ear in self.ears.of(number) {
            match *ear {
                Ear::Beat(at, pulse) => {
                    let (rule, beat) = &self.beats[usize::from(at)];
                    if let Some(off) = beat.hear(pulse, date) {
                        tell(Seen { rule: *rule, activity, date, fact: off.into() });
                    }
                }
                Ear::Order(at, event) => {
                    let (rule, order) = &self.orders[usize::from(at)];
                    if let Err(state) = order.hear(usize::from(event)) {
                        let fact = Fact::Disordered { what, state };
                        tell(Seen { rule: *rule, activity, date, fact });
                    }
                }
            }
        }
        if !self.others.of(number).is_empty() {
            let small = u32::try_from(number).unwrap_or(u32::MAX);
            let happened = Happened { what, number: small, activity, date };
            self.shared.hear(happened, |number| self.others.of(number as usize), tell);
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
                let write = (Happening::Write(port), activity, date);
                if let Some(own) = &mut own {
                    self.hear_own(write, own, &mut tell);
                }
                self.hear(write, &mut tell);
            }
        }
    }

    /// Takes in what threads left to others; returns what breaks rules.
    pub(super) fn take_left(&self) -> Vec<Seen> {
        let mut seen = Vec::new();
        self.shared.take_left(|number| self.others.of(number as usize), |one| seen.push(one));
        seen
    }

    /// What happened and found no room.
    pub(super) fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }

    /// From this date on heartbeats are waited for that depend on no activity.
    pub(super) fn begin(&self, now: u64) {
        self.beats.iter().for_each(|(_, beat)| beat.awaits_always(now));
    }

    /// Heartbeats that did not come in time until this date, by rule.
    pub(super) fn late(&self, now: u64) -> Vec<(usize, Fact)> {
        let late =
            self.beats.iter().filter_map(|(rule, beat)| Some((*rule, beat.look(now)?.into())));
        late.collect()
    }

    /// When the next one will be too late.
    pub(super) fn due(&self) -> Option<u64> {
        self.beats.iter().filter_map(|(_, beat)| beat.due()).min()
    }
}
