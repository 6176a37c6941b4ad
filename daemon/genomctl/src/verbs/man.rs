//! `genomctl man`: writes manual pages, from the definitions of `--help`.

use std::path::PathBuf;
use std::{fs, io};

use crate::failure::Failure;
use crate::session::Session;

/// Write the manual pages of genomctl and of each verb into a directory.
///
/// For instance ~/.local/share/man/man1; then `man genomctl-start`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Directory to write to; created if it does not exist.
    directory: PathBuf,
}

pub(super) fn run(args: &Args, session: &Session, genomctl: clap::Command) -> Result<(), Failure> {
    let refused = |error: io::Error| {
        let message = format!("{}: {error}", args.directory.display());
        Failure::usage(message, "name a directory to write to")
    };
    fs::create_dir_all(&args.directory).map_err(refused)?;
    clap_mangen::generate_to(genomctl, &args.directory).map_err(refused)?;
    let mut pages: Vec<_> = fs::read_dir(&args.directory)?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with("genomctl") && name.ends_with(".1"))
        .collect();
    pages.sort();
    if session.json {
        return session.print(&format!("{}\n", serde_json::json!({ "pages": pages })));
    }
    session.print(&pages.iter().map(|page| format!("{page}\n")).collect::<String>())
}
