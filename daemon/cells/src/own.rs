//! What makes this process a cell of another daemon: its journal, and what it does when that daemon
//! ends.

use std::fs::File;
use std::io;
use std::os::unix::net::UnixStream as StdStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::blackbox::Lease;
use crate::journal;
use crate::place::Place;
use crate::snapshots::Snapshots;
use crate::theirs;
use genom_configuration::{Config, ConfigError, Deployment, LoadRequest, WithoutDaemon};
use genom_gateway::{Listening, Reach, Server};
use genom_host::keep_from_children;
use genom_limits::{Grants, LimitError};
use genom_supervisor::Supervisor;
use genom_supervisor::Trials;
use genom_supervisor::bus::{Change, Heard};
use genom_supervisor::connections::between_processes;
use rustix::fs::StatVfsMountFlags;
use rustix::process::{Resource, Rlimit, Signal, getpid, getrlimit, kill_process, setrlimit};
use tokio::io::AsyncReadExt as _;
use tokio::net::UnixStream;

/// Changes within this time are written down together.
const TOGETHER: Duration = Duration::from_millis(20);

/// How long a process that ends by its supervision may write its note.
const LAST_WORDS: Duration = Duration::from_secs(3);

/// This process is a cell.
#[derive(Debug)]
pub struct OwnCell {
    place: Place,
    /// What it was to hold when it started; it counts until all of it is there again.
    before: Deployment,
    /// Copies of its components for its next process.
    snapshots: Arc<Snapshots>,
    /// Held while the journal is written.
    writing: Mutex<()>,
    /// Of a gateway: serves those who use it.
    serves: Mutex<Option<Listening>>,
}

impl OwnCell {
    /// The cell whose files stand beside its configuration.
    ///
    /// # Errors
    /// Its journal cannot be read.
    pub fn new(config: &Path) -> Result<Self, ConfigError> {
        let place = Place::of_config(config);
        let mut before = journal::read(&place.journal())?;
        genom_supervisor::reloading::roll_back(&place.trials(), &mut before);
        let (writing, serves) = (Mutex::default(), Mutex::default());
        let snapshots = Arc::new(Snapshots::new(config.parent().unwrap_or(Path::new("."))));
        Ok(Self { place, before, snapshots, writing, serves })
    }

    /// How libraries are tried that take the place of others.
    #[must_use]
    pub fn trials(&self) -> Trials {
        // An interpreter tells what is wrong with a script without ending.
        let program = std::env::current_exe().ok().filter(|_| !genom_host::interpreter::is_there());
        Trials { place: self.place.trials(), program }
    }

    /// Prepares for a crash: a note for the daemon, a dump by it if it takes one, and a core dump
    /// only where it is asked for.
    pub fn expect_crashes(&self, core: bool, lease: &mut Option<Lease>) {
        if let Some(dumper) = lease.as_mut().and_then(|lease| lease.dumper.take()) {
            genom_host::wait_for_dumps_at(dumper);
        }
        let prepare = || {
            genom_host::note_crashes_in(theirs::create(&self.place.note())?);
            let limit = getrlimit(Resource::Core);
            let current = if core { limit.maximum } else { none(limit.maximum) };
            Ok::<_, io::Error>(setrlimit(Resource::Core, Rlimit { current, ..limit })?)
        };
        if let Err(error) = prepare() {
            tracing::warn!("a crash of this cell will not be told in full: {error}");
        }
    }

    /// Of a gateway: serves its middleware, which is open, until nobody uses it any more.
    ///
    /// # Errors
    /// Its socket cannot be opened.
    pub fn serve(&self, supervisor: &Arc<Supervisor>) -> io::Result<()> {
        let Some(middleware) = self.gateway_of() else { return Ok(()) };
        let Some(open) = supervisor.backends.opened(middleware) else { return Ok(()) };
        let Some(door) = self.place.door() else { return Ok(()) };
        end_with_a_panic();
        let listening = Server::listen(&door, open)?;
        let (unused, supervisor) = (listening.unused(), Arc::clone(supervisor));
        std::thread::Builder::new().name("gateway-unused".to_owned()).spawn(move || {
            unused();
            supervisor.ask_to_stop("nobody uses this gateway any more");
        })?;
        *self.serves.lock().unwrap_or_else(PoisonError::into_inner) = Some(listening);
        Ok(())
    }

    /// Closes its gateway, if it is one.
    pub fn close(&self) {
        let listening = self.serves.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(listening);
    }

