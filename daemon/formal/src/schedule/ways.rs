//! Ways through a state machine within one cycle of its task: the dearest one.

use crate::action::Answer;
use crate::machines::Machine;
use crate::system::System;

/// A way without end: states follow each other in a circle without pause.
#[derive(Clone, Copy, Debug)]
pub(super) struct Endless;

/// Codels that are executed one after another in a cycle, and what they cost together.
#[derive(Clone, Debug, Default)]
pub(super) struct Way {
    pub(super) cost: u64,
    pub(super) codels: Vec<u16>,
}

impl Way {
    pub(super) fn then(mut self, next: Self) -> Self {
        self.cost = self.cost.saturating_add(next.cost);
        self.codels.extend(next.codels);
        self
    }
}

/// The costs of all codels, and what was found of each state of a machine.
pub(super) struct Ways<'a> {
    pub(super) system: &'a System,
    pub(super) machine: &'a Machine,
    pub(super) costs: &'a [u64],
}

impl Ways<'_> {
    /// The dearest way of an activity in a cycle: from its start or from where it paused, and, for
    /// it may be asked to stop at any time, through `stop` after what does not end it. Each external
    /// event that it handles comes once in a cycle at most, and adds a place of its own.
    pub(super) fn cycle(&self) -> Result<Way, Endless> {
        self.dearest(true)
    }

    /// The same of one that neither begins nor is asked to stop, as permanent activities while
    /// requests are served.
    pub(super) fn resumed(&self) -> Result<Way, Endless> {
        self.dearest(false)
    }

    fn dearest(&self, whole: bool) -> Result<Way, Endless> {
        let machine = self.machine;
        let stops = whole && machine.codel(machine.stop).is_some();
        let sinks = self.system.sinks.iter().filter(|sink| machine.codel(**sink).is_some());
        let mut events = Way::default();
        let mut has_events = false;
        for sink in sinks {
            events = events.then(self.from(*sink, false)?);
            has_events = true;
        }
        let mut dearest = Way::default();
        for ends_later in [false, true] {
            if ends_later && !stops {
                continue;
            }
            let start = if whole { self.from(machine.start, ends_later)? } else { Way::default() };
            let mut resumed = Way::default();
            for state in self.pausing() {
                let way = self.from(state, ends_later)?;
                // With events, several places may pause at the same time.
                if has_events {
                    resumed = resumed.then(way);
                } else if way.cost > resumed.cost || resumed.codels.is_empty() {
                    resumed = way;
                }
            }
            let mut way = if start.cost >= resumed.cost { start } else { resumed };
            if ends_later {
                way = way.then(self.from(machine.stop, false)?);
            }
            if way.cost > dearest.cost || dearest.codels.is_empty() {
                dearest = way;
            }
        }
        if stops {
            let stop = self.from(machine.stop, false)?;
            if stop.cost > dearest.cost {
                dearest = stop;
            }
        }
        Ok(dearest.then(events))
    }

    /// States in which places pause.
    fn pausing(&self) -> Vec<u16> {
        let mut states: Vec<u16> = Vec::new();
        let codels = self.machine.codels.iter().flatten();
        for answer in codels.flat_map(|codel| &self.system.codels[usize::from(*codel)].answers) {
            let to = match *answer {
                Answer::Pause(to) => to,
                Answer::Go(to) if self.system.by_period => to,
                _ => continue,
            };
            if !states.contains(&to) {
                states.push(to);
            }
        }
        states
    }

    /// The dearest way from a state; with `ends_later`, one whose last codel does not end the
    /// activity.
    pub(super) fn from(&self, state: u16, ends_later: bool) -> Result<Way, Endless> {
        let mut known = vec![Known::No; self.machine.codels.len()];
        self.look(state, ends_later, &mut known)
    }

    fn look(&self, state: u16, ends_later: bool, known: &mut [Known]) -> Result<Way, Endless> {
        let Some(codel) = self.machine.codel(state) else { return Ok(Way::default()) };
        match &known[usize::from(state)] {
            Known::No => {}
            Known::Looking => return Err(Endless),
            Known::Found(way) => return Ok(way.clone()),
        }
        known[usize::from(state)] = Known::Looking;
        let answers = &self.system.codels[usize::from(codel)].answers;
        let mut rest = Way::default();
        let mut goes_on = false;
        for answer in answers {
            match *answer {
                Answer::Go(to) if !self.system.by_period => {
                    goes_on = true;
                    let way = self.look(to, ends_later, known)?;
                    if way.cost > rest.cost {
                        rest = way;
                    }
                }
                Answer::Go(_) | Answer::Pause(_) | Answer::Sleep(_) => goes_on = true,
                Answer::End | Answer::Ok | Answer::Fail => {}
            }
        }
        let way = if ends_later && !goes_on {
            Way::default()
        } else {
            Way { cost: self.costs[usize::from(codel)], codels: vec![codel] }.then(rest)
        };
        known[usize::from(state)] = Known::Found(way.clone());
        Ok(way)
    }
}

#[derive(Clone)]
enum Known {
    No,
    Looking,
    Found(Way),
}
