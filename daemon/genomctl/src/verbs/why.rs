//! `genomctl why`: why no data flows through a port.

use clap_complete::engine::ArgValueCompleter;
use serde::Deserialize;

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::{Path2, url};
use crate::session::Session;

/// Tell why no data flows through a port, and what to do about it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// COMPONENT/PORT.
    #[arg(add = ArgValueCompleter::from(Names::Ports))]
    port: Path2,
}

#[derive(Debug, Deserialize)]
struct Reply {
    findings: Vec<Finding>,
    #[serde(default)]
    flows: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Finding {
    what: String,
    fix: String,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let (port, _) = args.port.port();
    let path = url(["components", &args.port.component, "ports", port, "why"]);
    let reply = session.get(&path).await?;
    session.show(reply, render)
}

fn render(reply: &Reply) -> String {
    if reply.findings.is_empty() {
        return "data flows: nothing is wrong\n".to_owned();
    }
    // What somebody asks comes first.
    let flows = reply.flows.iter().map(|flow| format!("data flows: {flow}\n"));
    let told = reply.findings.iter();
    flows.chain(told.map(|Finding { what, fix }| format!("{what}\n  fix: {fix}\n"))).collect()
}
