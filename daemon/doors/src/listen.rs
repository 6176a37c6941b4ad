//! Listeners: sockets are created safely, and removed at the end.

use std::fmt;
use std::fs::{self, DirBuilder, File, Permissions};
use std::io;
use std::net::SocketAddr;
use std::os::fd::OwnedFd;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, fcntl_lock};
use rustix::io::Errno;
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};
use tokio_rustls::TlsAcceptor;

/// Applied to each descriptor opened here. A process that runs foreign code can protect descriptors
/// from that code with it, and may return another number. `Ok` does nothing.
pub type Keep = fn(OwnedFd) -> io::Result<OwnedFd>;

/// Why a socket could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// Another daemon listens on this socket.
    #[error(
        "a genomd already listens on {}: stop it with `genomctl kill`, or give this one \
         another --socket",
        .0.display()
    )]
    Live(PathBuf),
    /// There is a file of that name that is not a socket.
    #[error("{} exists and is no socket: give another --socket", .0.display())]
    NotSocket(PathBuf),
    /// Another user could replace the socket.
    #[error(
        "{} belongs to another user, or others may write there: give another --socket",
        .0.display()
    )]
    Foreign(PathBuf),
    /// An error of the system.
    #[error("cannot listen on {}: {source}", path.display())]
    Unix {
        /// Path of the socket.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// An error of the system.
    #[error("cannot listen on {address}: {source}")]
    Tcp {
        /// The address.
        address: SocketAddr,
        /// The error of the system.
        source: io::Error,
    },
}

/// Where peers connect.
#[derive(Debug)]
pub struct Listener {
    pub(crate) kind: Kind,
    keep: Keep,
}

pub(crate) enum Kind {
    Unix(UnixListener),
    Tcp(TcpListener, Option<TlsAcceptor>),
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(listener) => listener.fmt(f),
            Self::Tcp(listener, tls) => write!(f, "{listener:?}, TLS: {}", tls.is_some()),
        }
    }
}

/// The connection of a peer.
pub(crate) enum Stream {
    Unix(UnixStream),
    Tcp(TcpStream, SocketAddr, Option<TlsAcceptor>),
}

/// A Unix socket that only the owner of the process can open.
#[derive(Debug)]
pub struct Socket {
    listener: Listener,
    name: SocketName,
}

/// The socket's file, removed when this is dropped.
#[derive(Debug)]
pub struct SocketName {
    path: PathBuf,
    /// Locked as long as the process lives; distinguishes its socket from a stale one.
    _lock: File,
}

impl Listener {
    /// Listens on a TCP address, with TLS if there is an acceptor. Also returns the actual address,
    /// if the port is chosen by the system.
    ///
    /// # Errors
    /// An error of the system.
    pub async fn tcp(
        address: SocketAddr,
        tls: Option<TlsAcceptor>,
        keep: Keep,
    ) -> Result<(Self, SocketAddr), ListenError> {
        let failed = |source| ListenError::Tcp { address, source };
        let listener = TcpListener::bind(address).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let kept = listener.into_std().and_then(|listener| keep(listener.into()));
        let listener = kept.and_then(|kept| TcpListener::from_std(kept.into())).map_err(failed)?;
        Ok((Self { kind: Kind::Tcp(listener, tls), keep }, address))
    }

    /// Waits for the next peer.
    pub(crate) async fn accept(&self) -> io::Result<Stream> {
        match &self.kind {
            Kind::Unix(listener) => {
                let stream = (self.keep)(listener.accept().await?.0.into_std()?.into())?;
                Ok(Stream::Unix(UnixStream::from_std(stream.into())?))
            }
            Kind::Tcp(listener, tls) => {
                let (stream, peer) = listener.accept().await?;
                let stream = (self.keep)(stream.into_std()?.into())?;
                Ok(Stream::Tcp(TcpStream::from_std(stream.into())?, peer, tls.clone()))
            }
        }
    }
}

