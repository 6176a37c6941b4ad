//! One end of a pair.

use std::io::{IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rustix::io::Errno;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};

/// How long an end looks for a message before it sleeps: several times what it takes to wake it.
pub const AWAKE: Duration = Duration::from_micros(50);

/// One end of a pair.
#[derive(Debug)]
pub struct End {
    socket: Arc<OwnedFd>,
    /// How long a message is looked for, at most: not at all on one processor, which the other end
    /// needs meanwhile.
    awake: Duration,
    /// Whether the next message is looked for before this thread sleeps.
    looks: bool,
}

impl End {
    /// This end.
    #[must_use]
    pub fn new(socket: Arc<OwnedFd>) -> Self {
        let many = thread::available_parallelism().is_ok_and(|count| count.get() > 1);
        Self { socket, awake: if many { AWAKE } else { Duration::ZERO }, looks: false }
    }

    /// Its socket.
    #[must_use]
    pub fn socket(&self) -> &Arc<OwnedFd> {
        &self.socket
    }

    /// Sends a message, in two parts, and a file with it.
    ///
    /// # Errors
    /// The other end is closed, or the message is larger than what a socket takes.
    pub fn send(&self, parts: [&[u8]; 2], file: Option<BorrowedFd<'_>>) -> Result<(), Errno> {
        let parts = parts.map(IoSlice::new);
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut ancillary = SendAncillaryBuffer::new(&mut space);
        let files = file.map(|file| [file]);
        if let Some(files) = &files {
            ancillary.push(SendAncillaryMessage::ScmRights(files));
        }
        loop {
            match sendmsg(&*self.socket, &parts, &mut ancillary, SendFlags::NOSIGNAL) {
                Err(Errno::INTR) => {}
                sent => return sent.map(drop),
            }
        }
    }

    /// Waits for a message; returns its length, 0 if the other end is closed, and the file that came
    /// with it. Of a longer message than this has room for, the rest is lost.
    ///
    /// # Errors
    /// The connection was reset.
    pub fn receive(&mut self, room: &mut [u8]) -> Result<(usize, Option<OwnedFd>), Errno> {
        let begin = Instant::now();
        while self.looks && begin.elapsed() < self.awake {
            match message(&self.socket, room, RecvFlags::DONTWAIT) {
                Err(Errno::AGAIN) => thread::yield_now(),
                received => return received,
            }
        }
        let received = message(&self.socket, room, RecvFlags::empty());
        self.looks = begin.elapsed() < self.awake;
        received
    }
}

fn message(
    socket: &OwnedFd,
    room: &mut [u8],
    flags: RecvFlags,
) -> Result<(usize, Option<OwnedFd>), Errno> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut ancillary = RecvAncillaryBuffer::new(&mut space);
    let count = loop {
        let mut parts = [IoSliceMut::new(room)];
        match recvmsg(socket, &mut parts, &mut ancillary, flags | RecvFlags::CMSG_CLOEXEC) {
            Err(Errno::INTR) => {}
            received => break received?.bytes,
        }
    };
    let file = ancillary.drain().find_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut files) => files.next(),
        _ => None,
    });
    Ok((count, file))
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{Read as _, Write as _};
    use std::os::fd::AsFd as _;

    use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};

    use super::*;

    fn pair() -> (End, End) {
        let flags = SocketFlags::CLOEXEC;
        let pair = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).unwrap();
        (End::new(Arc::new(pair.0)), End::new(Arc::new(pair.1)))
    }

    #[test]
    fn a_message_comes_whole_and_with_its_file_whether_the_end_sleeps_or_looks() {
        let ways = [(false, Duration::MAX), (true, Duration::MAX), (true, Duration::from_nanos(1))];
        for (looks, awake) in ways {
            let (ours, mut theirs) = pair();
            (theirs.looks, theirs.awake) = (looks, awake);
            let (mut reader, writer) = std::io::pipe().unwrap();
            let sender = thread::spawn(move || {
                ours.send([b"step", b" by 1 ms"], Some(writer.as_fd())).unwrap();
                ours.send([b"again", b""], None).unwrap();
            });
            let mut room = [0; 64];
            let (count, file) = theirs.receive(&mut room).unwrap();
            assert_eq!(&room[..count], b"step by 1 ms");
            File::from(file.unwrap()).write_all(b"file").unwrap();
            let (count, none) = theirs.receive(&mut room).unwrap();
            assert_eq!((&room[..count], none.is_none()), (&b"again"[..], true));
            sender.join().unwrap();
            // The other end is closed now.
            assert_eq!(theirs.receive(&mut room).unwrap().0, 0);
            let mut written = String::new();
            reader.read_to_string(&mut written).unwrap();
            assert_eq!(written, "file");
        }
    }

    /// Whether an end that has got a message looks for the next one.
    fn looks_on(awake: Duration, looks: bool) -> bool {
        let (ours, mut theirs) = pair();
        (theirs.looks, theirs.awake) = (looks, awake);
        ours.send([b"1", b""], None).unwrap();
        theirs.receive(&mut [0; 8]).unwrap();
        theirs.looks
    }

    #[test]
    fn an_end_looks_for_messages_only_while_they_come_soon() {
        assert!(looks_on(Duration::MAX, false) && looks_on(Duration::MAX, true));
        // Nothing comes so soon.
        assert!(!looks_on(Duration::ZERO, false) && !looks_on(Duration::ZERO, true));
    }
}
