//! `genomctl check`: reads descriptions and says all there is to say. No daemon.

use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;

use genom_description::diagnostic::Severity;
use genom_description::diagnostic::render::{human, json, short};
use genom_description::{Analysis, Options, preprocess, read};

use crate::failure::Failure;
use crate::session::Session;

/// Check descriptions: mistakes and surprises, drawn in the text.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// One line for each: FILE:LINE:COLUMN, as editors read it.
    #[arg(long)]
    short: bool,
    /// Refuse warnings too.
    #[arg(long)]
    deny_warnings: bool,
}

/// How to read descriptions.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Reading {
    /// Directory for #include; may be repeated.
    #[arg(long, short = 'I', value_name = "DIRECTORY")]
    include: Vec<PathBuf>,
    /// Definition for the preprocessor; may be repeated.
    #[arg(long = "define", short = 'D', value_name = "NAME[=VALUE]")]
    defines: Vec<String>,
}

impl Reading {
    /// Reads the files as one specification.
    pub(crate) fn read(&self, files: &[PathBuf]) -> Result<Analysis, Failure> {
        if let Some(missing) = files.iter().find(|path| !path.is_file()) {
            return Err(Failure::usage(
                format!("{}: no such file", missing.display()),
                "name a .gen file",
            ));
        }
        let preprocess = preprocess::Options {
            include_dirs: self.include.clone(),
            defines: self.defines.clone(),
            ..preprocess::Options::default()
        };
        Ok(read(files, &Options { preprocess, ..Options::default() }))
    }
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read(&args.files)?;
    let count =
        |severity| analysis.diagnostics.iter().filter(|said| said.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    if session.json {
        session.print(&json(&analysis.diagnostics, &analysis.sources))?;
    } else {
        let text = if args.short {
            short(&analysis.diagnostics, &analysis.sources)
        } else {
            human(&analysis.diagnostics, &analysis.sources, io::stderr().is_terminal())
        };
        io::stderr().lock().write_all(text.as_bytes())?;
    }
    let refused = errors + if args.deny_warnings { warnings } else { 0 };
    if refused > 0 {
        return Err(Failure::Description { errors, warnings });
    }
    if session.json { Ok(()) } else { session.print(&render(&analysis)) }
}

/// What was read, one component a line.
fn render(analysis: &Analysis) -> String {
    let components = &analysis.specification.components;
    components
        .iter()
        .map(|component| {
            format!(
                "component {}: {} services, {} ports, {} tasks, digest {}\n",
                component.name,
                component.services.iter().filter(|service| !service.standard).count(),
                component.ports.len(),
                component.tasks.len(),
                component.digest,
            )
        })
        .collect()
}
