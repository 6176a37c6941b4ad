//! Hostile bytes for a listener of zenoh: frames of a length (two bytes) and a message.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use super::dice::Dice;

/// How long a connection waits for an answer.
const ANSWER: Duration = Duration::from_millis(200);

fn frame(message: &[u8]) -> Vec<u8> {
    let length = u16::try_from(message.len()).unwrap_or(u16::MAX);
    [&length.to_le_bytes()[..], message].concat()
}

/// Opens a session: version 9, a peer with this identity, no options.
fn init(id: &[u8]) -> Vec<u8> {
    [&[0x01, 0x09, 0xf1][..], id].concat()
}

/// The cookie in the answer to it, which stands behind the identity of the other and two sizes.
fn cookie(answer: &[u8]) -> Option<Vec<u8>> {
    let (&header, rest) = answer.get(2..)?.split_first()?;
    let length = usize::from(rest.get(1)? >> 4) + 1;
    let sizes = if header & 0x40 == 0 { 0 } else { 3 };
    let rest = rest.get(2 + length + sizes..)?;
    let (&size, rest) = rest.split_first()?;
    rest.get(..usize::from(size & 0x7f)).map(<[u8]>::to_vec)
}

/// Makes a connection, and sends noise or parts of a session with changes in it. Returns how many
/// bytes it sent, and whether a session was open.
pub(super) fn strike(port: u16, dice: &mut Dice) -> (usize, bool) {
    // Nobody may be there: a gateway that is starting again.
    let Ok(mut stream) = TcpStream::connect(("127.0.0.1", port)) else { return (0, false) };
    let _ = stream.set_read_timeout(Some(ANSWER));
    let _ = stream.set_write_timeout(Some(ANSWER));
    let mut sent = 0;
    let mut send = |stream: &mut TcpStream, bytes: &[u8]| {
        sent += bytes.len();
        stream.write_all(bytes).is_ok()
    };
    let size = dice.below(2000);
    let noise = dice.bytes(size);
    let hello = init(&dice.bytes(16));
    let mut open = false;
    match dice.below(6) {
        0 => drop(send(&mut stream, &noise)),
        1 => drop(send(&mut stream, &frame(&noise))),
        2 => {
            let mut hello = frame(&hello);
            dice.spoil(&mut hello, 2);
            send(&mut stream, &hello);
        }
        _ => {
            send(&mut stream, &frame(&hello));
            let mut answer = [0; 4096];
            let read = stream.read(&mut answer).unwrap_or(0);
            let cookie = cookie(&answer[..read]).unwrap_or_default();
            let size = u8::try_from(cookie.len()).unwrap_or(0) & 0x7f;
            // A lease of 10 s, the first number 0.
            let mut begin = [&[0x42, 10, 0, size][..], &cookie].concat();
            if dice.below(4) == 0 {
                dice.spoil(&mut begin, 1);
            }
            send(&mut stream, &frame(&begin));
            open = stream.read(&mut answer).is_ok_and(|read| read > 2 && answer[2] & 0x1f == 2);
            for number in 0..=u8::try_from(dice.below(20)).unwrap_or(0) {
                // A frame of messages: samples, requests, answers, declarations.
                let kind = [0x1d, 0x1c, 0x1b, 0x1a, 0x1e, 0x19][dice.below(6)];
                let flags = u8::try_from(dice.below(8)).unwrap_or(0) << 5;
                let size = dice.below(300);
                let mut message = [0x25, number, kind | flags, 0, 3].to_vec();
                message.extend(b"a/b");
                message.extend(dice.bytes(size));
                dice.spoil(&mut message, 3);
                if !send(&mut stream, &frame(&message)) {
                    break;
                }
            }
        }
    }
    (sent, open)
}
