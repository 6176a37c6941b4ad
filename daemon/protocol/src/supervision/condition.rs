//! What must not happen, taken apart from its keys.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::formula::{Formula, NoFormula};
use super::order::{NoOrder, Order};
use super::short::Short;

/// Limit on the rules of a component.
pub const MOST_RULES: usize = 32;
/// Limit on `missed`.
pub(super) const MOST_MISSED: u32 = 1000;
/// Limit on times in milliseconds.
pub(super) const MOST_MS: f64 = 1e9;
/// Limit on the reactions of a rule.
pub(super) const MOST_REACTIONS: usize = 8;
/// Window of `missed` where none is given.
pub(super) const WITHIN_MS: f64 = 1000.0;

/// The kinds of supervision (AUTOSAR Watchdog Manager).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Kind {
    /// Periods of a task.
    Alive,
    /// Times of codels and activities.
    Deadline,
    /// Orders of codels, services and states.
    Logical,
    /// Time between two calls of a codel, or two values of a port.
    Heartbeat,
    /// What holds at each event.
    Formula,
}

impl Kind {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::Deadline => "deadline",
            Self::Logical => "logical",
            Self::Heartbeat => "heartbeat",
            Self::Formula => "formula",
        }
    }
}

/// Whose state machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Whose {
    /// That of an activity's service.
    Activity(String),
    /// That of the permanent activity of a task.
    Task(String),
}

impl fmt::Display for Whose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Activity(name) => write!(f, "activity {name}"),
            Self::Task(name) => write!(f, "task {name}"),
        }
    }
}

/// Whose heartbeat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Beats {
    /// The calls of a codel.
    Codel(String),
    /// The values that codels write on a port.
    Port(String),
}

impl fmt::Display for Beats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Codel(name) => write!(f, "codel {name} is not called"),
            Self::Port(name) => write!(f, "port {name} is not written"),
        }
    }
}

/// What must not happen. Names are not looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "members are named as the keys")]
pub enum Condition {
    /// A task misses ticks.
    Missed { task: String, ticks: u32, within: Duration },
    /// A codel takes longer.
    Longest { codel: String, longest: Duration },
    /// An activity takes longer.
    Activity { activity: String, longest: Duration },
    /// A codel, or any, takes longer than its `wcet`.
    Wcet { codel: Option<String> },
    /// A codel, or any, does not return.
    Stuck { codel: Option<String> },
    /// A codel comes before another.
    After { codel: String, first: String },
    /// A codel runs while an activity does.
    NeverWhile { codel: String, activity: String },
    /// A step between two states.
    Step { of: Whose, from: String, to: String },
    /// A cycle of a task takes longer.
    Cycle { task: String, longest: Duration },
    /// An activity that was asked to stop takes longer.
    Stop { activity: String, longest: Duration },
    /// Something comes too early or too late, while an activity runs or always.
    Beat { of: Beats, least: Duration, longest: Duration, during: Option<String> },
    /// A service starts before another one has ended.
    ServiceAfter { service: String, first: String },
    /// A service starts while another one runs.
    ServiceNeverWhile { service: String, other: String },
    /// Something happens that no step allows.
    Order(Order),
    /// It does not hold.
    Formula(Formula),
}

