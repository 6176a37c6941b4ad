//! `genomctl kill`: asks the daemon to stop, and waits until it has.

use genom_protocol::routes;

use crate::failure::Failure;
use crate::session::Session;

/// Stop the daemon: interrupts all activities and unloads all components.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    // The stream of events is closed when the daemon ends.
    let mut alive = session.client.stream(&routes::events()).await?;
    let reply = session.ask(routes::shutdown()).await?;
    while let Ok(Some(_)) = alive.next().await {}
    session.show(&reply, |_| "stopped\n".to_owned())
}
