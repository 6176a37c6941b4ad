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

use crate::slate::{Answer, Asked, Slate};

/// How long an end looks for a message before it sleeps: several times what it takes to wake it.
pub const AWAKE: Duration = Duration::from_micros(50);

/// How often a slate is looked at before others may have the processor: for about 1 us.
const GLANCES: u32 = 16;

/// What an end hears.
#[derive(Debug)]
pub enum Heard {
    /// A message of so many bytes, 0 if the other end is closed, and the file that came with it.
    Message(usize, Option<OwnedFd>),
    /// What was asked on the slate.
    Asked(Asked),
}

/// What became of a request on a slate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Replied {
    /// It was answered.
    Answer(Answer),
    /// It is there, and was not answered for [`AWAKE`]: the other end has to be sent a message.
    Late,
    /// It was not asked: the other end sleeps, or this one is to sleep until the answer comes.
    Unasked,
}

/// One end of a pair.
#[derive(Debug)]
pub struct End {
    socket: Arc<OwnedFd>,
    /// How long a message is looked for, at most: not at all on one processor, which the other end
    /// needs meanwhile.
    pub(crate) awake: Duration,
    /// Whether the next message is looked for before this thread sleeps.
    pub(crate) looks: bool,
    /// Since when an answer is waited for that did not come on the slate.
    late: Option<Instant>,
}

impl End {
    /// This end.
    #[must_use]
    pub fn new(socket: Arc<OwnedFd>) -> Self {
        let many = thread::available_parallelism().is_ok_and(|count| count.get() > 1);
        Self { socket, awake: if many { AWAKE } else { Duration::ZERO }, looks: false, late: None }
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
        let begin = self.late.take().unwrap_or_else(Instant::now);
        while self.looks && begin.elapsed() < self.awake {
            match message(&self.socket, room, RecvFlags::DONTWAIT) {
                Err(Errno::AGAIN) => thread::yield_now(),
                received => return received,
            }
        }
        self.sleep(room, begin)
    }

    /// Waits for a message, or for a request on the slate, which is heard only while this end is awake.
    ///
    /// # Errors
    /// The connection was reset.
    pub fn hear(&mut self, room: &mut [u8], slate: &Slate) -> Result<Heard, Errno> {
        let begin = Instant::now();
        slate.look(self.looks);
        while self.looks && begin.elapsed() < self.awake {
            if let Some(asked) = glance(|| slate.asked()) {
                return Ok(Heard::Asked(asked));
            }
            match message(&self.socket, room, RecvFlags::DONTWAIT) {
                Err(Errno::AGAIN) => thread::yield_now(),
                received => return received.map(|(count, file)| Heard::Message(count, file)),
            }
        }
        slate.look(false);
        self.sleep(room, begin).map(|(count, file)| Heard::Message(count, file))
    }

    /// Asks on a slate, and looks for the answer. After [`Replied::Late`] a message is to be sent that
    /// asks for it, and its answer is to be received.
    pub(crate) fn ask(&mut self, slate: &Slate, asked: Asked) -> Replied {
        if !self.looks || !slate.is_looked_at() {
            return Replied::Unasked;
        }
        let begin = Instant::now();
        slate.ask(asked);
        while begin.elapsed() < self.awake {
            if let Some(answer) = glance(|| slate.answer_to(asked.number)) {
                return Replied::Answer(answer);
            }
            thread::yield_now();
        }
        self.late = Some(begin);
        Replied::Late
    }

    /// Sleeps until a message comes. Whether the next one is looked for depends on how long it took
    /// since this moment.
    fn sleep(
        &mut self,
        room: &mut [u8],
        begin: Instant,
    ) -> Result<(usize, Option<OwnedFd>), Errno> {
        let received = message(&self.socket, room, RecvFlags::empty());
        self.looks = begin.elapsed() < self.awake;
        received
    }
}

/// Looks a few times.
fn glance<T>(mut look: impl FnMut() -> Option<T>) -> Option<T> {
    (0..GLANCES).find_map(|_| {
        let seen = look();
        if seen.is_none() {
            std::hint::spin_loop();
        }
        seen
    })
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

    const STEP: Asked = Asked { number: 3, verb: 1, argument: 1_000_000 };

    #[test]
    fn an_end_that_is_awake_hears_what_is_asked_on_the_slate() {
        let ((_ours, mut theirs), (slate, file)) = (pair(), Slate::new().unwrap());
        (theirs.looks, theirs.awake) = (true, Duration::MAX);
        let their_slate = Slate::of(file.into()).unwrap();
        let hearing = thread::spawn(move || {
            let heard = theirs.hear(&mut [0; 8], &their_slate).unwrap();
            assert!(matches!(heard, Heard::Asked(STEP)), "{heard:?}");
        });
        while !slate.is_looked_at() {
            thread::yield_now();
        }
        slate.ask(STEP);
        hearing.join().unwrap();
    }

    #[test]
    fn an_end_that_sleeps_says_so_and_is_woken_by_a_message() {
        let ((ours, mut theirs), (slate, _)) = (pair(), Slate::new().unwrap());
        slate.look(true);
        slate.ask(STEP);
        ours.send([b"tell", b""], None).unwrap();
        for looks in [false, true] {
            (theirs.looks, theirs.awake) = (looks, Duration::ZERO);
            if looks {
                ours.send([b"tell", b""], None).unwrap();
            }
            let heard = theirs.hear(&mut [0; 8], &slate).unwrap();
            assert!(matches!(heard, Heard::Message(4, None)), "{heard:?}");
            assert!(!slate.is_looked_at());
        }
        // What was asked is there still.
        assert_eq!(slate.asked(), Some(STEP));
    }

    #[test]
    fn nothing_is_asked_on_the_slate_of_an_end_that_sleeps() {
        let ((mut ours, _theirs), (slate, _)) = (pair(), Slate::new().unwrap());
        ours.awake = Duration::from_nanos(1);
        for (looks, looked_at) in [(false, false), (false, true), (true, false)] {
            ours.looks = looks;
            slate.look(looked_at);
            assert_eq!((ours.ask(&slate, STEP), slate.asked()), (Replied::Unasked, None));
        }
        (ours.looks, ours.awake) = (true, Duration::from_nanos(1));
        slate.look(true);
        assert_eq!((ours.ask(&slate, STEP), slate.asked()), (Replied::Late, Some(STEP)));
    }

    #[test]
    fn after_an_answer_that_was_late_the_next_one_is_slept_for() {
        let ((mut ours, theirs), (slate, _)) = (pair(), Slate::new().unwrap());
        (ours.looks, ours.awake) = (true, Duration::from_nanos(1));
        slate.look(true);
        assert_eq!(ours.ask(&slate, STEP), Replied::Late);
        theirs.send([b"told", b""], None).unwrap();
        assert_eq!(ours.receive(&mut [0; 8]).unwrap().0, 4);
        assert!(!ours.looks && ours.late.is_none());
    }
}
