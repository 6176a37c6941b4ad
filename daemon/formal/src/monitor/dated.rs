//! Looks for a run that breaks a formula with bounds, in the time that codels take.

use std::time::Instant;

use genom_runtime::{Happening, Judge, Program};
use indexmap::IndexSet;

use super::fires::{Fires, concluded, undecided};
use super::moment::Moment;
use super::run::{Broken, Traced};
use super::search::MOST_PORTS;
use crate::action::{Action, Told};
use crate::state::State;
use crate::system::System;
use crate::timed::{Times, clocks, guarded, initial, stepped};
use genom_timing::memory::{ENTRY, listed};
use genom_timing::{Age, Limit, Limits, Trail};

/// Limit on the dates that a formula has noted at the same time.
const MOST_CLOCKS: usize = 12;
/// Bytes of a judge, beside its key.
const JUDGE: usize = ENTRY + listed::<Judge>() + 1024;

/// Judges, by number: those that will judge alike are one.
#[derive(Default)]
struct Judges {
    all: Vec<Judge>,
    known: IndexSet<(u64, Vec<usize>, Vec<u32>)>,
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
    /// What broke it, and how long ago the dates of before the step were then.
    broken: Option<(String, Vec<(usize, Age)>)>,
}

impl System {
    /// Whether a formula can be broken, if codels take these times.
    pub(super) fn dated_search(&self, program: &Program, times: &Times, limits: &Limits) -> Fires {
        let heard = program.hears();
        if let Some(what) = heard.iter().find(|what| !self.is_heard(**what)) {
            let what = what.tell(self.plan.component());
            return Fires::Undecided(format!("it is not explored when \"{what}\""));
        }
        let (judge, begin) = (Judge::new(program), Instant::now());
        let (mut traced, mut judges) = (Traced::default(), Judges::default());
        let first = self.initial(false);
        let Some(zone) = initial(self, times, &first) else { return Fires::Never };
        traced.add((&first, judges.number(&judge)), zone, (0, 0), Trail::default());
        // The first violation, and whether anything that it hears did not break it.
        let (mut broken, mut kept) = (None::<Broken>, false);
        let (mut at, mut told) = (0u32, Vec::new());
        // What ends the search early, and whether it left out where too many dates are noted.
        let (mut limit, mut crowded) = (None::<Limit>, false);
        while (at as usize) < traced.table.len() {
            let number = at;
            at += 1;
            let Some((state, zone)) = traced.table.get(number) else { continue };
            let zone = zone.clone();
            let along = traced.table.along(number).unwrap_or_default();
            let Some(judge) = judges.all.get(along as usize).cloned() else { continue };
            let moment = Moment::at(judge, clocks(self, times, &state), zone);
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
                    if let Some(way) = walked.broken {
                        Broken::note(&mut broken, (number, Some(action)), way);
                    }
                    let own = walked.moment;
                    if own.noted().len() > MOST_CLOCKS {
                        crowded = true;
                        continue;
                    }
                    let mut after = clocks(self, times, &next);
                    after.extend(own.noted());
                    let from = (&own.clocks[..], &own.zone);
                    if let Some(zone) = stepped(self, times, from, action, (&next, &after)) {
                        let along = judges.number(&own.judge);
                        traced.add((&next, along), zone, (number, step), own.trail);
                    }
                }
            }
            if broken.is_some() && kept {
                break;
            }
            limit = limits.passed(
                traced.table.len(),
                traced.bytes() + judges.bytes,
                at as usize,
                begin,
            );
            if limit.is_some() {
                break;
            }
        }
        let broken = broken.map(|broken| traced.run(self, times, broken));
        match concluded(broken, kept || crowded, limit) {
            Fires::Never if crowded => Fires::Undecided(format!(
                "more than {MOST_CLOCKS} dates count at a time, which is not explored: move the \
                 bounds away from each other, or make one of them 0 or inf"
            )),
            found => found,
        }
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
                for (moment, wrong) in walked.moment.hear(*letter) {
                    let mut broken = walked.broken.clone();
                    if wrong {
                        broken.get_or_insert_with(|| {
                            (what.tell(self.plan.component()), moment.trail.ages.clone())
                        });
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
