//! The daemon: runs GenoM3 components on a middleware chosen at run time.
//!
//! This file only connects the parts: settings, components, control plane, and shutdown.

#![forbid(unsafe_code)]

mod announcements;
mod check;
mod cli;
mod daemon;
mod life;
mod refusal;
mod ros;
mod rpc;
mod run;
mod settings;
mod signals;

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{CommandFactory as _, Parser as _};
use genom_configuration::Config;

use crate::cli::Cli;
use crate::run::Refusal;
use crate::settings::Settings;
use genom_cells::OwnCell;
use genom_embedding::Program;
use genom_systemd::Invitation;
use genom_telemetry::logs;

/// The exit status of success.
const SUCCESS: u8 = 0;

/// Runs as the program does with these arguments, its name first, until it is asked to stop. Returns
/// the exit status. A process does that once: signals and limits are the daemon's from then on.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { SUCCESS };
            // A closed pipe is not a failure.
            let _ = error.print();
            return code;
        }
    };
    if cli.version {
        return print(version());
    }
    if let Some(shell) = cli.completion {
        let mut text = Vec::new();
        clap_complete::generate(shell, &mut Cli::command(), "genomd", &mut text);
        return print(text);
    }
    if let Some(directory) = &cli.man {
        return write_manual(directory);
    }
    if cli.dump_config {
        return dump_config(&cli);
    }
    // While this is the only thread: others could read the environment.
    let invitation = Invitation::take();
    genom_host::tell_last_words();
    genom_host::guard_process();
    let run = match (cli.check, cli.dump_sources) {
        (true, _) => check::run,
        (false, true) => check::dump_sources,
        (false, false) => run::run,
    };
    let cell_file = cell_file(&cli);
    let settings = settings(cli, invitation);
    if let (Some(file), Err(refusal)) = (&cell_file, &settings) {
        genom_cells::own::refuse(file, refusal.message());
    }
    let outcome = settings.and_then(run);
    genom_host::end_is_ours();
    match outcome {
        Ok(()) => SUCCESS,
        Err(refusal) => refusal.report(),
    }
}

/// The configuration of a cell, which stands among its files.
fn cell_file(cli: &Cli) -> Option<PathBuf> {
    cli.config.clone().filter(|_| cli.run_cell.is_some())
}

/// Applies the command line to the configuration file, and checks the result.
fn settings(cli: Cli, invitation: Invitation) -> Result<Settings, Refusal> {
    let config = Config::read(cli.config.as_deref(), &cli.set).map_err(Refusal::usage)?;
    let cell_file = cell_file(&cli);
    // First of all: limits hold for what comes after.
    let limit = |file: &PathBuf| genom_cells::own::limit(file, &config);
    let missing = cell_file.as_ref().map(limit).transpose().map_err(Refusal::usage)?;
    let program = cli.embedded.then(Program::take).transpose().map_err(Refusal::usage)?;
    let mut settings = Settings::new(cli, config).map_err(Refusal::usage)?;
    settings.invitation = invitation;
    settings.program = program;
    if let Some(file) = &cell_file {
        let own = OwnCell::new(file).map_err(Refusal::usage)?;
        let mut lease = genom_cells::own::take_lease().map_err(Refusal::own)?;
        settings.program = lease.steps.take().map(Program::of_daemon);
        settings.lease = Some(lease);
        settings.deployment = own.before();
        settings.supervisor.trials = Some(own.trials());
        settings.own_cell = Some(Arc::new(own));
    }
    logs::start(&settings.log, settings.collector.is_some()).map_err(Refusal::usage)?;
    if let (Some(file), Some(missing)) = (&cell_file, missing) {
        genom_cells::own::tell_limits(file, &missing);
    }
    if let Some(own) = &settings.own_cell {
        own.expect_crashes(settings.config.crashes.core, &mut settings.lease);
    }
    genom_registry::check(&settings.supervisor.backend).map_err(Refusal::usage)?;
    genom_registry::check_options(&settings.supervisor.backends).map_err(Refusal::usage)?;
    Ok(settings)
}

/// Writes the manual page, generated from the definitions of `--help`.
fn write_manual(directory: &Path) -> u8 {
    let written = std::fs::create_dir_all(directory)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), directory));
    match written {
        Ok(()) => SUCCESS,
        Err(error) => Refusal::usage(format!("--man {}: {error}", directory.display())).report(),
    }
}

/// Prints the configuration that results from file and command line.
fn dump_config(cli: &Cli) -> u8 {
    let config = Config::read(cli.config.as_deref(), &cli.set).map_err(Refusal::usage);
    let text = config.and_then(|config| cli.over(config).text().map_err(Refusal::usage));
    text.map_or_else(|refusal| refusal.report(), print)
}

/// Prints; a closed pipe is not a failure.
fn print(text: impl AsRef<[u8]>) -> u8 {
    let _ = std::io::stdout().lock().write_all(text.as_ref());
    SUCCESS
}

fn version() -> String {
    let mut text = format!("genomd {}\n", env!("CARGO_PKG_VERSION"));
    for known in genom_registry::known() {
        text.push_str(&format!("backend {} ({})\n", known.name, known.version));
    }
    text
}