/// Why a rule is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoRule {
    /// Keys that are too few, too many, or do not belong together.
    #[error(
        "supervision says no rule: one is `task` with `missed` (and `within_ms`); `codel`, \
         `activity` or `task` with `longest_ms`; `activity` with `longest_stop_ms`; `wcet = true` \
         or `stuck = true`, also with `codel`; `codel` or `port` with `every_ms` (and `while`); \
         `codel` or `service` with `after` or `never_while`; `activity` or `task` with `from` and \
         `to`; `order`; `formula`"
    )]
    Keys,
    /// A number out of range.
    #[error("supervision: `{key}` is {value}, and is to be {range}")]
    Number {
        /// The key.
        key: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: String,
    },
    /// Two times the wrong way round.
    #[error(
        "supervision: `every_ms` is [{0}, {1}], and is to be [LEAST, LONGEST] in milliseconds: from 0 \
         on, the first less than the second"
    )]
    Every(f64, f64),
    /// No formula.
    #[error("supervision: `formula`, {0}")]
    Formula(#[from] NoFormula),
    /// No order.
    #[error("supervision: {0}")]
    Order(#[from] NoOrder),
    /// Too many rules.
    #[error("supervision: {0} rules, and {MOST_RULES} are the most that a component has")]
    Many(usize),
    /// Too many reactions.
    #[error("supervision: {0} reactions, and {MOST_REACTIONS} are the most that a rule has")]
    ManyReactions(usize),
}

/// A time of the configuration.
pub(super) fn time(key: &'static str, ms: f64) -> Result<Duration, NoRule> {
    let range = || format!("more than 0 and at most {MOST_MS}");
    match ms > 0.0 && ms <= MOST_MS {
        true => Ok(Duration::from_secs_f64(ms / 1e3).max(Duration::from_nanos(1))),
        false => Err(NoRule::Number { key, value: ms, range: range() }),
    }
}

impl Condition {
    /// Which kind of supervision it is.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Missed { .. } => Kind::Alive,
            Self::Longest { .. }
            | Self::Activity { .. }
            | Self::Cycle { .. }
            | Self::Stop { .. }
            | Self::Wcet { .. }
            | Self::Stuck { .. } => Kind::Deadline,
            Self::After { .. }
            | Self::NeverWhile { .. }
            | Self::ServiceAfter { .. }
            | Self::ServiceNeverWhile { .. }
            | Self::Order(_)
            | Self::Step { .. } => Kind::Logical,
            Self::Beat { .. } => Kind::Heartbeat,
            Self::Formula(_) => Kind::Formula,
        }
    }
}

impl fmt::Display for Condition {
    /// What happens when it is broken: `codel demo_servo takes more than 2 ms`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let codel = |codel: &Option<String>| {
            codel.as_ref().map_or("a codel".to_owned(), |name| format!("codel {name}"))
        };
        match self {
            Self::Missed { task, ticks: 1, .. } => write!(f, "task {task} misses a tick"),
            Self::Missed { task, ticks, within } => {
                write!(f, "task {task} misses {ticks} ticks within {}", Short(*within))
            }
            Self::Longest { codel, longest } => {
                write!(f, "codel {codel} takes more than {}", Short(*longest))
            }
            Self::Activity { activity, longest } => {
                write!(f, "activity {activity} takes more than {}", Short(*longest))
            }
            Self::Wcet { codel: of } => write!(f, "{} takes more than its wcet", codel(of)),
            Self::Stuck { codel: of } => write!(f, "{} does not return", codel(of)),
            Self::After { codel, first } => {
                write!(f, "codel {codel} is called before {first} has returned")
            }
            Self::NeverWhile { codel, activity } => {
                write!(f, "codel {codel} is called while activity {activity} runs")
            }
            Self::Step { of, from, to } => write!(f, "{of} goes from {from} to {to}"),
            Self::Cycle { task, longest } => {
                write!(f, "a cycle of task {task} takes more than {}", Short(*longest))
            }
            Self::Stop { activity, longest } => {
                let longest = Short(*longest);
                write!(f, "activity {activity} takes more than {longest} to stop")
            }
            Self::Beat { of, least, longest, during } => {
                write!(f, "{of} every {} to {}", Short(*least), Short(*longest))?;
                during.as_ref().map_or(Ok(()), |activity| write!(f, " while {activity} runs"))
            }
            Self::ServiceAfter { service, first } => {
                write!(f, "service {service} starts before {first} has ended")
            }
            Self::ServiceNeverWhile { service, other } => {
                write!(f, "service {service} starts while {other} runs")
            }
            Self::Order(order) => write!(f, "something comes out of order: {order}"),
            Self::Formula(formula) => write!(f, "this does not hold: {formula}"),
        }
    }
}
