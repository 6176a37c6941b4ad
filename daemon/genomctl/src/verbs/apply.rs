//! `genomctl apply`: brings the daemon to what a deployment file says.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use hyper::Method;
use serde::Deserialize;
use serde_json::{Map, Value};
use tokio::time::{Instant, interval_at};

use crate::escape;
use crate::failure::Failure;
use crate::session::Session;
use crate::terminal::Progress;

/// Bring the daemon to what a deployment file says: load, connect, call, start.
///
/// What is there already stays as it is; a component whose tasks or quality of service are to be
/// others is loaded anew. A connection waits for its other side; when a step is refused, all steps
/// taken are taken back. What runs beside what the file says is named at the end.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The deployment file (TOML); see configs/robot.toml.
    file: PathBuf,
    /// Take away components and connections that the file does not have; activities are left alone.
    #[arg(long)]
    prune: bool,
    /// Only print the steps.
    #[arg(long)]
    dry_run: bool,
    /// Which daemon of the file this is [default: the one it was started as].
    #[arg(long, value_name = "NAME")]
    daemon: Option<String>,
    /// Give up after waiting this long for the other side of a connection.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
}

#[derive(Debug, Deserialize)]
struct Reply {
    steps: Vec<String>,
    applied: bool,
    #[serde(default)]
    beside: Vec<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let text = std::fs::read_to_string(&args.file).map_err(|error| {
        Failure::usage(
            format!("{}: {error}", args.file.display()),
            "`genomctl dump` prints the running system as such a file",
        )
    })?;
    // The daemon has another working directory, and paths in the file start from the file's.
    let file = std::path::absolute(&args.file)?;
    let mut body = Map::new();
    body.insert("text".into(), text.into());
    body.insert("file".into(), file.to_string_lossy().into_owned().into());
    body.insert("dry_run".into(), args.dry_run.into());
    body.insert("prune".into(), args.prune.into());
    body.insert("timeout".into(), args.timeout.into());
    body.extend(args.daemon.map(|name| ("daemon".to_owned(), Value::from(name))));
    let body = Value::Object(body);
    if args.dry_run {
        return session.show(session.post("/deployment", &body).await?, render);
    }
    // Open before anything is done, so that nothing is missed.
    let mut told = session.client.stream("/events").await?;
    let mut asked =
        std::pin::pin!(session.client.request(Method::POST, "/deployment", Some(&body)));
    let mut ticks = interval_at(Instant::now() + LONG, LONG);
    let mut at_work = AtWork::default();
    let reply = loop {
        tokio::select! {
            biased;
            Ok(Some(event)) = told.next() => at_work.hear(&event.data),
            reply = &mut asked => break reply?,
            _ = ticks.tick() => at_work.look(),
        }
    };
    drop(at_work);
    session.show(reply, render)
}

/// What takes longer is told also where nobody looks.
const LONG: Duration = Duration::from_secs(1);

/// What the daemon does now and waits for, on standard error: one line written over on a
/// terminal, else a line for each thing that takes long.
#[derive(Debug, Default)]
struct AtWork {
    progress: Progress,
    /// The step being taken, and since when.
    step: Option<(String, Instant)>,
    /// Connections that wait for their other sides.
    waits: Vec<(String, Instant)>,
    /// Whether the step was told.
    told: bool,
}

impl AtWork {
    /// Something changed in the daemon.
    fn hear(&mut self, data: &str) {
        let Ok(mut change) = serde_json::from_str::<Value>(data) else { return };
        escape::all(&mut change);
        let Some(step) = change["step"].as_str() else { return };
        match (change["event"].as_str(), change["status"].as_str()) {
            (Some("deployment_waits"), _) => {
                self.waits.push((step.to_owned(), Instant::now()));
                if !self.progress.seen() {
                    line(&format!("waiting: {step}"));
                }
            }
            (Some("deployment_step"), Some("begun")) => {
                self.step = Some((step.to_owned(), Instant::now()));
                self.told = false;
            }
            (Some("deployment_step"), _) => {
                self.waits.retain(|(waits, _)| waits != step);
                self.step = None;
            }
            _ => return,
        }
        self.show();
    }

    /// Time passed.
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

fn render(reply: &Reply) -> String {
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
