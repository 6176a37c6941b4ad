//! Writes a recording as MCAP.
//!
//! Samples are stored as CDR with their ROS 2 message definitions: the exact bits (JSON has no NaN
//! and rounds 64-bit integers), compact, and readable by Foxglove and ROS 2 tools without plugins.
//! Calls, activities and exceptions are stored as JSON with JSON Schema, which Foxglove reads as
//! well, because their inputs differ from service to service.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use genom_protocol::frames::{Channel, Lost, Sample, Start};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapError, WriteOptions, Writer};

use crate::room::{Counted, Room};

/// Upper bound of the size of the end of a file, apart from what grows with its content. In bytes.
const END: u64 = 4096;
/// Sizes of entries of the end, in bytes: per chunk, per channel, per channel of a chunk, per
/// sample.
const OF_CHUNK: u64 = 128;
const OF_CHANNEL: u64 = 128;
const OF_BOTH: u64 = 10;
const OF_SAMPLE: u64 = 16;
/// Size of the header of each sample, in bytes.
const HEAD: u64 = 31;

/// An MCAP file being written.
pub struct Recorder {
    path: PathBuf,
    writer: Writer<Counted<BufWriter<File>>>,
    /// The channels, by the daemon's number.
    channels: BTreeMap<u16, ChannelSummary>,
    room: Room,
    /// Bytes written so far.
    written: Arc<AtomicU64>,
    /// Size of schemas and channels, which the end of the file repeats.
    repeated: u64,
    /// How many times the file was saved.
    saved: u64,
    /// Samples since it was last saved.
    unsaved: u64,
}

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The disk is full, or the file reached the maximum size. The file can still be completed.
    #[error(
        "{}: {why} after {written} bytes: it ends there; make room, or record to another disk",
        path.display()
    )]
    Full {
        /// The file.
        path: PathBuf,
        /// Bytes written until then.
        written: u64,
        /// The system's own words.
        why: std::io::Error,
    },
    /// Writing failed; the end of the file is missing.
    #[error(
        "{}: {why} after {written} bytes: what came before can be read; \
         `genomctl recover` makes a whole file of it", path.display()
    )]
    Broken {
        /// The file.
        path: PathBuf,
        /// Bytes written until then.
        written: u64,
        /// What went wrong.
        why: String,
    },
}

/// A channel of the file, with its number of messages.
#[derive(Debug)]
pub struct ChannelSummary {
    /// Number of the channel in the file.
    id: u16,
    /// What it is of.
    pub topic: String,
    /// Messages in the file.
    pub messages: u64,
    /// Messages that are not, since they were lost.
    pub lost: u64,
}

impl Recorder {
    /// Creates a file; `program` is who writes it.
    ///
    /// # Errors
    /// There is no room for it, or it cannot be written.
    pub fn new(program: &str, path: &Path, file: File, start: &Start) -> Result<Self, WriteError> {
        let (path, mut room) = (path.to_owned(), Room::of(&file));
        let expected = END + 2 * start.deployment.len() as u64;
        let full = |why| WriteError::Full { path: path.clone(), written: 0, why };
        if let Ok(room) = &mut room {
            room.reach(expected).map_err(full)?;
        }
        let room = room.map_err(full)?;
        let (counted, written) = Counted::new(BufWriter::new(file));
        let broken = |why: McapError| broken(&path, &written, &why);
        let writer = begin(program, counted, start).map_err(broken)?;
        let channels = BTreeMap::new();
        Ok(Self { path, writer, channels, room, written, repeated: 0, saved: 0, unsaved: 0 })
    }

    /// Sets how many bytes the file may have, its end included.
    pub fn limit(&mut self, most: u64) {
        self.room.limit(most);
    }

    /// Bytes written so far, without what is kept in memory until the next [`save`](Self::save).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// Adds a channel.
    ///
    /// # Errors
    /// There is no room for it, or it cannot be written.
    pub fn channel(&mut self, channel: Channel) -> Result<(), WriteError> {
        let Channel { channel, topic, encoding, schema, definition, metadata } = channel;
        let texts = metadata.iter().map(|(key, value)| key.len() + value.len() + 8);
        let size = schema.len() + definition.len() + topic.len() + texts.sum::<usize>();
        self.repeated += size as u64;
        self.reach(size as u64 + OF_CHANNEL)?;
        let language = if encoding == "cdr" { "ros2msg" } else { "jsonschema" };
        let id = self
            .writer
            .add_schema(&schema, language, definition.as_bytes())
            .and_then(|schema| self.writer.add_channel(schema, &topic, &encoding, &metadata));
        let id = id.map_err(|why| broken(&self.path, &self.written, &why))?;
        self.channels.insert(channel, ChannelSummary { id, topic, messages: 0, lost: 0 });
        Ok(())
    }

    /// Adds a sample; a sample of an unknown channel is dropped.
    ///
    /// # Errors
    /// There is no room for it, or it cannot be written.
    pub fn sample(&mut self, sample: &Sample<'_>) -> Result<(), WriteError> {
        let Some(told) = self.channels.get(&sample.channel) else { return Ok(()) };
        let header = MessageHeader {
            channel_id: told.id,
            sequence: sample.number,
            log_time: sample.date,
            publish_time: sample.date,
        };
        self.unsaved += 1;
        self.reach(HEAD + sample.message.len() as u64)?;
        let written = self.writer.write_to_known_channel(&header, sample.message);
        written.map_err(|why| broken(&self.path, &self.written, &why))?;
        if let Some(told) = self.channels.get_mut(&sample.channel) {
            told.messages += 1;
        }
        Ok(())
    }

