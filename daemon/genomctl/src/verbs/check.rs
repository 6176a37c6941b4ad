//! `genomctl check`: reads descriptions and prints their diagnostics. No daemon.

use std::io::{self, Write as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use genom_description::diagnostic::render::{human, json, short};
use genom_description::diagnostic::{Diagnostic, first};
use genom_description::{Analysis, Options};

use crate::agreement::Agreement;
use crate::failure::Failure;
use crate::reading::{Reading, SHOWN, counts};
use crate::session::Session;
use crate::terminal::coloured_errors;

/// Check descriptions: errors and warnings, shown in the text.
///
/// Without errors, hints tell what cannot work as described: what `genomctl verify` finds without a
/// search. They refuse nothing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The .gen files, read in order as one specification; or one library of codels (demo.so),
    /// which `genomd --check` compares with its description.
    #[arg(required_unless_present = "manifest")]
    files: Vec<PathBuf>,
    /// Check all files listed in a table, and compare the verdicts with those of GenoM3's tool that
    /// it records. Its columns, separated by tabs: file, number of errors, accept, reject or CRASH,
    /// and why ours differs.
    #[arg(long, value_name = "FILE.tsv", conflicts_with_all = ["files", "format", "short", "deny_warnings"])]
    manifest: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Output: for people, with the text; one line each, FILE:LINE:COLUMN, for editors; or JSON.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// The same as `--format short`.
    #[arg(long, conflicts_with = "format")]
    short: bool,
    /// Treat warnings as errors.
    #[arg(long)]
    deny_warnings: bool,
    /// How many errors, warnings and hints to print; the others are counted. With 0 all, up to
    /// 10000 of each.
    #[arg(long, value_name = "N", default_value_t = SHOWN)]
    limit: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Human,
    Short,
    Json,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    if let Some(manifest) = &args.manifest {
        return compare(args, manifest, session);
    }
    if let Some(library) = args.files.iter().find(|path| is_library(path)) {
        return Err(check_library(args, library));
    }
    let mut analysis = args.reading.read(&args.files)?;
    hint(&mut analysis);
    let (errors, warnings) = counts(&analysis);
    let format = match (session.json, args.short) {
        (true, _) => Format::Json,
        (false, true) => Format::Short,
        (false, false) => args.format,
    };
    let sources = &analysis.sources;
    let most = if args.limit == 0 { usize::MAX } else { args.limit };
    let (said, rest) = first(&analysis.diagnostics, sources, most);
    let mut text = match format {
        // Data goes to standard output.
        Format::Json => {
            let text = json(&said, rest, sources);
            // One line with `--json`, as for every verb; indented with `--format json`.
            let line = session.json.then(|| serde_json::from_str::<serde_json::Value>(&text).ok());
            let line = line.flatten().map(|document| format!("{document}\n"));
            session.print(&line.unwrap_or(text))?;
            String::new()
        }
        Format::Short => short(&said, sources),
        Format::Human => human(&said, sources, coloured_errors()),
    };
    if format != Format::Json && !rest.is_empty() {
        text.push_str(&format!("{rest}\n"));
    }
    io::stderr().lock().write_all(text.as_bytes())?;
    let refused = errors + if args.deny_warnings { warnings } else { 0 };
    if refused > 0 {
        return Err(Failure::Description { errors, warnings });
    }
    if format == Format::Human { session.print(&render(&analysis)) } else { Ok(()) }
}

/// Adds what can be said of the components without looking at their states.
fn hint(analysis: &mut Analysis) {
    if !analysis.has_errors() {
        let hints = genom_formal::hints(&Arc::new(analysis.specification.clone())).into_iter();
        let hints = hints
            .map(|hint| Diagnostic::hint(hint.property, hint.span.unwrap_or_default(), hint.what));
        analysis.diagnostics.extend(hints);
    }
}

/// Prints the table of agreement. GenoM3's tool does not know the standard interface.
fn compare(args: &Args, manifest: &Path, session: &Session) -> Result<(), Failure> {
    let options = Options { standard_interface: false, ..args.reading.options() };
    let agreement = Agreement::read(manifest, &options)?;
    let text = if session.json { format!("{}\n", agreement.data()) } else { agreement.text() };
    session.print(&text)?;
    agreement.verdict()
}

/// Summary of what was read, one component per line.
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

/// Whether the name is like `x.so` or `x.so.1`.
fn is_library(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.ends_with(".so") || name.contains(".so.")
}

/// Replaces this process by `genomd --check`: only the daemon opens libraries.
fn check_library(args: &Args, library: &Path) -> Failure {
    let descriptions: Vec<_> = args.files.iter().filter(|path| !is_library(path)).collect();
    if args.files.len() - descriptions.len() > 1 || descriptions.len() > 1 {
        return Failure::usage(
            "several files with a library among them",
            "write `genomctl check LIBRARY [DESCRIPTION]`",
        );
    }
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name("genomd"));
    let Some(daemon) = beside.filter(|path| path.is_file()) else {
        return Failure::usage(
            "libraries are checked by genomd, which is not beside genomctl",
            format!("run `genomd --check {}`", library.display()),
        );
    };
    let mut command = Command::new(daemon);
    command.arg("--check").arg(library);
    if let Some(description) = descriptions.first() {
        command.arg("--gen").arg(description);
    }
    for directory in &args.reading.include {
        command.arg("-I").arg(directory);
    }
    Failure::Io(command.exec())
}
