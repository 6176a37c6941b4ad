//! `genomctl wait`: until an activity has ended.

use clap_complete::engine::ArgValueCompleter;
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;
use crate::terminal::Progress;
use crate::verbs::outcome::{self, Outcome};

/// Wait until an activity has ended, and tell how.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Number of the activity, or name of a service: then its latest.
    #[arg(add = ArgValueCompleter::from(Names::Activities))]
    activity: String,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS")]
    timeout: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Found {
    activity: u64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let activity = match args.activity.parse() {
        Ok(number) => number,
        Err(_) => {
            let url = url(["components", &args.component, "activities", &args.activity]);
            session.read::<Found>(session.get(&url).await?)?.activity
        }
    };
    let what = format!("{} activity {activity}", args.component);
    let Some(seconds) = args.timeout else {
        let reply = until_ended(session, &args.component, activity, &what).await?;
        return outcome::show(session, &what, reply);
    };
    let reply = session.get(&path(&args.component, activity, seconds)).await?;
    let outcome: Outcome = session.read(reply.clone())?;
    if outcome.ended() {
        return outcome::show(session, &what, reply);
    }
    Err(Failure::Refused(crate::failure::Refusal {
        code: "timeout".to_owned(),
        message: format!("{what} still runs after {seconds} s"),
        place: None,
        help: Some(format!("`genomctl abort {} {activity}` stops it", args.component)),
    }))
}

/// Asks again and again, each time for as long as the daemon holds a request; on a terminal, `what`
/// is shown with its state and the time that passes.
pub(super) async fn until_ended(
    session: &Session,
    component: &str,
    activity: u64,
    what: &str,
) -> Result<Value, Failure> {
    let mut progress = Progress::default();
    let hold = if session.json || !progress.seen() { 60.0 } else { 0.5 };
    let begin = Instant::now();
    if hold < 1.0 {
        progress.show(what);
    }
    loop {
        let reply = session.get(&path(component, activity, hold)).await?;
        let outcome: Outcome = session.read(reply.clone())?;
        if outcome.ended() {
            return Ok(reply);
        }
        if hold < 1.0 {
            let state = reply["state"].as_str().unwrap_or("waiting");
            progress.show(&format!("{what}: {state}, {} s", begin.elapsed().as_secs()));
        }
    }
}

fn path(component: &str, activity: u64, seconds: f64) -> String {
    let number = activity.to_string();
    format!("{}?wait={seconds}", url(["components", component, "activities", &number]))
}
