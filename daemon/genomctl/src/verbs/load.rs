//! `genomctl load`: loads a component into the daemon.

use clap_complete::engine::{ArgValueCompleter, PathCompleter};
use std::path::{Path, PathBuf};

use genom_protocol::{BackendNames, Component, LoadRequest, routes};

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
}

/// Whether a path can be completed: libraries, descriptions, and directories.
fn is_component(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    path.is_dir() || matches!(extension, Some("so" | "gen"))
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let request = LoadRequest {
        library: absolute(&args.library)?,
        gen_file: args.gen_file.as_deref().map(absolute).transpose()?,
        name: args.name,
        backend: args.backend.as_deref().map(BackendNames::from),
        ..LoadRequest::default()
    };
    let reply = session.send(routes::load(), &request).await?;
    session.show(&reply, render)
}

/// An existing file is sent with its absolute path, because the daemon has another working
/// directory.
fn absolute(path: &Path) -> Result<PathBuf, Failure> {
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
    let Component { name, component, backend, .. } = reply;
    format!("{name} runs (component {component}, backend {backend})\n")
}
