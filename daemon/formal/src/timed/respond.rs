//! How long clients wait: from the acceptance of an activity to its beginning, and from a request to
//! stop it to its end.
//!
//! One activity at a time is followed, with a clock of its own.

use std::time::Instant;

use super::clocks::{Clock, clocks, guarded, initial, stepped};
use super::follow::{Over, after_into, choices, forget, number, over};
use super::table::Table;
use super::times::Times;
use crate::codels::small;
use crate::property::stops_late;
use crate::state::State;
use crate::system::System;
use genom_timing::{Limit, Limits};

/// What takes more than so many of the longest period is not told apart.
const PERIODS: u64 = 16;

/// How long clients of a service wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// The service, an activity.
    pub service: String,
    /// From its acceptance to its beginning.
    pub begins: Longest,
    /// From when it is asked to stop to its end.
    pub ends: Longest,
}

/// The longest time that something may take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Longest {
    /// It never happens.
    Never,
    /// At most this, in nanoseconds, which is possible.
    Most(u64),
    /// There is no bound, or one above this, in nanoseconds.
    More(u64),
    /// There is no bound, for this reason.
    Unbounded(String),
    /// Not decided, for this reason.
    Undecided(String),
}

/// What was found of one service.
#[derive(Clone, Copy, Default)]
struct Found {
    begins: Option<Option<u64>>,
    ends: Option<Option<u64>>,
}

impl System {
    /// How long clients of each activity wait, if codels take these times.
    #[must_use]
    pub fn respond(&self, times: &Times, limits: &Limits) -> Vec<Response> {
        let mut all: Vec<(u16, Response)> = Vec::new();
        let (begin, parts) = (Instant::now(), self.parts_of_activities());
        for (at, part) in parts.iter().enumerate() {
            let limits = limits.share(begin, parts.len() - at - 1);
            let (found, limit) = explore(part, times, &limits);
            let services = (0..small(part.services.len())).filter(|service| {
                let facts = &part.services[usize::from(*service)];
                facts.machine.is_some() && part.clients[usize::from(*service)]
            });
            for service in services {
                let one = found[usize::from(service)];
                let told = |seen: Option<Option<u64>>| match (seen, limit) {
                    (Some(None), _) => Longest::More(cap(part)),
                    (_, Some(limit)) => Longest::Undecided(limit.to_string()),
                    (Some(Some(most)), None) => Longest::Most(most),
                    (None, None) => Longest::Never,
                };
                let late = stops_late(part, service);
                let (begins, ends) = (told(one.begins), told(one.ends));
                let ends = late.map_or(ends, Longest::Unbounded);
                all.push((service, Response { service: part.service_name(service), begins, ends }));
            }
        }
        all.sort_by_key(|(service, _)| *service);
        all.into_iter().map(|(_, response)| response).collect()
    }

    /// Groups of tasks with the services that matter to them; all at once if tasks without period
    /// run activities.
    pub(crate) fn parts_of_activities(&self) -> Vec<Self> {
        let aperiodic = |machine: &crate::machines::Machine| {
            machine.service.is_some() && self.is_aperiodic(machine.task)
        };
        if self.machines.iter().any(aperiodic) {
            return vec![self.clone()];
        }
        self.apart().into_iter().map(|(_, part)| part).collect()
    }
}

fn cap(system: &System) -> u64 {
    let longest = system.periods.iter().flatten().map(|period| period.period).max();
    longest.unwrap_or(1_000_000_000).saturating_mul(PERIODS)
}

fn explore(system: &System, times: &Times, limits: &Limits) -> (Vec<Found>, Option<Limit>) {
    let begin = Instant::now();
    let mut found = vec![Found::default(); system.services.len()];
    let mut table = Table::default();
    let first = system.initial(false);
    let Some(zone) = initial(system, times, &first) else { return (found, None) };
    table.add(&first, zone, (0, 0));
    let own = Clock::Followed(cap(system));
    let clocks_of = |state: &State| {
        let mut all = clocks(system, times, state);
        all.extend(number(state).map(|_| own));
        all
    };
    let (mut at, mut told, mut next) = (0u32, Vec::new(), first);
    while (at as usize) < table.len() {
        let number_of_node = at;
        at += 1;
        let Some((state, zone)) = table.get(number_of_node) else { continue };
        let zone = zone.clone();
        let before = clocks_of(&state);
        for (action, step) in system.timed(&state).into_iter().zip(0u16..) {
            let Some(possible) = guarded(system, times, (&state, &before), &zone, action) else {
                continue;
            };
            for follow in choices(system, &state, action) {
                told.clear();
                after_into(system, (&mut next, &state), action, follow, &mut told);
                if let Some((service, over)) = over(system, &state, &next, &told) {
                    let clock = before.iter().position(|clock| *clock == own);
                    let most = possible.most(clock.map_or(0, |clock| clock + 1));
                    let most = most.and_then(|most| u64::try_from(most).ok());
                    let found = &mut found[usize::from(service)];
                    match over {
                        Over::Begun => longer(&mut found.begins, most, cap(system)),
                        Over::Ended => longer(&mut found.ends, most, cap(system)),
                        Over::Gone => {}
                    }
                    forget(&mut next);
                }
                let all = clocks_of(&next);
                let from = (&before[..], &*possible);
                if let Some(zone) = stepped(system, times, from, action, (&next, &all)) {
                    table.add(&next, zone, (number_of_node, step));
                }
            }
        }
        let limit = limits.passed(table.len(), table.bytes(), at as usize, begin);
        if limit.is_some() {
            return (found, limit);
        }
    }
    (found, None)
}

fn longer(longest: &mut Option<Option<u64>>, most: Option<u64>, cap: u64) {
    let most = most.filter(|most| *most <= cap);
    *longest = Some(match *longest {
        None => most,
        Some(before) => before.zip(most).map(|(a, b)| a.max(b)),
    });
}
