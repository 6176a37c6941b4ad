//! `genomctl wait-ready`: until the daemon has loaded what it was started with.

use std::io;
use std::time::{Duration, Instant};

use hyper::Method;
use serde_json::Value;

use crate::failure::{Failure, Refusal};
use crate::session::Session;
use crate::terminal::Progress;

/// Wait until the daemon has loaded all components that it was started with.
///
/// For scripts that start a daemon: it may be started after this, too. Ends with 3 when the daemon
/// goes meanwhile, as when it refuses a component; its log says why.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Wait for the connections, calls and activities of its configuration, too.
    #[arg(long)]
    deployed: bool,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    within: f64,
}

/// Between two attempts to reach a daemon that is not there yet.
const LOOK: Duration = Duration::from_millis(50);
/// How long the daemon holds one request, in seconds.
const HOLD: f64 = 1.0;

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let within = Duration::try_from_secs_f64(args.within)
        .map_err(|_| Failure::usage(format!("--within {}: no time", args.within), "try 60"))?;
    let (begin, mut progress) = (Instant::now(), Progress::default());
    let mut seen = false;
    loop {
        let left = within.saturating_sub(begin.elapsed());
        let hold = left.as_secs_f64().min(HOLD);
        let path = format!("/ready?wait={hold}&deployed={}", args.deployed);
        let why = match session.client.request(Method::GET, &path, None).await {
            Ok(reply) => return session.show(reply, |_: &Value| "ready\n".to_owned()),
            Err(Failure::Refused(refusal)) if refusal.code == "not_ready" => {
                seen = true;
                progress.show(&format!("{}, {} s", refusal.message, begin.elapsed().as_secs()));
                let Refusal { message, .. } = refusal;
                Failure::Refused(Refusal {
                    code: "timeout".to_owned(),
                    message: format!("not ready after {} s: {message}", args.within),
                    place: None,
                    help: Some("`genomctl logs` tells how far it is".to_owned()),
                })
            }
            // It was there.
            Err(Failure::Unreachable { .. }) if seen => return Err(session.client.lost()),
            Err(Failure::Refused(refusal)) if refusal.code == "stopping" => {
                return Err(session.client.lost());
            }
            Err(failure) if comes_later(&failure) => {
                progress.show(&format!("no genomd yet, {} s", begin.elapsed().as_secs()));
                tokio::time::sleep(LOOK.min(left)).await;
                failure
            }
            Err(failure) => return Err(failure),
        };
        if begin.elapsed() >= within {
            return Err(why);
        }
    }
}

/// Whether a daemon that starts may answer otherwise.
fn comes_later(failure: &Failure) -> bool {
    use io::ErrorKind::{InvalidData, PermissionDenied};
    let Failure::Unreachable { source, .. } = failure else { return false };
    !matches!(source.kind(), InvalidData | PermissionDenied)
}
