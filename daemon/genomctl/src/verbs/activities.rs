//! `genomctl activities`: running activities, and those that ended recently.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Activities, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the activities of a component: running ones, and those that ended recently.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::activities(&args.component)).await?;
    session.show_table(&reply, render)
}

fn render(reply: &Activities) -> Table {
    let rows: Vec<_> = reply
        .activities
        .iter()
        .map(|activity| {
            vec![
                activity.activity.to_string(),
                activity.service.clone(),
                activity.status.to_string(),
                activity.outcome.exception.clone().or(activity.state.clone()).unwrap_or_default(),
            ]
        })
        .collect();
    Table { header: vec!["ACTIVITY", "SERVICE", "STATUS", "STATE"], rows }
}
