//! `genomctl backend`: moves a running component, or one of its ports, to other middlewares.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use serde_json::json;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;

/// Move a component, or one of its ports, to another backend while it runs.
///
/// Connections are made again; no codel notices. Several at once: shm+zenoh.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// COMPONENT, with all its ports and services, or COMPONENT/PORT.
    #[arg(add = ArgValueCompleter::from(Names::Movable))]
    target: String,
    /// The backend, or several: shm+zenoh.
    #[arg(add = ArgValueCompleter::from(Names::Backends))]
    backend: String,
}

#[derive(Debug, Deserialize)]
struct Reply {
    component: String,
    port: Option<String>,
    backend: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (component, port) = match args.target.split_once('/') {
        Some((component, port)) => (component, Some(port)),
        None => (args.target.as_str(), None),
    };
    let body = json!({"backend": args.backend, "port": port});
    let reply = session.put(&url(["components", component, "backend"]), &body).await?;
    session.show(reply, render)
}

fn render(reply: &Reply) -> String {
    let Reply { component, port, backend } = reply;
    match port {
        Some(port) => format!("{component}/{port} is on {backend}\n"),
        None => format!("{component} is on {backend}\n"),
    }
}
