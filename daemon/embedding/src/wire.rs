//! What goes over the socket: one message for each request and each reply, numbers in the order of the
//! machine. A program asks its daemon so, and that daemon its cells.
//!
//! A request is `u32` number, `u32` verb, and what the verb takes; of a reply it is the same number,
//! `u32` status, and what the verb returns, or the refusal as JSON as on the control plane. Requests
//! are answered one after the other.
//!
//! | verb | takes | returns |
//! |---|---|---|
//! | 0, hello | | `u64` time of the clock in ns, version of genomd |
//! | 1, step | `u64` ns | `u64` time of the clock in ns, `u32` how many open ports are not there |
//! | 2, open | address of a port | `u32` number of the port, `u32` 1 for an in port, `u64` size of its type in bytes, digest of its type; with it, its memory |
//! | 3, close | `u32` number of a port | |
//! | 4, publish | | |
//! | 5, take | `u64` count of the value that was published last, `u32` 1 for an in port, digest of its type, a space, address of a port; with it, the memory that it had in another process | as open, without memory |
//! | 6, slate | | with it, the file of a [`Slate`](genom_lockstep::Slate) |
//! | 7, tell | `u32` number of a request on the slate | as a step; 0 for what returns nothing |
//!
//! Steps and `publish` may be asked on the slate as well, one at a time; a step has its `ns` as argument
//! and its results there, `publish` has none. What is on the slate is done before the next message is
//! answered, so that `tell`, too, returns what was refused, or not done yet.
//!
//! A step publishes first; a daemon has its cells publish before it steps any of them, so that time
//! stays everywhere if a value is refused.

use genom_lockstep::{DONE, SLATE, TELL};

/// The longest request, in bytes.
pub(crate) const LONGEST: usize = 4096;

/// The other status of replies.
pub(crate) const REFUSED: u32 = 1;

/// Verbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Verb {
    Step = 1,
    Open = 2,
    Close = 3,
    Publish = 4,
    Take = 5,
}

/// What is asked.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Request<'a> {
    /// Answered once the daemon is ready.
    Hello,
    /// Advance the clock by so many nanoseconds.
    Step(u64),
    /// Share the memory of the port at this address.
    Open(&'a str),
    /// Forget the port of this number.
    Close(u32),
    /// Publish what was written to in ports.
    Publish,
    /// Go on with the memory of a port.
    Take(Taken<'a>),
    /// Share memory for requests.
    Slate,
    /// Tell what the request of this number on the slate returns.
    Tell(u32),
}

/// A port that had its memory in another process.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Taken<'a> {
    /// The count of the value that was published last.
    pub(crate) published: u64,
    pub(crate) is_in: bool,
    /// Of its type.
    pub(crate) digest: &'a str,
    pub(crate) address: &'a str,
}

impl Taken<'_> {
    /// What [`Verb::Take`] takes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let head = [&self.published.to_ne_bytes()[..], &u32::from(self.is_in).to_ne_bytes()];
        [head.concat(), format!("{} {}", self.digest, self.address).into_bytes()].concat()
    }
}

/// What is told of a port that was opened.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Opened<'a> {
    pub(crate) number: u32,
    pub(crate) is_in: bool,
    pub(crate) size: u64,
    /// Of its type.
    pub(crate) digest: &'a str,
}

impl<'a> Opened<'a> {
    /// What [`Verb::Open`] and [`Verb::Take`] return.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let head = [self.number.to_ne_bytes(), u32::from(self.is_in).to_ne_bytes()].concat();
        [&head, &self.size.to_ne_bytes()[..], self.digest.as_bytes()].concat()
    }

    /// The same, read.
    pub(crate) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (number, rest) = word(bytes)?;
        let (is_in, rest) = word(rest)?;
        let (size, digest) = rest.split_first_chunk()?;
        let digest = std::str::from_utf8(digest).ok()?;
        Some(Self { number, is_in: is_in == 1, size: u64::from_ne_bytes(*size), digest })
    }
}

