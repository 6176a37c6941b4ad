//! Cycles of a task from one of its ticks on, pass by pass (R7): with all activities that there may be, in
//! all orders of admission, and the latest date of each step. Who comes to a node later leaves it later,
//! or at the same date, so no earlier date can lead to a longer cycle.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use rustc_hash::FxBuildHasher;

use crate::action::Answer;
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;

/// Places of cycles that are looked at for one task.
const MOST: usize = 100_000;

/// The latest dates of a task.
#[derive(Clone, Debug)]
pub(crate) struct Latest {
    /// When a cycle ends.
    pub(crate) cycle: u64,
    /// When each node has been left.
    pub(super) left: Vec<u64>,
}

/// What an activity does in the rest of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Does {
    /// Begins, with the codel of `start`.
    Begins,
    /// Executes the codel of this state in the next pass, or `stop` if it is asked to and was not.
    Ready { state: u16, stopped: bool },
    /// Nothing unless it is asked to stop.
    Rests,
    /// Its outputs are read at the end of the pass.
    Fetch,
    /// It has ended, or only goes on in a later cycle.
    Nothing,
    /// The same, in a pass before.
    Gone,
}

/// Latest dates of a task in a cycle, from its tick on.
#[derive(Clone, Debug)]
pub(super) struct Dates {
    pub(super) now: u64,
    /// For each task, when this one has left the last node that it may have waited for.
    pub(super) left: Box<[u64]>,
}

/// Activities in order of admission, by machine; how many of them are through in this pass; whether
/// there is another pass; and whether one has begun in this one.
type Place = (Vec<(u16, Does)>, usize, bool, bool);
/// With the latest date of each.
type Places = HashMap<Place, Dates, FxBuildHasher>;

/// When a node is entered that is arrived at by then, with these activities.
pub(super) type Enters<'a> = dyn Fn(u16, &Dates, &[(u16, Does)]) -> u64 + 'a;

