//! `genomctl apply`: brings the daemon to what a deployment file says.

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
    let reply = session.post("/deployment", &Value::Object(body)).await?;
    session.show(reply, render)
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
