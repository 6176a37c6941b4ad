//! `genomctl abort`: asks activities to stop.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Aborted, AbortedActivity, AllAborted, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::{Reply, Session};

/// Ask activities to stop: each runs its `stop` codel, then ends.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component; may be left out with --all, for every component.
    #[arg(add = ArgValueCompleter::from(Names::Components), required_unless_present = "all")]
    component: Option<String>,
    /// Number of the activity, or name of a service to stop all its activities.
    #[arg(add = ArgValueCompleter::from(Names::Activities), required_unless_present = "all")]
    activity: Option<String>,
    /// All activities of the component, or of all components. `genomctl stop` also waits until they
    /// have ended.
    #[arg(long, conflicts_with = "activity")]
    all: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if let (Some(component), Some(activity)) = (&args.component, &args.activity) {
        let reply = session.ask(routes::abort(component, activity)).await?;
        return session.show(&reply, render);
    }
    session.show(&all(session, args.component.as_deref()).await?, render_all)
}

/// Asks all activities of the component, or of all components, to stop.
pub(super) async fn all(
    session: &Session,
    component: Option<&str>,
) -> Result<Reply<AllAborted>, Failure> {
    match component {
        Some(component) => session.ask(routes::abort_all(component)).await,
        None => session.ask(routes::stop()).await,
    }
}

fn render(reply: &Aborted) -> String {
    if reply.aborted.is_empty() {
        return "no activity runs\n".to_owned();
    }
    reply.aborted.iter().map(|number| format!("activity {number} told to stop\n")).collect()
}

pub(super) fn render_all(reply: &AllAborted) -> String {
    if reply.aborted.is_empty() {
        return "no activity runs\n".to_owned();
    }
    let aborted = reply.aborted.iter();
    aborted
        .map(|AbortedActivity { component, service, activity }| {
            format!("{component}/{service}, activity {activity}, told to stop\n")
        })
        .collect()
}
