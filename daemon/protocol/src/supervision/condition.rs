//! What must not happen, taken apart from its keys.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Limit on the rules of a component.
pub const MOST_RULES: usize = 32;
/// Limit on `missed`.
pub(super) const MOST_MISSED: u32 = 1000;
/// Limit on times in milliseconds.
const MOST_MS: f64 = 1e9;
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
    /// Orders of codels and states.
    Logical,
}

impl Kind {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::Deadline => "deadline",
            Self::Logical => "logical",
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
}

/// Why a rule is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoRule {
    /// Keys that are too few, too many, or do not belong together.
    #[error(
        "supervision says no rule: one is `task` with `missed` (and `within_ms`); `codel` or \
         `activity` with `longest_ms`; `wcet = true` or `stuck = true`, also with `codel`; `codel` \
         with `after` or `never_while`; `activity` or `task` with `from` and `to`"
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
            | Self::Wcet { .. }
            | Self::Stuck { .. } => Kind::Deadline,
            Self::After { .. } | Self::NeverWhile { .. } | Self::Step { .. } => Kind::Logical,
        }
    }
}

/// `2.5 ms`, `30 s`.
struct Short(Duration);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_secs_f64() {
            seconds if seconds < 0.1 => write!(f, "{} ms", seconds * 1e3),
            seconds => write!(f, "{seconds} s"),
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
        }
    }
}
