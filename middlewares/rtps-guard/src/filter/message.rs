//! Strict parser of RTPS messages (RTPS 2.5, 9.4).

use std::ops::Range;

use super::tally::Reason;

/// First 12 bytes of a GUID: the participant.
pub(crate) type Prefix = [u8; 12];

/// Last 4 bytes of a GUID: the writer or reader.
pub(crate) type Entity = [u8; 4];

/// Sizes in bytes of a message header (9.4.4) and of a submessage header (9.4.5.1).
pub(crate) const HEADER: usize = 20;
const HEAD: usize = 4;

/// Kinds of submessages (9.4.5.1.1).
pub(crate) mod kind {
    pub(crate) const PAD: u8 = 0x01;
    pub(crate) const ACKNACK: u8 = 0x06;
    pub(crate) const HEARTBEAT: u8 = 0x07;
    pub(crate) const GAP: u8 = 0x08;
    pub(crate) const INFO_TS: u8 = 0x09;
    pub(crate) const INFO_SRC: u8 = 0x0c;
    pub(crate) const INFO_REPLY: u8 = 0x0f;
    pub(crate) const NACK_FRAG: u8 = 0x12;
    pub(crate) const HEARTBEAT_FRAG: u8 = 0x13;
    pub(crate) const DATA: u8 = 0x15;
    pub(crate) const DATA_FRAG: u8 = 0x16;
}

/// A submessage: its kind and flags, and the position of its body in the message.
#[derive(Clone, Debug)]
pub(crate) struct Head {
    pub(crate) kind: u8,
    pub(crate) flags: u8,
    pub(crate) start: usize,
    pub(crate) body: Range<usize>,
}

impl Head {
    /// The submessage that begins at `start`; `None` at the end of the message.
    pub(crate) fn read(message: &[u8], start: usize) -> Result<Option<Self>, Reason> {
        if start >= message.len() {
            return Ok(None);
        }
        let &[kind, flags, a, b] = array(message, start).ok_or(Reason::Malformed)?;
        let said =
            if flags & 1 == 1 { u16::from_le_bytes([a, b]) } else { u16::from_be_bytes([a, b]) };
        let begin = start + HEAD;
        // 9.4.5.1.3: length 0 means up to the end of the message, except for kinds that may be
        // empty.
        let end = match said {
            0 if kind != kind::PAD && kind != kind::INFO_TS => message.len(),
            said => begin + usize::from(said),
        };
        if end > message.len() {
            return Err(Reason::Malformed);
        }
        Ok(Some(Self { kind, flags, start, body: begin..end }))
    }

    /// Turns it into a PAD submessage, which has no effect (8.3.8.11).
    pub(crate) fn silence(&self, message: &mut [u8]) {
        // Write the real length: 0 would mean an empty body for PAD.
        let length = u16::try_from(self.body.len()).unwrap_or(u16::MAX).to_le_bytes();
        if let Some(head) = message.get_mut(self.start..self.start + HEAD) {
            head.copy_from_slice(&[kind::PAD, 1, length[0], length[1]]);
        }
    }

    pub(crate) fn little(&self) -> bool {
        self.flags & 1 == 1
    }
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<&[u8; N]> {
    bytes.get(at..)?.first_chunk()
}

/// Reads fields one after the other.
#[derive(Clone)]
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> Fields<'a> {
    pub(crate) fn new(bytes: &'a [u8], little: bool) -> Self {
        Self { bytes, at: 0, little }
    }

    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn skip(&mut self, bytes: usize) -> Result<(), Reason> {
        self.at = self.at.checked_add(bytes).ok_or(Reason::Malformed)?;
        if self.at > self.bytes.len() { Err(Reason::Malformed) } else { Ok(()) }
    }

    pub(crate) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Reason> {
        let bytes = *array(self.bytes, self.at).ok_or(Reason::Malformed)?;
        self.at += N;
        Ok(bytes)
    }

    pub(crate) fn slice(&mut self, length: usize) -> Result<&'a [u8], Reason> {
        let end = self.at.checked_add(length).ok_or(Reason::Malformed)?;
        let slice = self.bytes.get(self.at..end).ok_or(Reason::Malformed)?;
        self.at = end;
        Ok(slice)
    }

    pub(crate) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Reason> {
        let bytes = self.bytes()?;
        Ok(if self.little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Reason> {
        let bytes = self.bytes()?;
        Ok(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    /// 9.3.2: the high word comes first in both byte orders.
    pub(crate) fn number(&mut self) -> Result<i64, Reason> {
        let (high, low) = (self.u32()?, self.u32()?);
        Ok((i64::from(high.cast_signed()) << 32) | i64::from(low))
    }

    /// Reads the bitmap of a set of numbers (9.4.2.6, 9.4.2.8).
    pub(crate) fn bitmap(&mut self) -> Result<Bitmap, Reason> {
        let length = self.u32()?;
        if length > Bitmap::MOST {
            return Err(Reason::Malformed);
        }
        let mut words = [0; Bitmap::MOST as usize / 32];
        for (word, begin) in words.iter_mut().zip((0..length).step_by(32)) {
            // What is beyond the last number does not count.
            *word = self.u32()? & (u32::MAX << (32 - (length - begin).min(32)));
        }
        Ok(Bitmap { length, words })
    }
}

/// Which numbers are in a set, counted from its base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bitmap {
    length: u32,
    /// The first number is the highest bit of the first word.
    words: [u32; Bitmap::MOST as usize / 32],
}

impl Bitmap {
    /// Numbers that a set may cover.
    pub(crate) const MOST: u32 = 256;

    /// How many numbers are in the set.
    pub(crate) fn count(&self) -> u32 {
        self.words.iter().map(|word| word.count_ones()).sum()
    }

    /// The numbers, from 0.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = u32> {
        (0..self.length).filter(|number| {
            let word = self.words.get(*number as usize / 32).copied().unwrap_or(0);
            word & (1 << (31 - number % 32)) != 0
        })
    }
}

/// Writes a sequence number into a body.
pub(crate) fn put_number(body: &mut [u8], at: usize, little: bool, number: i64) {
    let [a, b, c, d, e, f, g, h] = number.to_be_bytes();
    let bytes = if little { [d, c, b, a, h, g, f, e] } else { [a, b, c, d, e, f, g, h] };
    if let Some(place) = body.get_mut(at..at + 8) {
        place.copy_from_slice(&bytes);
    }
}

/// Reads a parameter list (9.4.2.11), and calls `each` with each parameter and its value.
pub(crate) fn parameters<'a>(
    fields: &mut Fields<'a>,
    most: usize,
    mut each: impl FnMut(u16, usize, &'a [u8]) -> Result<(), Reason>,
) -> Result<(), Reason> {
    const SENTINEL: u16 = 1;
    for _ in 0..most {
        let (id, length) = (fields.u16()?, fields.u16()?);
        if id == SENTINEL {
            return Ok(());
        }
        let at = fields.at();
        each(id, at, fields.slice(usize::from(length))?)?;
    }
    Err(Reason::Announcement)
}

/// Whether an entity is a built-in one of DDS (9.3.1.2).
pub(crate) fn is_builtin(entity: Entity) -> bool {
    entity[3] & 0xc0 == 0xc0
}
