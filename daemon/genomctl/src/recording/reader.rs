//! Reads samples of an MCAP file in order of their dates, a chunk at a time.

use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::sans_io::indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};
use mcap::{Channel, McapError, Summary};

/// A file that is being read.
pub(crate) struct Recording {
    file: BufReader<File>,
    /// Its size: what it says to have beyond is not asked of the memory.
    size: u64,
    summary: Summary,
    reader: Option<IndexedReader>,
    /// A chunk, as it lies in the file.
    chunk: Vec<u8>,
}

/// A sample of the file.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub(crate) channel: u16,
    pub(crate) date: u64,
    pub(crate) message: Vec<u8>,
}

/// The file cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReadError {
    #[error(transparent)]
    Io(#[from] std::io::Error),
    #[error("it is no MCAP file, or a damaged one: {0}")]
    Mcap(#[from] McapError),
    #[error("it was not ended properly and has no index: `mcap recover` repairs such files")]
    NoIndex,
    #[error("it is damaged: something in it is said to be larger than the file")]
    Beyond,
    #[error("it is damaged: a sample is dated years after the one before it")]
    Dates,
}

impl Recording {
    /// Opens a file and reads what is in it, but no samples.
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        let mut file = BufReader::new(file);
        let mut reader = SummaryReader::new();
        while let Some(event) = reader.next_event() {
            match event? {
                SummaryReadEvent::ReadRequest(need) => {
                    within(size, 0, need)?;
                    let read = file.read(reader.insert(need))?;
                    reader.notify_read(read);
                }
                SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
            }
        }
        let summary = reader.finish().ok_or(ReadError::NoIndex)?;
        Ok(Self { file, size, summary, reader: None, chunk: Vec::new() })
    }

    /// Its channels, by number.
    pub(crate) fn channels(&self) -> impl Iterator<Item = (u16, &Arc<Channel<'static>>)> {
        let mut all: Vec<_> = self.summary.channels.iter().collect();
        all.sort_by_key(|(number, _)| **number);
        all.into_iter().map(|(number, channel)| (*number, channel))
    }

    /// From now on only samples of these topics, the earliest first.
    pub(crate) fn read(&mut self, topics: Vec<String>) -> Result<(), ReadError> {
        let options = IndexedReaderOptions::new().include_topics(topics);
        self.reader = Some(IndexedReader::new_with_options(&self.summary, options)?);
        Ok(())
    }

    /// The next sample; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<Recorded>, ReadError> {
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

fn within(size: u64, offset: u64, length: usize) -> Result<(), ReadError> {
    let end = u64::try_from(length).ok().and_then(|length| offset.checked_add(length));
    if end.is_some_and(|end| end <= size) { Ok(()) } else { Err(ReadError::Beyond) }
}
