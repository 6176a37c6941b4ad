//! Format of samples to be published to in ports, each `length: u32, in port, length: u32, CDR`,
//! little endian. The CDR has its encapsulation header.

use serde::{Deserialize, Serialize};

/// The samples that were published.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Replayed {
    /// Number of samples.
    pub published: u64,
}

/// Appends a sample to `batch`.
pub fn append(batch: &mut Vec<u8>, inport: &str, message: &[u8]) {
    for part in [inport.as_bytes(), message] {
        let length = u32::try_from(part.len()).unwrap_or(u32::MAX);
        batch.extend_from_slice(&length.to_le_bytes());
        batch.extend_from_slice(part);
    }
}

/// The first sample of `batch` (in port and CDR), and the rest; `None` if the sample is incomplete.
#[must_use]
pub fn first(batch: &[u8]) -> Option<(&str, &[u8], &[u8])> {
    let (inport, rest) = part(batch)?;
    let (message, rest) = part(rest)?;
    Some((std::str::from_utf8(inport).ok()?, message, rest))
}

fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_read_back_as_written_and_half_a_sample_is_none() {
        let mut batch = Vec::new();
        append(&mut batch, "demo/parameter", &[1, 2, 3]);
        append(&mut batch, "demo/gain", &[]);
        let (inport, message, rest) = first(&batch).unwrap();
        assert_eq!((inport, message), ("demo/parameter", &[1, 2, 3][..]));
        assert_eq!(first(rest), Some(("demo/gain", &[][..], &[][..])));
        for end in 0..batch.len() - rest.len() {
            assert_eq!(first(&batch[..end]), None, "{end}");
        }
    }
}
