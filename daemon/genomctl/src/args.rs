//! What is typed before the verb, and the list of verbs.

use std::path::PathBuf;

use clap::{Args, Parser};

use crate::target::Host;
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
    /// Where the daemon is, if not at the socket: 127.0.0.1:7300 (`genomd --listen`),
    /// https://robot:7300 on another machine, or zenoh:NAME, one of those that the daemon at the
    /// socket sees over zenoh (`genomctl daemons`).
    #[arg(long, global = true, value_name = "HOST")]
    pub(crate) host: Option<Host>,
    /// Root of the daemon's certificate, in PEM.
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) ca: Option<PathBuf>,
    /// Your own certificate and its key, in PEM, for a daemon that asks for one.
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) cert: Option<PathBuf>,
    /// File with your token, which only you may read.
    #[arg(long, global = true, value_name = "FILE", env = "GENOMD_TOKEN_FILE")]
    pub(crate) token_file: Option<PathBuf>,
    /// Name of a context (`genomctl context`): options kept under that name.
    #[arg(long, global = true, value_name = "NAME")]
    pub(crate) context: Option<String>,
}
