//! `genomctl call`: calls a service and waits for its end.

use crate::complete::Names;
use crate::failure::Failure;
use crate::prompt;
use crate::session::Session;
use crate::verbs::{outcome, start};
use clap_complete::engine::ArgValueCompleter;

/// Call a service and wait for its outputs.
///
/// An activity is started and waited for, as with `start --wait`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// The service.
    #[arg(add = ArgValueCompleter::from(Names::Services))]
    service: String,
    /// Inputs: '{"velocity": 0.5}' or velocity=0.5. Inputs of an attribute that are left out keep
    /// their present values (`?` in `info`); those of a function or activity take their defaults.
    /// On a terminal, inputs are asked for if none are given; '{}' leaves all out.
    #[arg(add = ArgValueCompleter::from(Names::Inputs))]
    inputs: Vec<String>,
    /// Inputs that are left out take their defaults, or zero where there is none; also those of an
    /// attribute.
    #[arg(long)]
    zero: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply =
        prompt::call(session, &args.component, &args.service, &args.inputs, args.zero).await?;
    match reply.content.activity() {
        Some(activity) if reply.content.outcome().is_none() => {
            start::wait_for(session, &args.component, &args.service, activity).await
        }
        _ => outcome::show_call(session, &format!("{}/{}", args.component, args.service), &reply),
    }
}
