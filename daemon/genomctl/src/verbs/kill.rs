//! `genomctl kill`: asks the daemon to stop, and waits until it has.

use genom_protocol::routes;

use crate::failure::Failure;
use crate::session::Session;

/// Stop the daemon: activities are interrupted, components unloaded.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    // The event stream is the sign of life: it closes when the daemon is gone.
    let mut alive = session.client.stream(&routes::events()).await?;
    let reply = session.ask(routes::shutdown()).await?;
    while let Ok(Some(_)) = alive.next().await {}
    session.show(&reply, |_| "stopped\n".to_owned())
}
