//! `genomctl graph`: draws components, from their descriptions or as they run.

use std::path::PathBuf;
use std::time::Duration;

use genom_description_tools as tools;
use genom_drawing::picture::{dot, mermaid, svg};

use crate::failure::Failure;
use crate::picture;
use crate::reading::Reading;
use crate::session::Session;

/// Draw a running system, or state machines of descriptions.
///
/// Without files, what runs: components with their ports, in frames of their cells; connections in
/// one colour for each middleware, with the rates that their writers have now; remotes and the
/// services they call (dashed); peers that are none of this daemon's (dashed frames). With files, the
/// state machines of the components that they describe, without a daemon.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification [default: what runs].
    files: Vec<PathBuf>,
    /// Language of the drawing: Graphviz, Mermaid, or SVG, which needs no other program; SVG is of
    /// what runs only.
    #[arg(long, value_enum, default_value_t = Format::Dot)]
    format: Format,
    /// With files: one component [default: all].
    #[arg(long, value_name = "NAME", requires = "files")]
    component: Option<String>,
    /// Without files: seconds that rates are of; 0 leaves them out.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, conflicts_with = "files")]
    window: f64,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Format {
    Dot,
    Mermaid,
    Svg,
}

pub(super) async fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    if args.files.is_empty() { draw_running(args, session).await } else { draw(args, session) }
}

async fn draw_running(args: &Args, session: &Session) -> Result<(), Failure> {
    let window = Duration::try_from_secs_f64(args.window)
        .map_err(|_| Failure::usage(format!("--window {}: no time", args.window), "try 1, or 0"))?;
    let system = picture::read(session, (!window.is_zero()).then_some(window)).await?;
    let drawn = match args.format {
        Format::Dot => dot(&system),
        Format::Mermaid => mermaid(&system),
        Format::Svg => svg(&system),
    };
    session.print_text("graph", &drawn)
}

fn draw(args: &Args, session: &Session) -> Result<(), Failure> {
    let language = match args.format {
        Format::Dot => tools::Graph::Dot,
        Format::Mermaid => tools::Graph::Mermaid,
        Format::Svg => {
            let message = "state machines are drawn as dot or mermaid";
            return Err(Failure::usage(message, "`genomctl graph --format svg` draws what runs"));
        }
    };
    let analysis = args.reading.read_sound(&args.files)?;
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
