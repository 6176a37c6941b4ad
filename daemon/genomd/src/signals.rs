//! Handling of signals: stop, stop at once if repeated, and read the tokens again.

use std::fs::File;
use std::sync::Arc;
use std::time::Duration;

use genom_doors::Tokens;
use genom_host::KeptProcess;
use genom_supervisor::Supervisor;
use genom_systemd::Manager;
use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::daemon::Daemon;

/// A second signal within this time counts as the same request, sent for instance by both a
/// terminal and a supervisor.
const SAME: Duration = Duration::from_secs(1);

/// The signals that the daemon handles. The handlers are installed before anything else is done, so
/// that none of the signals ends the process.
pub(crate) struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hang_up: Signal,
    terminal: Terminal,
    /// Whether to continue without the terminal.
    keep: bool,
}

impl Signals {
    /// Installs the handlers. With `keep`, the end of the terminal does not stop the daemon.
    pub(crate) fn take(keep: bool) -> std::io::Result<Self> {
        // `nohup` starts programs with SIGHUP ignored.
        let keep = keep || ignores_hang_up();
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: signal(SignalKind::hangup())?,
            terminal: Terminal::of_process(),
            keep,
        })
    }

    /// Acts on signals until the process ends. A signal to stop that arrives a second or more after
    /// the daemon was asked to stop ends the process at once.
    pub(crate) async fn obey(mut self, daemon: Arc<Daemon>, tokens: Arc<Tokens>) {
        loop {
            let name = tokio::select! {
                _ = self.interrupt.recv() => Some("SIGINT"),
                _ = self.terminate.recv() => Some("SIGTERM"),
                _ = self.hang_up.recv() => self.hung_up(&tokens, &daemon.manager),
            };
            if let Some(name) = name {
                stop(&daemon.supervisor, name);
            }
        }
    }

    /// Distinguishes the two meanings of SIGHUP: the terminal is gone, or somebody sent the signal.
    fn hung_up(&mut self, tokens: &Tokens, manager: &Manager) -> Option<&'static str> {
        let ended = self.terminal.has_ended();
        match (ended, self.keep) {
            (true, false) => Some("the terminal was closed"),
            (true, true) => {
                tracing::info!("the terminal was closed: genomd goes on");
                None
            }
            (false, _) if tokens.has_file() => {
                if let Some(by) = genom_host::raised_to_stop() {
                    tracing::warn!("{by}: the tokens are read again");
                }
                manager.reloading();
                if let Err(error) = tokens.read_again() {
                    tracing::error!("the tokens are those of before: {error}");
                }
                manager.reloaded();
                None
            }
            (false, true) => {
                tracing::info!("SIGHUP is without effect: genomd was started to go on");
                None
            }
            (false, false) => Some("SIGHUP"),
        }
    }
}

fn stop(supervisor: &Supervisor, why: &str) {
    match supervisor.stopping_for() {
        None => supervisor.ask_to_stop(why),
        Some(time) if time >= SAME => {
            supervisor.forced.raise();
        }
        Some(_) => tracing::info!(
            "{why} while stopping: components have their time; another signal a second after the \
             first ends genomd at once, whatever codels are at"
        ),
    }
}

/// The terminal that the process was started on.
struct Terminal {
    there: bool,
}

impl Terminal {
    fn of_process() -> Self {
        Self { there: is_there() }
    }

    /// Whether there was a terminal that is gone now; true only once.
    fn has_ended(&mut self) -> bool {
        let ended = self.there && !is_there();
        self.there &= !ended;
        ended
    }
}

/// The kernel detaches a terminal from its processes before it sends them SIGHUP.
fn is_there() -> bool {
    File::open("/dev/tty").is_ok()
}

/// Whether the process was started with SIGHUP ignored.
fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ignored(&status).is_some_and(|signals| signals & 1 != 0)
}

/// The ignored signals from a process's `status` file, one bit each, the lowest for SIGHUP.
fn ignored(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// Restores signals, limits and descriptors of the process that codels changed, so that the daemon
/// keeps running and can be stopped.
pub(crate) async fn keep_process(kept: KeptProcess) {
    /// Interval between two checks.
    const LOOK: Duration = Duration::from_millis(100);
    loop {
        tokio::time::sleep(LOOK).await;
        for told in kept.look() {
            tracing::warn!("{told}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_status_of_a_process() {
        let status = |mask: &str| format!("Name:\tx\nSigBlk:\t01\nSigIgn:\t{mask}\nSigCgt:\t00\n");
        assert_eq!(ignored(&status("0000000000001001")), Some(0x1001));
        assert_eq!(ignored(&status("0000000000001000")).map(|bits| bits & 1), Some(0));
        assert_eq!(ignored("Name:\tx\n"), None);
    }
}
