//! A daemon for one test: with its own socket and shared memory, removed after the test.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::Value;
use tempfile::TempDir;

use crate::command::{Finished, Running};
use crate::{path, program, repository, signal};

/// Shared memory that only the daemons of one test use.
#[derive(Debug)]
pub struct Memory {
    root: TempDir,
    prefix: String,
}

impl Memory {
    /// Creates a new root folder and prefix.
    #[must_use]
    pub fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let prefix = format!("gt{}_{number}_", std::process::id());
        // In memory, as where `/run/user` is: iceoryx2 synchronises its files.
        let root = tempfile::Builder::new().prefix("genomd-test-").tempdir_in("/dev/shm");
        Self { root: root.expect("a directory can be made"), prefix }
    }

    /// Root folder of iceoryx2's files.
    #[must_use]
    pub fn root(&self) -> &Path {
        self.root.path()
    }

    /// Prefix of the names of all segments.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// A ROS domain. Another test may have the same by chance, but uses other names in it.
    #[must_use]
    pub fn domain(&self) -> u32 {
        self.prefix.bytes().fold(0, |sum, byte| (sum * 31 + u32::from(byte)) % 100) + 1
    }

    /// All files that belong to it, in all folders.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let mut found = Vec::new();
        let mut directories = vec![self.root.path().to_owned()];
        while let Some(directory) = directories.pop() {
            for entry in std::fs::read_dir(directory).into_iter().flatten().flatten() {
                let path = entry.path();
                if path.is_dir() { directories.push(path) } else { found.push(path) }
            }
        }
        let segments = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        found.extend(segments.map(|entry| entry.path()).filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            // The segment in which iceoryx2 counts nodes remains: one per prefix.
            name.starts_with(&self.prefix) && !name.ends_with(".global_mgmt")
        }));
        found.sort();
        found
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // Removes what a killed daemon left, so that tests do not fill up the machine.
        let all = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        for entry in all {
            if entry.file_name().to_string_lossy().starts_with(&self.prefix) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// Directory for a daemon's files.
#[derive(Debug)]
pub struct Home {
    scratch: TempDir,
    memory: Arc<Memory>,
}

impl Home {
    /// A new directory with new shared memory.
    #[must_use]
    pub fn new() -> Self {
        Self::with(&Arc::new(Memory::new()))
    }

    /// A new directory with shared memory that others use, too.
    #[must_use]
    pub fn with(memory: &Arc<Memory>) -> Self {
        let scratch = TempDir::new().expect("a directory can be made");
        let config = format!(
            "[backends.shm]\nprefix = {:?}\nroot = {:?}\n[backends.zenoh]\nrendezvous = {:?}\n\
             [backends.ros2]\ndomain = {}\nnamespace = \"{}\"\n",
            memory.prefix(),
            memory.root(),
            memory.root().join("zenoh"),
            memory.domain(),
            memory.prefix().trim_end_matches('_'),
        );
        std::fs::write(scratch.path().join("genomd.toml"), config).expect("a file can be written");
        Self { scratch, memory: Arc::clone(memory) }
    }

    /// Path of the daemon's socket.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.scratch.path().join("run/genomd.sock")
    }

    /// Its shared memory.
    #[must_use]
    pub fn memory(&self) -> &Arc<Memory> {
        &self.memory
    }

    /// The directory, for files of the test.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.scratch.path()
    }

    /// What the daemon here answers to `GET path`, whatever the status.
    #[must_use]
    #[track_caller]
    pub fn get(&self, path: &str) -> Value {
        crate::request(&self.socket(), "GET", path, "").body
    }

    /// Adds to the configuration: `text` comes first in the file.
    #[must_use]
    pub fn configured(self, text: &str) -> Self {
        let path = self.path().join("genomd.toml");
        let own = std::fs::read_to_string(&path).expect("the file was written");
        std::fs::write(path, format!("{text}\n{own}")).expect("a file can be written");
        self
    }

    pub(crate) fn command(&self, prefix: &[&str], arguments: &[&str]) -> Command {
        let genomd = program("genomd");
        let mut command = match prefix {
            [] => Command::new(genomd),
            [by, options @ ..] => {
                let mut command = Command::new(by);
                command.args(options).arg(genomd);
                command
            }
        };
        command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
        // Reports of crashes go with the test.
        command.env("XDG_STATE_HOME", self.path().join("state"));
        // For cells that run codels in Python.
        command.env("PYTHONPATH", crate::repository().join("clients/python/src"));
        command.current_dir(self.path());
        command.arg("--config").arg(self.path().join("genomd.toml"));
        command.arg("--socket").arg(self.socket()).args(arguments);
        command
    }

    /// Starts a daemon here and waits until it is ready.
    #[must_use]
    #[track_caller]
    pub fn start(self, arguments: &[&str]) -> Daemon {
        self.start_by(&[], arguments)
    }

    /// The same through a program that executes it, such as `prlimit --rtprio=0`.
    #[must_use]
    #[track_caller]
    pub fn start_by(self, prefix: &[&str], arguments: &[&str]) -> Daemon {
        let running = Running::start(&mut self.command(prefix, arguments));
        if running.error_line_where(|line| line.contains("ready on ")).is_none() {
            panic!("genomd does not start:\n{}", running.finish().err);
        }
        Daemon { running, home: self }
    }

    /// Starts a daemon here without waiting.
    #[must_use]
    pub fn spawn(&self, arguments: &[&str]) -> Running {
        self.spawn_by(&[], arguments)
    }

    /// The same through a program that executes it.
    #[must_use]
    pub fn spawn_by(&self, prefix: &[&str], arguments: &[&str]) -> Running {
        Running::start(&mut self.command(prefix, arguments))
    }

    /// Starts a daemon here that must refuse to start.
    #[must_use]
    pub fn refused(&self, arguments: &[&str]) -> Finished {
        self.spawn(arguments).finish()
    }
}

