//! `genomctl hz`: the rate of a port.

use crate::failure::Failure;
use crate::session::Session;
use crate::traffic::{Rate, Watch};
use genom_drawing::units::seconds;

/// Show the rate of a port: samples per second that its component writes or reads, and their
/// jitter.
///
/// The daemon counts every sample, so that the rate is exact. Times are those of the components'
/// clock.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    watch: Watch,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    args.watch.run(session, render).await
}

fn render(rate: &Rate) -> String {
    match rate.hertz {
        Some(hertz) => {
            let jitter = seconds(rate.jitter);
            format!("{hertz:.2} Hz, jitter {jitter}, {} samples", rate.samples)
        }
        None if rate.samples == 0 => "no sample".to_owned(),
        None => format!("{} sample", rate.samples),
    }
}
