//! `genomctl lsp`: the language server for descriptions. No daemon.

use crate::failure::Failure;
use crate::reading::Reading;

/// Run the language server (LSP) for editors, on standard input and output.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    reading: Reading,
    /// Accepted because editors pass it; it is the only transport.
    #[arg(long, hide = true)]
    stdio: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    genom_lsp::serve(args.reading.options()).map_err(Failure::Io)
}
