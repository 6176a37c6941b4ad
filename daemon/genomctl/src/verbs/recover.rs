//! `genomctl recover`: completes a recording whose recorder was killed.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use genom_recording::{Extent, Part, ReadError, records, walk, written_by};
use mcap::records::{Metadata, Record};
use mcap::{Attachment, McapError, Writer};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// Make a complete MCAP file from one that was not completed, as after a crash or on a full disk.
///
/// All intact samples, attachments and metadata are copied to a new file with an index; the
/// original stays as it is. `genomctl replay` reads incomplete files, too, but many other tools do
/// not.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The incomplete file.
    file: PathBuf,
    /// The complete file to write.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &Args, session: &Session) -> Result<(), Failure> {
    let same = |path: &PathBuf| path.canonicalize().ok();
    let there = same(&args.output);
    if there.is_some() && there == same(&args.file) {
        let message = format!("{} is the file to read", args.output.display());
        return Err(Failure::usage(message, "name another file"));
    }
    if there.is_some() && !args.force {
        let message = format!("{} is there already", args.output.display());
        return Err(Failure::usage(message, "name another file, or replace it with --force"));
    }
    let mut copy = Copy::default();
    // Read first, so that no file is created if this one cannot be read.
    walk(&args.file, |_| Ok::<_, ReadError>(())).map_err(|why| Failure::file(&args.file, why))?;
    let copied = copy.all(args);
    let extent = copied.map_err(|why| match why {
        CopyError::Read(why) => Failure::file(&args.file, why),
        CopyError::Write(McapError::Io(why)) => Failure::file(&args.output, why),
        CopyError::Write(why) => Failure::file(&args.file, why),
    })?;
    let lost = extent.size - extent.whole;
    let topics: Vec<Value> = copy
        .topics
        .values()
        .map(|(topic, messages)| json!({"topic": topic, "messages": messages}))
        .collect();
    let reply = json!({"file": args.output, "bytes_given_up": lost, "channels": topics});
    session.show_own(&reply, || {
        let rows = copy.topics.values();
        let rows = rows.map(|(topic, messages)| vec![topic.clone(), messages.to_string()]);
        Table { header: vec!["TOPIC", "MESSAGES"], rows: rows.collect() }
    })
}

/// A copy being made.
#[derive(Default)]
struct Copy {
    /// Topic and number of messages of each channel.
    topics: BTreeMap<u16, (String, u64)>,
}

#[derive(Debug, thiserror::Error)]
enum CopyError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Write(#[from] McapError),
}

impl Copy {
    fn all(&mut self, args: &Args) -> Result<Extent, CopyError> {
        let file = File::create(&args.output).map_err(McapError::from)?;
        let mut writer = written_by("genomctl").create(BufWriter::new(file))?;
        let mut recovered = BTreeMap::new();
        let extent = walk(&args.file, |part| match part {
            Part::Chunk { records: bytes, .. } => {
                records(bytes).try_for_each(|record| self.one(&mut writer, record))
            }
            Part::Record(record) => self.one(&mut writer, record),
        })?;
        recovered.insert("bytes_given_up".to_owned(), (extent.size - extent.whole).to_string());
        let metadata = Metadata { name: "genom.recovered".to_owned(), metadata: recovered };
        writer.write_metadata(&metadata)?;
        writer.finish()?;
        std::io::Write::flush(&mut writer.into_inner()).map_err(McapError::from)?;
        Ok(extent)
    }

    fn one<W: std::io::Write + std::io::Seek>(
        &mut self,
        writer: &mut Writer<W>,
        record: Record<'_>,
    ) -> Result<(), CopyError> {
        match record {
            Record::Schema { header, data } => {
                writer.add_schema_with_id(header.id, &header.name, &header.encoding, &data)?;
            }
            Record::Channel(one) => {
                let (topic, encoding) = (&one.topic, &one.message_encoding);
                writer.add_channel_with_id(
                    one.id,
                    one.schema_id,
                    topic,
                    encoding,
                    &one.metadata,
                )?;
                self.topics.entry(one.id).or_insert((one.topic, 0));
            }
            Record::Message { header, data } => {
                writer.write_to_known_channel(&header, &data)?;
                if let Some((_, messages)) = self.topics.get_mut(&header.channel_id) {
                    *messages += 1;
                }
            }
            Record::Attachment { header, data, .. } => writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data,
            })?,
            Record::Metadata(metadata) => writer.write_metadata(&metadata)?,
            // Indexes and checksums, which the writer creates, and unknown records.
            _ => {}
        }
        Ok(())
    }
}