    /// Stores the number of lost samples of a channel.
    pub fn lost(&mut self, lost: Lost) {
        if let Some(told) = self.channels.get_mut(&lost.channel) {
            told.lost = lost.lost;
        }
    }

    /// Samples and notes written so far, and those lost.
    #[must_use]
    pub fn counts(&self) -> (u64, u64) {
        let all = self.channels.values();
        all.fold((0, 0), |(messages, lost), told| (messages + told.messages, lost + told.lost))
    }

    /// Writes out everything received so far, so that it is in the file even if this process is
    /// killed.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn save(&mut self) -> Result<(), WriteError> {
        if self.unsaved > 0 {
            (self.saved, self.unsaved) = (self.saved + 1, 0);
        }
        self.writer.flush().map_err(|why| broken(&self.path, &self.written, &why))
    }

    /// Reserves disk space for `more` bytes, and for the end of the file after them.
    fn reach(&mut self, more: u64) -> Result<(), WriteError> {
        let written = self.written.load(Ordering::Relaxed);
        let channels = self.channels.len() as u64 + 1;
        let chunks = self.saved + written / WriteOptions::DEFAULT_CHUNK_SIZE + 2;
        let end = END
            + 3 * self.repeated
            + channels * OF_CHANNEL
            + chunks * (OF_CHUNK + channels * OF_BOTH)
            + self.unsaved * OF_SAMPLE;
        let why = self.room.reach(written + more + end);
        why.map_err(|why| WriteError::Full { path: self.path.clone(), written, why })
    }

    /// Adds a record of metadata.
    ///
    /// # Errors
    /// There is no room for it, or it cannot be written.
    pub fn tell(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), WriteError> {
        let texts = metadata.iter().map(|(key, value)| key.len() + value.len() + 8);
        self.reach(texts.sum::<usize>() as u64 + OF_CHANNEL)?;
        let record = Metadata { name: name.to_owned(), metadata };
        let written = self.writer.write_metadata(&record);
        written.map_err(|why| broken(&self.path, &self.written, &why))
    }

    /// Completes the file with its index and the numbers of lost samples.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self, complete: bool) -> Result<Vec<ChannelSummary>, WriteError> {
        let mut metadata = BTreeMap::from([("complete".to_owned(), complete.to_string())]);
        let mut all: BTreeMap<String, ChannelSummary> = BTreeMap::new();
        // A component that was unloaded and loaded again has two channels of the same topic.
        for told in std::mem::take(&mut self.channels).into_values() {
            match all.get_mut(&told.topic) {
                Some(before) => {
                    before.messages += told.messages;
                    before.lost += told.lost;
                }
                None => _ = all.insert(told.topic.clone(), told),
            }
        }
        for told in all.values() {
            metadata.insert(told.topic.clone(), told.lost.to_string());
        }
        let lost = Metadata { name: "genom.lost".to_owned(), metadata };
        let ended = self.writer.write_metadata(&lost).and_then(|()| self.writer.finish());
        ended.map_err(|why| broken(&self.path, &self.written, &why))?;
        // The last bytes are still in the buffer.
        let flushed = std::io::Write::flush(&mut self.writer.into_inner());
        let done = flushed.and_then(|()| self.room.done());
        done.map_err(|why| broken(&self.path, &self.written, &why.into()))?;
        Ok(all.into_values().collect())
    }
}

/// Writes the beginning of a recording.
fn begin(
    program: &str,
    file: Counted<BufWriter<File>>,
    start: &Start,
) -> Result<Writer<Counted<BufWriter<File>>>, McapError> {
    let mut writer = written_by(program).create(file)?;
    writer.write_metadata(&Metadata {
        name: "genom".to_owned(),
        metadata: BTreeMap::from([
            ("genomd".to_owned(), start.genomd.clone()),
            ("clock".to_owned(), start.clock.to_string()),
        ]),
    })?;
    writer.attach(&Attachment {
        log_time: 0,
        create_time: 0,
        name: "deployment.toml".to_owned(),
        media_type: "application/toml".to_owned(),
        data: Cow::Borrowed(start.deployment.as_bytes()),
    })?;
    Ok(writer)
}

/// Options of all files that are written here; `program` is who writes.
#[must_use]
pub fn written_by(program: &str) -> WriteOptions {
    let library = format!("{program} {}", env!("CARGO_PKG_VERSION"));
    WriteOptions::new().compression(None).library(library)
}

/// Why a file cannot be written, in the system's own words if it is the system that refuses.
pub(crate) fn words(why: &McapError) -> String {
    match why {
        McapError::Io(why) => why.to_string(),
        why => why.to_string(),
    }
}

fn broken(path: &Path, written: &AtomicU64, why: &McapError) -> WriteError {
    let (written, why) = (written.load(Ordering::Relaxed), words(why));
    WriteError::Broken { path: path.to_owned(), written, why }
}
