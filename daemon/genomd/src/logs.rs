//! Logs on standard error.

use std::io::IsTerminal as _;

use tracing_subscriber::EnvFilter;

/// The DDS library tells of each packet it cannot send yet: nobody else wants to know.
/// A filter that names it says otherwise.
const QUIET: &str = "rustdds=error";

/// Starts logging; the filter was wrong when this gives an error.
pub(crate) fn start(filter: &str) -> Result<(), String> {
    let filter = EnvFilter::try_new(format!("{QUIET},{filter}")).map_err(|error| {
        format!("--log {filter}: {error}; write for instance info,genomd=debug")
    })?;
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .try_init()
        .map_err(|error| error.to_string())
}
