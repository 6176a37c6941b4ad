//! `genomctl connect`: an in port to an out port, or a remote to a service.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::Path2;
use crate::session::Session;

/// Connect an in port to an out port, of this daemon or of another one; or a remote to a
/// service.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT; or a remote.
    #[arg(add = ArgValueCompleter::from(Names::Readers))]
    inport: Path2,
    /// The out port that feeds it, or the service that a remote calls; a middleware may stand
    /// before it: shm:robot/position.
    #[arg(add = ArgValueCompleter::from(Names::Outports))]
    outport: Path2,
    /// What the reader gets of the samples it has not read: latest, queue:N or ring:N.
    #[arg(long, add = ArgValueCompleter::from(Names::Policies))]
    policy: Option<String>,
    /// Middleware to use [default: that of the out port; for a service of another daemon one of
    /// the caller's].
    #[arg(long, add = ArgValueCompleter::from(Names::Backends))]
    backend: Option<String>,
    /// Connect also when the out port or service does not exist yet: it may come later.
    #[arg(long)]
    wait: bool,
}

#[derive(Debug, Deserialize)]
struct Reply {
    #[serde(rename = "in")]
    inport: String,
    #[serde(rename = "out")]
    outport: String,
    /// None for a remote that calls a service of the same daemon.
    backend: Option<String>,
    /// None for a remote.
    policy: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut body = Map::new();
    body.insert("in".into(), args.inport.to_string().into());
    body.insert("out".into(), args.outport.to_string().into());
    body.extend(args.policy.map(|policy| ("policy".to_owned(), Value::from(policy))));
    body.extend(args.backend.map(|backend| ("backend".to_owned(), Value::from(backend))));
    if args.wait {
        body.insert("wait".into(), true.into());
    }
    let reply = session.post("/connections", &Value::Object(body)).await?;
    session.show(reply, render)
}

fn render(reply: &Reply) -> String {
    let Reply { inport, outport, backend, policy } = reply;
    match (backend, policy) {
        (Some(backend), Some(policy)) => {
            format!("{inport} reads {outport} ({backend}, {policy})\n")
        }
        (Some(backend), None) => format!("{inport} calls {outport} ({backend})\n"),
        _ => format!("{inport} calls {outport}\n"),
    }
}