/// The number of a request, as far as it has one, and what it asks.
pub(crate) fn parse(message: &[u8]) -> (u32, Result<Request<'_>, &'static str>) {
    let Some((number, rest)) = word(message) else {
        return (0, Err("it has no number"));
    };
    let Some((verb, rest)) = word(rest) else {
        return (number, Err("it has no verb"));
    };
    if message.len() > LONGEST {
        return (number, Err("it is longer than 4096 bytes"));
    }
    let asked = match (verb, rest) {
        (0, []) => Ok(Request::Hello),
        (1, rest) => match rest.try_into() {
            Ok(bytes) => Ok(Request::Step(u64::from_ne_bytes(bytes))),
            Err(_) => Err("a step has 8 bytes"),
        },
        (2, rest) => std::str::from_utf8(rest).map(Request::Open).map_err(|_| "it is no text"),
        (3, rest) => match word(rest) {
            Some((port, [])) => Ok(Request::Close(port)),
            _ => Err("the number of a port has 4 bytes"),
        },
        (4, []) => Ok(Request::Publish),
        (5, rest) => take(rest).map(Request::Take).ok_or("a port to take is described otherwise"),
        (SLATE, []) => Ok(Request::Slate),
        (TELL, rest) => match word(rest) {
            Some((request, [])) => Ok(Request::Tell(request)),
            _ => Err("the number of a request has 4 bytes"),
        },
        _ => Err("there is no such verb, or it takes nothing"),
    };
    (number, asked)
}

fn take(rest: &[u8]) -> Option<Taken<'_>> {
    let (published, rest) = rest.split_first_chunk()?;
    let (is_in, rest) = word(rest)?;
    let (digest, address) = std::str::from_utf8(rest).ok()?.split_once(' ')?;
    Some(Taken { published: u64::from_ne_bytes(*published), is_in: is_in == 1, digest, address })
}

/// The first number, and what follows.
fn word(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (word, rest) = bytes.split_first_chunk()?;
    Some((u32::from_ne_bytes(*word), rest))
}

/// A reply that it is done, and what it returns.
pub(crate) fn done(number: u32, parts: &[&[u8]]) -> Vec<u8> {
    let heads = [number.to_ne_bytes(), DONE.to_ne_bytes()];
    [heads.concat(), parts.concat()].concat()
}

/// A reply that it was refused, and why.
pub(crate) fn refused(number: u32, why: &[u8]) -> Vec<u8> {
    let heads = [number.to_ne_bytes(), REFUSED.to_ne_bytes()];
    [&heads.concat(), why].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(parts: &[&[u8]]) -> Vec<u8> {
        parts.concat()
    }

    #[test]
    fn requests_are_read_as_they_are_written() {
        let n = 7_u32.to_ne_bytes();
        let verb = |verb: u32| verb.to_ne_bytes();
        let step = message(&[&n, &verb(1), &5_u64.to_ne_bytes()]);
        assert_eq!(parse(&step), (7, Ok(Request::Step(5))));
        let open = message(&[&n, &verb(2), b"demo/position"]);
        assert_eq!(parse(&open), (7, Ok(Request::Open("demo/position"))));
        assert_eq!(parse(&message(&[&n, &verb(0)])), (7, Ok(Request::Hello)));
        let close = message(&[&n, &verb(3), &verb(2)]);
        assert_eq!(parse(&close), (7, Ok(Request::Close(2))));
        assert_eq!(parse(&message(&[&n, &verb(4)])), (7, Ok(Request::Publish)));
        assert_eq!(parse(&message(&[&n, &verb(6)])), (7, Ok(Request::Slate)));
        assert_eq!(parse(&message(&[&n, &verb(7), &verb(5)])), (7, Ok(Request::Tell(5))));
        let taken = Taken { published: 9, is_in: true, digest: "ab", address: "demo/gain" };
        let take = message(&[&n, &verb(5), &taken.bytes()]);
        assert_eq!(parse(&take), (7, Ok(Request::Take(taken))));
        let opened = Opened { number: 3, is_in: false, size: 16, digest: "ab" };
        assert_eq!(Opened::read(&opened.bytes()), Some(opened));
        assert_eq!(Opened::read(&[0; 15]), None);
    }

    #[test]
    fn whatever_else_is_sent_is_refused_under_its_number() {
        let n = 7_u32.to_ne_bytes();
        let verb = |verb: u32| verb.to_ne_bytes();
        for rest in [
            &b""[..],
            &verb(9),
            &message(&[&verb(1), b"1234567"]),
            &message(&[&verb(1), b"123456789"]),
            &message(&[&verb(0), b"x"]),
            &message(&[&verb(2), b"\xff"]),
            &message(&[&verb(3), b"123"]),
            &message(&[&verb(2), &[b'x'; LONGEST]]),
            &message(&[&verb(4), b"x"]),
            &message(&[&verb(5), &[0; 12]]),
            &message(&[&verb(6), b"x"]),
            &message(&[&verb(7), b"123"]),
            &message(&[&verb(5), &[0; 11], b" demo/gain"]),
            &message(&[&verb(5), &[0; 12], b"\xff demo/gain"]),
        ] {
            let whole = message(&[&n, rest]);
            let (number, asked) = parse(&whole);
            assert!(number == 7 && asked.is_err(), "{rest:?}: {asked:?}");
        }
        assert!(parse(b"123").1.is_err());
    }
}
