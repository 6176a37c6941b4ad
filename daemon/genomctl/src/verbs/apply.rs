//! `genomctl apply`: applies a deployment file to the daemon.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use genom_protocol::{Applied, Change, DeploymentRequest, StepStatus, routes};
use serde_json::Value;
use tokio::time::{Instant, interval_at};

use crate::escape;
use crate::failure::Failure;
use crate::session::Session;
use crate::terminal::Progress;

/// Apply a deployment file: load, connect, call and start what it says.
///
/// What exists already stays as it is; a component is reloaded if its tasks or quality of service
/// differ from the file. A connection waits for its other side. When a step fails, all steps taken
/// are undone. What runs although the file does not mention it is listed at the end.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The deployment file (TOML); see configs/robot.toml.
    file: PathBuf,
    /// Remove components and connections that are not in the file; activities are left alone.
    #[arg(long)]
    prune: bool,
    /// Only print the steps.
    #[arg(long)]
    dry_run: bool,
    /// Which daemon of the file this is [default: the name it was started with].
    #[arg(long, value_name = "NAME")]
    daemon: Option<String>,
    /// Give up after waiting this long for the other side of a connection.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let text = std::fs::read_to_string(&args.file).map_err(|error| {
        Failure::usage(
            format!("{}: {error}", args.file.display()),
            "`genomctl dump` prints the running system as such a file",
        )
    })?;
    // The daemon has another working directory, and paths in the file are relative to the file.
    let file = std::path::absolute(&args.file)?;
    let request = DeploymentRequest {
        text,
        // Used in messages only if it is not UTF-8: files beside it are not found then.
        file: file.to_string_lossy().into_owned().into(),
        daemon: args.daemon,
        prune: args.prune,
        dry_run: args.dry_run,
        timeout: Some(args.timeout),
        cell: None,
    };
    if request.dry_run {
        return session.show(&session.send(routes::apply(), &request).await?, render);
    }
    // Opened before anything is done, so that no change is missed.
    let mut changes = session.client.stream(&routes::events()).await?;
    let (route, body) = (routes::apply(), serde_json::to_vec(&request).unwrap_or_default());
    let mut asked = std::pin::pin!(session.client.request(&route, body));
    let mut ticks = interval_at(Instant::now() + LONG, LONG);
    let mut at_work = AtWork::default();
    let reply = loop {
        tokio::select! {
            biased;
            Ok(Some(event)) = changes.next() => at_work.hear(&event.data),
            reply = &mut asked => break reply?,
            _ = ticks.tick() => at_work.look(),
        }
    };
    drop(at_work);
    session.show(&session.reply::<Applied>(reply)?, render)
}

/// Steps that take longer are reported even if standard error is not a terminal.
const LONG: Duration = Duration::from_secs(1);

/// Shows on standard error what the daemon is doing and waiting for: on a terminal one line that is
/// overwritten, otherwise one line for each thing that takes long.
#[derive(Debug, Default)]
struct AtWork {
    progress: Progress,
    /// The current step, and when it began.
    step: Option<(String, Instant)>,
    /// Connections that wait for their other sides.
    waits: Vec<(String, Instant)>,
    /// Whether the current step was reported.
    told: bool,
}

impl AtWork {
    /// A change in the daemon was received.
    fn hear(&mut self, data: &str) {
        let Ok(mut change) = serde_json::from_str::<Value>(data) else { return };
        escape::all(&mut change);
        match serde_json::from_value(change) {
            Ok(Change::DeploymentWaits { step }) => {
                if !self.progress.seen() {
                    line(&format!("waiting: {step}"));
                }
                self.waits.push((step, Instant::now()));
            }
            Ok(Change::DeploymentStep { step, status: StepStatus::Begun }) => {
                self.step = Some((step, Instant::now()));
                self.told = false;
            }
            Ok(Change::DeploymentStep { step, status: StepStatus::Done }) => {
                self.waits.retain(|(waits, _)| *waits != step);
                self.step = None;
            }
            _ => return,
        }
        self.show();
    }

    /// Called regularly, to report what takes long.
    fn look(&mut self) {
        let slow = self.step.as_ref().filter(|(_, since)| since.elapsed() >= LONG);
        if let (Some((step, _)), false, false) = (slow, self.told, self.progress.seen()) {
            line(&format!("taking long: {step}"));
            self.told = true;
        }
        self.show();
    }

    fn show(&mut self) {
        let text = match (&self.step, self.waits.as_slice()) {
            (Some((step, since)), _) => format!("{step}, {} s", since.elapsed().as_secs()),
            (None, [(step, since), others @ ..]) => {
                let others = match others.len() {
                    0 => String::new(),
                    number => format!(" and {number} more"),
                };
                format!("waiting: {step}{others}, {} s", since.elapsed().as_secs())
            }
            (None, []) => return,
        };
        self.progress.show(&text);
    }
}

fn line(text: &str) {
    let _ = io::stderr().lock().write_all(format!("{text}\n").as_bytes());
}

fn render(reply: &Applied) -> String {
    let mut out = String::new();
    if reply.steps.is_empty() {
        out.push_str(match reply.beside.is_empty() {
            true => "nothing to do: everything is as the file says\n",
            false => "nothing to do: all that the file says is so\n",
        });
    }
    for step in &reply.steps {
        out.push_str(if reply.applied { "done   " } else { "would  " });
        out.push_str(step);
        out.push('\n');
    }
    if !reply.beside.is_empty() {
        let beside = reply.beside.join(", ");
        out.push_str(&format!("beside the file: {beside}; --prune takes that away\n"));
    }
    out
}
