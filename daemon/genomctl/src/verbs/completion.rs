//! `genomctl completion`: completion scripts for shells, from the definitions of `--help`.

use std::io;

use clap_complete::env::Shells;

use crate::failure::Failure;
use crate::session::Session;

/// Print the completion script of genomctl for a shell: verbs and options, and the live names of
/// components, services, ports and inputs.
///
/// In ~/.bashrc: `source <(genomctl completion bash)`; in ~/.zshrc, after compinit: `source
/// <(genomctl completion zsh)`; in ~/.config/fish/config.fish: `genomctl completion fish | source`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

/// The environment variable by which the script asks `genomctl` for completions.
pub(crate) const VARIABLE: &str = "GENOMCTL_COMPLETE";

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let mut text = Vec::new();
    let shells = Shells::builtins();
    let shell = shells
        .completer(&args.shell.to_string())
        .ok_or_else(|| io::Error::other(format!("nothing completes for {}", args.shell)))?;
    shell.write_registration(VARIABLE, "genomctl", "genomctl", "genomctl", &mut text)?;
    session.print_text("script", &String::from_utf8_lossy(&text))
}
