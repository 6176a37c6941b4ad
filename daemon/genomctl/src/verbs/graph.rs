//! `genomctl graph`: a description as a picture. No daemon.

use std::path::PathBuf;

use genom_description::tools::{Graph, graph};

use crate::failure::Failure;
use crate::session::Session;
use crate::verbs::check::Reading;

/// Draw the components of a description: parts and state machines, as Graphviz or Mermaid.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Language of the picture.
    #[arg(long, value_enum, default_value = "dot")]
    format: Format,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Format {
    Dot,
    Mermaid,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let specification = args.reading.understand(&args.files)?;
    let language = match args.format {
        Format::Dot => Graph::Dot,
        Format::Mermaid => Graph::Mermaid,
    };
    for component in &specification.components {
        session.print(&graph(component, language))?;
    }
    Ok(())
}
