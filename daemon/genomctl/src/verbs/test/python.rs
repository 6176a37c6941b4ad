//! Scenarios in Python: an interpreter lists those of a file (`python -m genom.scenario`), and plays
//! each in a process of its own.

use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::time::Duration;

use genom_scenario::{Outcome, Overrides, Played, Scenario, ScenarioReport};
use rustix::process::{Pid, Signal, kill_process};
use tokio::time::timeout;

use crate::apart::Genomd;
use crate::failure::Failure;

/// Between two looks whether it has ended.
const MOMENT: Duration = Duration::from_millis(5);

/// How long a scenario that is given up may take to end its daemon.
const ENDING: Duration = Duration::from_secs(10);

/// The interpreter, which has the package `genom`.
#[derive(Debug)]
pub(super) struct Python {
    program: PathBuf,
    genomd: Genomd,
}

impl Python {
    pub(super) fn new(program: PathBuf, genomd: Genomd) -> Self {
        Self { program, genomd }
    }

    /// The scenarios of a file, in its order.
    pub(super) fn list(&self, file: &Path) -> Result<Vec<Scenario>, Failure> {
        let output = self.command(file).arg("--list").output();
        let output = output.map_err(|error| self.not_run(&error))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let message = format!("{}: {}", file.display(), said.trim_end());
            return Err(Failure::usage(
                message,
                "its interpreter is that of --python, and needs the package genom of this version",
            ));
        }
        let told = String::from_utf8_lossy(&output.stdout);
        let all: Result<Vec<Scenario>, _> = told.lines().map(Scenario::listed).collect();
        match all {
            Ok(all) if all.is_empty() => {
                let message = format!("{}: no function is a scenario", file.display());
                Err(Failure::usage(message, "write `@scenario` of genom.scenario above it"))
            }
            Ok(all) => Ok(all),
            Err(error) => {
                Err(Failure::refused("python", format!("{}: {error}", self.program.display())))
            }
        }
    }

    /// Plays one of them; gives it up after this time of the machine.
    pub(super) async fn play(
        &self,
        file: &Path,
        scenario: &Scenario,
        overrides: &Overrides,
        limit: Duration,
    ) -> (Outcome, Played) {
        let not_begun = |why: String| (Outcome::not_begun(scenario, &why), Played::default());
        // What it makes in a directory for temporary files goes with this. Sockets of cells have long
        // paths, and little room.
        let scratch = match tempfile::Builder::new().prefix("gtest-").tempdir() {
            Ok(scratch) => scratch,
            Err(error) => return not_begun(error.to_string()),
        };
        let mut command = self.command(file);
        command.args(["--line", &scenario.place.line.to_string()]).env("TMPDIR", scratch.path());
        if let Some(backend) = &overrides.backend {
            command.args(["--backend", backend]);
        }
        for directory in &overrides.path {
            command.arg("--path").arg(directory);
        }
        let mut running = match Running::start(&mut command) {
            Ok(running) => running,
            Err(error) => return not_begun(self.not_run(&error).to_string()),
        };
        let Ok(came) = timeout(limit, running.report()).await else {
            running.ask_to_end();
            // It ends its daemon; dropping it ends one that does not.
            let _ = timeout(ENDING, running.ended()).await;
            let why =
                format!("it has not ended after {} s of the machine's time", limit.as_secs_f64());
            return not_ended(scenario, &why);
        };
        match came {
            Ok(text) => match serde_json::from_str::<ScenarioReport>(text.trim_end()) {
                Ok(report) => (report.outcome, report.played),
                Err(_) => {
                    let how = running.ended().await;
                    let how =
                        how.map_or_else(|error| error.to_string(), |status| status.to_string());
                    not_ended(scenario, &format!("the interpreter ended before ({how})"))
                }
            },
            Err(error) => not_ended(scenario, &error.to_string()),
        }
    }

    fn command(&self, file: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command.args(["-m", "genom.scenario"]).arg(file);
        command.env("GENOMD", self.genomd.path()).stdin(Stdio::null());
        command
    }

    fn not_run(&self, error: &io::Error) -> Failure {
        let message = format!("{}: {error}", self.program.display());
        Failure::usage(message, "name the interpreter with --python")
    }
}

fn not_ended(scenario: &Scenario, why: &str) -> (Outcome, Played) {
    (Outcome::not_ended(scenario, why), Played::default())
}

/// A process of the interpreter; killed when dropped.
#[derive(Debug)]
struct Running {
    process: Child,
    out: Option<ChildStdout>,
}

impl Running {
    fn start(command: &mut Command) -> io::Result<Self> {
        let mut process = command.stdout(Stdio::piped()).spawn()?;
        let out = process.stdout.take();
        Ok(Self { process, out })
    }

    /// What it reports, up to its end.
    async fn report(&mut self) -> io::Result<String> {
        let Some(mut out) = self.out.take() else { return Ok(String::new()) };
        let reading = tokio::task::spawn_blocking(move || {
            let mut text = String::new();
            out.read_to_string(&mut text).map(|_| text)
        });
        reading.await.unwrap_or_else(|error| Err(io::Error::other(error)))
    }

    fn ask_to_end(&self) {
        let pid = i32::try_from(self.process.id()).ok().and_then(Pid::from_raw);
        // It may have ended already.
        let _ = pid.map(|pid| kill_process(pid, Signal::TERM));
    }

    async fn ended(&mut self) -> io::Result<ExitStatus> {
        loop {
            if let Some(status) = self.process.try_wait()? {
                return Ok(status);
            }
            tokio::time::sleep(MOMENT).await;
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended is no error.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
