//! Bytes on the wire of YARP: how connections begin, and how messages are framed.

/// Number in the first eight bytes of a connection, to which the kind of the carrier is added.
const CARRIERS: i32 = 7777;
/// Kind of the carrier tcp, and what is added if each message is acknowledged.
const TCP: i32 = 3;
const ACKNOWLEDGED: i32 = 128;

/// Number in the header of a message: the bytes that follow it.
const INDEX: i32 = 10;

/// How a connection carries messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Carrier {
    /// `tcp`: a message is sent when the one before was acknowledged.
    Tcp,
    /// `fast_tcp`: without acknowledgements.
    FastTcp,
    /// `text`: lines, as people type them.
    Text,
    /// `text_ack`: the same, with acknowledgements.
    TextAck,
}

impl Carrier {
    /// Carriers that this side connects with.
    pub(crate) const OFFERED: [Self; 2] = [Self::Tcp, Self::FastTcp];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Tcp => "tcp",
            Self::FastTcp => "fast_tcp",
            Self::Text => "text",
            Self::TextAck => "text_ack",
        }
    }

    /// A carrier that this side connects with.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::OFFERED.into_iter().find(|carrier| carrier.name() == name)
    }

    pub(crate) fn is_text(self) -> bool {
        matches!(self, Self::Text | Self::TextAck)
    }

    /// Whether the receiver answers each message.
    pub(crate) fn acknowledges(self) -> bool {
        matches!(self, Self::Tcp | Self::TextAck)
    }

    /// The carrier that a connection begins with.
    pub(crate) fn begun(head: [u8; 8]) -> Option<Self> {
        match &head {
            b"CONNECT " => return Some(Self::Text),
            b"CONNACK " => return Some(Self::TextAck),
            _ => {}
        }
        let number = framed(head)?;
        Self::OFFERED.into_iter().find(|carrier| carrier.number() == Some(number))
    }

    fn number(self) -> Option<i32> {
        match self {
            Self::Tcp => Some(CARRIERS + TCP + ACKNOWLEDGED),
            Self::FastTcp => Some(CARRIERS + TCP),
            Self::Text | Self::TextAck => None,
        }
    }
}

/// Eight bytes with a number.
pub(crate) fn frame(number: i32) -> [u8; 8] {
    let [a, b, c, d] = number.to_le_bytes();
    [b'Y', b'A', a, b, c, d, b'R', b'P']
}

/// The number in eight bytes.
pub(crate) fn framed(bytes: [u8; 8]) -> Option<i32> {
    match bytes {
        [b'Y', b'A', a, b, c, d, b'R', b'P'] => Some(i32::from_le_bytes([a, b, c, d])),
        _ => None,
    }
}

/// The answer to a message.
pub(crate) const ACK: [u8; 8] = [b'Y', b'A', 0, 0, 0, 0, b'R', b'P'];

/// Whether these bytes begin the header of a message.
pub(crate) fn is_message(head: [u8; 8]) -> bool {
    framed(head) == Some(INDEX)
}

/// What one who dials says first.
pub(crate) fn greeting(carrier: Carrier, name: &str) -> Vec<u8> {
    match carrier.number() {
        Some(number) => {
            let length = name.len() as u32 + 1;
            [&frame(number)[..], &length.to_le_bytes(), name.as_bytes(), &[0]].concat()
        }
        None if carrier == Carrier::Text => format!("CONNECT {name}\r\n").into_bytes(),
        None => format!("CONNACK {name}\r\n").into_bytes(),
    }
}

/// What a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A bottle; whether its sender waits for another.
    Data {
        /// Whether it does.
        reply: bool,
    },
    /// A bottle for the port itself.
    Administration,
}

/// Room for the header of a message whose body is appended; [`close`] fills it in.
pub(crate) const HEADER: usize = 8 + 10 + 4 * 3 + 8;

/// Begins a message in an empty buffer.
pub(crate) fn begin(purpose: Purpose, out: &mut Vec<u8>) {
    out.clear();
    out.extend_from_slice(&frame(INDEX));
    // Two blocks, and room for a reply, whose lengths follow.
    out.extend_from_slice(&[2, 1]);
    out.extend_from_slice(&[0xff; 8]);
    out.extend_from_slice(&8u32.to_le_bytes());
    out.extend_from_slice(&[0; 8]);
    let letter = match purpose {
        Purpose::Data { reply: true } => b'd',
        Purpose::Data { reply: false } => b'D',
        Purpose::Administration => b'a',
    };
    out.extend_from_slice(&[0, 0, 0, 0, b'~', letter, 0, 1]);
}

/// Ends a message whose body was appended.
pub(crate) fn close(out: &mut [u8]) {
    let body = out.len().saturating_sub(HEADER) as u32;
    if let Some(room) = out.get_mut(22..26) {
        room.copy_from_slice(&body.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_begin_as_genuine_ones_do() {
        assert_eq!(greeting(Carrier::Tcp, "/w"), b"YA\xe4\x1e\0\0RP\x03\0\0\0/w\0");
        assert_eq!(greeting(Carrier::FastTcp, "/w"), b"YA\x64\x1e\0\0RP\x03\0\0\0/w\0");
        for carrier in [Carrier::Tcp, Carrier::FastTcp, Carrier::Text, Carrier::TextAck] {
            let head = greeting(carrier, "/w")[..8].try_into().unwrap();
            assert_eq!(Carrier::begun(head), Some(carrier));
        }
        // udp, and no number at all.
        assert_eq!(Carrier::begun(*b"YA\xe1\x1e\0\0RP"), None);
        assert_eq!(Carrier::begun(*b"GET / HT"), None);
    }

    #[test]
    fn a_message_is_framed_as_a_genuine_one() {
        let mut out = Vec::new();
        begin(Purpose::Data { reply: false }, &mut out);
        out.extend_from_slice(b"body.");
        close(&mut out);
        let expected = b"YA\n\0\0\0RP\x02\x01\xff\xff\xff\xff\xff\xff\xff\xff\x08\0\0\0\x05\0\0\0\0\0\0\0\0\0\0\0~D\0\x01body.";
        assert_eq!(out, expected);
    }
}
