//! `genomctl connections`: what feeds what.

use serde::Deserialize;

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List what the daemon's in ports and remotes are connected to.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

#[derive(Debug, Deserialize)]
struct Reply {
    connections: Vec<Connection>,
}

#[derive(Debug, Deserialize)]
struct Connection {
    #[serde(rename = "in")]
    inport: String,
    #[serde(rename = "out")]
    outport: String,
    /// None for a remote that calls a service of the same daemon.
    backend: Option<String>,
    /// None for a remote.
    policy: Option<String>,
}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get("/connections").await?;
    session.show_table(reply, render)
}

fn render(reply: &Reply) -> Table {
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
