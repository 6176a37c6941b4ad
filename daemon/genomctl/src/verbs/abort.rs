//! `genomctl abort`: asks an activity to stop.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;

/// Ask an activity to stop: it runs its `stop` codel, then ends.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Number of the activity, or name of a service: then all its activities.
    #[arg(add = ArgValueCompleter::from(Names::Activities))]
    activity: String,
}

#[derive(Debug, Deserialize)]
struct Reply {
    aborted: Vec<u64>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply =
        session.delete(&url(["components", &args.component, "activities", &args.activity])).await?;
    session.show(reply, render)
}

fn render(reply: &Reply) -> String {
    if reply.aborted.is_empty() {
        return "no activity runs\n".to_owned();
    }
    reply.aborted.iter().map(|number| format!("activity {number} told to stop\n")).collect()
}
