//! `genomctl describe`: prints what components offer, from their descriptions. No daemon.

use std::path::PathBuf;

use genom_description_tools::{describe, describe_text};

use crate::failure::Failure;
use crate::reading::Reading;
use crate::session::Session;

/// Describe components: services, ports and tasks with their documentation.
///
/// With --json, one line per component.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read_sound(&args.files)?;
    let specification = &analysis.specification;
    let components = specification.components.iter().map(|component| {
        if session.json {
            format!("{}\n", describe(specification, component))
        } else {
            describe_text(specification, component)
        }
    });
    let between = if session.json { "" } else { "\n" };
    session.print(&components.collect::<Vec<_>>().join(between))
}
