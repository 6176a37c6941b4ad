//! `genomctl connect`: connects an in port to an out port, or a remote to a service.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, Connection, ConnectionRequest, Place, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::{address, place};
use crate::session::Session;

/// Connect an in port to an out port, or a remote to a service, of this daemon or of another one.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The in port, COMPONENT/PORT or COMPONENT/PORT/ELEMENT, or the remote.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Readers))]
    inport: Address,
    /// The out port or the service, optionally with its middleware: shm:robot/position.
    #[arg(value_parser = place, add = ArgValueCompleter::from(Names::Outports))]
    outport: Place,
    /// Which unread samples are kept for the reader: latest, queue:N or ring:N.
    #[arg(long, add = ArgValueCompleter::from(Names::Policies))]
    policy: Option<String>,
    /// Middleware to use [default: that of the out port; for a service of another daemon one of the
    /// caller's]. An out port of this daemon that is not on it is opened there, and closed again with
    /// the last connection over it.
    #[arg(long, visible_alias = "backend", value_name = "MIDDLEWARE", add = ArgValueCompleter::from(Names::Backends))]
    over: Option<String>,
    /// Connect even if the out port or service does not exist yet.
    #[arg(long)]
    wait: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let request = ConnectionRequest {
        inport: args.inport.to_string(),
        outport: args.outport.to_string(),
        policy: args.policy,
        over: args.over,
        wait: args.wait,
    };
    let reply = session.send(routes::connect(), &request).await?;
    session.show(&reply, render)
}

fn render(reply: &Connection) -> String {
    let Connection { inport, outport, backend, policy, .. } = reply;
    match (backend, policy) {
        (Some(backend), Some(policy)) => {
            format!("{inport} reads {outport} ({backend}, {policy})\n")
        }
        (Some(backend), None) => format!("{inport} calls {outport} ({backend})\n"),
        _ => format!("{inport} calls {outport}\n"),
    }
}
