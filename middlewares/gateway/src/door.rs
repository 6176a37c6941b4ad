//! How a process gets a stream to another one: it makes both ends, and sends one of them in a
//! datagram to the other's door. So can a process in a sandbox that may make no socket that
//! connects.

use std::fs::{self, Permissions};
use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::{UnixDatagram, UnixStream};
use std::path::{Path, PathBuf};

use rustix::net::sockopt::{socket_domain, socket_peercred, socket_type};
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, SocketType, recvmsg, sendmsg,
};

use crate::channel::PATIENCE;

/// Opens a stream to who is behind the door of this path.
///
/// # Errors
/// Nobody is, or the system refuses.
pub fn knock(path: &Path) -> io::Result<UnixStream> {
    let (own, theirs) = UnixStream::pair()?;
    let way = UnixDatagram::unbound()?;
    way.connect(path)?;
    // A queue of such datagrams may be full.
    way.set_write_timeout(Some(PATIENCE))?;
    let sent = [theirs.as_fd()];
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut control = SendAncillaryBuffer::new(&mut room);
    if !control.push(SendAncillaryMessage::ScmRights(&sent)) {
        return Err(io::ErrorKind::OutOfMemory.into());
    }
    sendmsg(&way, &[IoSlice::new(&[0])], &mut control, SendFlags::NOSIGNAL)?;
    Ok(own)
}

/// Where streams come from; nobody can knock any more when it is dropped.
#[derive(Debug)]
pub struct Door {
    socket: UnixDatagram,
    path: PathBuf,
}

impl Drop for Door {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

impl AsFd for Door {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl Door {
    /// Opens one that only this user can knock at, in the place of another one that nobody is
    /// behind any more.
    ///
    /// # Errors
    /// An error of the system.
    pub fn open(path: &Path) -> io::Result<Self> {
        // Nobody finds it before it has its mode: it gets its name last.
        let aside = path.with_extension("new");
        for file in [path, aside.as_path()] {
            if let Err(error) = fs::remove_file(file)
                && error.kind() != io::ErrorKind::NotFound
            {
                return Err(error);
            }
        }
        let socket = UnixDatagram::bind(&aside)?;
        fs::set_permissions(&aside, Permissions::from_mode(0o600))?;
        fs::rename(&aside, path)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, path: path.to_owned() })
    }

    /// A handle that can be read when somebody has knocked.
    ///
    /// # Errors
    /// An error of the system.
    pub fn knocks(&self) -> io::Result<UnixDatagram> {
        self.socket.try_clone()
    }

    /// The stream of the next who knocked.
    ///
    /// # Errors
    /// `WouldBlock`: nobody did. Another one: somebody sent something else.
    pub fn next(&self) -> io::Result<UnixStream> {
        let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut control = RecvAncillaryBuffer::new(&mut room);
        let mut byte = [0];
        recvmsg(
            &self.socket,
            &mut [IoSliceMut::new(&mut byte)],
            &mut control,
            RecvFlags::CMSG_CLOEXEC,
        )?;
        let mut got = None;
        for message in control.drain() {
            if let RecvAncillaryMessage::ScmRights(mut all) = message {
                got = all.next();
            }
        }
        let stream = got.ok_or_else(|| wrong("somebody knocks, and sends no stream"))?;
        check(&stream)?;
        let stream = UnixStream::from(stream);
        stream.set_nonblocking(false)?;
        Ok(stream)
    }
}

fn wrong(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Whoever sent it may send any descriptor.
fn check(sent: &OwnedFd) -> io::Result<()> {
    let no_stream = |_| wrong("somebody knocks, and sends something else than a stream");
    let domain = socket_domain(sent).map_err(no_stream)?;
    let kind = socket_type(sent).map_err(no_stream)?;
    if (domain, kind) != (AddressFamily::UNIX, SocketType::STREAM) {
        return Err(wrong("somebody knocks, and sends a socket of another kind"));
    }
    // Of one that is not connected, there is no user.
    let other = || wrong("another user knocks");
    let peer = socket_peercred(sent).map_err(|_| other())?;
    if peer.uid == rustix::process::geteuid() { Ok(()) } else { Err(other()) }
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};

    use super::*;

    #[test]
    fn a_stream_leads_to_who_is_behind_the_door() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("door");
        assert_eq!(knock(&path).unwrap_err().kind(), io::ErrorKind::NotFound);
        let door = Door::open(&path).unwrap();
        assert_eq!(door.next().unwrap_err().kind(), io::ErrorKind::WouldBlock);
        let mut own = knock(&path).unwrap();
        let mut theirs = door.next().unwrap();
        own.write_all(b"ping").unwrap();
        let mut heard = [0; 4];
        theirs.read_exact(&mut heard).unwrap();
        assert_eq!(&heard, b"ping");
        // The end of one is seen by the other.
        drop(theirs);
        assert_eq!(own.read(&mut heard).unwrap(), 0);
        // Also of one that was never taken in.
        let mut own = knock(&path).unwrap();
        drop(door);
        assert_eq!(own.read(&mut heard).unwrap(), 0);
        assert!(!path.exists());
    }

    #[test]
    fn what_is_no_stream_is_refused_and_the_next_one_gets_in() {
        let place = tempfile::tempdir().unwrap();
        let door = Door::open(&place.path().join("door")).unwrap();
        let way = UnixDatagram::unbound().unwrap();
        way.connect(place.path().join("door")).unwrap();
        let file = fs::File::open("/dev/null").unwrap();
        let unconnected = rustix::net::socket(AddressFamily::UNIX, SocketType::STREAM, None);
        let unconnected = unconnected.unwrap();
        let (mut seen, hidden) = UnixStream::pair().unwrap();
        let sent = [
            vec![],
            vec![file.as_fd()],
            vec![way.as_fd()],
            vec![unconnected.as_fd()],
            [vec![file.as_fd()], vec![hidden.as_fd(); 19]].concat(),
        ];
        for all in &sent {
            let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(20))];
            let mut control = SendAncillaryBuffer::new(&mut room);
            control.push(SendAncillaryMessage::ScmRights(all));
            sendmsg(&way, &[IoSlice::new(&[7; 100])], &mut control, SendFlags::NOSIGNAL).unwrap();
            assert_eq!(door.next().unwrap_err().kind(), io::ErrorKind::InvalidData);
        }
        drop(sent);
        drop(hidden);
        // None of those that came with it is kept.
        assert_eq!(seen.read(&mut [0]).unwrap(), 0);
        let _own = knock(&place.path().join("door")).unwrap();
        door.next().unwrap();
    }
}
