//! `genomctl start`: starts an activity, and waits for its end on request.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::routes;

use crate::complete::Names;
use crate::failure::Failure;
use crate::prompt;
use crate::session::Session;
use crate::verbs::outcome;
use tokio::signal::unix::{SignalKind, signal};

/// Start an activity and print its number.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// The activity.
    #[arg(add = ArgValueCompleter::from(Names::Startable))]
    service: String,
    /// Inputs: '{"goal": 1.0}' or goal=1.0; those left out take their defaults. On a terminal,
    /// inputs are asked for if none are given; '{}' leaves all out.
    #[arg(add = ArgValueCompleter::from(Names::Inputs))]
    inputs: Vec<String>,
    /// Inputs that are left out take their defaults, or zero where there is none; also those of an
    /// attribute.
    #[arg(long)]
    zero: bool,
    /// Wait for its end. Ctrl-C aborts it; a second Ctrl-C stops waiting.
    #[arg(long, short)]
    wait: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply =
        prompt::call(session, &args.component, &args.service, &args.inputs, args.zero).await?;
    match reply.content.activity() {
        Some(activity) if args.wait && reply.content.outcome().is_none() => {
            wait_for(session, &args.component, &args.service, activity).await
        }
        _ => outcome::show_call(session, &format!("{}/{}", args.component, args.service), &reply),
    }
}

/// Waits for the end of an activity that this command started. Ctrl-C aborts it; a second one stops
/// waiting.
pub(super) async fn wait_for(
    session: &Session,
    component: &str,
    service: &str,
    activity: u64,
) -> Result<(), Failure> {
    let what = format!("{component}/{service} (activity {activity})");
    // Before anything is printed: a reader of the number may send the interrupt at once.
    let mut interrupt = signal(SignalKind::interrupt())?;
    let end = super::wait::until_ended(session, component, activity, &what);
    tokio::pin!(end);
    tokio::select! {
        reply = &mut end => return outcome::show(session, &what, &reply?),
        _ = interrupt.recv() => {}
    }
    session.tell(&format!("{what} is told to stop; Ctrl-C again leaves it alone"))?;
    let number = activity.to_string();
    match session.ask(routes::abort(component, &number)).await {
        // It ended in between.
        Ok(_) | Err(Failure::Refused(_)) => {}
        Err(failure) => return Err(failure),
    }
    tokio::select! {
        reply = end => outcome::show(session, &what, &reply?),
        _ = interrupt.recv() => Err(Failure::refused_with(
            "left",
            format!("{what} was told to stop, and still runs"),
            format!("`genomctl wait {component} {activity}` tells how it ends"),
        )),
    }
}
