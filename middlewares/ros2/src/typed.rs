//! Messages whose types ros2-client or this crate defines with serde, as CDR.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::dds::rustdds::cdr_encoding;
use crate::rmw::HEADER;

/// Encodes a CDR payload, little endian, without header.
pub(crate) fn encode(value: &impl Serialize) -> Option<Vec<u8>> {
    cdr_encoding::to_vec::<_, byteorder::LittleEndian>(value).ok()
}

/// Decodes a message: header and payload. `None` if it is cut, or is no such message.
pub(crate) fn decode<T: DeserializeOwned>(message: &[u8]) -> Option<T> {
    let (header, payload) = message.split_at_checked(HEADER)?;
    let value = match header.get(1) {
        Some(&1) => cdr_encoding::from_bytes::<T, byteorder::LittleEndian>(payload),
        _ => cdr_encoding::from_bytes::<T, byteorder::BigEndian>(payload),
    };
    value.ok().map(|(value, _)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_larger_than_any_memory_is_refused() {
        assert!(decode::<Vec<u64>>(&[0, 1, 0, 0, 255, 255, 255, 255]).is_none());
        assert!(decode::<Vec<u64>>(&[0, 0, 0, 0, 255, 255, 255, 255]).is_none());
        assert!(decode::<Vec<u64>>(&[0, 1]).is_none());
    }

    #[test]
    fn an_empty_text_without_its_nul_is_empty() {
        assert_eq!(decode::<String>(&[0, 1, 0, 0, 0, 0, 0, 0]).as_deref(), Some(""));
    }
}
