//! `genomctl reload`: exchanges the library of a running component.

use std::path::PathBuf;

use clap_complete::engine::{ArgValueCompleter, PathCompleter};
use genom_protocol::{ComponentReload, ReloadRequest, routes};

use super::load::{absolute, is_component};
use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;

/// Exchange the library of a running component.
///
/// IDS, ports, connections and activities stay as they are: each activity goes on in its state,
/// with the new code. A library that does not fit is refused, and the component goes on.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Instance name of the component.
    #[arg(add = ArgValueCompleter::from(Names::Components))]
    component: String,
    /// Library of codels (.so), description (.gen), or a name on the daemon's component path
    /// [default: what it was loaded from].
    #[arg(add = ArgValueCompleter::new(PathCompleter::any().filter(is_component)))]
    library: Option<PathBuf>,
    /// Description, if it is neither in the library nor beside it.
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(PathCompleter::any()))]
    gen_file: Option<PathBuf>,
    /// With another description, stop the component before the new one starts: for start codels that
    /// need what the running one has, such as a device. Periods are missed meanwhile.
    #[arg(long)]
    stop_first: bool,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let request = ReloadRequest {
        library: args.library.as_deref().map(absolute).transpose()?,
        gen_file: args.gen_file.as_deref().map(absolute).transpose()?,
        stop_first: args.stop_first,
    };
    let reply = session.send(routes::reload(&args.component), &request).await?;
    session.show(&reply, render)
}

fn render(reply: &ComponentReload) -> String {
    let mut text = format!("{} runs {} now\n", reply.component, reply.library.display());
    if reply.restarted {
        text.push_str(
            "its description is another one, or it has native data: start and stop codels ran\n",
        );
    }
    reply.notes.iter().for_each(|note| text.push_str(&format!("{note}\n")));
    if reply.old_stays {
        text.push_str("the library before it stays in memory: something may still use it\n");
    }
    text
}
