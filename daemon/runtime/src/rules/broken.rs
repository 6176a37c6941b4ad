//! What broke a rule: in numbers only for the thread that saw it, which must not allocate, and as a
//! sentence for people.

use genom_description::model::{CodelIx, Component, ServiceIx, StateIx, TaskIx};

use super::{Beats, Rule, Violation};
use crate::clock::nanos;
use crate::plan::owner_name;
use genom_monitor::{Happening, OffBeat};

/// A rule was broken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Index of the rule.
    pub(crate) rule: usize,
    /// The activity that did it; 0 if none did.
    pub(crate) activity: u32,
    /// By the clock of the instance.
    pub(crate) date: u64,
    pub(crate) fact: Fact,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fact {
    /// A call took so long.
    Took { codel: CodelIx, ns: u64 },
    /// A call has not returned; the thread that is in it, 0 if unknown.
    Lasts { codel: CodelIx, ns: u64, thread: u32 },
    /// An activity takes so long.
    Activity { service: ServiceIx, ns: u64 },
    /// A task missed ticks.
    Missed { task: TaskIx, ticks: u64 },
    /// A codel was called too early.
    Early { codel: CodelIx, first: CodelIx },
    /// A codel was called while an activity of this service ran.
    During { codel: CodelIx, service: ServiceIx },
    /// A codel yielded this.
    Step { from: StateIx, to: StateIx },
    /// A cycle of a task took or takes so long.
    Cycle { task: TaskIx, ns: u64, over: bool },
    /// An activity that was asked to stop takes so long.
    Stop { service: ServiceIx, ns: u64 },
    /// A heartbeat came so long after the one before.
    Soon { ns: u64 },
    /// A heartbeat did not come for so long.
    Late { ns: u64 },
    /// Something happened that is not allowed in this state of an order.
    Disordered { what: Happening, state: u8 },
    /// This part of a formula did not hold when something happened.
    False { what: Happening, part: u8 },
}

impl From<OffBeat> for Fact {
    fn from(beat: OffBeat) -> Self {
        match beat {
            OffBeat::Soon(ns) => Self::Soon { ns },
            OffBeat::Late(ns) => Self::Late { ns },
        }
    }
}

impl Seen {
    /// The same in words.
    pub(crate) fn violation(self, model: &Component, rule: &Rule, count: u64) -> Violation {
        let thread = match self.fact {
            Fact::Lasts { thread, .. } => Some(thread).filter(|thread| *thread > 0),
            _ => None,
        };
        Violation {
            rule: self.rule,
            what: self.fact.tell(model, rule),
            activity: Some(self.activity).filter(|activity| *activity > 0),
            count,
            date: self.date,
            thread,
            value: self.fact.value(),
            bound: self.fact.bound(rule),
        }
    }
}

