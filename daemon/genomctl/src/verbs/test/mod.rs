//! `genomctl test`: plays scenarios of components on the stepped clock.

mod python;
mod scripted;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueHint;
use genom_apart::Private;
use genom_protocol::routes::{Bytes, Route};
use genom_scenario::{
    Daemon, Mistakes, NoSuite, Outcome, Overrides, Played, Progress, Report, Scenario, Suite,
    Trouble, find, play,
};
use rustix::process::{Pid, Signal, kill_process};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tokio::signal::unix::{SignalKind, signal};

use crate::apart::{Apart, Genomd};
use crate::escape;
use crate::failure::Failure;
use crate::session::Session;
use crate::times::seconds;
use python::Python;

/// Waits between two looks at a cell.
const MOMENT: Duration = Duration::from_millis(5);

/// Play scenarios of components on the stepped clock: what is called, published, expected, and what
/// goes wrong meanwhile.
///
/// Each scenario has a daemon of its own that nothing else on this machine sees. Its clock stands
/// still between steps, so two runs give the same report. docs/testing.md explains the files. The
/// exit status is 1 if a scenario does not pass, and 2 if a file has mistakes. Ctrl-C stops what was
/// started. Scenarios in Python are functions that step a daemon; `python -m genom.scenario` plays them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Files of scenarios (TOML or Python), or directories: all such files in and below them.
    #[arg(value_name = "FILE|DIRECTORY", default_value = "tests", value_hint = ValueHint::AnyPath)]
    files: Vec<PathBuf>,
    /// Only scenarios whose name contains this.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// List the scenarios, and play none.
    #[arg(long, conflicts_with = "junit")]
    list: bool,
    /// Write the report into a file as JUnit XML, too.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    junit: Option<PathBuf>,
    /// The middleware of all ports, in place of what the files say.
    #[arg(long, value_name = "BACKEND")]
    backend: Option<String>,
    /// Search components in this directory first; may be repeated.
    #[arg(long, value_name = "DIRECTORY", value_hint = ValueHint::DirPath)]
    path: Vec<PathBuf>,
    /// Give a scenario up after this time of the machine.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    limit: Duration,
    /// The program that runs the components [default: genomd beside genomctl, else on PATH].
    #[arg(long, value_name = "PATH", value_hint = ValueHint::ExecutablePath)]
    genomd: Option<PathBuf>,
    /// The interpreter of scenarios in Python, with the package genom.
    #[arg(long, value_name = "PATH", default_value = "python3", value_hint = ValueHint::ExecutablePath)]
    python: PathBuf,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    let suites = chosen(&args, session)?;
    if args.list {
        return list(&suites, session);
    }
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let junit = args.junit.clone();
    // Dropping what it began stops what it started.
    let report = tokio::select! {
        report = play_all(args, &suites, session) => report?,
        _ = interrupt.recv() => return Err(interrupted()),
        _ = terminate.recv() => return Err(interrupted()),
    };
    if let Some(file) = junit {
        std::fs::write(&file, report.junit()?).map_err(|error| Failure::file(&file, error))?;
    }
    match session.json {
        true => session.print(&format!("{}\n", json!(report)))?,
        false => session.print(&report.summary())?,
    }
    match report.failed {
        0 => Ok(()),
        failed => {
            let message = format!("{failed} of {} scenarios did not pass", report.total());
            Err(Failure::refused("not_passed", message))
        }
    }
}

fn interrupted() -> Failure {
    Failure::refused("interrupted", "interrupted; what was started has ended".to_owned())
}

/// The scenarios to play; files without any are left out.
fn chosen(args: &Args, session: &Session) -> Result<Vec<Suite>, Failure> {
    let mut suites = match find(&args.files) {
        Ok(suites) => suites,
        Err(NoSuite::Mistakes(all)) if !session.json => {
            for file in &all {
                session.tell(&escape::lines(file.drawn().trim_end()))?;
            }
            let count: usize = all.iter().map(Mistakes::count).sum();
            let message =
                format!("{count} mistake{} in scenarios", if count == 1 { "" } else { "s" });
            return Err(Failure::Usage { message, help: None });
        }
        Err(error) => {
            let help = "`genomctl test FILE` names a file of scenarios; docs/testing.md shows one";
            return Err(Failure::usage(error.to_string(), help));
        }
    };
    let python = Python::new(args.python.clone(), Genomd::new(args.genomd.clone()));
    for suite in suites.iter_mut().filter(|suite| suite.script) {
        suite.scenarios = python.list(&suite.file)?;
    }
    let Some(only) = &args.only else { return Ok(suites) };
    for suite in &mut suites {
        suite.scenarios.retain(|scenario| scenario.name.contains(only.as_str()));
    }
    suites.retain(|suite| !suite.scenarios.is_empty());
    if suites.is_empty() {
        let message = format!("no name of a scenario contains `{only}`");
        return Err(Failure::usage(message, "`genomctl test --list` lists them"));
    }
    Ok(suites)
}

