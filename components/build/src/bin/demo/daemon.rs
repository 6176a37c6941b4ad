//! A private genomd for the demonstration, controlled by genomctl.

use std::io::{BufRead as _, BufReader, Lines};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::failure::Failure;

/// Text in the log once the components run.
const READY: &str = "ready on";
/// Loading takes milliseconds; the limit allows for a machine that is busy compiling.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running genomd; killed when dropped without `stop`.
pub(crate) struct Daemon {
    process: Mutex<Child>,
    genomctl: PathBuf,
    socket: PathBuf,
    /// Collects the standard error of genomd.
    talk: Option<JoinHandle<String>>,
    /// Directory of the socket; private, so that a daemon of the user is not affected.
    _directory: TempDir,
}

impl Daemon {
    /// Starts genomd with one component and waits until that runs.
    pub(crate) fn start(
        genomd: &Path,
        genomctl: &Path,
        backend: &str,
        library: &Path,
    ) -> Result<Self, Failure> {
        let directory = tempfile::Builder::new()
            .prefix("genomd-demo-")
            .tempdir()
            .map_err(Failure::system("cannot make a temporary directory"))?;
        let socket = directory.path().join("socket");
        let mut process = Command::new(genomd)
            .args(["--backend", backend, "--log", "info", "--socket"])
            .arg(&socket)
            .arg(library)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(Failure::system("cannot start genomd"))?;
        let (talk, ready) = listen(process.stderr.take());
        let daemon = Self {
            process: Mutex::new(process),
            genomctl: genomctl.to_owned(),
            socket,
            talk: Some(talk),
            _directory: directory,
        };
        match ready.recv_timeout(PATIENCE) {
            Ok(()) => Ok(daemon),
            Err(_) => {
                daemon.abandon();
                Err(Failure::NotReady { said: daemon.said() })
            }
        }
    }

    /// Runs genomctl and returns its output, in JSON.
    pub(crate) fn ask(&self, arguments: &[&str]) -> Result<String, Failure> {
        let output = self
            .genomctl()
            .args(arguments)
            .output()
            .map_err(Failure::system("cannot run genomctl"))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
        }
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Err(Failure::Refused { command: arguments.join(" "), said })
    }

    /// Follows a port, with at most `rate` samples per second.
    pub(crate) fn echo(&self, port: &str, rate: u32) -> Result<Echo, Failure> {
        let mut process = self
            .genomctl()
            .args(["echo", port, "--rate", &rate.to_string()])
            .stdout(Stdio::piped())
            .spawn()
            .map_err(Failure::system("cannot run genomctl"))?;
        let output = process.stdout.take();
        Ok(Echo { process, output })
    }

    /// Stops it as a user would, and checks that it ended cleanly.
    pub(crate) fn stop(mut self) -> Result<(), Failure> {
        let process = self.process.get_mut().unwrap_or_else(PoisonError::into_inner);
        let pid = Pid::from_child(process);
        kill_process(pid, Signal::TERM)
            .map_err(|error| Failure::system("cannot stop genomd")(error.into()))?;
        let status = process.wait().map_err(Failure::system("cannot wait for genomd"))?;
        if status.success() {
            return Ok(());
        }
        Err(Failure::BadEnd { status, said: self.talk.take().map(joined).unwrap_or_default() })
    }

    /// Kills it, so that nobody waits for an answer any more.
    pub(crate) fn abandon(&self) {
        let mut process = self.process.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = process.kill();
        let _ = process.wait();
    }

    fn said(mut self) -> String {
        self.talk.take().map(joined).unwrap_or_default()
    }

    fn genomctl(&self) -> Command {
        let mut command = Command::new(&self.genomctl);
        command.arg("--json").arg("--socket").arg(&self.socket).stdin(Stdio::null());
        command
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        self.abandon();
    }
}

/// A running `genomctl echo`.
pub(crate) struct Echo {
    process: Child,
    output: Option<ChildStdout>,
}

impl Echo {
    /// The values, one per line.
    pub(crate) fn lines(&mut self) -> impl Iterator<Item = std::io::Result<String>> + use<> {
        self.output.take().into_iter().flat_map(|output| BufReader::new(output).lines())
    }

    /// Ends it, and thereby its lines.
    pub(crate) fn end(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        self.end();
    }
}

/// Reads the standard error of genomd, and sends a message once it is ready.
fn listen(stderr: Option<ChildStderr>) -> (JoinHandle<String>, Receiver<()>) {
    let (ready, is_ready) = mpsc::channel();
    let talk = thread::spawn(move || {
        let mut said = String::new();
        let lines = stderr
            .into_iter()
            .flat_map(|stderr: ChildStderr| -> Lines<_> { BufReader::new(stderr).lines() });
        for line in lines.map_while(Result::ok) {
            if line.contains(READY) {
                let _ = ready.send(());
            }
            said.push_str(&line);
            said.push('\n');
        }
        said
    });
    (talk, is_ready)
}

fn joined(talk: JoinHandle<String>) -> String {
    talk.join().unwrap_or_default()
}
