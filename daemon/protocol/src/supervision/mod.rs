//! What a component is supervised by, and what is done when a rule is broken: alive, deadline and
//! logical supervision, in the words of AUTOSAR; heartbeats, in those of S-CORE; and formulas.

mod condition;
mod formula;
mod order;
mod read;
mod response;
mod short;

use serde::{Deserialize, Serialize};

use crate::several::{Item, one_or_several};
use crate::{Reaction, is_false};

pub use condition::{Beats, Condition, Kind, MOST_RULES, NoRule, Whose};
pub use formula::{Atom, Formula, MOST_PARTS, MOST_TEXT, NoFormula, What, Within};
pub use order::{MOST_STEPS, NoOrder, Order, OrderStep};
pub use response::{OwnResponse, Response};

/// A rule, and what is done when it is broken.
///
/// Each says one of: `task` with `missed` and `within_ms`; `codel`, `activity` or `task` with
/// `longest_ms`; `activity` with `longest_stop_ms`; `wcet`; `stuck`; `codel` or `port` with `every_ms`
/// and `while`; `codel` or `service` with `after` or `never_while`; `activity` or `task` with `from`
/// and `to`; `order`; `formula`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SupervisionEntry {
    /// A task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// A codel: the name of its function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// A service that is an activity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub activity: Option<String>,
    /// A service of any kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub service: Option<String>,
    /// An out port.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<String>,
    /// Alive: the task misses so many ticks within `within_ms`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 1, maximum = 1000))]
    pub missed: Option<u32>,
    /// Milliseconds of the window for `missed`; 1000 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub within_ms: Option<f64>,
    /// Deadline: milliseconds that a call of the codel may take, the activity from its acceptance to
    /// its end, or a cycle of the task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub longest_ms: Option<f64>,
    /// Deadline: milliseconds that the activity may take to its end once it was asked to stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub longest_stop_ms: Option<f64>,
    /// Deadline: a call may take the `wcet` of the description: of this `codel`, or of each that
    /// states one.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wcet: bool,
    /// Deadline: this `codel`, or any of the component, counts as stuck (`stuck_after`).
    #[serde(default, skip_serializing_if = "is_false")]
    pub stuck: bool,
    /// Heartbeat: the least and the longest time in milliseconds between two calls of the codel, or
    /// two values of the port.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_ms: Option<[f64; 2]>,
    /// Heartbeat: only while an activity of this service runs. A codel of an activity is awaited only
    /// while that runs.
    #[serde(default, rename = "while", skip_serializing_if = "Option::is_none")]
    pub during: Option<String>,
    /// Logical: the codel is called before this one has returned, or the service starts before this
    /// one has ended, since the component started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Logical: the codel is called, or the service starts, while this service runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub never_while: Option<String>,
    /// Logical: the codel of this state of the activity, or of the task's permanent one...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// ...yields this state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
    /// Logical: steps `STATE: EVENT -> STATE`. The events that they name may happen only where a step
    /// allows it; the first step leaves the first state.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub order: Vec<String>,
    /// Formula: what must hold at each event that it names: `arm_move -> once[0, 2s] pose`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<String>,
    /// What is done: `event` by default.
    #[serde(default, deserialize_with = "one_or_several", skip_serializing_if = "Vec::is_empty")]
    pub reaction: Vec<Response>,
}

impl SupervisionEntry {
    /// What is done, at least an event.
    #[must_use]
    pub fn responses(&self) -> Vec<Response> {
        match self.reaction.is_empty() {
            true => vec![Response::Own(OwnResponse::Event)],
            false => self.reaction.clone(),
        }
    }

    /// What is done of other components.
    pub fn others(&self) -> impl Iterator<Item = &Reaction> {
        self.reaction.iter().filter_map(|one| match one {
            Response::Other(reaction) => Some(reaction),
            Response::Own(_) => None,
        })
    }

    /// Whether this is done.
    #[must_use]
    pub fn does(&self, own: OwnResponse) -> bool {
        self.responses().iter().any(|one| one.is(own))
    }
}

impl Item for SupervisionEntry {
    const EXPECTED: &str = "a table with a rule, or a list of such tables";

    fn mistake(&self) -> Option<String> {
        self.condition().err().map(|error| error.to_string())
    }
}

