//! `genomctl backend`: moves a running component, or one of its ports, to other middlewares.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{BackendNames, MoveRequest, Moved, Subject, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;

/// Move a component, or one of its ports, to another middleware while it runs.
///
/// Its connections follow, and its codels are not affected. Several middlewares: shm+zenoh.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// COMPONENT, with all its ports and services, or COMPONENT/PORT.
    #[arg(add = ArgValueCompleter::from(Names::Movable))]
    target: Subject,
    /// The middleware, or several: shm+zenoh.
    #[arg(add = ArgValueCompleter::from(Names::Backends))]
    backend: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (component, port) = match args.target {
        Subject::Component(component) => (component, None),
        Subject::Port(address) => (address.component.clone(), Some(address.name())),
    };
    let request = MoveRequest { backend: BackendNames::from(args.backend.as_str()), port };
    let reply = session.send(routes::move_component(&component), &request).await?;
    session.show(&reply, render)
}

fn render(reply: &Moved) -> String {
    let Moved { component, port, backend } = reply;
    match port {
        Some(port) => format!("{component}/{port} is on {backend}\n"),
        None => format!("{component} is on {backend}\n"),
    }
}
