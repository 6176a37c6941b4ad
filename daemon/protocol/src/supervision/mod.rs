//! What a component is supervised by, and what is done when a rule is broken: alive, deadline and
//! logical supervision, in the words of AUTOSAR.

mod condition;
mod response;

use serde::{Deserialize, Serialize};

use crate::several::{Item, one_or_several};
use crate::{Reaction, is_false};

pub use condition::{Condition, Kind, MOST_RULES, NoRule, Whose};
use condition::{MOST_MISSED, MOST_REACTIONS, WITHIN_MS, time};
pub use response::{OwnResponse, Response};

/// A rule, and what is done when it is broken.
///
/// Each says one of: `task` with `missed` and `within_ms`; `codel` or `activity` with `longest_ms`;
/// `wcet`; `stuck`; `codel` with `after` or `never_while`; `activity` or `task` with `from` and `to`.
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
    /// Alive: the task misses so many ticks within `within_ms`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 1, maximum = 1000))]
    pub missed: Option<u32>,
    /// Milliseconds of the window for `missed`; 1000 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub within_ms: Option<f64>,
    /// Deadline: milliseconds that a call of the codel may take, or the activity from its acceptance
    /// to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub longest_ms: Option<f64>,
    /// Deadline: a call may take the `wcet` of the description: of this `codel`, or of each that
    /// states one.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wcet: bool,
    /// Deadline: this `codel`, or any of the component, counts as stuck (`stuck_after`).
    #[serde(default, skip_serializing_if = "is_false")]
    pub stuck: bool,
    /// Logical: the codel is called before this one has returned, since the component started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// Logical: the codel is called while an activity of this service runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub never_while: Option<String>,
    /// Logical: the codel of this state of the activity, or of the task's permanent one...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// ...yields this state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
    /// What is done: `event` by default.
    #[serde(default, deserialize_with = "one_or_several", skip_serializing_if = "Vec::is_empty")]
    pub reaction: Vec<Response>,
}

impl SupervisionEntry {
    /// What must not happen.
    ///
    /// # Errors
    /// Its keys say no rule, or a number is out of range.
    pub fn condition(&self) -> Result<Condition, NoRule> {
        if self.reaction.len() > MOST_REACTIONS {
            return Err(NoRule::ManyReactions(self.reaction.len()));
        }
        let Self { task, codel, activity, missed, within_ms, longest_ms, .. } = self.clone();
        let Self { wcet, stuck, after, never_while, from, to, .. } = self.clone();
        let subject = (task, codel, activity);
        let words = (missed, within_ms, longest_ms, wcet, stuck);
        let order = (after, never_while, from, to);
        Ok(match (subject, words, order) {
            (
                (Some(task), None, None),
                (Some(missed), within, None, false, false),
                (None, None, None, None),
            ) => {
                if !(1..=MOST_MISSED).contains(&missed) {
                    let range = format!("from 1 to {MOST_MISSED}");
                    return Err(NoRule::Number { key: "missed", value: missed.into(), range });
                }
                let within = time("within_ms", within.unwrap_or(WITHIN_MS))?;
                Condition::Missed { task, ticks: missed, within }
            }
            (
                (None, Some(codel), None),
                (None, None, Some(longest), false, false),
                (None, None, None, None),
            ) => Condition::Longest { codel, longest: time("longest_ms", longest)? },
            (
                (None, None, Some(activity)),
                (None, None, Some(longest), false, false),
                (None, None, None, None),
            ) => Condition::Activity { activity, longest: time("longest_ms", longest)? },
            ((None, codel, None), (None, None, None, true, false), (None, None, None, None)) => {
                Condition::Wcet { codel }
            }
            ((None, codel, None), (None, None, None, false, true), (None, None, None, None)) => {
                Condition::Stuck { codel }
            }
            (
                (None, Some(codel), None),
                (None, None, None, false, false),
                (Some(first), None, None, None),
            ) => Condition::After { codel, first },
            (
                (None, Some(codel), None),
                (None, None, None, false, false),
                (None, Some(activity), None, None),
            ) => Condition::NeverWhile { codel, activity },
            (
                (task, None, activity),
                (None, None, None, false, false),
                (None, None, Some(from), Some(to)),
            ) => {
                let of = match (task, activity) {
                    (Some(task), None) => Whose::Task(task),
                    (None, Some(activity)) => Whose::Activity(activity),
                    _ => return Err(NoRule::Keys),
                };
                Condition::Step { of, from, to }
            }
            _ => return Err(NoRule::Keys),
        })
    }
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
    /// `alive`, `deadline` or `logical`.
    pub kind: Kind,
    /// What is done when it does.
    pub reactions: Vec<String>,
    /// How often it did since the component started.
    pub violations: u64,
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
            (json!({"task": "t", "missed": 1001}), "`missed` is 1001"),
            (json!({"task": "t", "missed": 4_294_967_296_u64}), "invalid value"),
            (json!({"task": "t", "missed": 3, "within_ms": 0}), "`within_ms` is 0"),
            (json!({"stuck": true, "reaction": "restrat"}), "did you mean `restart`?"),
            (json!({"stuck": true, "reaction": {"call": "base"}}), "`base` is no COMPONENT/NAME"),
            (json!({"stuck": true, "reaction": {}}), "takes one of"),
            (json!({"stuck": true, "reaction": 3}), "`log`, `event`, `interrupt`, `restart`"),
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
