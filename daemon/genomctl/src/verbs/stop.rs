//! `genomctl stop`: everything that moves comes to rest.

use std::time::{Duration, Instant};

use serde_json::json;

use super::abort::{self, One, Told};
use crate::failure::{Failure, Refusal};
use crate::names::url;
use crate::session::Session;

/// Stop everything: tell every activity of every component to stop, and wait until all have ended.
///
/// Components stay loaded, with their ports connected; `genomctl kill` ends the daemon as well. Ends
/// with 1 when an activity does not end in time.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How long the activities may take to end, together, in seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    within: f64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let within = Duration::try_from_secs_f64(args.within)
        .map_err(|_| Failure::usage(format!("--within {}: no time", args.within), "try 10"))?;
    let mut reply = abort::all(session, None).await?;
    let told: Told = session.read(reply.clone())?;
    if !session.json {
        session.print(&abort::render_all(&told))?;
    }
    let end = Instant::now() + within;
    let mut left = Vec::new();
    for one in &told.aborted {
        if let Some(state) = state_after(session, one, end).await? {
            left.push((one, state));
        }
    }
    if session.json {
        let left = left.iter().map(|(one, state)| {
            json!({"component": one.component, "service": one.service,
                   "activity": one.activity, "state": state})
        });
        reply["running"] = left.collect();
        session.print(&format!("{reply}\n"))?;
    } else if left.is_empty() && !told.aborted.is_empty() {
        session.print("all have ended\n")?;
    }
    if left.is_empty() {
        return Ok(());
    }
    let told = left.iter().map(|(One { component, service, activity }, state)| {
        format!("{component}/{service} (activity {activity}, {state})")
    });
    Err(Failure::Refused(Refusal {
        code: "timeout".to_owned(),
        message: format!(
            "after {} s run still: {}",
            args.within,
            told.collect::<Vec<_>>().join(", ")
        ),
        place: None,
        help: Some(
            "`genomctl doctor` names codels that do not return; `genomctl unload COMPONENT` takes \
             a component down"
                .to_owned(),
        ),
    }))
}

/// The state of an activity that runs at the end of the time; `None` when it ended.
async fn state_after(
    session: &Session,
    one: &One,
    end: Instant,
) -> Result<Option<String>, Failure> {
    let number = one.activity.to_string();
    let path = url(["components", &one.component, "activities", &number]);
    let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
    match session.get(&format!("{path}?wait={left}")).await {
        Ok(looked) if looked["status"] == "running" => {
            Ok(Some(looked["state"].as_str().unwrap_or("running").to_owned()))
        }
        // It ended, and so did its component perhaps.
        Ok(_) | Err(Failure::Refused(_)) => Ok(None),
        Err(failure) => Err(failure),
    }
}
