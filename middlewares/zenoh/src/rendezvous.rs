//! How daemons of one machine find each other: Unix sockets in one folder of the user's.
//!
//! Each session listens on a socket of its own there, and connects to all it finds when it opens.
//! Opening is serialised by a lock on the folder, so of two sessions the later one sees the
//! earlier. Nobody is special: any session may end, and the others stay connected.

use std::fs::{DirBuilder, File, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest path of a Unix socket on Linux, without the final NUL.
const LONGEST: usize = 107;

/// Sessions opened by this process so far.
static SESSIONS: AtomicU64 = AtomicU64::new(0);

/// The folder daemons meet in unless told otherwise: `/run/user/<uid>/genomd/zenoh`, or
/// `/tmp/genomd-<uid>/zenoh` where there is no such thing as `/run/user`.
#[must_use]
pub fn default_directory() -> PathBuf {
    let uid = rustix::process::getuid().as_raw();
    let run = PathBuf::from(format!("/run/user/{uid}"));
    let base =
        if run.is_dir() { run.join("genomd") } else { PathBuf::from(format!("/tmp/genomd-{uid}")) };
    base.join("zenoh")
}

/// A session's place in the folder; its files go when it is dropped.
#[derive(Debug)]
pub(crate) struct Rendezvous {
    socket: PathBuf,
}

/// Keeps other sessions from opening until it is dropped.
#[derive(Debug)]
pub(crate) struct Opening {
    /// Sockets of the sessions that are there.
    pub(crate) others: Vec<PathBuf>,
    _lock: File,
}

impl Rendezvous {
    /// Takes a place, and removes what sessions left that were killed.
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

    /// Where this session listens.
    pub(crate) fn socket(&self) -> &Path {
        &self.socket
    }
}

impl Drop for Rendezvous {
    fn drop(&mut self) {
        remove(&self.socket);
    }
}

/// zenoh's name of a socket.
pub(crate) fn endpoint(socket: &Path) -> String {
    format!("unixsock-stream/{}", socket.display())
}

fn lock_of(socket: &Path) -> PathBuf {
    let mut path = socket.as_os_str().to_owned();
    path.push(".lock");
    path.into()
}

/// Whether a session listens there: zenoh holds a lock beside the socket as long as it does.
fn is_alive(socket: &Path) -> bool {
    let Ok(lock) = File::open(lock_of(socket)) else { return false };
    matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

fn remove(socket: &Path) {
    // What is not there need not be removed.
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
