//! A participant that sends whatever bytes a test wants (RTPS 2.5, 9.4).

#![allow(dead_code, reason = "not all tests say everything")]
#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "test code")]

/// Entities: built-in writers and readers of announcements, and a user's writer.
pub(crate) const PARTICIPANTS: [u8; 4] = [0, 1, 0, 0xc2];
pub(crate) const WRITERS: [u8; 4] = [0, 0, 3, 0xc2];
pub(crate) const READERS: [u8; 4] = [0, 0, 4, 0xc2];
pub(crate) const USER: [u8; 4] = [0, 0, 0x12, 0x03];
pub(crate) const ANYBODY: [u8; 4] = [0; 4];

/// UDP ports of a domain's first eight participants, for announcements and samples (9.6.1.1).
pub(crate) fn ports(domain: u16) -> impl Iterator<Item = u16> {
    (0..8).flat_map(move |number| [10, 11].map(|port| 7400 + 250 * domain + port + 2 * number))
}

/// UDP ports for announcements.
pub(crate) fn announcement_ports(domain: u16) -> impl Iterator<Item = u16> {
    ports(domain).step_by(2)
}

fn number(number: i64) -> [u8; 8] {
    let (high, low) = ((number >> 32) as i32, number as u32);
    [high.to_le_bytes(), low.to_le_bytes()].concat().try_into().unwrap()
}

pub(crate) fn submessage(kind: u8, flags: u8, body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).unwrap().to_le_bytes();
    [&[kind, flags | 1], &length[..], body].concat()
}

pub(crate) fn heartbeat(writer: [u8; 4], first: i64, last: i64, count: i32) -> Vec<u8> {
    let count = count.to_le_bytes();
    let body = [&ANYBODY[..], &writer, &number(first), &number(last), &count].concat();
    submessage(0x07, 0, &body)
}

pub(crate) fn gap(writer: [u8; 4], start: i64, end: i64) -> Vec<u8> {
    let body = [&ANYBODY[..], &writer, &number(start), &number(end), &[0; 4]].concat();
    submessage(0x08, 0, &body)
}

/// A DATA submessage; `payload` starts with its encapsulation header.
pub(crate) fn data(writer: [u8; 4], sequence: i64, payload: &[u8]) -> Vec<u8> {
    let body = [&[0, 0, 16, 0], &ANYBODY[..], &writer, &number(sequence), payload].concat();
    submessage(0x15, 4, &body)
}

/// A DATA_FRAG of a sample of `whole` bytes.
pub(crate) fn fragment(
    writer: [u8; 4],
    sequence: i64,
    (first, count, size): (u32, u16, u16),
    whole: u32,
    payload: &[u8],
) -> Vec<u8> {
    let sizes =
        [&first.to_le_bytes()[..], &count.to_le_bytes(), &size.to_le_bytes(), &whole.to_le_bytes()];
    let head = [&[0, 0, 28, 0], &ANYBODY[..], &writer, &number(sequence)].concat();
    submessage(0x16, 0, &[&head[..], &sizes.concat(), payload].concat())
}

/// A NACK_FRAG: requests fragments from a writer.
pub(crate) fn nack_fragments(writer: [u8; 4], sequence: i64, base: u32, count: i32) -> Vec<u8> {
    let set = [&base.to_le_bytes()[..], &1_u32.to_le_bytes(), &[0, 0, 0, 0x80]].concat();
    let body =
        [&[0, 0, 0x12, 0x04][..], &writer, &number(sequence), &set, &count.to_le_bytes()].concat();
    submessage(0x12, 0, &body)
}

/// An ACKNACK: requests the first eight samples of a participant's writer.
pub(crate) fn acknack(to: &[u8], writer: [u8; 4], count: i32) -> Vec<u8> {
    let reader = [writer[0], writer[1], writer[2], 0xc7];
    let set = [&number(1)[..], &8_u32.to_le_bytes(), &[0, 0, 0, 0xff]].concat();
    let body = [&reader[..], &writer, &set, &count.to_le_bytes()].concat();
    [submessage(0x0e, 0, to), submessage(0x06, 0, &body)].concat()
}

fn parameter(id: u16, value: &[u8]) -> Vec<u8> {
    let mut value = value.to_vec();
    value.resize(value.len().next_multiple_of(4), 0);
    [&id.to_le_bytes()[..], &(value.len() as u16).to_le_bytes(), &value].concat()
}

fn text(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32 + 1).to_le_bytes().to_vec();
    bytes.extend_from_slice(text.as_bytes());
    bytes.push(0);
    bytes
}

fn list(parameters: &[Vec<u8>]) -> Vec<u8> {
    [&[0, 3, 0, 0][..], &parameters.concat(), &[1, 0, 0, 0]].concat()
}

fn locator(port: u16) -> Vec<u8> {
    let address = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 127, 0, 0, 1];
    [&1_u32.to_le_bytes()[..], &u32::from(port).to_le_bytes(), &address].concat()
}

/// A participant with this GUID prefix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forger(pub(crate) [u8; 12]);

impl Forger {
    pub(crate) fn message(self, submessages: &[Vec<u8>]) -> Vec<u8> {
        [&b"RTPS\x02\x04\x01\x10"[..], &self.0, &submessages.concat()].concat()
    }

    fn guid(self, entity: [u8; 4]) -> Vec<u8> {
        [&self.0[..], &entity].concat()
    }

    /// Announces the participant, with a UDP port and a lease in seconds.
    pub(crate) fn announcement(self, sequence: i64, port: u16, lease: u32) -> Vec<u8> {
        let payload = list(&[
            parameter(0x15, &[2, 4]),
            parameter(0x16, &[1, 0x10]),
            parameter(0x50, &self.guid([0, 0, 1, 0xc1])),
            parameter(0x32, &locator(port)),
            parameter(0x31, &locator(port)),
            parameter(0x02, &[lease.to_le_bytes(), [0; 4]].concat()),
            parameter(0x58, &0x0c3f_u32.to_le_bytes()),
        ]);
        self.message(&[data(PARTICIPANTS, sequence, &payload)])
    }

    /// The announcement of a reliable writer or reader of a topic.
    pub(crate) fn end(self, entity: [u8; 4], topic: &str, ty: &str) -> Vec<u8> {
        list(&[
            parameter(0x15, &[2, 4]),
            parameter(0x16, &[1, 0x10]),
            parameter(0x5a, &self.guid(entity)),
            parameter(0x05, &text(topic)),
            parameter(0x07, &text(ty)),
            parameter(0x1a, &[&2_u32.to_le_bytes()[..], &[0; 8]].concat()),
        ])
    }

    /// Announces a writer as its first one.
    pub(crate) fn writer(self, topic: &str, ty: &str) -> Vec<u8> {
        let payload = self.end(USER, topic, ty);
        self.message(&[data(WRITERS, 1, &payload), heartbeat(WRITERS, 1, 1, 1)])
    }
}