    /// The middleware whose gateway this process is.
    fn gateway_of(&self) -> Option<&str> {
        self.place.name().and_then(genom_gateway::middleware_of)
    }

    /// Writes down, for the daemon, why the middleware of this gateway cannot be opened: another
    /// attempt would change nothing.
    pub fn cannot_open(&self, why: &str) {
        if self.gateway_of().is_some() {
            let _ = theirs::write(&self.place.refusal(), why.as_bytes());
        }
    }

    /// What it is to bring up, with the copies that the process before this one made.
    #[must_use]
    pub fn before(&self) -> Deployment {
        let mut before = self.before.clone();
        self.snapshots.put_back(&mut before);
        before
    }

    /// Ends this process as a crash of that thread does, so that its daemon starts it again, also a
    /// daemon that comes later. The thread is in a codel that has not returned: the report of the
    /// crash shows where.
    pub(crate) fn end(&self, violation: &Change, why: &str, thread: Option<u32>) {
        tracing::error!("this cell ends: {why}");
        if let Err(error) = self.place.write_broken_rule(violation, why) {
            tracing::warn!("why it ends is not written down: {error}");
        }
        genom_host::abort_in(thread);
        // A codel may block the signal, or its stack be of no use.
        let spawned = std::thread::Builder::new().name("genomd-end".to_owned()).spawn(|| {
            let end = Instant::now() + LAST_WORDS;
            while let Some(left) = end.checked_duration_since(Instant::now()) {
                std::thread::park_timeout(left);
            }
            let _ = kill_process(getpid(), Signal::KILL);
        });
        if spawned.is_err() {
            let _ = kill_process(getpid(), Signal::KILL);
        }
    }

    /// Writes down what it is to hold now. What of its start is not there yet still counts.
    ///
    /// `all_there`: whether what it started with is loaded, connected and called.
    pub fn write(&self, supervisor: &Supervisor, all_there: bool) {
        // A component that goes since the cell stops is not one that somebody took away.
        if supervisor.stopping() {
            return;
        }
        let _turn = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        self.snapshots.make(supervisor, true);
        let held = supervisor.declared();
        let held = if all_there { held } else { held.over(&self.before) };
        let journal = self.place.journal();
        if let Err(error) = journal::write(&journal, &held) {
            tracing::error!("{}: {error}", journal.display());
        }
    }

    /// Writes it again whenever something changes that no request asked for, until the end.
    pub async fn keep(self: Arc<Self>, supervisor: Arc<Supervisor>, all_there: impl Fn() -> bool) {
        tokio::spawn(Arc::clone(&self.snapshots).keep(Arc::clone(&supervisor)));
        let mut changes = supervisor.bus.listen(None);
        while let Some(heard) = changes.next().await {
            let matters = match &heard {
                Heard::Missed { .. } => true,
                Heard::Told(change) => {
                    let kind = change.data["event"].as_str().unwrap_or_default();
                    !matches!(kind, "transition" | "overrun" | "event_fired" | "deployment_step")
                }
            };
            if matters {
                // Many changes come together, and requests have written theirs already.
                tokio::time::sleep(TOGETHER).await;
                while tokio::time::timeout(Duration::ZERO, changes.next())
                    .await
                    .is_ok_and(|one| one.is_some())
                {}
                let (own, supervisor) = (Arc::clone(&self), Arc::clone(&supervisor));
                let all_there = all_there();
                let writing =
                    tokio::task::spawn_blocking(move || own.write(&supervisor, all_there));
                let _ = writing.await;
            }
        }
    }
}

/// The limit with which the kernel dumps nothing. 0 is for dumps to files only: a program named by
/// `core_pattern` (of a distribution that collects crashes) gets the memory all the same, and the
/// process waits for it; with 1 the kernel does not start that program.
fn none(maximum: Option<u64>) -> Option<u64> {
    Some(maximum.map_or(1, |most| most.min(1)))
}

/// From now on a panic of any thread ends this process: a library whose thread is gone, or that has
/// left a lock behind, passes nothing on any more, and the next process of the gateway does.
fn end_with_a_panic() {
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        tell(panic);
        std::process::abort();
    }));
}

