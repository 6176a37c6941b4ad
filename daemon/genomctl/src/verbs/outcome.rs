//! Prints the outcome of a service.

use genom_protocol::{Activity, CallReply, Outcome};
use serde_json::Value;

use crate::failure::Failure;
use crate::session::{Reply, Session};

/// Prints the outcome of an activity, or fails with its exception. `what` names it.
pub(crate) fn show(session: &Session, what: &str, reply: &Reply<Activity>) -> Result<(), Failure> {
    print(session, what, &reply.sent, None, Some(&reply.content.outcome))
}

/// Prints the reply to a call or a start, or fails with its exception. `what` names the service.
pub(crate) fn show_call(
    session: &Session,
    what: &str,
    reply: &Reply<CallReply>,
) -> Result<(), Failure> {
    print(session, what, &reply.sent, reply.content.activity(), reply.content.outcome())
}

fn print(
    session: &Session,
    what: &str,
    sent: &Value,
    activity: Option<u64>,
    outcome: Option<&Outcome>,
) -> Result<(), Failure> {
    if session.json {
        session.print(&format!("{sent}\n"))?;
    }
    if let Some(exception) = outcome.and_then(|outcome| outcome.exception.clone()) {
        let detail = outcome.and_then(|outcome| outcome.detail.clone()).unwrap_or_default();
        return Err(Failure::Exception { what: what.to_owned(), exception, detail });
    }
    if session.json { Ok(()) } else { session.print(&render(activity, outcome)) }
}

/// One output per line; for a running activity its number; `done` if there is nothing else.
fn render(activity: Option<u64>, outcome: Option<&Outcome>) -> String {
    match (outcome.and_then(|outcome| outcome.result.as_ref()), activity) {
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
        let reply: CallReply = serde_json::from_value(reply).unwrap();
        assert_eq!(render(reply.activity(), reply.outcome()), shown);
    }

    #[test]
    fn outcomes_are_told_in_one_line_per_output() {
        check(json!({"activity": 3}), "activity 3\n");
        check(json!({"result": {}}), "done\n");
        check(json!({"result": {"velocity": 0.5, "ok": true}}), "velocity = 0.5\nok = true\n");
    }
}
