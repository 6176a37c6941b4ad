//! A DATA_FRAG submessage of ours (RTPS 2.5, 9.4.5.5): a part of a large sample.

use super::super::limits;
use super::super::message::{self, Entity, Fields, HEADER, Head, is_builtin, kind};

/// Where the number of fragments is in the body of the submessage.
const COUNT: usize = 24;

/// Bytes of the head of a submessage.
const HEAD: usize = 4;

/// The DATA_FRAG that a message ends with; RustDDS sends no other ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    pub(crate) reader: Entity,
    pub(crate) writer: Entity,
    /// Sequence number of the sample.
    pub(crate) number: i64,
    /// Number of its first fragment, from 1, and how many it has.
    pub(crate) first: u32,
    pub(crate) count: u16,
    /// Whether the sample ends with it.
    pub(crate) last: bool,
    /// Where the submessage begins in the message, and where its fragments do.
    start: usize,
    pub(crate) payload: usize,
}

impl Cut {
    /// `None` if the message does not end with one of a port or service.
    pub(crate) fn read(message: &[u8]) -> Option<Self> {
        let mut at = HEADER;
        while let Some(head) = Head::read(message, at).ok()? {
            at = head.body.end;
            if head.kind == kind::DATA_FRAG {
                return (at == message.len()).then(|| Self::of(message, &head)).flatten();
            }
        }
        None
    }

    /// `None` if this submessage of the message, a DATA_FRAG, is not one of a port or service.
    pub(crate) fn of(message: &[u8], head: &Head) -> Option<Self> {
        const INLINE: u8 = 2;
        let mut fields = Fields::new(message.get(head.body.clone())?, head.little());
        fields.skip(2).ok()?;
        let skipped = usize::from(fields.u16().ok()?).checked_sub(28)?;
        let (reader, writer) = (fields.bytes().ok()?, fields.bytes().ok()?);
        let number = fields.number().ok()?;
        let (first, count) = (fields.u32().ok()?, fields.u16().ok()?);
        let (size, whole) = (u32::from(fields.u16().ok()?), fields.u32().ok()?);
        fields.skip(skipped).ok()?;
        if head.flags & INLINE != 0 {
            message::parameters(&mut fields, limits::PARAMETERS, |_, _, _| Ok(())).ok()?;
        }
        let end = first.checked_add(u32::from(count))?;
        let sound = size > 0 && first > 0 && count > 0 && !is_builtin(writer);
        sound.then(|| Self {
            reader,
            writer,
            number,
            first,
            count,
            last: end > whole.div_ceil(size),
            start: head.start,
            payload: head.body.start + fields.at(),
        })
    }

    /// The number after its last fragment.
    pub(crate) fn end(&self) -> u32 {
        self.first.saturating_add(u32::from(self.count))
    }

    /// Gives the submessage of a message that begins with this one's the length that it has there,
    /// and as many fragments as there are up to `end`.
    pub(crate) fn extend(&self, message: &mut [u8], end: u32) {
        let body = self.start + HEAD;
        let Some(&[_, flags]) = message.get(self.start..).and_then(<[u8]>::first_chunk) else {
            return;
        };
        let number = |of: usize| {
            let of = u16::try_from(of).unwrap_or(u16::MAX);
            if flags & 1 == 1 { of.to_le_bytes() } else { of.to_be_bytes() }
        };
        let length = number(message.len().saturating_sub(body));
        let count = number(end.saturating_sub(self.first) as usize);
        for (at, bytes) in [(self.start + 2, length), (body + COUNT, count)] {
            if let Some(place) = message.get_mut(at..at + 2) {
                place.copy_from_slice(&bytes);
            }
        }
    }
}
