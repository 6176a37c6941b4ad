//! `genomctl describe`: what a description offers. No daemon.

use std::path::PathBuf;

use genom_description::tools::{describe, describe_text};

use crate::failure::Failure;
use crate::session::Session;
use crate::verbs::check::Reading;

/// Describe the components of a description: what they offer and need.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let specification = args.reading.understand(&args.files)?;
    for component in &specification.components {
        if session.json {
            session.print(&format!("{}\n", describe(&specification, component)))?;
        } else {
            session.print(&describe_text(&specification, component))?;
        }
    }
    Ok(())
}
