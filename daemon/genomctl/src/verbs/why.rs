//! `genomctl why`: why no data flows through a port.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, Finding, Findings, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::address;
use crate::session::Session;

/// Tell why no data flows through a port, and what to do about it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// COMPONENT/PORT.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Ports))]
    port: Address,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let reply = session.ask(routes::why(&args.port.component, &args.port.port)).await?;
    session.show(&reply, render)
}

fn render(reply: &Findings) -> String {
    if reply.findings.is_empty() {
        return "data flows: nothing is wrong\n".to_owned();
    }
    // Comes first, because it answers the question.
    let flows = reply.flows.iter().map(|flow| format!("data flows: {flow}\n"));
    let told = reply.findings.iter();
    flows.chain(told.map(|Finding { what, fix, .. }| format!("{what}\n  fix: {fix}\n"))).collect()
}
