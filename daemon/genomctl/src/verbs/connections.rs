//! `genomctl connections`: lists connections.

use genom_protocol::{Connections, routes};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List what the in ports and remotes of the daemon are connected to.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::connections()).await?;
    session.show_table(&reply, render)
}

fn render(reply: &Connections) -> Table {
    let rows: Vec<_> = reply
        .connections
        .iter()
        .map(|connection| {
            vec![
                connection.inport.clone(),
                connection.outport.clone(),
                connection.backend.clone().unwrap_or_else(|| "-".to_owned()),
                connection.policy.clone().unwrap_or_else(|| "-".to_owned()),
            ]
        })
        .collect();
    Table { header: vec!["IN", "OUT", "BACKEND", "POLICY"], rows }
}
