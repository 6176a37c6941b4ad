//! `genomctl step`: advances the virtual clock of a daemon.

use genom_protocol::{Clock, StepRequest, routes};
use genom_scenario::duration::nanoseconds;

use crate::failure::Failure;
use crate::session::Session;

/// Advance the virtual clock (`genomd --clock virtual`), and run everything that is due in that
/// time.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How far: 10ms, 2s, 500us, 100ns. 0s runs what is due now.
    #[arg(value_parser = nanoseconds)]
    duration: u64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.send(routes::step(), &StepRequest { nanoseconds: args.duration }).await?;
    session.show(&reply, |Clock { now, .. }| {
        format!("{}.{:09} s\n", now / 1_000_000_000, now % 1_000_000_000)
    })
}
