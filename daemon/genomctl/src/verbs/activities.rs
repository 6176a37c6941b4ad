//! `genomctl activities`: what runs, and what ended lately.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;
use crate::table::Table;

/// List the activities of a component, running and lately ended.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
}

#[derive(Debug, Deserialize)]
struct Reply {
    activities: Vec<Activity>,
}

#[derive(Debug, Deserialize)]
struct Activity {
    activity: u64,
    service: String,
    status: String,
    #[serde(default)]
    state: String,
    #[serde(default)]
    exception: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get(&url(["components", &args.component, "activities"])).await?;
    session.show_table(reply, render)
}

fn render(reply: &Reply) -> Table {
    let rows: Vec<_> = reply
        .activities
        .iter()
        .map(|activity| {
            vec![
                activity.activity.to_string(),
                activity.service.clone(),
                activity.status.clone(),
                activity.exception.clone().unwrap_or_else(|| activity.state.clone()),
            ]
        })
        .collect();
    Table { header: vec!["ACTIVITY", "SERVICE", "STATUS", "STATE"], rows }
}
