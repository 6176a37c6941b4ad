//! Rules about one time: from when something happens until something else does. A clock of their own
//! counts it, in zones with those of codels and ticks.

use std::time::Instant;

use super::fires::{Fires, concluded, undecided};
use super::run::{Broken, Traced};
use crate::action::Action;
use crate::state::{Phase, State};
use crate::system::System;
use crate::timed::{Clock, Times, bound, clocks, guarded, initial, stepped};
use genom_timing::{Age, Limit, Limits, Trail, Zone};

/// What a rule waits for, going along with the system.
pub(super) trait Watch {
    /// The number of where it is at first.
    fn first(&self, system: &System, state: &State) -> u32;

    /// The longest time that it tells from shorter ones, in nanoseconds.
    fn longest(&self) -> u64;

    /// Whether it counts time.
    fn counts(&self, state: &State, along: u32) -> bool;

    /// Where a step leads; `None` if there are too many choices.
    fn lead(&mut self, system: &System, step: &Step<'_>) -> Option<Vec<Led>>;

    /// What breaks it while time passes, if it has counted this much at most, or any time.
    fn waits(&self, system: &System, state: &State, time: Option<u64>) -> Option<String>;

    /// Whether nothing that comes after this state matters: that of a shutdown, which asks for passes
    /// at once, or of a permanent activity that failed, after which there is one.
    fn is_over(&self, state: &State) -> bool {
        matches!(state.phase, Phase::Stopping(_)) || state.failed
    }

    /// Memory that it takes, about.
    fn bytes(&self) -> usize {
        0
    }
}

/// A step, where it is possible.
pub(super) struct Step<'a> {
    pub(super) state: &'a State,
    pub(super) along: u32,
    pub(super) action: Action,
    zone: &'a Zone,
    /// The clock of the rule, from 1.
    clock: Option<usize>,
}

impl Step<'_> {
    /// Whether it can come when the clock of the rule has counted at most this.
    pub(super) fn within(&self, most: u64) -> bool {
        self.clock.is_some_and(|clock| self.zone.clone().at_most(clock, bound(most)))
    }

    /// Whether it can come when that has counted so much at least, and at most.
    pub(super) fn between(&self, least: u64, most: u64) -> bool {
        let mut zone = self.zone.clone();
        self.clock.is_some_and(|clock| {
            zone.at_least(clock, bound(least)) && zone.at_most(clock, bound(most))
        })
    }

    /// Whether it can come when that has counted more.
    pub(super) fn beyond(&self, most: u64) -> bool {
        let more = |clock| self.zone.most(clock).is_none_or(|time| time > bound(most));
        self.clock.is_some_and(more)
    }
}

/// Where a step leads.
pub(super) struct Led {
    pub(super) next: State,
    pub(super) along: u32,
    /// The clock counts from here.
    pub(super) anew: bool,
    /// Something that the rule is about did not break it.
    pub(super) kept: bool,
    /// What broke it, and what the clock had counted then.
    pub(super) broken: Option<(String, Option<Age>)>,
}

impl Led {
    /// A step by which nothing changes for the rule.
    pub(super) fn on(next: State, along: u32) -> Self {
        Self { next, along, anew: false, kept: false, broken: None }
    }
}

impl System {
    /// Whether a rule can be broken, if codels take these times; or why they are not known.
    pub(super) fn clocked(
        &self,
        watch: &mut impl Watch,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let times = match times {
            Ok(times) => times,
            Err(why) => return undecided(why),
        };
        let begin = Instant::now();
        let mut traced = Traced::default();
        let first = self.initial(false);
        let Some(zone) = initial(self, times, &first) else { return Fires::Never };
        let along = watch.first(self, &first);
        // The clock of the rule counts from a date.
        let since = |counts: bool, date: Option<usize>| Trail {
            dates: if counts { vec![date] } else { Vec::new() },
            ages: Vec::new(),
        };
        traced.add((&first, along), zone, (0, 0), since(watch.counts(&first, along), None));
        // The first violation, by a step or while time passes, and whether anything did not break it.
        let (mut broken, mut kept) = (None::<Broken>, false);
        let (mut at, mut limit) = (0u32, None::<Limit>);
        let own = Clock::Noted(0, watch.longest());
        while (at as usize) < traced.table.len() {
            let number = at;
            at += 1;
            let Some((state, zone)) = traced.table.get(number) else { continue };
            if state.phase == Phase::Stopped || watch.is_over(&state) {
                continue;
            }
            let zone = zone.clone();
            let along = traced.table.along(number).unwrap_or_default();
            let mut before = clocks(self, times, &state);
            let others = before.len();
            let clock = watch.counts(&state, along).then(|| {
                before.push(own);
                before.len()
            });
            if let Some(clock) = clock {
                let time = zone.most(clock).map(|time| u64::try_from(time).unwrap_or(0));
                if let Some(what) = watch.waits(self, &state, time) {
                    let ages = vec![(0, Age::Least(watch.longest()))];
                    Broken::note(&mut broken, (number, None), (what, ages));
                }
            }
            for (action, step) in self.timed(&state).into_iter().zip(0u16..) {
                let from = (&state, &before[..]);
                let Some(zone) = guarded(self, times, from, &zone, action) else { continue };
                let taken = Step { state: &state, along, action, zone: &zone, clock };
                let Some(all) = watch.lead(self, &taken) else {
                    return undecided("a codel writes too many ports that it hears of");
                };
                for led in all {
                    kept |= led.kept;
                    if let Some((what, age)) = led.broken {
                        let ages = age.map(|age| (0, age)).into_iter().collect();
                        Broken::note(&mut broken, (number, Some(action)), (what, ages));
                    }
                    let mut after = clocks(self, times, &led.next);
                    let counts = watch.counts(&led.next, led.along);
                    after.extend(counts.then_some(own));
                    // A clock that was not there is at zero.
                    let all: Vec<Option<usize>> = (1..=others).map(Some).collect();
                    let anew = (led.anew && clock.is_some()).then(|| zone.select(&all));
                    let from = match &anew {
                        Some(zone) => (&before[..others], zone),
                        None => (&before[..], &*zone),
                    };
                    if let Some(zone) = stepped(self, times, from, action, (&led.next, &after)) {
                        let from = clock.filter(|_| !led.anew).map(|_| 0);
                        let node = (&led.next, led.along);
                        traced.add(node, zone, (number, step), since(counts, from));
                    }
                }
            }
            if broken.is_some() && kept {
                break;
            }
            let bytes = traced.bytes() + watch.bytes();
            limit = limits.passed(traced.table.len(), bytes, at as usize, begin);
            if limit.is_some() {
                break;
            }
        }
        let broken = broken.map(|broken| traced.run(self, times, broken));
        concluded(broken, kept, limit)
    }
}
