//! What is typed before the verb, and the list of verbs.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Parser};

use crate::verbs::Verb;

/// Supervises the components of a running genomd.
///
/// Exit status: 0 done; 1 refused, or the service ended with an exception; 2 wrong usage;
/// 3 no daemon answers.
#[derive(Debug, Parser)]
#[command(name = "genomctl", version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) connection: Connection,
    /// Print the daemon's replies as JSON, one a line.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// Which daemon to talk to.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Connection {
    /// Socket of the daemon [default: $XDG_RUNTIME_DIR/genomd.sock, else /tmp/genomd-UID/genomd.sock].
    #[arg(long, global = true, value_name = "PATH", env = "GENOMD_SOCKET")]
    pub(crate) socket: Option<PathBuf>,
    /// TCP address of the daemon (`genomd --listen`), instead of the socket.
    #[arg(long, global = true, value_name = "ADDRESS:PORT", conflicts_with = "socket")]
    pub(crate) host: Option<SocketAddr>,
}
