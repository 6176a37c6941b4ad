//! A daemon that is a child of this program.

use std::fs::{self, File};
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, pidfd_open};
use tempfile::TempDir;

use crate::door::{Door, NoReply, Verb};
use crate::ended::Ended;
use crate::error::{AskError, OpenError, StartError};
use crate::options::Options;
use crate::shared::{Shared, lock};

/// How long a daemon may take to stop, beyond what its components may.
const STOPPING: Timespec = Timespec { tv_sec: 20, tv_nsec: 0 };

/// A daemon that runs as long as this value: a child of this program, with a clock that only
/// [`step`](Self::step) advances.
#[derive(Debug)]
pub struct Daemon {
    door: Arc<Mutex<Door>>,
    child: Child,
    /// Its socket and log.
    place: TempDir,
    /// Of what has to have a name on this machine.
    name: String,
    ended: bool,
}

impl Daemon {
    /// Starts one, and returns when it is ready.
    ///
    /// # Errors
    /// It does not run, has ended with what it said, or is of another version.
    pub fn start(options: &Options) -> Result<Self, StartError> {
        let place = tempfile::Builder::new().prefix("genomd-").tempdir()?;
        let random = place.path().file_name().unwrap_or_default().to_string_lossy();
        let name = random.replace('-', "");
        let program = options.program.clone();
        let program = program
            .or_else(|| {
                std::env::var_os("GENOMD").filter(|named| !named.is_empty()).map(PathBuf::from)
            })
            .unwrap_or_else(|| "genomd".into());
        let (door, theirs) = Door::new()?;
        let mut command = Command::new(&program);
        command.args(["--embedded", "--clock", "virtual", "--socket"]);
        command.arg(place.path().join(SOCKET));
        match &options.config {
            Some(file) => command.arg("--config").arg(file),
            None => command.args(apart(place.path(), &name)),
        };
        command.args(["--set", "cells.without_daemon=\"stop\""]).args(&options.arguments);
        command.stdin(theirs).stdout(Stdio::null()).stderr(File::create(place.path().join(LOG))?);
        // Ctrl-C is for this program.
        command.process_group(0);
        let child = command.spawn().map_err(|error| StartError::Program {
            program: program.display().to_string(),
            error,
        })?;
        // The daemon's end is its own.
        drop(command);
        let mut daemon =
            Self { door: Arc::new(Mutex::new(door)), child, place, name, ended: false };
        let version = match lock(&daemon.door).ask(Verb::Hello, &[]) {
            Ok(reply) => {
                Ok(String::from_utf8_lossy(&reply.body[TIME.min(reply.body.len())..]).into_owned())
            }
            Err(no) => Err(no),
        };
        let theirs = match version {
            Ok(version) => version,
            Err(NoReply::Refused(reason)) => return Err(StartError::Refused(reason)),
            Err(NoReply::Closed) => return Err(daemon.lost().into()),
        };
        let ours = env!("CARGO_PKG_VERSION");
        if theirs == ours { Ok(daemon) } else { Err(StartError::Version { ours, theirs }) }
    }

    /// The process of the daemon.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The Unix socket of its control plane.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        self.place.path().join(SOCKET)
    }

    /// The file that it logs to; it is removed when it has ended.
    #[must_use]
    pub fn log(&self) -> PathBuf {
        self.place.path().join(LOG)
    }

    /// Advances the clock, and runs all that is due in that time; returns its new time, since it was
    /// started.
    ///
    /// Values that were written to in ports are published first. A codel that does not return is
    /// waited for.
    ///
    /// # Errors
    /// It has ended; or a value is refused, or the step is longer than an hour: time stays.
    pub fn step(&mut self, time: Duration) -> Result<Duration, AskError> {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        let now = lock(&self.door).step(nanoseconds);
        now.map(Duration::from_nanos).map_err(|no| self.failed(no))
    }

    /// Stops the daemon, and waits for its end.
    ///
    /// # Errors
    /// The system does not tell how it ended.
    pub fn stop(mut self) -> io::Result<ExitStatus> {
        self.end()
    }

    /// Whether the daemon has this door.
    pub(crate) fn has(&self, door: &Arc<Mutex<Door>>) -> bool {
        Arc::ptr_eq(&self.door, door)
    }

    /// Opens a port of either kind.
    pub(crate) fn open(&mut self, address: &str) -> Result<Shared, OpenError> {
        let opened = Shared::open(&self.door, address);
        opened.map_err(|error| match error {
            Ok(error) => error,
            Err(no) => OpenError::Ask(self.failed(no)),
        })
    }

    fn failed(&mut self, no: NoReply) -> AskError {
        match no {
            NoReply::Refused(reason) => AskError::Refused(reason),
            NoReply::Closed => AskError::Ended(self.lost()),
        }
    }

    /// The daemon has closed its end: waits for its end.
    fn lost(&mut self) -> Ended {
        let status = self.end().ok();
        Ended::new(status, &self.log())
    }

    /// Ends the daemon: it stops when its socket is closed. Nothing of it runs after this.
    fn end(&mut self) -> io::Result<ExitStatus> {
        lock(&self.door).close();
        if !self.ended {
            if !ends(&self.child) {
                self.child.kill()?;
            }
            self.ended = true;
        }
        self.child.wait()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // A daemon whose end cannot be had is not this program's any more.
        let _ = self.end();
        // iceoryx2 leaves a segment in which it counts nodes, and a killed process all of its own.
        let prefix = format!("{}_", self.name);
        let segments = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        for segment in segments {
            if segment.file_name().to_string_lossy().starts_with(&prefix) {
                let _ = fs::remove_file(segment.path());
            }
        }
    }
}

/// Names in its directory.
const SOCKET: &str = "genomd.sock";
const LOG: &str = "log";

/// Bytes of a time in a reply.
const TIME: usize = 8;

/// Whether the child ends within [`STOPPING`].
fn ends(child: &Child) -> bool {
    let Ok(process) = pidfd_open(Pid::from_child(child), PidfdFlags::empty()) else { return false };
    let mut end = [PollFd::new(&process, PollFlags::IN)];
    loop {
        match poll(&mut end, Some(&STOPPING)) {
            Err(Errno::INTR) => {}
            Ok(count) => return count > 0,
            Err(_) => return false,
        }
    }
}

/// Options with which nothing of a daemon reaches others.
fn apart(place: &Path, name: &str) -> Vec<String> {
    let settings = [
        ("backends.shm.prefix", format!("{name}_")),
        ("backends.shm.root", place.join("shm").display().to_string()),
        ("backends.zenoh.rendezvous", place.join("zenoh").display().to_string()),
        ("backends.ros2.networks", "loopback".to_owned()),
        ("backends.ros2.namespace", name.to_owned()),
    ];
    let words =
        settings.iter().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value:?}")]);
    words.collect()
}
