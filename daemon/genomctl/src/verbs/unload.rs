//! `genomctl unload`: stops and unloads a component.

use genom_protocol::routes;

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use clap_complete::engine::ArgValueCompleter;

/// Stop a component and unload its library.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::unload(&args.component)).await?;
    session.show(&reply, |_| format!("{} unloaded\n", args.component))
}
