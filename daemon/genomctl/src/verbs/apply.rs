//! `genomctl apply`: brings the daemon to what a deployment file says.

use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::session::Session;

/// Bring the daemon to what a deployment file says: load, connect, call, start.
///
/// What is there already stays as it is. A connection waits for its other side; when a step is
/// refused, all steps taken are taken back.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The deployment file (TOML); see configs/robot.toml.
    file: PathBuf,
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
    body.insert("timeout".into(), args.timeout.into());
    body.extend(args.daemon.map(|name| ("daemon".to_owned(), Value::from(name))));
    let body = Value::Object(body);
    // Open before anything is done, so that nothing is missed.
    let told = if args.dry_run { None } else { Some(session.client.stream("/events").await?) };
    let mut asked = std::pin::pin!(session.post("/deployment", &body));
    let reply = match told {
        None => asked.await?,
        Some(mut told) => loop {
            tokio::select! {
                reply = &mut asked => break reply?,
                Some(event) = told.next() => progress(&event.data),
            }
        },
    };
    session.show(reply, render)
}

/// What the daemon does meanwhile: what it waits for, and on a terminal each step.
fn progress(data: &str) {
    let Ok(change) = serde_json::from_str::<Value>(data) else { return };
    let line = match (change["event"].as_str(), change["what"].as_str(), change["step"].as_str()) {
        (Some("deployment_waits"), Some(what), _) => format!("waiting: {what}\n"),
        (Some("deployment_step"), _, Some(step)) if io::stderr().is_terminal() => {
            format!("{step}\n")
        }
        _ => return,
    };
    let _ = io::stderr().lock().write_all(line.as_bytes());
}

fn render(reply: &Reply) -> String {
    if reply.steps.is_empty() {
        return "nothing to do: everything is as the file says\n".to_owned();
    }
    let mut out = String::new();
    for step in &reply.steps {
        out.push_str(if reply.applied { "done   " } else { "would  " });
        out.push_str(step);
        out.push('\n');
    }
    out
}
