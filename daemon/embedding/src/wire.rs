//! What goes over the socket: one message for each request and each reply, numbers in the order of the
//! machine.
//!
//! A request is `u32` number, `u32` verb, and what the verb takes; of a reply it is the same number,
//! `u32` status, and what the verb returns, or the refusal as JSON as on the control plane. Requests
//! are answered one after the other.
//!
//! | verb | takes | returns |
//! |---|---|---|
//! | 0, hello | | `u64` time of the clock in ns, version of genomd |
//! | 1, step | `u64` ns | `u64` time of the clock in ns |
//! | 2, open | address of a port | `u32` number of the port, `u32` 1 for an in port, `u64` size of its type in bytes, digest of its type; with it, its memory |
//! | 3, close | `u32` number of a port | |

/// The longest request, in bytes.
pub(crate) const LONGEST: usize = 4096;

/// Statuses of replies.
const DONE: u32 = 0;
const REFUSED: u32 = 1;

/// What the program asks.
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
        _ => Err("there is no such verb, or it takes nothing"),
    };
    (number, asked)
}

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
        ] {
            let whole = message(&[&n, rest]);
            let (number, asked) = parse(&whole);
            assert!(number == 7 && asked.is_err(), "{rest:?}: {asked:?}");
        }
        assert!(parse(b"123").1.is_err());
    }
}
