//! Reads the samples of an MCAP file in order of date, one chunk at a time.
//!
//! A file that was not completed has no index; one is then built from the readable part.

pub(crate) mod error;
pub(crate) mod walk;
mod zstd;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::records::{ChunkIndex, Record};
use mcap::sans_io::indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};
use mcap::{Channel, McapError, Schema, Summary};

use self::error::ReadError;
use self::walk::{Extent, Part, begins_well, records, walk};
use self::zstd::Zstd;

/// Greatest size of a chunk in bytes, also of what a compressed one says that it unpacks to.
const LARGEST: usize = 1 << 30;

/// An MCAP file being read.
pub struct Recording {
    file: BufReader<File>,
    /// Size of the file: lengths in the file that exceed it are refused before memory is allocated.
    size: u64,
    summary: Summary,
    reader: Option<IndexedReader>,
    /// The chunk read last, as stored in the file.
    chunk: Vec<u8>,
    /// For an incomplete file: how far it can be read, and the number of samples in that part.
    pub cut: Option<(Extent, u64)>,
}

/// What the end of a file tells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Glance {
    /// Samples and notes in it.
    pub messages: u64,
    /// Seconds from the first to the last.
    pub seconds: f64,
}

/// Looks at the end of a file alone; `None` if it has none, since whoever wrote it was killed.
///
/// # Errors
/// It cannot be read, or is no recording.
pub fn glance(file: &File) -> Result<Option<Glance>, ReadError> {
    let mut file = file.try_clone()?;
    file.seek(SeekFrom::Start(0))?;
    begins_well(&mut file)?;
    let size = file.metadata()?.len();
    match summary(&mut BufReader::new(file), size) {
        Ok(summary) => Ok(Some(summary.stats.map_or_else(Glance::default, |told| Glance {
            messages: told.message_count,
            seconds: told.message_end_time.saturating_sub(told.message_start_time) as f64 * 1e-9,
        }))),
        Err(Some(error)) => Err(error),
        Err(None) => Ok(None),
    }
}

/// A sample of the file.
#[derive(Debug)]
pub struct Recorded {
    /// Number of its channel in the file.
    pub channel: u16,
    /// When it was taken, in nanoseconds since 1970, or of a virtual clock.
    pub date: u64,
    /// Its content as it was recorded.
    pub message: Vec<u8>,
}

impl Recording {
    /// Opens a file and reads its index, but no samples.
    ///
    /// # Errors
    /// It cannot be read, or is no recording.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut file = File::open(path)?;
        begins_well(&mut file)?;
        let size = file.metadata()?.len();
        let mut file = BufReader::new(file);
        let (summary, cut) = match summary(&mut file, size) {
            Ok(summary) => (summary, None),
            Err(Some(error)) => return Err(error),
            Err(None) => {
                let mut index = Index::default();
                let extent = walk(path, |part| index.add(&part))?;
                (index.summary, Some((extent, index.messages)))
            }
        };
        Ok(Self { file, size, summary, reader: None, chunk: Vec::new(), cut })
    }

    /// Its channels, by number.
    pub fn channels(&self) -> impl Iterator<Item = (u16, &Arc<Channel<'static>>)> {
        let mut all: Vec<_> = self.summary.channels.iter().collect();
        all.sort_by_key(|(number, _)| **number);
        all.into_iter().map(|(number, channel)| (*number, channel))
    }

    /// Selects the topics whose samples [`next_sample`](Self::next_sample) returns, the earliest
    /// first.
    ///
    /// # Errors
    /// Its index is damaged.
    pub fn read(&mut self, topics: Vec<String>) -> Result<(), ReadError> {
        let options = IndexedReaderOptions::new().include_topics(topics);
        let options = options.with_record_length_limit(LARGEST);
        let mut reader = IndexedReader::new_with_options(&self.summary, options)?;
        reader.add_decompressor(Zstd)?;
        self.reader = Some(reader);
        Ok(())
    }

    /// The next sample; `None` at the end.
    ///
    /// # Errors
    /// The file is damaged there.
    pub fn next_sample(&mut self) -> Result<Option<Recorded>, ReadError> {
        let Some(reader) = &mut self.reader else { return Ok(None) };
        while let Some(event) = reader.next_event() {
            let (offset, length) = match event? {
                IndexedReadEvent::Message { header, data } => {
                    let (channel, date) = (header.channel_id, header.log_time);
                    return Ok(Some(Recorded { channel, date, message: data.to_vec() }));
                }
                IndexedReadEvent::ReadChunkRequest { offset, length } => (offset, length),
            };
            within(self.size, offset, length)?;
            self.file.seek(SeekFrom::Start(offset))?;
            self.chunk.resize(length, 0);
            self.file.read_exact(&mut self.chunk)?;
            reader.insert_chunk_record_data(offset, &self.chunk)?;
        }
        Ok(None)
    }
}

