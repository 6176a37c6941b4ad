//! `genomctl dump`: the running system as a deployment file.

use serde::Deserialize;

use crate::failure::Failure;
use crate::session::Session;

/// Print the running system as a deployment file, for `genomctl apply` on a fresh daemon.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

#[derive(Debug, Deserialize)]
struct Reply {
    text: String,
}

pub(super) async fn run(_: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.get("/deployment").await?;
    session.show(reply, |reply: &Reply| reply.text.clone())
}
