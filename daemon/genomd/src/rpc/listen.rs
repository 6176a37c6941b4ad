//! Sockets of the control plane: made safely, served with limits, removed at the end.

use std::fs::{self, DirBuilder, File, Permissions};
use std::io;
use std::net::SocketAddr;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use genom_host::keep_from_children;
use rustix::fs::{FlockOperation, fcntl_lock};
use rustix::io::Errno;
use tokio::net::{TcpListener, UnixListener};

/// A socket could not be opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ListenError {
    /// Another daemon serves this socket.
    #[error(
        "a genomd already listens on {}: stop it with `genomctl kill`, or give this one \
         another --socket",
        .0.display()
    )]
    Live(PathBuf),
    /// Something else bears the name.
    #[error("{} exists and is no socket: give another --socket", .0.display())]
    NotSocket(PathBuf),
    /// Somebody else could replace the socket.
    #[error(
        "{} belongs to another user, or others may write there: give another --socket",
        .0.display()
    )]
    Foreign(PathBuf),
    /// The system refused.
    #[error("cannot listen on {}: {source}", path.display())]
    Unix { path: PathBuf, source: io::Error },
    /// The system refused.
    #[error("cannot listen on {address}: {source}")]
    Tcp { address: SocketAddr, source: io::Error },
}

/// The daemon's Unix socket.
#[derive(Debug)]
pub(crate) struct Socket {
    listener: UnixListener,
    file: SocketFile,
}

/// The socket's name in the file system; it goes when this is dropped.
#[derive(Debug)]
pub(crate) struct SocketFile {
    path: PathBuf,
    /// Held as long as the daemon lives: tells a live daemon's socket from a stale one.
    _lock: File,
}

impl Socket {
    /// Opens the socket with mode 0600. A dead daemon's socket is replaced.
    pub(crate) fn open(path: &Path) -> Result<Self, ListenError> {
        let failed = |source| ListenError::Unix { path: path.to_owned(), source };
        prepare_directory(path)?;
        let lock = take_lock(&lock_path(path)).map_err(failed)?;
        let Some(lock) = lock else { return Err(ListenError::Live(path.to_owned())) };
        if let Ok(found) = fs::symlink_metadata(path)
            && !std::os::unix::fs::FileTypeExt::is_socket(&found.file_type())
        {
            return Err(ListenError::NotSocket(path.to_owned()));
        }
        // Made aside and renamed: it has its mode before anybody can connect, and replaces a
        // stale one in one step.
        let aside = with_suffix(path, &format!(".{}", std::process::id()));
        let listener = UnixListener::bind(&aside).map_err(failed)?;
        fs::set_permissions(&aside, Permissions::from_mode(0o600))
            .and_then(|()| fs::rename(&aside, path))
            .map_err(|source| {
                let _ = fs::remove_file(&aside);
                failed(source)
            })?;
        keep_from_children(&listener);
        Ok(Self { listener, file: SocketFile { path: path.to_owned(), _lock: lock } })
    }

    /// The listener, and the name apart: the name goes first.
    pub(crate) fn split(self) -> (UnixListener, SocketFile) {
        (self.listener, self.file)
    }
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        for path in [self.path.clone(), lock_path(&self.path)] {
            if let Err(why) = fs::remove_file(&path) {
                tracing::warn!("{} stays behind: {why}", path.display());
            }
        }
    }
}

/// Opens a TCP listener; the address as it is, for a port that was left to the system.
pub(crate) async fn tcp(address: SocketAddr) -> Result<(TcpListener, SocketAddr), ListenError> {
    let failed = |source| ListenError::Tcp { address, source };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    Ok((listener, address))
}

/// Makes the socket's directory, for this user alone.
fn prepare_directory(path: &Path) -> Result<(), ListenError> {
    let Some(directory) = path.parent().filter(|dir| !dir.as_os_str().is_empty()) else {
        return Ok(());
    };
    let failed = |source| ListenError::Unix { path: path.to_owned(), source };
    DirBuilder::new().recursive(true).mode(0o700).create(directory).map_err(failed)?;
    let found = fs::metadata(directory).map_err(failed)?;
    let ours = rustix::process::geteuid().as_raw();
    // Its owner may replace what is in it, and so may others unless it is sticky, as /tmp is.
    let open = found.mode() & 0o002 != 0 && found.mode() & 0o1000 == 0;
    if open || found.uid() != ours && found.uid() != 0 {
        return Err(ListenError::Foreign(directory.to_owned()));
    }
    Ok(())
}

/// The lock, or `None` when a live daemon holds it.
///
/// It belongs to the process (`fcntl`), not to the open file: a child that a codel forked has no
/// part in it.
fn take_lock(path: &Path) -> io::Result<Option<File>> {
    loop {
        let file =
            File::options().create(true).truncate(false).write(true).read(true).open(path)?;
        match fcntl_lock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(Errno::AGAIN | Errno::ACCESS) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        // A daemon that stops removes the file: what we locked must still be there.
        let still = fs::metadata(path).is_ok_and(|now| {
            file.metadata().is_ok_and(|held| (held.dev(), held.ino()) == (now.dev(), now.ino()))
        });
        if still {
            keep_from_children(&file);
            return Ok(Some(file));
        }
    }
}

fn lock_path(path: &Path) -> PathBuf {
    with_suffix(path, ".lock")
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_socket_is_private_and_leaves_nothing() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("run/genomd.sock");
        let socket = Socket::open(&path).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert_eq!(fs::metadata(path.parent().unwrap()).unwrap().mode() & 0o777, 0o700);
        drop(socket);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
    }

    #[tokio::test]
    async fn a_stale_socket_is_replaced() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("genomd.sock");
        // What a killed daemon leaves: a socket nobody serves, and a lock nobody holds.
        drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
        File::create(lock_path(&path)).unwrap();
        assert!(Socket::open(&path).is_ok());
    }

    #[tokio::test]
    async fn a_file_of_that_name_is_left_alone() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("precious");
        fs::write(&path, "text").unwrap();
        assert!(matches!(Socket::open(&path), Err(ListenError::NotSocket(_))));
        assert_eq!(fs::read_to_string(&path).unwrap(), "text");
    }
}