impl Fact {
    fn tell(self, model: &Component, rule: &Rule) -> String {
        let codel = |ix: CodelIx| {
            let codel = &model.codels[ix];
            format!("codel {} of {}", codel.name, owner_name(model, codel.owner))
        };
        let state = |ix: StateIx| model.states.get(ix).map_or("ether", String::as_str);
        match self {
            Self::Took { codel: ix, ns } => format!("{} took {}", codel(ix), time(ns)),
            Self::Lasts { codel: ix, ns, .. } => {
                format!("{} has not returned for {}", codel(ix), time(ns))
            }
            Self::Activity { service, ns } => {
                format!("activity {} has taken {}", model.services[service].name, time(ns))
            }
            Self::Missed { task, ticks } => {
                let ticks = if ticks == 1 { "a tick".to_owned() } else { format!("{ticks} ticks") };
                format!("task {} missed {ticks}", model.tasks[task].name)
            }
            Self::Early { codel: ix, first } => {
                format!("{} was called before codel {}", codel(ix), model.codels[first].name)
            }
            Self::During { codel: ix, service } => {
                let service = &model.services[service].name;
                format!("{} was called while activity {service} ran", codel(ix))
            }
            Self::Step { from, to } => format!("it went from {} to {}", state(from), state(to)),
            Self::Cycle { task, ns, over } => {
                let took = if over { "took" } else { "has taken" };
                format!("a cycle of task {} {took} {}", model.tasks[task].name, time(ns))
            }
            Self::Stop { service, ns } => {
                let name = &model.services[service].name;
                format!("activity {name} was asked to stop {} ago", time(ns))
            }
            Self::Soon { ns } => {
                let (what, done) = beat(model, rule);
                format!("{what} was {done} {} after the time before", time(ns))
            }
            Self::Late { ns } => {
                let (what, done) = beat(model, rule);
                format!("{what} was not {done} for {}", time(ns))
            }
            Self::Disordered { what, state } => {
                let Rule::Order(order) = rule else { return what.tell(model) };
                let allowed = order.allowed(state);
                let allowed = match allowed.is_empty() {
                    true => "nothing of it may happen any more".to_owned(),
                    false => format!("only {} may come", allowed.join(", ")),
                };
                format!("{} in state {}, where {allowed}", what.tell(model), order.state(state))
            }
            Self::False { what, part } => {
                let Rule::Formula(program) = rule else { return what.tell(model) };
                format!("{}, and `{}` did not hold", what.tell(model), program.text(part.into()))
            }
        }
    }

    /// What was measured: nanoseconds, or ticks.
    fn value(self) -> Option<u64> {
        match self {
            Self::Took { ns, .. }
            | Self::Lasts { ns, .. }
            | Self::Activity { ns, .. }
            | Self::Cycle { ns, .. }
            | Self::Stop { ns, .. }
            | Self::Soon { ns }
            | Self::Late { ns } => Some(ns),
            Self::Missed { ticks, .. } => Some(ticks),
            Self::Early { .. }
            | Self::During { .. }
            | Self::Step { .. }
            | Self::Disordered { .. }
            | Self::False { .. } => None,
        }
    }

    /// What that was compared with.
    fn bound(self, rule: &Rule) -> Option<u64> {
        match (rule, self) {
            (Rule::Missed { ticks, .. }, _) => Some(*ticks),
            (Rule::Longest { codels }, Self::Took { codel, .. } | Self::Lasts { codel, .. }) => {
                codels.iter().find(|(own, _)| *own == codel).map(|(_, limit)| nanos(*limit))
            }
            (
                Rule::Activity { longest, .. }
                | Rule::Cycle { longest, .. }
                | Rule::Stop { longest, .. },
                _,
            ) => Some(nanos(*longest)),
            (Rule::Beat { least, .. }, Self::Soon { .. }) => Some(nanos(*least)),
            (Rule::Beat { longest, .. }, _) => Some(nanos(*longest)),
            _ => None,
        }
    }
}

/// What beats, and what is done to it: `codel arm_servo`, `called`.
fn beat(model: &Component, rule: &Rule) -> (String, &'static str) {
    match rule {
        Rule::Beat { of: Beats::Port(port), .. } => {
            (format!("port {}", model.ports[*port].name), "written")
        }
        Rule::Beat { of: Beats::Codels(codels), .. } => {
            let name = codels.first().map_or("", |ix| model.codels[*ix].name.as_str());
            (format!("codel {name}"), "called")
        }
        _ => (String::new(), "seen"),
    }
}

/// With three digits: `7.25 ms`, `12.0 s`.
#[allow(clippy::cast_precision_loss, reason = "three digits are shown")]
fn time(ns: u64) -> String {
    let (value, unit) = match ns {
        0..1_000_000 => (ns as f64 / 1e3, "us"),
        1_000_000..1_000_000_000 => (ns as f64 / 1e6, "ms"),
        _ => (ns as f64 / 1e9, "s"),
    };
    let digits = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_told_with_three_digits() {
        assert_eq!([7_250_000, 12_000_000_000, 999, 431_200].map(time).join(", "), {
            "7.25 ms, 12.0 s, 1.00 us, 431 us"
        });
    }
}
