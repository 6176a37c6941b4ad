//! `genomctl thaw`: brings a frozen system back.

use std::path::PathBuf;

use genom_protocol::freeze::MOST;
use genom_protocol::{Frozen, ThawRequest, Thawed, ThawedComponent, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Bring back a system that `genomctl freeze` wrote, on this or another machine.
///
/// Components are loaded and run their start codels; then IDS and ports are put back, connections
/// are made, and activities go on in the states where they were. If something of it fails, all is
/// undone. Where a description changed, values are taken over by the names of members, and what is
/// new or gone is listed.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The file that `genomctl freeze` wrote.
    file: PathBuf,
    /// Unload components of the same names first; they come back if the file cannot be thawed.
    #[arg(long)]
    replace: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let refused = |why: String| {
        let message = format!("{}: {why}", args.file.display());
        Failure::usage(message, "`genomctl freeze FILE` writes such a file")
    };
    let size = std::fs::metadata(&args.file).map_err(|error| refused(error.to_string()))?.len();
    if size > MOST as u64 {
        return Err(refused(format!("{size} bytes are more than the {MOST} that are read")));
    }
    let text = std::fs::read_to_string(&args.file).map_err(|error| refused(error.to_string()))?;
    let frozen = Frozen::read(&text).map_err(|error| refused(error.to_string()))?;
    let request = ThawRequest { frozen, replace: args.replace };
    let reply = session.send(routes::thaw(), &request).await?;
    session.show(&reply, render)
}

fn render(reply: &Thawed) -> String {
    let mut out = String::new();
    for ThawedComponent { name, activities, notes } in &reply.components {
        out.push_str(&match activities {
            0 => format!("{name} goes on\n"),
            1 => format!("{name} goes on with 1 activity\n"),
            many => format!("{name} goes on with {many} activities\n"),
        });
        notes.iter().for_each(|note| out.push_str(&format!("  {note}\n")));
    }
    if reply.components.is_empty() {
        out.push_str("nothing to do: the file has no component\n");
    }
    out
}
