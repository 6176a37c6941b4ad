//! `genomctl disconnect`: disconnects an in port or a remote.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::address;
use crate::session::Session;

/// Disconnect an in port or a remote.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port, COMPONENT/PORT or COMPONENT/PORT/ELEMENT, or the remote.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Connected))]
    inport: Address,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let Address { component, port, element } = &args.inport;
    let route = match element {
        None => routes::disconnect(component, port),
        Some(element) => routes::disconnect_element(component, port, element),
    };
    let reply = session.ask(route).await?;
    session.show(&reply, |_| format!("{} disconnected\n", args.inport))
}
