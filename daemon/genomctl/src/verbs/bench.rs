//! `genomctl bench`: compares middlewares on one deployment.

use std::path::{Path, PathBuf};
use std::time::Duration;

use genom_comparison::report::{CONNECTIONS, Report, WAYS};
use genom_comparison::{Way, chart};
use serde_json::json;
use tokio::signal::unix::{SignalKind, signal};

use crate::apart::Genomd;
use crate::bench::Plan;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;
use crate::times::seconds;

/// Compare middlewares on one deployment: rates, latencies, losses, processor time and memory.
///
/// Runs a deployment file on each middleware, one after the other, with daemons of its own that
/// nothing else on this machine or its network sees, and prints the figures side by side, with
/// those of the bare middleware. docs/bench.md says what each column is. A way that cannot run is
/// listed with the reason, and the exit status is 1. Ctrl-C stops what was started.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The deployment file (TOML), as for `genomd --config`; see configs/mission.toml.
    file: PathBuf,
    /// Middlewares to run it on, all ports on one [default: local,shm,zenoh,ros2; with --isolated
    /// all but local].
    #[arg(long, value_name = "BACKEND,...", value_delimiter = ',')]
    backends: Vec<String>,
    /// Besides those, run it on a middleware with single ports on others: "shm: camera/image=zenoh,
    /// ..."; may be repeated.
    #[arg(long, value_name = "BACKEND: PORT=BACKEND")]
    mix: Vec<Way>,
    /// Measure for so long, first counters, then the times of samples.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    seconds: Duration,
    /// Wait so long before.
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = seconds)]
    warm_up: Duration,
    /// Run each way so often, in turns; figures are of all runs together.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    runs: u32,
    /// Run each component in a process of its own (a cell), so that all samples cross processes.
    #[arg(long)]
    isolated: bool,
    /// Leave out the bare middlewares.
    #[arg(long)]
    no_floor: bool,
    /// Write the result into a file (JSON), too.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Draw it into a file (SVG).
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// The program that runs the deployment [default: genomd beside genomctl, else on PATH].
    #[arg(long, value_name = "PATH")]
    genomd: Option<PathBuf>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let (save, svg) = (args.save.clone(), args.svg.clone());
    let plan = args.plan()?;
    // Dropping what it began stops what it started.
    let report = tokio::select! {
        report = plan.compare(session) => report?,
        _ = interrupt.recv() => return Err(interrupted()),
        _ = terminate.recv() => return Err(interrupted()),
    };
    save.map_or(Ok(()), |file| write(&file, &format!("{}\n", json!(report))))?;
    svg.map_or(Ok(()), |file| write(&file, &chart::svg(&report)))?;
    if session.json {
        session.print(&format!("{}\n", json!(report)))?;
    } else {
        let [ways, connections] = tables(&report).map(|table| table.text(session.terminal));
        let between = if connections.is_empty() { "" } else { "\n" };
        session.print(&format!("{ways}{between}{connections}"))?;
    }
    match report.failed() {
        0 => Ok(()),
        failed => {
            let message = format!("{failed} of {} ways did not run", report.ways.len());
            Err(Failure::refused("not_run", message))
        }
    }
}

impl Args {
    fn plan(self) -> Result<Plan, Failure> {
        let all: &[&str] = match self.isolated {
            true => &["shm", "zenoh", "ros2"],
            false => &["local", "shm", "zenoh", "ros2"],
        };
        let alone: Vec<Way> = match self.backends.is_empty() {
            true => all.iter().map(|name| Way::all_on(name)).collect(),
            false => self.backends.iter().map(|name| Way::all_on(name.trim())).collect(),
        };
        if self.seconds.is_zero() || self.runs == 0 {
            return Err(Failure::usage(
                "nothing to measure in no time",
                "try --seconds 1 --runs 1",
            ));
        }
        Ok(Plan {
            genomd: Genomd::new(self.genomd),
            file: self.file,
            ways: alone.into_iter().chain(self.mix).collect(),
            seconds: self.seconds,
            warm_up: self.warm_up,
            runs: self.runs,
            isolated: self.isolated,
            floor: !self.no_floor,
        })
    }
}

fn write(file: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(file, text).map_err(|error| Failure::file(file, error))
}

fn interrupted() -> Failure {
    Failure::refused("interrupted", "interrupted; what was started has ended".to_owned())
}

fn tables(report: &Report) -> [Table; 2] {
    let mut ways = Table { header: WAYS.to_vec(), rows: report.way_rows() };
    if report.failed() == 0 {
        ways.header.pop();
        ways.rows.iter_mut().for_each(|row| drop(row.pop()));
    }
    [ways, Table { header: CONNECTIONS.to_vec(), rows: report.connection_rows() }]
}
