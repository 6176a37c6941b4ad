//! Writes a recording as MCAP.
//!
//! Samples are CDR with their ROS 2 message definitions: what is on the wire, exact to the bit
//! (JSON has no NaN and rounds 64-bit integers), small, and read by Foxglove and by ROS 2 tools
//! without plugins. Calls, activities and exceptions are JSON with JSON Schema, which Foxglove
//! reads as well: their inputs differ from service to service.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapError, WriteOptions, Writer};

use super::frames::{Channel, Lost, Sample, Start};

/// A file that is being written.
pub(crate) struct Recorder {
    writer: Writer<BufWriter<File>>,
    /// By number of the daemon's.
    channels: BTreeMap<u16, Told>,
    /// Date of the last sample.
    last: u64,
}

/// What became of a channel.
#[derive(Debug)]
pub(crate) struct Told {
    /// Number in the file.
    id: u16,
    pub(crate) topic: String,
    pub(crate) messages: u64,
    pub(crate) lost: u64,
}

impl Recorder {
    /// Begins a file.
    pub(crate) fn new(file: File, start: &Start) -> Result<Self, McapError> {
        let library = format!("genomctl {}", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(None).library(library);
        let mut writer = options.create(BufWriter::new(file))?;
        writer.write_metadata(&Metadata {
            name: "genom".to_owned(),
            metadata: BTreeMap::from([
                ("genomd".to_owned(), start.genomd.clone()),
                ("clock".to_owned(), start.clock.clone()),
            ]),
        })?;
        writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: "deployment.toml".to_owned(),
            media_type: "application/toml".to_owned(),
            data: Cow::Borrowed(start.deployment.as_bytes()),
        })?;
        Ok(Self { writer, channels: BTreeMap::new(), last: 0 })
    }

    /// A channel comes.
    pub(crate) fn channel(&mut self, channel: Channel) -> Result<(), McapError> {
        let Channel { channel, topic, encoding, schema, definition, metadata } = channel;
        let language = if encoding == "cdr" { "ros2msg" } else { "jsonschema" };
        let schema = self.writer.add_schema(&schema, language, definition.as_bytes())?;
        let id = self.writer.add_channel(schema, &topic, &encoding, &metadata)?;
        self.channels.insert(channel, Told { id, topic, messages: 0, lost: 0 });
        Ok(())
    }

    /// A sample comes; one of a channel that never was announced is given up.
    pub(crate) fn sample(&mut self, sample: &Sample) -> Result<(), McapError> {
        let Some(told) = self.channels.get_mut(&sample.channel) else { return Ok(()) };
        let header = MessageHeader {
            channel_id: told.id,
            sequence: sample.number,
            log_time: sample.date,
            publish_time: sample.date,
        };
        self.writer.write_to_known_channel(&header, &sample.message)?;
        told.messages += 1;
        self.last = self.last.max(sample.date);
        Ok(())
    }

    /// Samples were lost on their way here.
    pub(crate) fn lost(&mut self, lost: &Lost) {
        if let Some(told) = self.channels.get_mut(&lost.channel) {
            told.lost = lost.lost;
        }
    }

    /// Samples and notes so far, and lost ones.
    pub(crate) fn counts(&self) -> (u64, u64) {
        let all = self.channels.values();
        all.fold((0, 0), |(messages, lost), told| (messages + told.messages, lost + told.lost))
    }

    /// What came so far is in the file then, whatever happens.
    pub(crate) fn save(&mut self) -> Result<(), McapError> {
        self.writer.flush()
    }

    /// Ends the file: with its index, and with what was lost.
    pub(crate) fn finish(mut self, complete: bool) -> Result<Vec<Told>, McapError> {
        let mut metadata = BTreeMap::from([("complete".to_owned(), complete.to_string())]);
        let mut all: BTreeMap<String, Told> = BTreeMap::new();
        // A component that went and came back has had two channels of one topic.
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
        self.writer.write_metadata(&Metadata { name: "genom.lost".to_owned(), metadata })?;
        self.writer.finish()?;
        Ok(all.into_values().collect())
    }
}
