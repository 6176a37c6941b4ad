//! `genomctl wait`: waits for the end of an activity.

use clap_complete::engine::ArgValueCompleter;
use std::time::Instant;

use genom_protocol::{Activity, Code, LookParameters, routes};
use serde_json::json;

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::{Reply, Session};
use crate::terminal::Progress;
use crate::verbs::outcome;

/// Wait until an activity has ended, and print its outcome.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Number of the activity, or name of a service for its latest activity.
    #[arg(add = ArgValueCompleter::from(Names::Activities))]
    activity: String,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS")]
    timeout: Option<f64>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let activity = match args.activity.parse() {
        Ok(number) => number,
        Err(_) => {
            let found = session.ask(routes::activity(&args.component, &args.activity)).await?;
            found.content.activity
        }
    };
    let what = format!("{} activity {activity}", args.component);
    let Some(seconds) = args.timeout else {
        let reply = until_ended(session, &args.component, activity, &what).await?;
        return outcome::show(session, &what, &reply);
    };
    let reply = look(session, &args.component, activity, seconds).await?;
    if reply.content.outcome.ended() {
        return outcome::show(session, &what, &reply);
    }
    Err(Failure::refused_with(
        Code::Timeout.name(),
        format!("{what} still runs after {seconds} s"),
        format!("`genomctl abort {} {activity}` stops it", args.component),
    ))
}

/// Waits by repeated requests, each as long as the daemon holds one; on a terminal, shows `what`
/// with its state and the time elapsed.
pub(super) async fn until_ended(
    session: &Session,
    component: &str,
    activity: u64,
    what: &str,
) -> Result<Reply<Activity>, Failure> {
    let mut progress = Progress::default();
    let hold = if session.json || !progress.seen() { 60.0 } else { 0.5 };
    let begin = Instant::now();
    if hold < 1.0 {
        progress.show(what);
    }
    loop {
        let reply = match look(session, component, activity, hold).await {
            // The activity was accepted, and ended with the process of its cell.
            Err(Failure::Refused(reason)) if reason.is(Code::CellDown) => {
                return Err(Failure::Exception {
                    what: what.to_owned(),
                    exception: "::genom::gone".to_owned(),
                    detail: json!({ "why": reason.message }),
                });
            }
            reply => reply?,
        };
        if reply.content.outcome.ended() {
            return Ok(reply);
        }
        if hold < 1.0 {
            let state = reply.content.state.as_deref().unwrap_or("waiting");
            progress.show(&format!("{what}: {state}, {} s", begin.elapsed().as_secs()));
        }
    }
}

/// Asks about an activity; the daemon replies when it has ended, or after `seconds`.
async fn look(
    session: &Session,
    component: &str,
    activity: u64,
    seconds: f64,
) -> Result<Reply<Activity>, Failure> {
    let query = LookParameters { wait: Some(seconds) };
    session.ask(routes::activity(component, &activity.to_string()).with(&query)).await
}