impl Drop for Home {
    /// Cells go on without a daemon that was killed: they end with the test.
    fn drop(&mut self) {
        let mut all = self.socket().into_os_string();
        all.push(".cells");
        for cell in std::fs::read_dir(all).into_iter().flatten().flatten() {
            let pid = cell.path().join("pid");
            // A test may have put a pipe there.
            let Some(Ok(pid)) = pid.is_file().then(|| std::fs::read_to_string(pid)) else {
                continue;
            };
            let arguments = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            if arguments.windows(10).any(|word| word == b"--run-cell") {
                signal(pid, "KILL");
            }
        }
    }
}

impl Default for Home {
    fn default() -> Self {
        Self::new()
    }
}

/// A running daemon; killed when dropped.
#[derive(Debug)]
pub struct Daemon {
    running: Running,
    home: Home,
}

impl Daemon {
    /// Starts a daemon with these arguments in a new home.
    #[must_use]
    #[track_caller]
    pub fn start(arguments: &[&str]) -> Self {
        Home::new().start(arguments)
    }

    /// Starts a daemon with the demo on this backend.
    #[must_use]
    #[track_caller]
    pub fn demo(backend: &str) -> Self {
        let demo = crate::component("demo");
        Self::start(&["--backend", backend, path(&demo.library)])
    }

    /// The directory of its files.
    #[must_use]
    pub fn home(&self) -> &Home {
        &self.home
    }

    /// Its process.
    #[must_use]
    pub fn process(&self) -> &Running {
        &self.running
    }

    /// Starts a `genomctl`.
    #[must_use]
    pub fn spawn(&self, arguments: &[&str]) -> Running {
        let mut command = Command::new(program("genomctl"));
        command.env_clear().arg("--socket").arg(self.home.socket()).args(arguments);
        Running::start(&mut command)
    }

    /// Runs a `genomctl` to its end on a terminal with this many columns. Steps: see
    /// tests/fixtures/terminal.py.
    #[must_use]
    pub fn on_terminal(
        &self,
        columns: usize,
        environment: &[(&str, &str)],
        steps: &Value,
        arguments: &[&str],
    ) -> Finished {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        let mut command = Command::new(python);
        command
            .env_clear()
            .env("PATH", std::env::var_os("PATH").unwrap_or_default())
            .env("TERM", "xterm")
            .env("GENOMD_SOCKET", self.home.socket())
            .envs(environment.iter().copied())
            .arg(repository().join("tests/fixtures/terminal.py"))
            .arg(columns.to_string())
            .arg(steps.to_string())
            .arg(program("genomctl"))
            .args(arguments);
        Running::start(&mut command).finish()
    }

    /// Runs a `genomctl` to its end.
    #[must_use]
    pub fn ctl(&self, arguments: &[&str]) -> Finished {
        self.spawn(arguments).finish()
    }

    /// Runs a `genomctl --json` that must succeed, and returns its reply.
    #[track_caller]
    #[must_use]
    pub fn json(&self, arguments: &[&str]) -> Value {
        let finished = self.ctl(&[&["--json"], arguments].concat());
        finished.expect_code(0);
        serde_json::from_str(&finished.out).expect("JSON")
    }

    /// Number of periods that the tasks of a component missed so far.
    #[track_caller]
    #[must_use]
    pub fn missed(&self, component: &str) -> u64 {
        let stats = self.json(&["stats", component]);
        let tasks = stats["tasks"].as_array().expect("tasks");
        tasks.iter().map(|task| task["overruns"].as_u64().expect("a number")).sum()
    }

    /// A port as the daemon reports it: type, connection, value.
    #[track_caller]
    #[must_use]
    pub fn port(&self, component: &str, name: &str) -> Value {
        let reply = self.json(&["ports", component]);
        let mut ports = reply["ports"].as_array().expect("ports").iter();
        ports.find(|port| port["name"] == name).expect("the port").clone()
    }

    /// Opens the stream of events; those after this returns are received.
    #[must_use]
    pub fn events(&self) -> crate::Events {
        crate::Events::open(&self.home.socket())
    }

    /// Waits for its end, which something else causes.
    #[must_use]
    pub fn finish(self) -> (Finished, Home) {
        (self.running.finish(), self.home)
    }

    /// The same; fails if it takes longer than `longest`.
    #[must_use]
    pub fn finish_within(self, longest: std::time::Duration) -> (Finished, Home) {
        (self.running.finish_within(longest), self.home)
    }

    /// Sends a signal and waits for the end.
    #[must_use]
    pub fn stop(self, signal: &str) -> (Finished, Home) {
        self.running.signal(signal);
        (self.running.finish(), self.home)
    }

    /// Kills the daemon alone: its cells go on, and hold its standard error open.
    #[must_use]
    pub fn abandon(self) -> Home {
        self.running.signal("KILL");
        drop(self.running);
        self.home
    }
}