/// Limits this process to what its configuration grants: called first, before it has threads or
/// libraries. Returns what does not hold.
///
/// # Errors
/// It is not to run without what does not hold, or cannot.
pub fn limit(file: &Path, config: &Config) -> Result<Vec<String>, OwnLimitError> {
    let limits = &config.cells.limits;
    let place = file.parent().unwrap_or(Path::new("."));
    let temporary = std::env::temp_dir();
    if limits.is_sandbox()
        && temporary.starts_with(place)
        && rustix::fs::statvfs(&temporary)
            .is_ok_and(|told| told.f_flag.contains(StatVfsMountFlags::NOEXEC))
    {
        return Err(OwnLimitError::NoExecute(temporary));
    }
    let program = std::env::current_exe().ok();
    let own = program.into_iter().chain(genom_host::interpreter::reads());
    let own = own.chain(config.plugin_libraries());
    let read = config.path.iter().chain(&config.include).cloned().chain(own).collect();
    let mut write = genom_registry::places(&config.backends);
    write.push(place.to_owned());
    // A gateway opens its door; others knock there.
    let door = Place::of_config(file).door();
    write.extend(door.as_deref().and_then(Path::parent).map(Path::to_owned));
    let daemon = config.gateways.daemon.as_deref().filter(|_| !config.gateways.of.is_empty());
    let reach = daemon.map(|daemon| Reach::new(daemon).directory()).into_iter().collect();
    Ok(genom_limits::apply(limits, &Grants { read, write, reach })?)
}

/// Tells what of its limits does not hold: once, not at each start of its process.
pub fn tell_limits(file: &Path, missing: &[String]) {
    let (told, text) = (Place::of_config(file).told(), missing.join("\n"));
    let before = theirs::read(&told, text.len() as u64).unwrap_or_default();
    if before == text {
        return;
    }
    missing.iter().for_each(|line| tracing::warn!("limits of this cell: {line}"));
    if let Err(error) = theirs::write(&told, text.as_bytes()) {
        tracing::debug!("{}: {error}", told.display());
    }
}

/// Why a cell does not run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OwnLimitError {
    /// Limits that cannot be had.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A copy of a library could not be loaded from there.
    #[error(
        "{}: programs cannot be executed from this file system (`noexec`), and a cell in a sandbox \
         loads its libraries from there: give the daemon a --socket elsewhere", .0.display()
    )]
    NoExecute(PathBuf),
}

/// Writes down, for the daemon, why this cell does not run.
pub fn refuse(file: &Path, why: &str) {
    // The message is on standard error as well.
    let _ = theirs::write(&Place::of_config(file).refusal(), why.as_bytes());
}

/// Components of a cell meet those of other processes: what would stay within the daemon goes over
/// shared memory.
pub fn share(request: &mut LoadRequest) {
    let all = request.backend.iter_mut().chain(request.ports.values_mut());
    all.for_each(|names| *names = between_processes(names));
}

/// The standard input, which the daemon holds open as long as it lives, and what came with it;
/// codels get none.
///
/// # Errors
/// The system refuses.
pub fn take_lease() -> io::Result<Lease> {
    let lease = rustix::io::fcntl_dupfd_cloexec(rustix::stdio::stdin(), 3)?;
    keep_from_children(&lease);
    rustix::stdio::dup2_stdin(File::open("/dev/null")?)?;
    Ok(Lease::new(lease))
}

/// Waits for the end of the daemon that started this process, and does what was configured.
pub async fn outlive(lease: Lease, then: WithoutDaemon, supervisor: Arc<Supervisor>) {
    let socket = StdStream::from(lease.daemon);
    let opened = socket.set_nonblocking(true).and_then(|()| UnixStream::from_std(socket));
    let Ok(mut lease) = opened else { return };
    // Nothing is written there but what was taken already.
    while lease.read(&mut [0; 64]).await.is_ok_and(|count| count > 0) {}
    match then {
        WithoutDaemon::Continue => tracing::warn!("the daemon has ended; this cell goes on"),
        WithoutDaemon::Stop => supervisor.ask_to_stop("the daemon of this cell has ended"),
    }
}

#[cfg(test)]
mod tests {
    use genom_configuration::BackendNames;

    use super::*;

    #[test]
    fn what_would_stay_within_the_daemon_goes_over_shared_memory() {
        let mut request = LoadRequest {
            backend: Some(BackendNames::from("local+zenoh")),
            ports: [("pose".to_owned(), BackendNames::from("local+shm"))].into(),
            ..LoadRequest::default()
        };
        share(&mut request);
        assert_eq!(request.backend.unwrap().to_string(), "shm+zenoh");
        assert_eq!(request.ports["pose"].to_string(), "shm");
    }
}
