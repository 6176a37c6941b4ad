//! `genomctl check`: reads descriptions and says all there is to say. No daemon.

use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;

use genom_description::diagnostic::Severity;
use genom_description::diagnostic::render::{human, json, short};
use genom_description::model::Specification;
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

    /// Reads files that must be right; what is wrong is drawn on standard error.
    pub(crate) fn understand(&self, files: &[PathBuf]) -> Result<Specification, Failure> {
        let analysis = self.read(files)?;
        if analysis.has_errors() {
            draw(&analysis)?;
            return Err(counted(&analysis));
        }
        Ok(analysis.specification)
    }
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let analysis = args.reading.read(&args.files)?;
    if session.json {
        session.print(&json(&analysis.diagnostics, &analysis.sources))?;
    } else if args.short {
        let text = short(&analysis.diagnostics, &analysis.sources);
        io::stderr().lock().write_all(text.as_bytes())?;
    } else {
        draw(&analysis)?;
    }
    if analysis.has_errors() || (args.deny_warnings && !analysis.diagnostics.is_empty()) {
        return Err(counted(&analysis));
    }
    if session.json { Ok(()) } else { session.print(&render(&analysis)) }
}

fn draw(analysis: &Analysis) -> Result<(), Failure> {
    let color = io::stderr().is_terminal();
    let text = human(&analysis.diagnostics, &analysis.sources, color);
    io::stderr().lock().write_all(text.as_bytes())?;
    Ok(())
}

fn counted(analysis: &Analysis) -> Failure {
    let count =
        |severity| analysis.diagnostics.iter().filter(|said| said.severity == severity).count();
    Failure::Description { errors: count(Severity::Error), warnings: count(Severity::Warning) }
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
