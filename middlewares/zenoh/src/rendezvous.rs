//! How the daemons of one machine find each other: by Unix sockets in a folder of the user.
//!
//! When a session opens, it listens on a socket of its own in that folder and connects to all
//! others in it. A lock on the folder serialises opening, so that of two sessions the later one
//! sees the earlier. All sessions are equal: any may end, and the others stay connected.

use std::fs::{DirBuilder, File, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Greatest length in bytes of a Unix socket's path on Linux, without the final NUL.
const LONGEST: usize = 107;

/// Number of sessions that this process has opened.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

/// Default folder of the sockets: `/run/user/<uid>/genomd/zenoh`, or `/tmp/genomd-<uid>/zenoh` if
/// there is no `/run/user/<uid>`.
#[must_use]
pub fn default_directory() -> PathBuf {
    let uid = rustix::process::getuid().as_raw();
    let run = PathBuf::from(format!("/run/user/{uid}"));
    let base =
        if run.is_dir() { run.join("genomd") } else { PathBuf::from(format!("/tmp/genomd-{uid}")) };
    base.join("zenoh")
}

/// A session's files in the folder; removed on drop.
#[derive(Debug)]
pub(crate) struct Rendezvous {
    socket: PathBuf,
}

/// Prevents other sessions from opening until it is dropped.
#[derive(Debug)]
pub(crate) struct Opening {
    /// Sockets of the existing sessions.
    pub(crate) others: Vec<PathBuf>,
    _lock: File,
}

impl Rendezvous {
    /// Adds this session, and removes files of sessions that were killed.
    pub(crate) fn enter(directory: &Path) -> io::Result<(Self, Opening)> {
        DirBuilder::new().recursive(true).mode(0o700).create(directory)?;
        let of = std::fs::metadata(directory)?;
        if of.uid() != rustix::process::getuid().as_raw() || of.mode() & 0o022 != 0 {
            return Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "others may write there; it must be this user's alone",
            ));
        }
        let lock = File::open(directory)?;
        lock.lock()?;
        let mut others = Vec::new();
        for entry in std::fs::read_dir(directory)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "sock") {
                if is_alive(&path) {
                    others.push(path);
                } else {
                    remove(&path);
                }
            }
        }
        others.sort();
        let number = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let socket = directory.join(format!("{}-{number}.sock", std::process::id()));
        if socket.as_os_str().len() + ".lock".len() > LONGEST {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the path is too long for a socket; name a shorter one",
            ));
        }
        Ok((Self { socket }, Opening { others, _lock: lock }))
    }

    /// The socket on which this session listens.
    pub(crate) fn socket(&self) -> &Path {
        &self.socket
    }
}

impl Drop for Rendezvous {
    fn drop(&mut self) {
        remove(&self.socket);
    }
}

/// The socket as a zenoh endpoint.
pub(crate) fn endpoint(socket: &Path) -> String {
    format!("unixsock-stream/{}", socket.display())
}

/// The same, to connect to. What fails at first, such as with a session that notices only now that
/// another one was killed, is tried again soon: zenoh would wait for one second, then for two.
pub(crate) fn endpoint_of_other(socket: &Path) -> String {
    format!("{}#retry_period_init_ms=50;retry_period_max_ms=1000", endpoint(socket))
}

fn lock_of(socket: &Path) -> PathBuf {
    let mut path = socket.as_os_str().to_owned();
    path.push(".lock");
    path.into()
}

/// Whether a session listens there: zenoh holds a lock on a file beside the socket while it does.
fn is_alive(socket: &Path) -> bool {
    let Ok(lock) = File::open(lock_of(socket)) else { return false };
    matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

fn remove(socket: &Path) {
    // It may not exist.
    let _ = std::fs::remove_file(socket);
    let _ = std::fs::remove_file(lock_of(socket));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_session_left_is_removed_and_a_living_one_is_found() {
        let directory = tempfile::tempdir().unwrap();
        let stale = directory.path().join("1-0.sock");
        let alive = directory.path().join("2-0.sock");
        for socket in [&stale, &alive] {
            File::create(socket).unwrap();
            File::create(lock_of(socket)).unwrap();
        }
        let held = File::open(lock_of(&alive)).unwrap();
        held.lock().unwrap();
        let (own, opening) = Rendezvous::enter(directory.path()).unwrap();
        assert_eq!(opening.others, [alive]);
        assert!(!stale.exists() && !lock_of(&stale).exists());
        File::create(own.socket()).unwrap();
        let path = own.socket().to_owned();
        drop(own);
        assert!(!path.exists());
    }

    #[test]
    fn a_folder_others_may_write_to_is_refused() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let open = std::fs::Permissions::from_mode(0o777);
        std::fs::set_permissions(directory.path(), open).unwrap();
        let error = Rendezvous::enter(directory.path()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
    }
}
