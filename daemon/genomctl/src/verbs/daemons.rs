//! `genomctl daemons`: other daemons that this one sees.

use serde::Deserialize;

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the daemons that are visible over zenoh.
///
/// `genomctl --host zenoh:NAME VERB` talks to one of them; it asks for a token (--token-file)
/// that its own token file knows.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

#[derive(Debug, Deserialize)]
struct Reply {
    own: Option<String>,
    daemons: Vec<Visible>,
}

#[derive(Debug, Deserialize)]
struct Visible {
    name: String,
    backend: String,
}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get("/daemons").await?;
    session.show_table(reply, render)
}

fn render(reply: &Reply) -> Table {
    let rows = reply
        .daemons
        .iter()
        .map(|one| {
            let star = if reply.own.as_ref() == Some(&one.name) { "*" } else { "" };
            vec![format!("{}{star}", one.name), one.backend.clone()]
        })
        .collect();
    Table { header: vec!["DAEMON", "BACKEND"], rows }
}
