//! Options before the verb, and the list of verbs.

use clap::Parser;

use crate::connection::Connection;
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
    /// Print the daemon's replies as JSON, one per line.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    #[command(subcommand)]
    pub(crate) verb: Verb,
}
