//! The attachment of each sample, request and reply, without which `rmw_zenoh_cpp` drops it.

use std::time::{SystemTime, UNIX_EPOCH};

use zenoh::bytes::ZBytes;

use crate::rmw::Gid;

/// Size in bytes: number, time, length of the gid, gid.
const SIZE: usize = 8 + 8 + 1 + 16;

/// Identifies a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Attachment {
    /// Sequence number among those of the writer or client, from 1.
    pub(crate) number: i64,
    /// Of the writer; of a reply, that of the client.
    pub(crate) gid: Gid,
}

impl Attachment {
    /// With the present as the time of the source.
    pub(crate) fn encode(&self) -> [u8; SIZE] {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let now = i64::try_from(since.as_nanos()).unwrap_or(i64::MAX);
        let mut out = [0; SIZE];
        let fields = self.number.to_le_bytes().into_iter().chain(now.to_le_bytes());
        let fields = fields.chain([16]).chain(self.gid);
        out.iter_mut().zip(fields).for_each(|(to, byte)| *to = byte);
        out
    }

    /// `None` if it has another form.
    pub(crate) fn decode(attachment: &ZBytes) -> Option<Self> {
        let bytes = Some(attachment).filter(|bytes| bytes.len() == SIZE)?.to_bytes();
        let (number, rest) = bytes.split_first_chunk::<8>()?;
        let (length, gid) = rest.get(8..)?.split_first()?;
        let gid = gid.first_chunk::<16>().filter(|_| *length == 16)?;
        Some(Self { number: i64::from_le_bytes(*number), gid: *gid })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attachment_has_33_bytes_and_comes_back_as_it_was() {
        let attachment = Attachment { number: 258, gid: [9; 16] };
        let bytes = attachment.encode();
        assert_eq!(bytes.len(), 33);
        assert_eq!(bytes[..8], [2, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[16..], [[16].as_slice(), &[9; 16]].concat());
        assert_eq!(Attachment::decode(&ZBytes::from(&bytes[..])), Some(attachment));
        for wrong in [&bytes[..32], &[0; 33], &[], &[0; 200]] {
            assert_eq!(Attachment::decode(&ZBytes::from(wrong)), None);
        }
    }
}
