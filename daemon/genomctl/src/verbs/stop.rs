//! `genomctl stop`: stops all activities.

use std::time::{Duration, Instant};

use genom_protocol::{AbortedActivity, Code, LookParameters, Status, routes};
use serde::Serialize;
use serde_json::json;

use super::abort;
use crate::failure::Failure;
use crate::session::Session;
use crate::times::seconds;

/// Stop everything: ask every activity of every component to stop, and wait until all have ended.
///
/// Components stay loaded, with their ports connected; `genomctl kill` ends the daemon as well. The
/// exit status is 1 if an activity does not end in time.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How long the activities may take to end, all together, in seconds.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    within: Duration,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let aborted = abort::all(session, None).await?.content;
    if !session.json {
        session.print(&abort::render_all(&aborted))?;
    }
    let end = Instant::now() + args.within;
    let mut running = Vec::new();
    for one in &aborted.aborted {
        if let Some(state) = state_after(session, one, end).await? {
            running.push(Running { activity: one.clone(), state });
        }
    }
    let names: Vec<String> = running.iter().map(Running::to_string).collect();
    if session.json {
        session.print(&format!("{}\n", json!(Stopped { aborted: aborted.aborted, running })))?;
    } else if running.is_empty() && !aborted.aborted.is_empty() {
        session.print("all have ended\n")?;
    }
    if names.is_empty() {
        return Ok(());
    }
    Err(Failure::refused_with(
        Code::Timeout.name(),
        format!("after {} s run still: {}", args.within.as_secs_f64(), names.join(", ")),
        "`genomctl doctor` names codels that do not return; `genomctl unload COMPONENT` takes a \
         component down"
            .to_owned(),
    ))
}

/// The activities asked to stop, and those that have not ended; for `--json`.
#[derive(Serialize)]
struct Stopped {
    aborted: Vec<AbortedActivity>,
    running: Vec<Running>,
}

/// An activity that did not end in time.
#[derive(Serialize)]
struct Running {
    #[serde(flatten)]
    activity: AbortedActivity,
    state: String,
}

impl std::fmt::Display for Running {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let AbortedActivity { component, service, activity } = &self.activity;
        write!(f, "{component}/{service} (activity {activity}, {})", self.state)
    }
}

/// The state of an activity that still runs when the time is over; `None` if it ended.
async fn state_after(
    session: &Session,
    one: &AbortedActivity,
    end: Instant,
) -> Result<Option<String>, Failure> {
    let number = one.activity.to_string();
    let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
    let query = LookParameters { wait: Some(left) };
    match session.ask(routes::activity(&one.component, &number).with(&query)).await {
        Ok(looked) if looked.content.status == Status::Running => {
            Ok(Some(looked.content.state.unwrap_or_else(|| Status::Running.to_string())))
        }
        // The activity ended, and its component may have been unloaded.
        Ok(_) | Err(Failure::Refused(_)) => Ok(None),
        Err(failure) => Err(failure),
    }
}
