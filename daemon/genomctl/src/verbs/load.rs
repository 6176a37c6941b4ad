//! `genomctl load`: loads a component into the daemon.

use clap_complete::engine::{ArgValueCompleter, PathCompleter};
use std::path::{Path, PathBuf};

use genom_protocol::{BackendNames, Component, LoadRequest, RestartPolicy, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;

/// Load a component into the running daemon.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Library of codels (.so), description (.gen), or a name on the daemon's component path.
    #[arg(add = ArgValueCompleter::new(PathCompleter::any().filter(is_component)))]
    library: PathBuf,
    /// Description, if it is neither in the library nor beside it.
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(PathCompleter::any()))]
    gen_file: Option<PathBuf>,
    /// Instance name [default: the component's name].
    #[arg(long)]
    name: Option<String>,
    /// Middleware of its ports [default: that of the daemon].
    #[arg(long, add = ArgValueCompleter::from(Names::Backends))]
    backend: Option<String>,
    /// Run it in this cell: a process that components of one cell share, so that a fault of theirs
    /// takes nothing else down.
    #[arg(long, value_name = "CELL", add = ArgValueCompleter::from(Names::Cells))]
    cell: Option<String>,
    /// Run it in a cell of its own, of its name.
    #[arg(long, conflicts_with = "cell")]
    isolated: bool,
    /// Whether it is brought up again when the process of its cell has ended [default: on-failure].
    #[arg(long, value_name = "POLICY")]
    restart: Option<RestartPolicy>,
}

/// Whether a path can be completed: libraries, descriptions, and directories.
pub(super) fn is_component(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    path.is_dir() || matches!(extension, Some("so" | "gen"))
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut request = LoadRequest {
        library: absolute(&args.library)?,
        gen_file: args.gen_file.as_deref().map(absolute).transpose()?,
        name: args.name,
        backend: args.backend.as_deref().map(BackendNames::from),
        cell: args.cell,
        restart: args.restart.unwrap_or_default(),
        ..LoadRequest::default()
    };
    if args.isolated {
        request.cell = Some(request.instance());
    }
    let reply = session.send(routes::load(), &request).await?;
    session.show(&reply, render)
}

/// An existing file is sent with its absolute path, because the daemon has another working
/// directory.
pub(super) fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    let full = if path.exists() { std::path::absolute(path)? } else { path.to_owned() };
    match full.to_str() {
        Some(_) => Ok(full),
        None => Err(Failure::usage(
            format!("{} is not UTF-8", path.display()),
            "rename the file, or its directory",
        )),
    }
}

fn render(reply: &Component) -> String {
    let Component { name, component, backend, cell, .. } = reply;
    let cell = cell.as_ref().map_or(String::new(), |cell| format!(", cell {cell}"));
    format!("{name} runs (component {component}, backend {backend}{cell})\n")
}
