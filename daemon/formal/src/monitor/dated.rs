//! Looks for a run that breaks a formula with bounds, in the time that codels take.

use std::time::Instant;

use genom_runtime::{Happening, Judge, Program};
use indexmap::IndexSet;

use super::bounded;
use super::fires::{Fires, concluded, undecided};
use super::moment::{Moment, most_clocks};
use super::search::MOST_PORTS;
use crate::action::{Action, Told};
use crate::state::State;
use crate::system::System;
use crate::timed::{Table, Times, clocks, guarded, initial, stepped};
use genom_timing::memory::{ENTRY, listed};
use genom_timing::{Limit, Limits};

/// Limit on the dates that a formula has noted at the same time.
const MOST_CLOCKS: u16 = 8;
/// Bytes of a judge, beside its key.
const JUDGE: usize = ENTRY + listed::<Judge>() + 1024;

/// Judges, by number: those that will judge alike are one.
#[derive(Default)]
struct Judges {
    all: Vec<Judge>,
    known: IndexSet<(u64, Vec<bool>, Vec<u32>)>,
    bytes: usize,
}

impl Judges {
    fn number(&mut self, judge: &Judge) -> u32 {
        let (at, is_new) = self.known.insert_full(judge.place());
        if is_new {
            self.all.push(judge.clone());
            self.bytes += JUDGE;
        }
        u32::try_from(at).unwrap_or(u32::MAX)
    }
}

/// What is heard in a step, with the number under which the formula hears it, and whether it may
/// also not happen.
type Heard = (Happening, usize, bool);

/// Where a step led.
struct Walked {
    moment: Moment,
    /// Something was heard that did not break it.
    kept: bool,
    /// What broke it.
    broken: Option<String>,
}

impl System {
    /// Whether a formula can be broken, if codels take these times.
    pub(super) fn dated_search(&self, program: &Program, times: &Times, limits: &Limits) -> Fires {
        let heard = program.hears();
        if let Some(what) = heard.iter().find(|what| !self.is_heard(**what)) {
            let what = what.tell(self.plan.component());
            return Fires::Undecided(format!("it is not explored when \"{what}\""));
        }
        let judge = Judge::new(program);
        match most_clocks(&judge) {
            None => return undecided(bounded::BETWEEN),
            Some(clocks) if clocks > MOST_CLOCKS => return undecided(bounded::MANY),
            Some(_) => {}
        }
        let begin = Instant::now();
        let (mut table, mut judges) = (Table::default(), Judges::default());
        let first = self.initial(false);
        let Some(zone) = initial(self, times, &first) else { return Fires::Never };
        table.add_with(&first, Some(judges.number(&judge)), zone, (0, 0));
        // The first violation, and whether anything that it hears did not break it.
        let (mut broken, mut kept) = (None, false);
        let (mut at, mut told) = (0u32, Vec::new());
        let mut limit: Option<Limit> = None;
        while (at as usize) < table.len() {
            let number = at;
            at += 1;
            let Some((state, zone)) = table.get(number) else { continue };
            let zone = zone.clone();
            let along = table.along(number).unwrap_or_default();
            let Some(judge) = judges.all.get(along as usize).cloned() else { continue };
            let mut moment = Moment { judge, clocks: clocks(self, times, &state), zone };
            moment.add_noted();
            for (action, step) in self.timed(&state).into_iter().zip(0u16..) {
                let from = (&state, &moment.clocks[..]);
                let Some(zone) = guarded(self, times, from, &moment.zone, action) else { continue };
                told.clear();
                let next = self.after(&state, action, &mut told);
                let happens = self.letters(&heard, &state, action, &next, &told);
                let before = Moment { zone: zone.into_owned(), ..moment.clone() };
                let Some(all) = self.dated_walks(before, &happens) else {
                    return undecided("a codel writes too many ports that it hears of");
                };
                for walked in all {
                    kept |= walked.kept;
                    if let Some(what) = walked.broken {
                        broken.get_or_insert((number, action, what));
                    }
                    let own = &walked.moment;
                    let mut after = clocks(self, times, &next);
                    after.extend(own.noted());
                    let from = (&own.clocks[..], &own.zone);
                    if let Some(zone) = stepped(self, times, from, action, (&next, &after)) {
                        let along = judges.number(&own.judge);
                        table.add_with(&next, Some(along), zone, (number, step));
                    }
                }
            }
            if broken.is_some() && kept {
                break;
            }
            limit = limits.passed(table.len(), table.bytes() + judges.bytes, at as usize, begin);
            if limit.is_some() {
                break;
            }
        }
        let broken = broken.map(|(node, action, what)| {
            let run = table.run_to(self, (node, action));
            let run = run.iter().filter_map(|(state, action)| self.words(state, *action));
            (what, run.collect())
        });
        concluded(broken, kept, limit)
    }

    /// What a formula hears in a step.
    fn letters(
        &self,
        heard: &[Happening],
        state: &State,
        action: Action,
        next: &State,
        told: &[Told],
    ) -> Vec<Heard> {
        let happens = self.heard(state, action, next, told).into_iter();
        let letter = |what: &Happening| heard.iter().position(|one| one == what);
        happens.filter_map(|(what, open)| Some((what, letter(&what)?, open))).collect()
    }

    /// Where that leads: each port is written or not, at each date that there may be.
    fn dated_walks(&self, moment: Moment, happens: &[Heard]) -> Option<Vec<Walked>> {
        let open = happens.iter().filter(|(.., open)| *open).count();
        if u32::try_from(open).is_ok_and(|open| open > MOST_PORTS) {
            return None;
        }
        let mut all = vec![Walked { moment, kept: false, broken: None }];
        for (what, letter, open) in happens {
            let mut next = Vec::new();
            for walked in all {
                for (moment, wrong) in walked.moment.hear(*letter)? {
                    let mut broken = walked.broken.clone();
                    if wrong {
                        broken.get_or_insert_with(|| what.tell(self.plan.component()));
                    }
                    next.push(Walked { moment, kept: walked.kept || !wrong, broken });
                }
                if *open {
                    next.push(walked);
                }
            }
            all = next;
        }
        Some(all)
    }
}