/// Reads one rule, or a list of them.
pub(crate) fn rules<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> Result<Vec<SupervisionEntry>, D::Error> {
    let all: Vec<SupervisionEntry> = one_or_several(from)?;
    match all.len() {
        0..=MOST_RULES => Ok(all),
        count => Err(serde::de::Error::custom(NoRule::Many(count))),
    }
}

/// A rule of a running component, and how often it was broken.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Rule {
    /// What must not happen: `codel demo_servo takes more than 2 ms`.
    pub rule: String,
    /// `alive`, `deadline`, `logical`, `heartbeat` or `formula`.
    pub kind: Kind,
    /// What is done when it does.
    pub reactions: Vec<String>,
    /// How often it did since the component started.
    pub violations: u64,
    /// When it did last; absent if never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last: Option<Broken>,
}

/// A rule was broken.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Broken {
    /// What happened; of a formula, the part that did not hold.
    pub what: String,
    /// Milliseconds since 1970, by the clock of the machine.
    pub unix_ms: u64,
    /// The activity that did it; absent if none did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub activity: Option<u64>,
    /// What was measured, in nanoseconds, or the number of ticks missed; absent for orders and
    /// formulas.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<u64>,
    /// What it was compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<u64>,
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::LoadRequest;

    fn read(supervision: Value) -> Result<Vec<SupervisionEntry>, String> {
        let request = json!({"library": "arm", "supervision": supervision});
        let read: Result<LoadRequest, _> = serde_json::from_value(request);
        read.map(|request| request.supervision).map_err(|error| error.to_string())
    }

    fn told(supervision: Value) -> String {
        let one = &read(supervision).unwrap()[0];
        let reactions: Vec<String> = one.responses().iter().map(ToString::to_string).collect();
        let condition = one.condition().unwrap();
        format!("{:?} {condition}: {}", condition.kind(), reactions.join(", "))
    }

    #[test]
    fn a_rule_of_each_kind_is_read_and_told_in_words() {
        for (rule, words) in [
            (
                json!({"task": "main", "missed": 3, "within_ms": 250, "reaction": "interrupt"}),
                "Alive task main misses 3 ticks within 0.25 s: interrupt",
            ),
            (json!({"task": "main", "missed": 1}), "Alive task main misses a tick: event"),
            (
                json!({"codel": "servo", "longest_ms": 2.5, "reaction": ["log", "restart"]}),
                "Deadline codel servo takes more than 2.5 ms: log, restart",
            ),
            (json!({"activity": "goto", "longest_ms": 30000}), {
                "Deadline activity goto takes more than 30 s: event"
            }),
            (json!({"wcet": true}), "Deadline a codel takes more than its wcet: event"),
            (json!({"wcet": true, "codel": "f"}), {
                "Deadline codel f takes more than its wcet: event"
            }),
            (
                json!({"stuck": true, "reaction": {"call": "base/stop", "inputs": {"hard": true}}}),
                "Deadline a codel does not return: call base/stop",
            ),
            (json!({"codel": "move", "after": "calibrate"}), {
                "Logical codel move is called before calibrate has returned: event"
            }),
            (json!({"codel": "reset", "never_while": "goto"}), {
                "Logical codel reset is called while activity goto runs: event"
            }),
            (json!({"activity": "goto", "from": "main", "to": "start"}), {
                "Logical activity goto goes from main to start: event"
            }),
            (json!({"task": "main", "longest_ms": 4}), {
                "Deadline a cycle of task main takes more than 4 ms: event"
            }),
            (json!({"activity": "goto", "longest_stop_ms": 200, "reaction": "kill"}), {
                "Deadline activity goto takes more than 0.2 s to stop: kill"
            }),
            (json!({"port": "pose", "every_ms": [0, 12], "while": "goto"}), {
                "Heartbeat port pose is not written every 0 to 12 ms while goto runs: event"
            }),
            (json!({"codel": "f", "every_ms": [8, 12], "reaction": "withhold"}), {
                "Heartbeat codel f is not called every 8 ms to 12 ms: withhold"
            }),
            (json!({"service": "reset", "never_while": "goto"}), {
                "Logical service reset starts while goto runs: event"
            }),
            (json!({"service": "move", "after": "calibrate"}), {
                "Logical service move starts before calibrate has ended: event"
            }),
            (json!({"order": ["new: calibrate -> ready", "ready: move -> ready"]}), {
                "Logical something comes out of order: new: calibrate -> ready, ready: move -> ready: \
                 event"
            }),
            (json!({"formula": "[] (main -> once[0,2s] pose)"}), {
                "Formula this does not hold: main -> once[0, 2 s] pose: event"
            }),
        ] {
            assert_eq!(told(rule), words);
        }
    }

    #[test]
    fn a_rule_is_written_as_it_was_read() {
        let all = json!([
            {"task": "main", "missed": 3, "within_ms": 250.0, "reaction": ["interrupt"]},
            {"wcet": true, "reaction": ["event", {"fire": "base/emergency"}]},
        ]);
        let read = read(all.clone()).unwrap();
        assert_eq!(serde_json::to_value(&read).unwrap(), all);
        let request = LoadRequest { supervision: read, ..LoadRequest::default() };
        let text = toml::to_string(&request).unwrap();
        assert_eq!(toml::from_str::<LoadRequest>(&text).unwrap(), request, "{text}");
    }

    #[test]
    fn what_is_no_rule_is_refused_with_what_a_rule_is() {
        for (wrong, why) in [
            (json!({}), "says no rule"),
            (json!({"task": "main"}), "says no rule"),
            (json!({"codel": "f", "missed": 3}), "says no rule"),
            (json!({"codel": "f", "longest_ms": 1, "after": "g"}), "says no rule"),
            (json!({"codel": "f", "task": "g", "longest_ms": 1}), "says no rule"),
            (json!({"activity": "a", "from": "main"}), "says no rule"),
            (json!({"codel": "f", "longest_ms": 1, "within_ms": 3}), "says no rule"),
            (json!({"codel": "f", "longest_ms": 0}), "`longest_ms` is 0, and is to be"),
            (json!({"codel": "f", "longest_ms": -1}), "`longest_ms` is -1"),
            (json!({"codel": "f", "longest_ms": 1e300}), "`longest_ms` is 1"),
            (json!({"task": "t", "missed": 0}), "`missed` is 0"),
            (json!({"activity": "a", "longest_stop_ms": 0}), "`longest_stop_ms` is 0"),
            (json!({"port": "p", "every_ms": [3, 3]}), "`every_ms` is [3, 3], and is to be"),
            (json!({"port": "p", "every_ms": [-1, 3]}), "`every_ms` is [-1, 3]"),
            (json!({"port": "p", "every_ms": [0, 1e10]}), "`every_ms` is 10000000000"),
            (json!({"port": "p", "every_ms": [1]}), "invalid length 1"),
            (json!({"port": "p", "while": "a"}), "says no rule"),
            (json!({"service": "s", "longest_ms": 1}), "says no rule"),
            (json!({"order": []}), "says no rule"),
            (json!({"order": ["a"]}), "step 1 of `order`, column 2"),
            (json!({"formula": "a ->"}), "supervision: `formula`, column 5"),
            (json!({"formula": "a or ".repeat(2000)}), "10000 bytes, and 1000 are the most"),
            (json!({"formula": "a", "codel": "f"}), "says no rule"),
            (json!({"task": "t", "missed": 1001}), "`missed` is 1001"),
            (json!({"task": "t", "missed": 4_294_967_296_u64}), "invalid value"),
            (json!({"task": "t", "missed": 3, "within_ms": 0}), "`within_ms` is 0"),
            (json!({"stuck": true, "reaction": "restrat"}), "did you mean `restart`?"),
            (json!({"stuck": true, "reaction": {"call": "base"}}), "`base` is no COMPONENT/NAME"),
            (json!({"stuck": true, "reaction": {}}), "takes one of"),
            (json!({"stuck": true, "reaction": 3}), "`log`, `event`, `interrupt`, `kill`"),
            (json!({"wcet": true, "deadline": 3}), "unknown field `deadline`"),
            (json!("wcet"), "a table with a rule"),
            (json!(vec![json!({"wcet": true}); 33]), "33 rules, and 32 are the most"),
            (json!({"wcet": true, "reaction": vec!["log"; 9]}), "9 reactions"),
        ] {
            let refused = read(wrong.clone()).unwrap_err();
            assert!(refused.contains(why), "{wrong}: {refused}");
        }
    }
}
