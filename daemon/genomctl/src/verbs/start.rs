//! `genomctl start`: an activity, and on request its end.

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;
use crate::verbs::outcome::{self, Outcome};
use clap_complete::engine::ArgValueCompleter;

/// Start an activity; its number is printed at once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// The activity.
    #[arg(add = ArgValueCompleter::from(Names::Startable))]
    service: String,
    /// Inputs: '{"goal": 1.0}' or goal=1.0; what is missing takes its default.
    #[arg(add = ArgValueCompleter::from(Names::Inputs))]
    inputs: Vec<String>,
    /// Wait for its end; Ctrl-C aborts it, a second Ctrl-C leaves it alone.
    #[arg(long, short)]
    wait: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let inputs = crate::inputs::parse(&args.inputs)?;
    let path = url(["components", &args.component, "services", &args.service]);
    let reply = session.post(&path, &inputs).await?;
    let so_far: Outcome = session.read(reply.clone())?;
    match so_far.activity {
        Some(activity) if args.wait && !so_far.ended() => {
            wait_for(session, &args.component, &args.service, activity).await
        }
        _ => outcome::show(session, &format!("{}/{}", args.component, args.service), reply),
    }
}

/// Waits for the end of an activity that this command started.
pub(super) async fn wait_for(
    session: &Session,
    component: &str,
    service: &str,
    activity: u64,
) -> Result<(), Failure> {
    let what = format!("{component}/{service} (activity {activity})");
    let end = super::wait::until_ended(session, component, activity);
    tokio::pin!(end);
    tokio::select! {
        reply = &mut end => return outcome::show(session, &what, reply?),
        _ = tokio::signal::ctrl_c() => {}
    }
    let number = activity.to_string();
    session.delete(&url(["components", component, "activities", &number])).await?;
    tokio::select! {
        reply = end => outcome::show(session, &what, reply?),
        _ = tokio::signal::ctrl_c() => Err(Failure::Exception {
            what,
            exception: "nothing yet: abort was asked, not waited for".to_owned(),
            detail: serde_json::Value::Null,
        }),
    }
}
