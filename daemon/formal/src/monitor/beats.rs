//! Heartbeats: the time between two calls of codels, or two values of a port.

use genom_description::model::{CodelIx, PortIx, ServiceIx};
use genom_runtime::{Beats, Happening};
use genom_timing::{Age, Limits, duration};

use super::clocked::{Led, Step, Watch};
use super::fires::Fires;
use super::search::choices;
use crate::state::{Phase, State};
use crate::system::System;
use crate::timed::Times;

/// What is waited for, as the runtime does (`runtime/src/rules/beat.rs`).
#[derive(Clone, Copy, PartialEq, Eq)]
enum Since {
    /// Nothing.
    Nothing,
    /// The next beat, since the end of the start-up or since an activity began.
    Begin,
    /// The next beat, since another one.
    Beat,
}

/// A heartbeat.
struct Heart<'a> {
    of: &'a Beats,
    /// In nanoseconds.
    least: u64,
    longest: u64,
    during: Option<ServiceIx>,
    /// Two beats came one after the other.
    paired: bool,
}

/// Where it is, from what goes along with a state: what is waited for, and how many activities run.
fn place(along: u32) -> (Since, u32) {
    let since = match along & 3 {
        0 => Since::Nothing,
        1 => Since::Begin,
        _ => Since::Beat,
    };
    (since, along >> 2)
}

fn along(since: Since, running: u32) -> u32 {
    running << 2 | since as u32
}

impl Heart<'_> {
    fn beats(&self, what: Happening) -> bool {
        match (self.of, what) {
            (Beats::Codels(all), Happening::Call(codel)) => all.contains(&codel),
            (Beats::Port(own), Happening::Write(port)) => *own == port,
            _ => false,
        }
    }

    fn name(&self, system: &System) -> String {
        let model = system.plan.component();
        let codel = |ix: &CodelIx| format!("codel {}", model.codels[*ix].name);
        let port = |ix: &PortIx| format!("port {}", model.ports[*ix].name);
        match self.of {
            Beats::Codels(all) => all.first().map_or_else(String::new, codel),
            Beats::Port(ix) => port(ix),
        }
    }

    /// What it is called if it comes.
    fn verb(&self) -> &'static str {
        if matches!(self.of, Beats::Port(_)) { "written" } else { "called" }
    }

    fn late(&self, system: &System) -> String {
        let (name, verb, longest) = (self.name(system), self.verb(), duration(self.longest));
        format!("{name} may not be {verb} for longer than {longest}")
    }

    fn soon(&self, system: &System) -> String {
        let (name, verb, least) = (self.name(system), self.verb(), duration(self.least));
        format!("{name} may be {verb} again within less than {least}")
    }

    /// Hears what happens in a step, in order.
    fn hear(
        &mut self,
        system: &System,
        step: &Step<'_>,
        happens: impl Iterator<Item = Happening>,
    ) -> Led {
        let mut led = Led::on(step.state.clone(), 0);
        let (mut since, mut running) = place(step.along);
        let over = Some(Age::Least(self.longest()));
        // Whether the clock counts from this very step.
        let mut now = false;
        for what in happens {
            let is = |service: Option<ServiceIx>, own| service == Some(own);
            match what {
                Happening::Start(service) if is(self.during, service) => {
                    running += 1;
                    if running == 1 {
                        (since, now) = (Since::Begin, true);
                    }
                }
                Happening::End(service) if is(self.during, service) => {
                    if running == 1 && since != Since::Nothing {
                        if !now && step.beyond(self.longest) {
                            led.broken.get_or_insert_with(|| (self.late(system), over));
                        }
                        since = Since::Nothing;
                    }
                    running = running.saturating_sub(1);
                }
                what if self.beats(what) && (self.during.is_none() || running > 0) => {
                    self.beat(system, step, (since, now), &mut led);
                    (since, now) = (Since::Beat, true);
                }
                _ => {}
            }
        }
        led.anew = now;
        led.along = along(since, running);
        led
    }

    /// It beats after something, which is `now` if it was in this step.
    fn beat(&mut self, system: &System, step: &Step<'_>, after: (Since, bool), led: &mut Led) {
        let (since, now) = after;
        if since == Since::Nothing {
            return;
        }
        let late = !now && step.beyond(self.longest);
        let before = self.least.saturating_sub(1);
        let soon = since == Since::Beat && self.least > 0 && (now || step.within(before));
        if soon {
            let age = (!now).then_some(Age::Most(before));
            led.broken.get_or_insert_with(|| (self.soon(system), age));
        }
        if late {
            let age = Some(Age::Least(self.longest()));
            led.broken.get_or_insert_with(|| (self.late(system), age));
        }
        if since == Since::Beat {
            self.paired = true;
            led.kept |= if now { self.least == 0 } else { step.between(self.least, self.longest) };
        }
    }
}

impl Watch for Heart<'_> {
    fn first(&self, _: &System, state: &State) -> u32 {
        let waits = self.during.is_none() && state.phase == Phase::Running;
        along(if waits { Since::Begin } else { Since::Nothing }, 0)
    }

    fn longest(&self) -> u64 {
        self.longest.saturating_add(1)
    }

    fn counts(&self, _: &State, along: u32) -> bool {
        place(along).0 != Since::Nothing
    }

    fn lead(&mut self, system: &System, step: &Step<'_>) -> Option<Vec<Led>> {
        let mut told = Vec::new();
        let next = system.after(step.state, step.action, &mut told);
        let all = system.heard(step.state, step.action, &next, &told);
        let all: Vec<_> = all
            .into_iter()
            .filter(|(what, _)| {
                let own = |what: &Happening| {
                    let (Happening::Start(one) | Happening::End(one)) = what else { return false };
                    self.during == Some(*one)
                };
                own(what) || self.beats(*what)
            })
            .collect();
        let opens = matches!(step.state.phase, Phase::Starting(_)) && next.phase == Phase::Running;
        let mut ways = Vec::new();
        for happens in choices(&all, |(_, open)| *open)? {
            let mut led = self.hear(system, step, happens.map(|(what, _)| *what));
            led.next = next.clone();
            if opens && self.during.is_none() {
                (led.along, led.anew) = (along(Since::Begin, 0), true);
            }
            ways.push(led);
        }
        Some(ways)
    }

    fn waits(&self, system: &System, state: &State, time: Option<u64>) -> Option<String> {
        let late = time.is_none_or(|time| time > self.longest);
        // Before the start-up is over nobody waits.
        (late && state.phase == Phase::Running).then(|| self.late(system))
    }
}

impl System {
    /// Beats that come sooner or later than they may.
    pub(super) fn heartbeat(
        &self,
        of: &Beats,
        (least, longest): (u64, u64),
        during: Option<ServiceIx>,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let mut heart = Heart { of, least, longest, during, paired: false };
        match self.clocked(&mut heart, times, limits) {
            // A wrong bound is one that no time between two beats keeps.
            Fires::Always { what, run } if !heart.paired => Fires::Can { what, run },
            other => other,
        }
    }
}