/// Reads the index at the end of a file; `Err(None)` if there is none.
fn summary(file: &mut BufReader<File>, size: u64) -> Result<Summary, Option<ReadError>> {
    let failed = |error: std::io::Error| Some(ReadError::from(error));
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(SummaryReadEvent::ReadRequest(need)) => {
                within(size, 0, need).map_err(Some)?;
                let read = file.read(reader.insert(need)).map_err(failed)?;
                reader.notify_read(read);
            }
            Ok(SummaryReadEvent::SeekRequest(to)) => {
                let Ok(at) = file.seek(to) else { return Err(None) };
                reader.notify_seeked(at);
            }
            // Errors that mean the end of the file is missing.
            Err(McapError::BadMagic | McapError::BadFooter | McapError::UnexpectedEof) => {
                return Err(None);
            }
            Err(error) => return Err(Some(error.into())),
        }
    }
    reader.finish().ok_or(None)
}

/// An index being built.
#[derive(Default)]
struct Index {
    summary: Summary,
    messages: u64,
}

impl Index {
    fn add(&mut self, part: &Part<'_>) -> Result<(), ReadError> {
        match part {
            Part::Record(record) => self.describe(record),
            Part::Chunk { start, records: bytes } => {
                let (mut first, mut last) = (u64::MAX, 0);
                for record in records(bytes) {
                    if let Record::Message { header, .. } = &record {
                        (first, last) = (first.min(header.log_time), last.max(header.log_time));
                        self.messages += 1;
                    }
                    self.describe(&record);
                }
                let size = bytes.len() as u64;
                self.summary.chunk_indexes.push(ChunkIndex {
                    message_start_time: first.min(last),
                    message_end_time: last,
                    chunk_start_offset: *start,
                    chunk_length: size,
                    message_index_offsets: BTreeMap::new(),
                    message_index_length: 0,
                    compression: String::new(),
                    compressed_size: size,
                    uncompressed_size: size,
                });
            }
        }
        Ok(())
    }

    fn describe(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let schema = Schema {
                    id: header.id,
                    name: header.name.clone(),
                    encoding: header.encoding.clone(),
                    data: Cow::Owned(data.to_vec()),
                };
                self.summary.schemas.insert(header.id, Arc::new(schema));
            }
            Record::Channel(channel) => {
                let known = Channel {
                    id: channel.id,
                    topic: channel.topic.clone(),
                    schema: self.summary.schemas.get(&channel.schema_id).cloned(),
                    message_encoding: channel.message_encoding.clone(),
                    metadata: channel.metadata.clone(),
                };
                self.summary.channels.insert(channel.id, Arc::new(known));
            }
            _ => {}
        }
    }
}

fn within(size: u64, offset: u64, length: usize) -> Result<(), ReadError> {
    let end = u64::try_from(length).ok().and_then(|length| offset.checked_add(length));
    if end.is_some_and(|end| end <= size) { Ok(()) } else { Err(ReadError::Beyond) }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use mcap::WriteOptions;
    use mcap::records::MessageHeader;

    use super::*;

    /// A file with a sample in a chunk, and the size of that chunk.
    fn file() -> (Vec<u8>, u64) {
        let mut bytes = Cursor::new(Vec::new());
        let options = WriteOptions::new().compression(None);
        let mut writer = options.calculate_summary_section_crc(false).create(&mut bytes).unwrap();
        let channel = writer.add_channel(0, "/a", "cdr", &BTreeMap::new()).unwrap();
        let (sequence, log_time, publish_time) = (0, 7, 7);
        let header = MessageHeader { channel_id: channel, sequence, log_time, publish_time };
        writer.write_to_known_channel(&header, &[5; 1000]).unwrap();
        let summary = writer.finish().unwrap();
        drop(writer);
        (bytes.into_inner(), summary.chunk_indexes[0].uncompressed_size)
    }

    fn read(bytes: &[u8]) -> Result<Option<Recorded>, ReadError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        let mut recording = Recording::open(file.path())?;
        recording.read(vec!["/a".to_owned()])?;
        recording.next_sample()
    }

    #[test]
    fn a_chunk_that_says_it_is_enormous_is_refused_before_it_has_room() {
        let (bytes, size) = file();
        let sample = read(&bytes).unwrap().unwrap();
        assert_eq!((sample.date, sample.message), (7, vec![5; 1000]));
        let told = size.to_le_bytes();
        for more in [size + 1, 1 << 31, u64::MAX] {
            let mut lies = bytes.clone();
            let places = (0..lies.len() - 8).filter(|at| bytes[*at..].starts_with(&told));
            let places: Vec<usize> = places.collect();
            assert!(places.len() >= 2, "the chunk and its index: {places:?}");
            places.iter().for_each(|at| lies[*at..at + 8].copy_from_slice(&more.to_le_bytes()));
            assert!(read(&lies).is_err(), "{more}");
        }
    }
}
