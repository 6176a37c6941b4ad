//! `genomctl graph`: draws components. No daemon.

use std::path::PathBuf;

use genom_description_tools as tools;

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Draw components and their state machines.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Language of the drawing: Graphviz or Mermaid.
    #[arg(long, value_enum, default_value_t = Format::Dot)]
    format: Format,
    /// One component [default: all].
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Format {
    Dot,
    Mermaid,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read_sound(&args.files)?;
    let language = match args.format {
        Format::Dot => tools::Graph::Dot,
        Format::Mermaid => tools::Graph::Mermaid,
    };
    let all = &analysis.specification.components;
    let wanted = |name: &str| args.component.as_deref().is_none_or(|wanted| wanted == name);
    let drawn: Vec<String> = all
        .iter()
        .filter(|component| wanted(&component.name))
        .map(|component| tools::graph(component, language))
        .collect();
    if let (Some(name), true) = (&args.component, drawn.is_empty()) {
        let known: Vec<_> = all.iter().map(|component| format!("`{}`", component.name)).collect();
        let message = format!(
            "there is no component `{name}`; those described are: {}",
            if known.is_empty() { "none".to_owned() } else { known.join(", ") }
        );
        return Err(Failure::refused("graph", message));
    }
    session.print_text("graph", &drawn.concat())
}
