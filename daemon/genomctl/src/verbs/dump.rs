//! `genomctl dump`: the running system as a deployment file.

use genom_protocol::{Dumped, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Print the running system as a deployment file, to be applied to a new daemon with `genomctl
/// apply`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::dump()).await?;
    session.show(&reply, |reply: &Dumped| reply.text.clone())
}
