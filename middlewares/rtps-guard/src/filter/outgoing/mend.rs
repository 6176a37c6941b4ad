//! Mends what RustDDS 0.15.1 sends wrongly: fragments of a reply.
//!
//! A sample that is longer than a fragment goes out as DATA_FRAG submessages (RTPS 2.5, 9.4.5.5).
//! Those of a reply have, as inline QoS, the request that they answer. Before these parameters
//! RustDDS writes one byte that does not belong there, the mark of a Rust `Option`, and does not
//! count it in the length of the submessage: no reader understands the reply. Where the byte is not
//! there, nothing is changed.

use super::super::message::{HEADER, kind};

/// Bytes of a submessage header, and of DATA_FRAG before its inline QoS.
const HEAD: usize = 4;
const FIXED: usize = 32;

/// RustDDS's number (RTPS 2.5, 9.3.1.3, and its vendors).
const VENDOR: [u8; 2] = [0x01, 0x12];

/// The flag that says that there are parameters.
const INLINE_QOS: u8 = 2;

/// Parameters that RustDDS puts there: the identity of the request, by either number.
const IDENTITIES: [u16; 2] = [0x0083, 0x800f];

/// The message without such bytes; `None` if it has none.
pub(crate) fn mended(message: &[u8]) -> Option<Vec<u8>> {
    if message.get(..4)? != b"RTPS" || message.get(6..8)? != VENDOR {
        return None;
    }
    let mut surplus = Vec::new();
    let mut start = HEADER;
    while let Some(&[kind, flags, a, b]) = message.get(start..).and_then(|rest| rest.first_chunk())
    {
        let two = |bytes| {
            if flags & 1 == 1 { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) }
        };
        let (said, body) = (usize::from(two([a, b])), start + HEAD);
        let at = body + FIXED;
        let marked = kind == kind::DATA_FRAG && flags & INLINE_QOS != 0;
        let marked = marked
            && matches!(
                message.get(at..at + 3),
                Some(&[1, c, d]) if IDENTITIES.contains(&two([c, d]))
            );
        if marked {
            surplus.push(at);
        }
        if said == 0 {
            // Up to the end.
            break;
        }
        start = body + said + usize::from(marked);
    }
    let mut left = message.to_vec();
    for &at in surplus.iter().rev() {
        left.remove(at);
    }
    (!surplus.is_empty()).then_some(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message of RustDDS with these submessages: kind, flags, body, and bytes not counted.
    fn message(submessages: &[(u8, u8, &[u8], usize)]) -> Vec<u8> {
        let mut all = b"RTPS\x02\x05\x01\x12\0\0\0\0\0\0\0\0\0\0\0\0".to_vec();
        for (kind, flags, body, surplus) in submessages {
            let length = u16::try_from(body.len() - surplus).unwrap().to_le_bytes();
            all.extend([*kind, *flags, length[0], length[1]]);
            all.extend(*body);
        }
        all
    }

    /// A DATA_FRAG, with or without the byte before its parameters.
    fn fragment(marked: bool) -> Vec<u8> {
        let mut body = vec![0; FIXED];
        body.extend(marked.then_some(1));
        body.extend(0x0083_u16.to_le_bytes());
        body.extend([24, 0]);
        body.extend([7; 24]);
        body.extend([1, 0, 0, 0]);
        body.extend(b"payload");
        body
    }

    #[test]
    fn fragments_of_a_reply_lose_the_byte_that_does_not_belong_there() {
        let time: (u8, u8, &[u8], usize) = (kind::INFO_TS, 1, &[0; 8], 0);
        let (wrong, right) = (fragment(true), fragment(false));
        let sent =
            message(&[time, (kind::DATA_FRAG, 3, &wrong, 1), (kind::DATA_FRAG, 3, &wrong, 1)]);
        let meant =
            message(&[time, (kind::DATA_FRAG, 3, &right, 0), (kind::DATA_FRAG, 3, &right, 0)]);
        assert_eq!(mended(&sent), Some(meant.clone()));
        assert_eq!(mended(&meant), None);
    }

    #[test]
    fn whatever_else_is_sent_stays_as_it_is() {
        let wrong = fragment(true);
        assert_eq!(mended(&message(&[(kind::DATA, 3, &wrong, 1)])), None);
        assert_eq!(mended(&message(&[(kind::DATA_FRAG, 1, &wrong, 1)])), None);
        let mut other = message(&[(kind::DATA_FRAG, 3, &wrong, 1)]);
        other[7] = 0x0f;
        assert_eq!(mended(&other), None);
        let whole = message(&[(kind::DATA_FRAG, 3, &wrong, 1)]);
        for length in 0..whole.len() {
            // Never more than one byte less, and no panic.
            let _ = mended(&whole[..length]).map(|left| assert_eq!(left.len() + 1, length));
        }
        assert_eq!(mended(&[0xff; 100]), None);
    }
}
