//! `genomctl bw`: the bandwidth of a port.

use crate::failure::Failure;
use crate::session::Session;
use crate::traffic::{Rate, Watch};
use genom_drawing::units::bytes;

/// Show the bandwidth of a port: bytes per second that its component writes or reads.
///
/// A sample counts with its size in memory or, if sizes vary, its size as CDR. The latter is
/// measured only while this command runs.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    watch: Watch,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    args.watch.run(session, render).await
}

fn render(rate: &Rate) -> String {
    match (rate.bandwidth(), rate.size) {
        (Some(bandwidth), Some(size)) => {
            format!("{}/s, {} samples of {}", bytes(bandwidth), rate.samples, bytes(size))
        }
        _ if rate.samples == 0 => "no sample".to_owned(),
        _ => format!("{} samples, not enough to tell", rate.samples),
    }
}
