//! A daemon whose calls on shared memory are recorded, and that ends before one of them.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::os::unix::ffi::{OsStrExt as _, OsStringExt as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::trace::{self, Stop};
use crate::{Memory, WATCHDOG, signal};

/// Greatest length of a path that is read.
const PATH: usize = 512;

/// A call on shared memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// Name of the call.
    pub call: &'static str,
    /// Kind of the file: `shm .data`, `root .service`.
    pub file: String,
}

/// When a daemon ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// On its own.
    Own,
    /// Before the call with this index within a phase.
    Before {
        /// Index of the phase.
        phase: usize,
        /// Index of the call.
        call: usize,
    },
}

/// State that the tracing thread shares with its owner.
struct Shared {
    phase: AtomicUsize,
    process: Mutex<Option<libc::pid_t>>,
    started: Condvar,
}

/// The daemon.
pub(super) struct Watched {
    shared: Arc<Shared>,
    tracer: JoinHandle<Vec<Vec<Step>>>,
    lines: Receiver<String>,
}

impl Watched {
    /// Starts it; the indices of phases are less than `phases`.
    pub(super) fn start(mut command: Command, memory: &Memory, phases: usize, end: End) -> Self {
        let shared = Arc::new(Shared {
            phase: AtomicUsize::new(0),
            process: Mutex::new(None),
            started: Condvar::new(),
        });
        let (send, lines) = channel();
        let own = Arc::clone(&shared);
        let mut tracer = Tracer {
            shared: own,
            places: [memory.root().to_owned(), Path::new("/dev/shm").join(memory.prefix())],
            prefix: memory.prefix().to_owned(),
            steps: vec![Vec::new(); phases],
            end,
            process: 0,
        };
        // All `ptrace` requests must come from the thread that started the process.
        let tracer = thread::spawn(move || {
            trace::make_traced(&mut command);
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
            #[allow(clippy::zombie_processes, reason = "`follow` waits for its end by `waitpid`")]
            let mut child = command.spawn().expect("genomd can be started");
            let errors = child.stderr.take().expect("piped");
            thread::spawn(move || {
                for line in BufReader::new(errors).lines().map_while(Result::ok) {
                    let _ = send.send(line);
                }
            });
            tracer.follow(libc::pid_t::try_from(child.id()).expect("a process id"));
            tracer.steps
        });
        Self { shared, tracer, lines }
    }

    /// Calls from now on belong to this phase.
    pub(super) fn enter(&self, phase: usize) {
        self.shared.phase.store(phase, Ordering::SeqCst);
    }

    /// Waits for the line that says it is ready. Returns whether it came.
    pub(super) fn is_ready(&self) -> bool {
        while let Ok(line) = self.lines.recv_timeout(WATCHDOG) {
            if line.contains("ready on ") {
                return true;
            }
        }
        false
    }

    fn signal(&self, name: &str) {
        let mut process = self.shared.process.lock().unwrap_or_else(PoisonError::into_inner);
        while process.is_none() {
            let waited = self.shared.started.wait_timeout(process, Duration::from_secs(1));
            process = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        // The process may be gone already.
        signal(process.unwrap_or_default(), name);
    }

    /// Asks it to end (SIGTERM).
    pub(super) fn stop(&self) {
        self.signal("TERM");
    }

    /// Waits for its end. Returns its calls by phase.
    pub(super) fn finish(self) -> Vec<Vec<Step>> {
        self.tracer.join().expect("the tracing thread ends")
    }

    /// Kills it. Returns its calls by phase.
    pub(super) fn kill(self) -> Vec<Vec<Step>> {
        self.signal("KILL");
        self.finish()
    }
}

struct Tracer {
    shared: Arc<Shared>,
    /// Prefixes of the paths that count.
    places: [PathBuf; 2],
    prefix: String,
    steps: Vec<Vec<Step>>,
    end: End,
    process: libc::pid_t,
}

impl Tracer {
    /// Traces the daemon until it has ended.
    fn follow(&mut self, process: libc::pid_t) {
        self.process = process;
        *self.shared.process.lock().unwrap_or_else(PoisonError::into_inner) = Some(process);
        self.shared.started.notify_all();
        let mut known = BTreeSet::new();
        while let Some((thread, stop)) = trace::wait() {
            let first = known.insert(thread);
            let signal = match stop {
                Stop::Gone => continue,
                Stop::Signal(libc::SIGTRAP) if thread == process => {
                    // The new program is loaded, and has made no call yet.
                    trace::follow(thread).expect("the daemon can be traced");
                    0
                }
                // New threads begin with a stop.
                Stop::Signal(libc::SIGSTOP) if first => 0,
                Stop::Signal(signal) => signal,
                Stop::Other => 0,
                Stop::Call { name, arguments } => {
                    self.call(thread, name, arguments);
                    0
                }
            };
            trace::go_on(thread, signal);
        }
    }

    fn call(&mut self, thread: libc::pid_t, call: &'static str, arguments: [u64; 6]) {
        let Some(file) = file(thread, call, arguments).and_then(|path| self.kind(&path)) else {
            return;
        };
        let phase = self.shared.phase.load(Ordering::SeqCst);
        let Some(steps) = self.steps.get_mut(phase) else { return };
        if self.end == (End::Before { phase, call: steps.len() }) {
            trace::kill(self.process);
        }
        steps.push(Step { call, file });
    }

    /// Kind of a file of shared memory; `None` for other files.
    fn kind(&self, path: &Path) -> Option<String> {
        let whole = path.as_os_str().as_bytes();
        let place =
            self.places.iter().position(|at| whole.starts_with(at.as_os_str().as_bytes()))?;
        let name = path.file_name()?.to_string_lossy();
        let name = name.strip_suffix(" (deleted)").unwrap_or(&name);
        let name = name.strip_prefix(&self.prefix).unwrap_or(name);
        let kind = name.find('.').map_or("directory", |dot| &name[dot..]);
        Some(format!("{} {kind}", ["root", "shm"][place]))
    }
}

/// The file that a call refers to.
fn file(thread: libc::pid_t, call: &str, arguments: [u64; 6]) -> Option<PathBuf> {
    let [first, second, ..] = arguments;
    match call {
        "openat" | "unlinkat" | "mkdirat" | "fchmodat" | "renameat" | "renameat2" => {
            let path = text(thread, second)?;
            if path.is_absolute() {
                Some(path)
            } else {
                Some(descriptor(thread, first)?.join(path))
            }
        }
        "open" | "creat" | "chmod" | "unlink" | "rename" | "mkdir" | "rmdir" => text(thread, first),
        "mmap" => descriptor(thread, arguments[4]),
        _ => descriptor(thread, first),
    }
}

fn descriptor(thread: libc::pid_t, number: u64) -> Option<PathBuf> {
    #[allow(clippy::cast_possible_truncation, reason = "descriptors are ints in registers")]
    let number = number as u32 as i32;
    if number < 0 {
        return None;
    }
    std::fs::read_link(format!("/proc/{thread}/fd/{number}")).ok()
}

/// Reads a path from the memory of a process.
fn text(thread: libc::pid_t, at: u64) -> Option<PathBuf> {
    let memory = File::open(format!("/proc/{thread}/mem")).ok()?;
    let mut bytes = vec![0; PATH];
    // Fewer bytes if the next page is not mapped.
    let read = memory.read_at(&mut bytes, at).ok()?;
    bytes.truncate(read);
    let end = bytes.iter().position(|byte| *byte == 0)?;
    bytes.truncate(end);
    Some(OsString::from_vec(bytes).into())
}
