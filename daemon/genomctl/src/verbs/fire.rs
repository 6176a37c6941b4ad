//! `genomctl fire`: fires an external event.

use genom_protocol::routes;

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use clap_complete::engine::ArgValueCompleter;

/// Fire an external event of a component.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// The event.
    #[arg(add = ArgValueCompleter::from(Names::Events))]
    event: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::fire(&args.component, &args.event)).await?;
    session.show(&reply, |_| format!("{}/{} fired\n", args.component, args.event))
}
