//! Reads an MCAP file from its beginning without its index, as far as it is intact: the file of a
//! killed recorder has no index, and may end in the middle of a sample.

use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use mcap::records::{Record, op};
use mcap::{MAGIC, parse_record};

use super::error::ReadError;

/// Bytes before the content of a record: kind and length.
const HEAD: usize = 9;
/// Bytes before the records of a chunk, without the name of the compression: dates, sizes,
/// checksum.
const CHUNK_HEAD: usize = 40;

/// A part of a file.
#[derive(Debug)]
pub enum Part<'a> {
    /// An uncompressed chunk of records, up to the last intact one.
    Chunk {
        /// Offset of the chunk in the file.
        start: u64,
        /// The intact records, one after the other.
        records: &'a [u8],
    },
    /// Any other record.
    Record(Record<'a>),
}

/// How far a file can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Bytes up to the end of the last intact part.
    pub whole: u64,
    /// Size of the file.
    pub size: u64,
}

/// Passes each part of a file to `each`, in order, up to the end or the first damage.
///
/// # Errors
/// The file cannot be read, is not MCAP, or is compressed; or `each` failed.
pub fn walk<E: From<ReadError>>(
    path: &Path,
    mut each: impl FnMut(Part<'_>) -> Result<(), E>,
) -> Result<Extent, E> {
    let mut file = File::open(path).map_err(ReadError::from)?;
    let size = file.metadata().map_err(ReadError::from)?.len();
    begins_well(&mut file)?;
    let mut file = BufReader::new(file);
    let mut whole = MAGIC.len() as u64;
    let mut content = Vec::new();
    while let Some((kind, length)) = head(&mut file)? {
        // Kind 0 is not a record but zeros, as in parts of a file that were never written.
        if matches!(kind, 0 | op::DATA_END | op::FOOTER) {
            break;
        }
        let begin = whole + HEAD as u64;
        let complete = begin.checked_add(length).is_some_and(|end| end <= size);
        if !complete && kind != op::CHUNK {
            break;
        }
        let length = if complete { length } else { size - begin };
        content.resize(usize::try_from(length).map_err(|_| ReadError::Beyond)?, 0);
        file.read_exact(&mut content).map_err(ReadError::from)?;
        if kind == op::CHUNK {
            let Some(records) = records_of(&content, complete)? else { break };
            let records = &records[..whole_records(records)];
            each(Part::Chunk { start: whole, records })?;
            if !complete {
                let before = (HEAD + CHUNK_HEAD + records.len()) as u64;
                return Ok(Extent { whole: whole + before, size });
            }
        } else {
            if kind == op::ATTACHMENT && !is_attachment(&content) {
                break;
            }
            let Ok(record) = parse_record(kind, &content) else { break };
            each(Part::Record(record))?;
        }
        whole = begin + length;
    }
    Ok(Extent { whole, size })
}

/// Fails if the file does not begin with the MCAP magic.
pub(crate) fn begins_well(file: &mut File) -> Result<(), ReadError> {
    let mut magic = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(MAGIC.len() as u64).read_to_end(&mut magic)?;
    if magic == MAGIC { Ok(()) } else { Err(ReadError::NotMcap) }
}

/// Kind and length of the next record; `None` at the end of the file.
fn head(file: &mut BufReader<File>) -> Result<Option<(u8, u64)>, ReadError> {
    let mut head = Vec::new();
    file.take(HEAD as u64).read_to_end(&mut head)?;
    let Some((&kind, length)) = head.split_first() else { return Ok(None) };
    let length = length.first_chunk::<8>().map(|length| u64::from_le_bytes(*length));
    Ok(length.map(|length| (kind, length)))
}

/// Whether the content is long enough for the lengths in an attachment, which the parser does not
/// check.
fn is_attachment(content: &[u8]) -> bool {
    let number = |at: usize| {
        let four = content.get(at..)?.first_chunk::<4>()?;
        usize::try_from(u32::from_le_bytes(*four)).ok()
    };
    // Two dates; then name, media type and data, each preceded by its length; then a checksum.
    let end = number(16).and_then(|name| {
        let kind = 20_usize.checked_add(name)?;
        kind.checked_add(4)?.checked_add(number(kind)?)?.checked_add(12)
    });
    end.is_some_and(|end| end <= content.len())
}

/// The records in a chunk's content; `None` if even its header is incomplete.
fn records_of(content: &[u8], complete: bool) -> Result<Option<&[u8]>, ReadError> {
    let text = |at: usize, length: usize| content.get(at..at + length);
    let Some(length) = text(28, 4).and_then(|four| four.first_chunk::<4>()) else {
        return Ok(None);
    };
    let length = u32::from_le_bytes(*length) as usize;
    if length > 0 {
        let name = text(32, length.min(16)).unwrap_or_default();
        return Err(ReadError::Compressed(String::from_utf8_lossy(name).into_owned()));
    }
    let Some(size) = text(32, 8).and_then(|eight| eight.first_chunk::<8>()) else {
        return Ok(None);
    };
    let records = &content[CHUNK_HEAD..];
    let size = usize::try_from(u64::from_le_bytes(*size)).unwrap_or(usize::MAX);
    // The size of an incomplete chunk was not written yet.
    Ok(Some(if complete { &records[..size.min(records.len())] } else { records }))
}

/// Total length of the intact records at the beginning of `bytes`.
fn whole_records(bytes: &[u8]) -> usize {
    let mut whole = 0;
    while let Some((_, length)) = split(&bytes[whole..]) {
        whole += length;
    }
    whole
}

/// The first record of a chunk, and its length with header; `None` if it is incomplete or of a kind
/// that chunks do not contain.
fn split(bytes: &[u8]) -> Option<(Record<'_>, usize)> {
    let (&kind, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let record = parse_record(kind, rest.get(..length)?).ok()?;
    let known = matches!(
        record,
        Record::Schema { .. }
            | Record::Channel(_)
            | Record::Message { .. }
            | Record::Unknown { .. }
    );
    // Kind 0 is not a record here either.
    (known && kind != 0).then_some((record, HEAD + length))
}

/// The records of a chunk.
pub fn records(mut bytes: &[u8]) -> impl Iterator<Item = Record<'_>> {
    std::iter::from_fn(move || {
        let (record, length) = split(bytes)?;
        bytes = &bytes[length..];
        Some(record)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::io::Write as _;

    use mcap::WriteOptions;
    use mcap::records::MessageHeader;

    use super::*;

    /// A file of two chunks with three messages each.
    fn file() -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut writer = WriteOptions::new().compression(None).create(&mut bytes).unwrap();
        let channel = writer.add_channel(0, "/a", "json", &BTreeMap::new()).unwrap();
        for sequence in 0..6 {
            let log_time = u64::from(sequence);
            let header = MessageHeader { channel_id: channel, sequence, log_time, publish_time: 0 };
            writer.write_to_known_channel(&header, b"[1,2,3]").unwrap();
            if sequence == 2 {
                writer.flush().unwrap();
            }
        }
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    }

    /// Numbers of the intact messages, and how far the file can be read.
    fn read(bytes: &[u8]) -> Result<(Vec<u32>, Extent), ReadError> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        let mut seen = Vec::new();
        let extent = walk(file.path(), |part| {
            if let Part::Chunk { records: bytes, .. } = part {
                seen.extend(records(bytes).filter_map(|record| match record {
                    Record::Message { header, .. } => Some(header.sequence),
                    _ => None,
                }));
            }
            Ok::<_, ReadError>(())
        })?;
        Ok((seen, extent))
    }

    #[test]
    fn a_file_that_ends_anywhere_has_all_messages_before_its_end() {
        let whole = file();
        let (all, extent) = read(&whole).unwrap();
        assert_eq!(all, [0, 1, 2, 3, 4, 5]);
        assert!(extent.whole < extent.size);
        let mut before = 0;
        for length in 0..whole.len() {
            let cut = read(&whole[..length]);
            if length < MAGIC.len() {
                assert!(matches!(cut, Err(ReadError::NotMcap)), "{length}");
                continue;
            }
            let (seen, extent) = cut.unwrap();
            assert!(seen.iter().copied().eq(0..seen.len() as u32), "{length}: {seen:?}");
            assert!(extent.whole <= extent.size && extent.size == length as u64);
            // A longer part of the file never yields fewer messages.
            assert!(seen.len() >= before, "{length}");
            before = seen.len();
        }
        assert_eq!(before, 6);
    }

    #[test]
    fn a_damaged_file_is_read_as_far_as_it_goes_and_ends_nothing() {
        let whole = file();
        for at in MAGIC.len()..whole.len() {
            for damage in [0, 0x7F, 0xFF] {
                let mut bytes = whole.clone();
                bytes[at] = damage;
                let _ = read(&bytes);
            }
        }
        let mut zeros = whole[..200].to_vec();
        zeros.resize(4096, 0);
        // The record in which the zeros begin counts as intact: only its length is known.
        let extent = read(&zeros).unwrap().1;
        assert!((200..300).contains(&extent.whole), "{extent:?}");
    }
}
