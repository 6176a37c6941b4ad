//! `genomctl lsp`: helps editors with descriptions. No daemon.

use crate::failure::Failure;
use crate::lsp;
use crate::reading::Reading;

/// Serve editors: the Language Server Protocol on standard input and output.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    reading: Reading,
    /// Accepted because editors pass it; there is no other way to talk.
    #[arg(long, hide = true)]
    stdio: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    lsp::serve(args.reading.options()).map_err(Failure::Io)
}
