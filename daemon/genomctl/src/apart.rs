//! Daemons that a verb starts for itself, and that nothing else sees.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use genom_apart::Private;
use genom_apart::process::Program;
use genom_protocol::{Code, ReadyParameters, Sources, routes};
use toml::Table;

use crate::connection::Connection;
use crate::failure::Failure;
use crate::session::Session;

/// How long a daemon may take until its deployment is complete.
const DEPLOYED: Duration = Duration::from_secs(60);
/// How often to look whether it has begun to answer.
const LOOK: Duration = Duration::from_millis(5);

/// The program `genomd`.
#[derive(Clone, Debug)]
pub(crate) struct Genomd(PathBuf);

impl Genomd {
    /// The one given, else that beside this program, else that on PATH.
    pub(crate) fn new(given: Option<PathBuf>) -> Self {
        let beside = || {
            let here = std::env::current_exe().ok()?.with_file_name("genomd");
            here.exists().then_some(here)
        };
        Self(given.or_else(beside).unwrap_or_else(|| PathBuf::from("genomd")))
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// What it reads in a deployment file, as text of a configuration with absolute paths.
    pub(crate) fn deployment(&self, file: &Path) -> Result<String, Failure> {
        // Relative paths in it become absolute if its own is.
        let file = std::path::absolute(file)?;
        let output = Command::new(&self.0).arg("--config").arg(file).arg("--dump-config").output();
        let output = output.map_err(|error| self.not_run(&error))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let why = String::from_utf8_lossy(&output.stderr);
        let why = why.trim().trim_start_matches("error: ").to_owned();
        Err(Failure::Usage { message: why, help: None })
    }

    /// What the components of a deployment file are made of. No library is opened.
    pub(crate) fn sources(&self, file: &Path) -> Result<Vec<Sources>, Failure> {
        let file = std::path::absolute(file)?;
        let arguments = ["--dump-sources", "--log", "error", "--config"];
        let output = Command::new(&self.0).args(arguments).arg(file).output();
        let output = output.map_err(|error| self.not_run(&error))?;
        let told = String::from_utf8_lossy(&output.stdout);
        let all: Result<Vec<Sources>, _> = told.lines().map(serde_json::from_str).collect();
        match all {
            Ok(all) if output.status.success() => Ok(all),
            Err(error) if output.status.success() => {
                Err(Failure::refused("sources", format!("{}: {error}", self.0.display())))
            }
            _ => {
                let why = String::from_utf8_lossy(&output.stderr);
                let why = why.trim().trim_start_matches("error: ").to_owned();
                Err(Failure::Usage { message: why, help: None })
            }
        }
    }

    /// The first line of `genomd --version`.
    pub(crate) fn version(&self) -> Result<String, Failure> {
        let output = Command::new(&self.0).arg("--version").output();
        let output = output.map_err(|error| self.not_run(&error))?;
        let told = String::from_utf8_lossy(&output.stdout);
        Ok(told.lines().next().unwrap_or_default().to_owned())
    }

    fn not_run(&self, error: &io::Error) -> Failure {
        let message = format!("{}: {error}", self.0.display());
        Failure::usage(message, "name the program with --genomd")
    }
}

/// A daemon that was started. It ends when this is dropped, before its files go.
pub(crate) struct Apart {
    /// Asks it.
    pub(crate) session: Session,
    pub(crate) program: Program,
    _private: Private,
}

impl Apart {
    /// Starts a daemon and waits until it has its components, connections, calls and activities.
    pub(crate) async fn start(
        genomd: &Genomd,
        private: Private,
        table: Table,
    ) -> Result<Self, String> {
        let file = private.configure(table).map_err(|error| error.to_string())?;
        let (file, socket) = (file.display().to_string(), private.socket());
        let arguments =
            ["--config", &file, "--socket", &socket.display().to_string(), "--log", "warn"];
        let started = Program::start(genomd.path(), &arguments, &private.log());
        let mut program = started.map_err(|error| genomd.not_run(&error).to_string())?;
        let given = Connection { socket: Some(socket), ..Connection::default() };
        let session = Session::new(given, false);
        // Its file has another name each time, and is gone when this is read.
        let named = |why: String| why.replace(&file, "its configuration");
        deployed(&session, &mut program).await.map_err(named)?;
        Ok(Self { session, program, _private: private })
    }
}

async fn deployed(session: &Session, program: &mut Program) -> Result<(), String> {
    let begin = Instant::now();
    let query = ReadyParameters { wait: Some(0.2), deployed: Some(true) };
    loop {
        if let Some(why) = program.ended() {
            return Err(why);
        }
        let why = match session.client.request(&routes::ready().with(&query), Vec::new()).await {
            Ok(_) => return Ok(()),
            // One that stops tells why when it has.
            Err(Failure::Refused(reason))
                if reason.is(Code::NotReady) || reason.is(Code::Stopping) =>
            {
                reason.message
            }
            Err(failure @ (Failure::Unreachable { .. } | Failure::Lost { .. })) => {
                failure.to_string()
            }
            Err(failure) => return Err(failure.to_string()),
        };
        if begin.elapsed() >= DEPLOYED {
            return Err(format!("not deployed after {} s: {why}", DEPLOYED.as_secs()));
        }
        tokio::time::sleep(LOOK).await;
    }
}