impl Socket {
    /// Opens the socket with mode 0600. Replaces the socket of a process that does not live any
    /// more.
    ///
    /// # Errors
    /// A running process listens on it, another kind of file has the name, other users could
    /// replace it, or an error of the system.
    pub fn open(path: &Path, keep: Keep) -> Result<Self, ListenError> {
        let failed = |source| ListenError::Unix { path: path.to_owned(), source };
        prepare_directory(path)?;
        let lock = take_lock(&lock_path(path), keep).map_err(failed)?;
        let Some(lock) = lock else { return Err(ListenError::Live(path.to_owned())) };
        if let Ok(found) = fs::symlink_metadata(path)
            && !std::os::unix::fs::FileTypeExt::is_socket(&found.file_type())
        {
            return Err(ListenError::NotSocket(path.to_owned()));
        }
        // Created under another name and renamed: the socket has its mode before anybody can
        // connect, and replaces a stale one atomically.
        let aside = with_suffix(path, &format!(".{}", std::process::id()));
        let listener = std::os::unix::net::UnixListener::bind(&aside).map_err(failed)?;
        fs::set_permissions(&aside, Permissions::from_mode(0o600))
            .and_then(|()| fs::rename(&aside, path))
            .map_err(|source| {
                let _ = fs::remove_file(&aside);
                failed(source)
            })?;
        let kept = listener.set_nonblocking(true).and_then(|()| keep(listener.into()));
        let listener = kept.and_then(|kept| UnixListener::from_std(kept.into())).map_err(failed)?;
        let listener = Listener { kind: Kind::Unix(listener), keep };
        Ok(Self { listener, name: SocketName { path: path.to_owned(), _lock: lock } })
    }

    /// Splits the listener from the file, which is removed earlier.
    #[must_use]
    pub fn split(self) -> (Listener, SocketName) {
        (self.listener, self.name)
    }
}

impl Drop for SocketName {
    fn drop(&mut self) {
        for path in [self.path.clone(), lock_path(&self.path)] {
            if let Err(why) = fs::remove_file(&path) {
                tracing::warn!("{} stays behind: {why}", path.display());
            }
        }
    }
}

/// Creates the socket's directory, with access for this user only.
fn prepare_directory(path: &Path) -> Result<(), ListenError> {
    let Some(directory) = path.parent().filter(|dir| !dir.as_os_str().is_empty()) else {
        return Ok(());
    };
    let failed = |source| ListenError::Unix { path: path.to_owned(), source };
    DirBuilder::new().recursive(true).mode(0o700).create(directory).map_err(failed)?;
    let found = fs::metadata(directory).map_err(failed)?;
    let ours = rustix::process::geteuid().as_raw();
    // Its owner can replace files in it, and so can others unless it is sticky, as /tmp is.
    let open = found.mode() & 0o002 != 0 && found.mode() & 0o1000 == 0;
    if open || found.uid() != ours && found.uid() != 0 {
        return Err(ListenError::Foreign(directory.to_owned()));
    }
    Ok(())
}

/// Takes the lock; `None` if a running process holds it.
///
/// The lock belongs to the process (`fcntl`), not to the open file, so that children forked by
/// codels do not keep it.
fn take_lock(path: &Path, keep: Keep) -> io::Result<Option<File>> {
    loop {
        let file =
            File::options().create(true).truncate(false).write(true).read(true).open(path)?;
        // Before locking: closing any descriptor of the file would release the lock.
        let file = File::from(keep(file.into())?);
        match fcntl_lock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(Errno::AGAIN | Errno::ACCESS) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        // A daemon that stops removes the file: check that the locked file still has its name.
        let still = fs::metadata(path).is_ok_and(|now| {
            file.metadata().is_ok_and(|held| (held.dev(), held.ino()) == (now.dev(), now.ino()))
        });
        if still {
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
        let socket = Socket::open(&path, Ok).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert_eq!(fs::metadata(path.parent().unwrap()).unwrap().mode() & 0o777, 0o700);
        drop(socket);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
    }

    #[tokio::test]
    async fn a_stale_socket_is_replaced() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("genomd.sock");
        // What a killed daemon leaves behind: a socket without listener, and a lock file without
        // lock.
        drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
        File::create(lock_path(&path)).unwrap();
        assert!(Socket::open(&path, Ok).is_ok());
    }

    #[tokio::test]
    async fn a_file_of_that_name_is_left_alone() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("precious");
        fs::write(&path, "text").unwrap();
        assert!(matches!(Socket::open(&path, Ok), Err(ListenError::NotSocket(_))));
        assert_eq!(fs::read_to_string(&path).unwrap(), "text");
    }
}
