//! `genomctl disconnect`: an in port from what feeds it.

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::{Path2, url};
use crate::session::Session;
use clap_complete::engine::ArgValueCompleter;

/// Disconnect an in port or a remote.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(add = ArgValueCompleter::from(Names::Connected))]
    inport: Path2,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (port, element) = args.inport.port();
    let mut segments = vec!["connections", &args.inport.component, port];
    segments.extend(element);
    let reply = session.delete(&url(segments)).await?;
    session.show(reply, |_: &serde_json::Value| format!("{} disconnected\n", args.inport))
}