/// Walks through the cycles of a task from one of its ticks on.
pub(super) struct Walk<'a> {
    system: &'a System,
    times: &'a Times,
    machines: Vec<u16>,
    enters: &'a Enters<'a>,
    /// For each task, what it may wait for.
    linked: &'a [Vec<u16>],
    /// Services of activities of another task that are there all the time, in order of admission.
    beside: &'a [u16],
    found: Latest,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        system: &'a System,
        times: &'a Times,
        task: u16,
        (enters, linked): (&'a Enters<'a>, &'a [Vec<u16>]),
        beside: &'a [u16],
    ) -> Self {
        let machines = 0..small(system.machines.len());
        let own = |machine: &u16| {
            let machine = &system.machines[usize::from(*machine)];
            let requested = machine.service.is_none_or(|one| system.clients[usize::from(one)]);
            machine.task == task && requested
        };
        let found = Latest { cycle: 0, left: vec![0; system.plan.nodes().len()] };
        Self {
            system,
            times,
            machines: machines.filter(own).collect(),
            enters,
            linked,
            beside,
            found,
        }
    }

    /// With these activities at the tick, or any; `None` if there are too many cycles.
    pub(super) fn from(mut self, runs: Option<Vec<(u16, Does)>>) -> Option<Latest> {
        self.walk(runs, MOST)?;
        Some(self.found)
    }

    /// With any activities at the tick, one list after the other: what is waited for then depends on all
    /// that are there, and not only on those that are through.
    pub(super) fn each(mut self) -> Option<Latest> {
        let (mut lists, mut at, mut left) = (vec![(Vec::new(), false)], 0, MOST);
        while let Some((runs, begun)) = lists.get(at).cloned() {
            at += 1;
            let more = self.admitted(&runs, begun).into_iter();
            lists.extend(more.map(|one| {
                let begun = begun || one.1 == Does::Begins;
                (runs.iter().copied().chain([one]).collect(), begun)
            }));
            left = left.checked_sub(self.walk(Some(runs), left)?)?;
        }
        Some(self.found)
    }

    /// The same for the number of places; `None` if there are more than `most`.
    fn walk(&mut self, runs: Option<Vec<(u16, Does)>>, most: usize) -> Option<usize> {
        let mut first = runs.is_none();
        // Places of the tick's pass by the number of activities in it, then those of later passes.
        let begin = Dates { now: 0, left: vec![0; self.system.periods.len()].into() };
        let mut present = Places::from_iter([((runs.unwrap_or_default(), 0, false, false), begin)]);
        let (mut later, mut looked) = (Places::default(), 0);
        while !present.is_empty() {
            let mut next = Places::default();
            looked += present.len();
            if looked > most {
                return None;
            }
            for (place, dates) in present {
                if first {
                    self.admit(&place, &dates, &mut next);
                }
                let (runs, at, again, begun) = place;
                if at < runs.len() {
                    self.step((runs, at, again, begun), &dates, &mut next);
                } else {
                    self.end_pass(runs, again, dates, &mut later);
                }
            }
            present = next;
            if present.is_empty() {
                (present, first) = (std::mem::take(&mut later), false);
            }
        }
        Some(looked)
    }

    /// Another activity is there at the tick, behind those that are.
    fn admit(&mut self, (runs, at, again, begun): &Place, dates: &Dates, next: &mut Places) {
        for (machine, does) in self.admitted(runs, *begun) {
            let mut runs = runs.clone();
            runs.push((machine, does));
            self.step((runs, *at, *again, *begun || does == Does::Begins), dates, next);
        }
    }

    /// What may be there at the tick behind these activities, of which one begins then or none does.
    fn admitted(&self, runs: &[(u16, Does)], begun: bool) -> Vec<(u16, Does)> {
        let mut all = Vec::new();
        for &machine in self.machines.iter().filter(|machine| self.may_follow(runs, **machine)) {
            // Who has begun before was admitted before who begins now.
            if !begun {
                all.extend(self.pauses(machine).into_iter().map(|does| (machine, does)));
            }
            if self.system.machines[usize::from(machine)].service.is_some() {
                all.push((machine, Does::Begins));
            }
        }
        all
    }

    /// Whether an activity may be admitted after these. When it was sent, none had begun that its
    /// service interrupts, and those that had not never will (R12).
    fn may_follow(&self, runs: &[(u16, Does)], machine: u16) -> bool {
        let service = |machine: u16| self.system.machines[usize::from(machine)].service;
        let Some(own) = service(machine) else {
            // Permanent activities come first.
            return runs.is_empty();
        };
        let others = || runs.iter().filter_map(|(machine, _)| service(*machine));
        let all: Vec<u16> = others().chain([own]).collect();
        others().all(|other| !self.system.interrupts(own, other))
            && self.system.may_be_beside(&all, self.beside)
            && others().filter(|other| *other == own).count() < self.system.bounds.instances
            && others().count() < self.system.bounds.slots
    }

    /// Where an activity may be that has begun before the tick.
    fn pauses(&self, machine: u16) -> Vec<Does> {
        let facts = &self.system.machines[usize::from(machine)];
        let mut all = Vec::new();
        for codel in facts.codels.iter().flatten() {
            for answer in &self.system.codels[usize::from(*codel)].answers {
                let does = match *answer {
                    Answer::Pause(state) => Does::Ready { state, stopped: false },
                    Answer::Sleep(_) => Does::Rests,
                    _ => continue,
                };
                if !all.contains(&does) {
                    all.push(does);
                }
            }
        }
        all
    }

    /// The next activity of a pass is prepared, and executes its codel.
    fn step(&mut self, (runs, at, again, begun): Place, dates: &Dates, next: &mut Places) {
        let (machine, does) = runs[at];
        let facts = &self.system.machines[usize::from(machine)];
        let mut goes_on = |does: Does, dates: &Dates, goes: bool| {
            let mut runs = runs.clone();
            runs[at].1 = does;
            keep(next, (runs, at + 1, again || goes, begun), dates.clone());
        };
        let stops = match does {
            Does::Ready { stopped, .. } => !stopped,
            Does::Rests => true,
            Does::Begins | Does::Fetch | Does::Nothing | Does::Gone => false,
        };
        let mut executed = Vec::new();
        match does {
            Does::Begins => executed.push((facts.start, false)),
            Does::Ready { state, stopped } => executed.push((state, stopped)),
            Does::Rests | Does::Fetch | Does::Nothing | Does::Gone => goes_on(does, dates, false),
        }
        if stops && facts.service.is_some() {
            executed.push((facts.stop, true));
        }
        for (state, stopped) in executed {
            let Some(codel) = facts.codel(state) else {
                let ends = if facts.fetch.is_some() { Does::Fetch } else { Does::Nothing };
                goes_on(ends, dates, false);
                continue;
            };
            let mut dates = dates.clone();
            self.execute(codel, &mut dates, &runs);
            let dates = &dates;
            for answer in &self.system.codels[usize::from(codel)].answers {
                match *answer {
                    Answer::Go(state) => goes_on(Does::Ready { state, stopped }, dates, true),
                    Answer::Pause(_) | Answer::Sleep(_) if stopped => {
                        goes_on(Does::Nothing, dates, false);
                    }
                    Answer::Pause(_) | Answer::Sleep(_) => goes_on(Does::Rests, dates, false),
                    Answer::End if facts.fetch.is_some() => goes_on(Does::Fetch, dates, false),
                    Answer::End | Answer::Ok | Answer::Fail => goes_on(Does::Nothing, dates, false),
                }
            }
        }
    }

    /// Waits for a node, executes and leaves it.
    fn execute(&mut self, node: u16, dates: &mut Dates, runs: &[(u16, Does)]) {
        let most = self.times.of(node).most.unwrap_or(0);
        dates.now = (self.enters)(node, dates, runs).saturating_add(most);
        let left = &mut self.found.left[usize::from(node)];
        *left = dates.now.max(*left);
        for (left, linked) in dates.left.iter_mut().zip(self.linked) {
            if linked.contains(&node) {
                *left = dates.now;
            }
        }
    }

    /// Outputs of activities that ended are read; then there is another pass, or the cycle is over.
    fn end_pass(
        &mut self,
        mut runs: Vec<(u16, Does)>,
        again: bool,
        mut dates: Dates,
        later: &mut Places,
    ) {
        let read = runs.iter_mut().filter(|(_, does)| *does == Does::Fetch);
        let read = read.filter_map(|(machine, does)| {
            *does = Does::Nothing;
            self.system.machines[usize::from(*machine)].fetch
        });
        for node in read.collect::<Vec<u16>>() {
            // Control may have collected those that were read before.
            self.execute(node, &mut dates, &[]);
        }
        self.found.cycle = self.found.cycle.max(dates.now);
        if again {
            let over = runs.iter_mut().filter(|(_, does)| *does == Does::Nothing);
            over.for_each(|(_, does)| *does = Does::Gone);
            keep(later, (runs, 0, false, false), dates);
        }
    }
}

fn keep(places: &mut Places, place: Place, dates: Dates) {
    match places.entry(place) {
        Entry::Vacant(new) => drop(new.insert(dates)),
        Entry::Occupied(mut known) => {
            let known = known.get_mut();
            known.now = dates.now.max(known.now);
            known.left.iter_mut().zip(dates.left).for_each(|(all, one)| *all = one.max(*all));
        }
    }
}