fn list(suites: &[Suite], session: &Session) -> Result<(), Failure> {
    let all =
        || suites.iter().flat_map(|suite| suite.scenarios.iter().map(move |one| (suite, one)));
    if session.json {
        let rows: Vec<Value> = all()
            .map(|(suite, one)| {
                json!({"file": suite.file, "line": one.place.line, "name": one.name})
            })
            .collect();
        return session.print(&format!("{}\n", json!({ "scenarios": rows })));
    }
    let line = |(suite, one): (&Suite, &Scenario)| {
        escape::line(&format!("{}:{}: {}", suite.file.display(), one.place.line, one.name)) + "\n"
    };
    session.print(&all().map(line).collect::<String>())
}

async fn play_all(args: Args, suites: &[Suite], session: &Session) -> Result<Report, Failure> {
    let genomd = Genomd::new(args.genomd);
    let python = Python::new(args.python, genomd.clone());
    let path = args.path.iter().map(std::path::absolute).collect::<Result<_, _>>()?;
    let overrides = Overrides { backend: args.backend, path };
    let mut report = Report::default();
    let mut number = 0;
    for suite in suites {
        report.begin(suite.file.clone());
        tell(session, &format!("{}\n", suite.file.display()))?;
        for scenario in &suite.scenarios {
            number += 1;
            let (outcome, played) = if suite.script {
                python.play(&suite.file, scenario, &overrides, args.limit).await
            } else if let Some(run) = &scenario.run {
                scripted::play(scenario, run, args.limit).await
            } else {
                match begin(&genomd, scenario, &overrides, number).await {
                    Ok(mut daemon) => play_one(scenario, &mut daemon, args.limit).await,
                    Err(why) => (Outcome::not_begun(scenario, &why), Played::default()),
                }
            };
            report.add(scenario, outcome, played);
            let last = report.files.last().and_then(|suite| suite.scenarios.last());
            last.map_or(Ok(()), |last| tell(session, &last.text(&suite.file)))?;
        }
    }
    Ok(report)
}

/// Starts the daemon of a scenario.
async fn begin(
    genomd: &Genomd,
    scenario: &Scenario,
    overrides: &Overrides,
    number: usize,
) -> Result<Apart, String> {
    let text = |error: &dyn std::error::Error| error.to_string();
    let deployment = scenario.setup.deployment.as_deref();
    let deployment = deployment.map(|file: &Path| genomd.deployment(file)).transpose();
    let deployment = deployment.map_err(|error| text(&error))?;
    let table = scenario.setup.configuration(deployment.as_deref(), overrides);
    let private = Private::new("test", number).map_err(|error| text(&error))?;
    Apart::start(genomd, private, table.map_err(|error| text(&error))?).await
}

async fn play_one(scenario: &Scenario, daemon: &mut Apart, limit: Duration) -> (Outcome, Played) {
    let progress = Progress::default();
    let playing = play(scenario, &daemon.session, &progress);
    let (outcome, played) = tokio::time::timeout(limit, playing).await.unwrap_or_else(|_| {
        let why = format!("it has not after {} s of the machine's time", limit.as_secs_f64());
        progress.given_up(scenario, &why)
    });
    match (outcome, daemon.program.ended()) {
        // The end of the daemon explains more than that it does not answer.
        (Outcome::Error(mut unmet), Some(why)) => {
            unmet.came = format!("the daemon ended: {why}");
            (Outcome::Error(unmet), played)
        }
        (outcome, _) => (outcome, played),
    }
}

fn tell(session: &Session, text: &str) -> Result<(), Failure> {
    if session.json {
        return Ok(());
    }
    session.print(&text.lines().map(|line| escape::line(line) + "\n").collect::<String>())
}

impl Daemon for Session {
    async fn send<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: Route<R, Q, B>,
        body: &B,
    ) -> Result<R, Trouble> {
        let body = serde_json::to_vec(body).map_err(|error| Trouble::Gone(error.to_string()))?;
        read(self.client.request(&route, body).await)
    }

    async fn ask<R: DeserializeOwned, Q>(&self, route: Route<R, Q>) -> Result<R, Trouble> {
        read(self.client.request(&route, Vec::new()).await)
    }

    async fn bytes<Q>(&self, route: Route<Bytes, Q>) -> Result<Vec<u8>, Trouble> {
        let body = self.client.open(&route, Vec::new()).await.map_err(trouble)?;
        let whole = body.whole().await.map_err(trouble)?;
        whole.map(Vec::from).ok_or_else(|| trouble(self.client.lost()))
    }

    fn kill(&self, pid: u32) -> Result<(), Trouble> {
        let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
        let killed = pid.map_or(Ok(()), |pid| kill_process(pid, Signal::KILL));
        killed.map_err(|error| Trouble::Gone(error.to_string()))
    }

    async fn moment(&self) {
        tokio::time::sleep(MOMENT).await;
    }
}

fn read<R: DeserializeOwned>(reply: Result<Value, Failure>) -> Result<R, Trouble> {
    let reply = reply.map_err(trouble)?;
    serde_json::from_value(reply).map_err(|error| Trouble::Gone(error.to_string()))
}

fn trouble(failure: Failure) -> Trouble {
    match failure {
        Failure::Refused(reason) => Trouble::Refused(reason),
        failure => Trouble::Gone(failure.to_string()),
    }
}
