//! `genomctl connections`: what feeds what.

use serde::Deserialize;

use crate::failure::Failure;
use crate::session::Session;
use crate::table::table;

/// List the connections of the daemon's in ports.
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
    backend: String,
    policy: String,
}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get("/connections").await?;
    session.show(reply, render)
}

fn render(reply: &Reply) -> String {
    let rows: Vec<_> = reply
        .connections
        .iter()
        .map(|connection| {
            vec![
                connection.inport.clone(),
                connection.outport.clone(),
                connection.backend.clone(),
                connection.policy.clone(),
            ]
        })
        .collect();
    table(&["IN", "OUT", "BACKEND", "POLICY"], &rows)
}
