//! How a service ended, as the daemon tells it and as it is shown.

use serde::Deserialize;
use serde_json::Value;

use crate::failure::Failure;
use crate::session::Session;

/// Reply to a call, a start or a wait.
#[derive(Debug, Deserialize)]
pub(crate) struct Outcome {
    /// Number of the activity; none for attributes and functions.
    pub(crate) activity: Option<u64>,
    /// Outputs, once it ended well.
    pub(crate) result: Option<Value>,
    /// Full name of the exception it ended with.
    pub(crate) exception: Option<String>,
    /// Members of the exception.
    #[serde(default)]
    pub(crate) detail: Value,
}

impl Outcome {
    /// Whether it ended, well or not.
    pub(crate) fn ended(&self) -> bool {
        self.result.is_some() || self.exception.is_some()
    }
}

/// Prints the outcome, or fails with its exception. `what` names the service or activity.
pub(crate) fn show(session: &Session, what: &str, reply: Value) -> Result<(), Failure> {
    let outcome: Outcome = session.read(reply.clone())?;
    if session.json {
        session.print(&format!("{reply}\n"))?;
    }
    if let Some(exception) = outcome.exception {
        let detail = outcome.detail;
        return Err(Failure::Exception { what: what.to_owned(), exception, detail });
    }
    if session.json { Ok(()) } else { session.print(&render(&outcome)) }
}

/// Outputs one a line; an activity that runs says its number; nothing to say gives `done`.
pub(crate) fn render(outcome: &Outcome) -> String {
    match (&outcome.result, outcome.activity) {
        (None, Some(activity)) => format!("activity {activity}\n"),
        (Some(Value::Object(outputs)), _) if !outputs.is_empty() => {
            outputs.iter().map(|(name, value)| format!("{name} = {value}\n")).collect()
        }
        _ => "done\n".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn check(reply: Value, shown: &str) {
        assert_eq!(render(&serde_json::from_value(reply).unwrap()), shown);
    }

    #[test]
    fn outcomes_are_told_in_one_line_per_output() {
        check(json!({"activity": 3}), "activity 3\n");
        check(json!({"result": {}}), "done\n");
        check(json!({"result": {"velocity": 0.5, "ok": true}}), "velocity = 0.5\nok = true\n");
    }
}
