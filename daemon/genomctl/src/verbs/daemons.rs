//! `genomctl daemons`: lists other daemons that this one sees.

use genom_protocol::{Daemons, routes};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the daemons that are visible over zenoh.
///
/// `genomctl --host zenoh:NAME VERB` talks to one of them. This takes a token (--token-file) that
/// the token file of that daemon contains.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::daemons()).await?;
    session.show_table(&reply, render)
}

fn render(reply: &Daemons) -> Table {
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
