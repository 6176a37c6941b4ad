//! `genomctl completion`: completions for a shell, from the same definitions as `--help`.

use clap::CommandFactory as _;

use crate::failure::Failure;
use crate::session::Session;

/// Print the completions of genomctl for a shell.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let mut text = Vec::new();
    let mut command = crate::args::Cli::command();
    clap_complete::generate(args.shell, &mut command, "genomctl", &mut text);
    session.print(&String::from_utf8_lossy(&text))
}
