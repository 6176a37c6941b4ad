//! `genomctl abort`: asks activities to stop.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use serde_json::Value;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;

/// Ask activities to stop: each runs its `stop` codel, then ends.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component; with --all, none means every component.
    #[arg(add = ArgValueCompleter::from(Names::Components), required_unless_present = "all")]
    component: Option<String>,
    /// Number of the activity, or name of a service: then all its activities.
    #[arg(add = ArgValueCompleter::from(Names::Activities), required_unless_present = "all")]
    activity: Option<String>,
    /// All activities of the component, or of all components: `genomctl stop` waits for their
    /// ends, too.
    #[arg(long, conflicts_with = "activity")]
    all: bool,
}

#[derive(Debug, Deserialize)]
struct Reply {
    aborted: Vec<u64>,
}

/// Activities that were told to stop.
#[derive(Debug, Deserialize)]
pub(super) struct Told {
    pub(super) aborted: Vec<One>,
}

/// One of them.
#[derive(Debug, Deserialize)]
pub(super) struct One {
    pub(super) component: String,
    pub(super) service: String,
    pub(super) activity: u64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if let (Some(component), Some(activity)) = (&args.component, &args.activity) {
        let path = url(["components", component, "activities", activity]);
        return session.show(session.delete(&path).await?, render);
    }
    session.show(all(session, args.component.as_deref()).await?, render_all)
}

/// Tells all activities to stop, of this component or of all.
pub(super) async fn all(session: &Session, component: Option<&str>) -> Result<Value, Failure> {
    match component {
        Some(component) => session.delete(&url(["components", component, "activities"])).await,
        None => session.delete("/activities").await,
    }
}

fn render(reply: &Reply) -> String {
    if reply.aborted.is_empty() {
        return "no activity runs\n".to_owned();
    }
    reply.aborted.iter().map(|number| format!("activity {number} told to stop\n")).collect()
}

pub(super) fn render_all(told: &Told) -> String {
    if told.aborted.is_empty() {
        return "no activity runs\n".to_owned();
    }
    let told = told.aborted.iter();
    told.map(|One { component, service, activity }| {
        format!("{component}/{service}, activity {activity}, told to stop\n")
    })
    .collect()
}
