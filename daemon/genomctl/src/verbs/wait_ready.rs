//! `genomctl wait-ready`: waits until the daemon has loaded the components it was started with.

use std::io;
use std::time::{Duration, Instant};

use genom_protocol::{Code, Ready, ReadyParameters, routes};

use crate::failure::Failure;
use crate::session::Session;
use crate::terminal::Progress;
use crate::times::seconds;

/// Wait until the daemon has loaded all components that it was started with.
///
/// For scripts that start a daemon; it may also be started after this command. The exit status is 3
/// if the daemon ends meanwhile, for instance because a component was refused; its log has the
/// reason.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Wait for the connections, calls and activities of its configuration, too.
    #[arg(long)]
    deployed: bool,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    within: Duration,
}

/// Interval between attempts to connect to a daemon that is not there yet.
const LOOK: Duration = Duration::from_millis(50);
/// How long the daemon may hold one request, in seconds.
const HOLD: f64 = 1.0;

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (begin, mut progress) = (Instant::now(), Progress::default());
    let mut seen = false;
    loop {
        let left = args.within.saturating_sub(begin.elapsed());
        let hold = left.as_secs_f64().min(HOLD);
        let query = ReadyParameters { wait: Some(hold), deployed: Some(args.deployed) };
        let why = match session.client.request(&routes::ready().with(&query), Vec::new()).await {
            Ok(sent) => {
                return session.show(&session.reply::<Ready>(sent)?, |_| "ready\n".to_owned());
            }
            Err(Failure::Refused(reason)) if reason.is(Code::NotReady) => {
                seen = true;
                progress.show(&format!("{}, {} s", reason.message, begin.elapsed().as_secs()));
                let within = args.within.as_secs_f64();
                Failure::refused_with(
                    Code::Timeout.name(),
                    format!("not ready after {within} s: {}", reason.message),
                    "`genomctl logs` tells how far it is".to_owned(),
                )
            }
            // It was reachable before.
            Err(Failure::Unreachable { .. }) if seen => return Err(session.client.lost()),
            Err(Failure::Refused(reason)) if reason.is(Code::Stopping) => {
                return Err(session.client.lost());
            }
            Err(failure) if comes_later(&failure) => {
                progress.show(&format!("no genomd yet, {} s", begin.elapsed().as_secs()));
                tokio::time::sleep(LOOK.min(left)).await;
                failure
            }
            Err(failure) => return Err(failure),
        };
        if begin.elapsed() >= args.within {
            return Err(why);
        }
    }
}

/// Whether the failure may disappear while a daemon is starting.
fn comes_later(failure: &Failure) -> bool {
    use io::ErrorKind::{InvalidData, PermissionDenied};
    let Failure::Unreachable { source, .. } = failure else { return false };
    !matches!(source.kind(), InvalidData | PermissionDenied)
}
