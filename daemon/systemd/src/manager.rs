//! The way to the service manager: one datagram for each thing that it is told.

use std::ffi::OsStr;
use std::io;
use std::os::fd::OwnedFd;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

use genom_host::{keep_from_children, keep_off};
use rustix::time::{ClockId, clock_gettime};

use crate::invitation::Invitation;

/// How long a message waits for room in a manager's queue.
const PATIENCE: Duration = Duration::from_secs(1);

/// Why a service manager hears nothing of this daemon.
#[derive(Debug, thiserror::Error)]
enum SocketError {
    #[error("NOTIFY_SOCKET is neither a path nor `@NAME`")]
    Kind,
    #[error("NOTIFY_SOCKET: {0}")]
    Io(#[from] io::Error),
}

/// The service manager of this process, if there is one; else nobody hears what it is told.
#[derive(Debug, Default)]
pub struct Manager {
    socket: Option<UnixDatagram>,
    watchdog: Option<Duration>,
}

impl Manager {
    /// Opens the way to it. When that fails it is logged, and nothing is told: the daemon runs as
    /// without a manager, which will find that it does not get ready.
    #[must_use]
    pub fn new(invitation: &Invitation) -> Self {
        let socket = invitation.socket.as_deref().map(open).transpose();
        let socket = socket.unwrap_or_else(|error| {
            tracing::warn!("the service manager cannot be told anything: {error}");
            None
        });
        Self { socket, watchdog: invitation.watchdog }
    }

    /// How long it waits for a sign of life, if it does.
    #[must_use]
    pub fn watchdog(&self) -> Option<Duration> {
        self.watchdog.filter(|_| self.socket.is_some())
    }

    /// What the daemon does, for `systemctl status`.
    pub fn status(&self, text: &str) {
        self.send(&[&status(text)]);
    }

    /// The same of work that may take this long, which its timeouts of starting and stopping are
    /// to allow for.
    pub fn status_of_work(&self, text: &str, longest: Duration) {
        let longest = format!("EXTEND_TIMEOUT_USEC={}", longest.as_micros());
        self.send(&[&status(text), &longest]);
    }

    /// The daemon has started.
    pub fn ready(&self, text: &str) {
        self.send(&["READY=1", &status(text)]);
    }

    /// It reads something again; [`reloaded`](Self::reloaded) is to follow.
    pub fn reloading(&self) {
        let now = clock_gettime(ClockId::Monotonic);
        let now = now.tv_sec.saturating_mul(1_000_000).saturating_add(now.tv_nsec / 1000);
        self.send(&["RELOADING=1", &format!("MONOTONIC_USEC={now}")]);
    }

    /// It has read it.
    pub fn reloaded(&self) {
        self.send(&["READY=1"]);
    }

    /// It stops, which may take this long.
    pub fn stopping(&self, longest: Duration) {
        let longest = format!("EXTEND_TIMEOUT_USEC={}", longest.as_micros());
        self.send(&["STOPPING=1", &status("stops"), &longest]);
    }

    /// It lives.
    pub(crate) fn lives(&self) {
        self.send(&["WATCHDOG=1"]);
    }

    fn send(&self, lines: &[&str]) {
        let Some(socket) = &self.socket else { return };
        if let Err(error) = socket.send(lines.join("\n").as_bytes()) {
            tracing::warn!("the service manager was not told {}: {error}", lines[0]);
        }
    }
}

/// One line, whatever is in the text.
fn status(text: &str) -> String {
    format!("STATUS={}", text.replace(['\n', '\r'], " "))
}

fn open(name: &OsStr) -> Result<UnixDatagram, SocketError> {
    let address = match name.as_bytes() {
        [b'@', name @ ..] => SocketAddr::from_abstract_name(name)?,
        [b'/', ..] => SocketAddr::from_pathname(name)?,
        _ => return Err(SocketError::Kind),
    };
    // Codels may close low descriptors, and fork.
    let socket = keep_off(OwnedFd::from(UnixDatagram::unbound()?))?;
    keep_from_children(&socket);
    let socket = UnixDatagram::from(socket);
    socket.set_write_timeout(Some(PATIENCE))?;
    socket.connect_addr(&address)?;
    Ok(socket)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_manager_is_told_is_lines_of_one_datagram() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("notify");
        let heard = UnixDatagram::bind(&path).unwrap();
        let invitation = Invitation { socket: Some(path.into()), watchdog: None };
        let manager = Manager::new(&invitation);
        manager.ready("ready\non /run/x");
        let mut bytes = [0; 512];
        let length = heard.recv(&mut bytes).unwrap();
        assert_eq!(&bytes[..length], b"READY=1\nSTATUS=ready on /run/x");
        manager.reloading();
        let length = heard.recv(&mut bytes).unwrap();
        assert!(bytes[..length].starts_with(b"RELOADING=1\nMONOTONIC_USEC="));
    }

    #[test]
    fn a_socket_of_another_kind_or_of_nobody_is_no_reason_not_to_run() {
        for name in ["vsock:2:1", "", "/nobody/listens/here"] {
            let socket = Some(name.into());
            let watchdog = Some(Duration::from_secs(1));
            let manager = Manager::new(&Invitation { socket, watchdog });
            manager.ready("unheard");
            assert_eq!(manager.watchdog(), None, "{name}");
        }
    }
}
