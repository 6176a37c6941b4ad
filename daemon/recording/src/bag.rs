//! Bags of ROS 2 (`rosbag2`): a directory with a file in MCAP and one in YAML that tells what is in
//! it, as `ros2 bag` and other tools for bags read it.
//!
//! A recording of genomd has more than a bag may have, notes of calls and activities as JSON: of one
//! with samples in several formats, `ros2 bag play` plays nothing. So a bag has the samples only.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use genom_protocol::is_ros_part;
use mcap::records::MessageHeader;
use mcap::{Channel, McapError};

use crate::file::{words, written_by};
use crate::read::Recording;
use crate::read::error::ReadError;

/// Format of `metadata.yaml`: that of Humble, which later releases read, too.
const VERSION: u32 = 5;

/// Ending of the files of bags that can be read here.
const MCAP: &str = "mcap";

const SAMPLES: &str = "samples_0.mcap";
const ABOUT: &str = "metadata.yaml";

/// A bag was not written, or there is none.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The directory is there already.
    #[error("{} is there already", .0.display())]
    There(PathBuf),
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It has no samples that ROS knows.
    #[error("it has no samples of ports")]
    Empty,
    /// A topic changed its type while it was recorded, which a bag cannot tell.
    #[error("/{topic} has samples of two types: {one} and {other}")]
    TwoTypes {
        /// Without the first `/`.
        topic: String,
        /// Of the first samples.
        one: String,
        /// Of later ones.
        other: String,
    },
    /// It cannot be written.
    #[error("{}: {why}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// What the system or the library says.
        why: String,
    },
    /// A directory that is no bag, or one in another format.
    #[error("{why}")]
    NoBag {
        /// What is in it instead.
        why: String,
    },
}

fn unwritten(path: &Path, why: &McapError) -> BagError {
    BagError::Write { path: path.to_owned(), why: words(why) }
}

/// A topic of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagTopic {
    /// With the first `/`.
    pub name: String,
    /// `demo/msg/State`.
    pub ty: String,
    /// Number of its samples.
    pub messages: u64,
}

/// What became of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bagged {
    /// What is in the bag.
    pub topics: Vec<BagTopic>,
    /// Topics of the recording that ROS would not take: calls, activities, and names that are none
    /// in ROS.
    pub left_out: Vec<String>,
}

/// Dates in nanoseconds, of the first sample and of the last.
#[derive(Clone, Copy, Default)]
struct Span(Option<(u64, u64)>);

impl Span {
    fn add(&mut self, date: u64) {
        let (first, last) = self.0.unwrap_or((date, date));
        self.0 = Some((first.min(date), last.max(date)));
    }

    fn start(self) -> u64 {
        self.0.map_or(0, |(first, _)| first)
    }

    fn duration(self) -> u64 {
        self.0.map_or(0, |(first, last)| last - first)
    }
}

/// Whether ROS takes this as the name of a topic.
fn is_topic(name: &str) -> bool {
    name.strip_prefix('/').unwrap_or(name).split('/').all(is_ros_part)
}

/// Whether this is the name of a message: `demo/msg/State`.
fn is_message(name: &str) -> bool {
    is_topic(name) && matches!(name.split('/').collect::<Vec<_>>()[..], [_, "msg", _])
}

/// Copies the samples of a recording into a bag, a directory that is made; `program` is who writes
/// it.
///
/// # Errors
/// The directory is there, the recording cannot be read, has no samples or a topic of two types, or
/// the bag cannot be written: then nothing is left of it.
pub fn write_bag(
    program: &str,
    recording: &mut Recording,
    into: &Path,
) -> Result<Bagged, BagError> {
    let (topics, left_out) = choose(recording)?;
    let failed = |why: io::Error| unwritten(into, &why.into());
    match fs::create_dir(into) {
        Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {
            return Err(BagError::There(into.to_owned()));
        }
        made => made.map_err(failed)?,
    }
    let written = fill(program, recording, topics, into);
    if written.is_err() {
        // What is left could be taken for a bag.
        let _ = fs::remove_dir_all(into);
    }
    Ok(Bagged { topics: written?, left_out })
}

type Chosen = BTreeMap<u16, Arc<Channel<'static>>>;

fn choose(recording: &Recording) -> Result<(Chosen, Vec<String>), BagError> {
    let (mut chosen, mut left_out) = (Chosen::new(), Vec::new());
    let mut types: BTreeMap<&str, &str> = BTreeMap::new();
    for (number, channel) in recording.channels() {
        let ty = channel.schema.as_ref().map(|schema| schema.name.as_str());
        let ty = ty.filter(|ty| channel.message_encoding == "cdr" && is_message(ty));
        let Some(ty) = ty.filter(|_| is_topic(&channel.topic)) else {
            left_out.push(channel.topic.clone());
            continue;
        };
        let topic = channel.topic.trim_start_matches('/');
        let before = *types.entry(topic).or_insert(ty);
        if before != ty {
            let (one, other) = (before.to_owned(), ty.to_owned());
            return Err(BagError::TwoTypes { topic: topic.to_owned(), one, other });
        }
        chosen.insert(number, Arc::clone(channel));
    }
    if chosen.is_empty() { Err(BagError::Empty) } else { Ok((chosen, left_out)) }
}

fn fill(
    program: &str,
    recording: &mut Recording,
    chosen: Chosen,
    into: &Path,
) -> Result<Vec<BagTopic>, BagError> {
    let path = into.join(SAMPLES);
    let failed = |why: McapError| unwritten(&path, &why);
    let file = File::create_new(&path).map_err(|why| failed(why.into()))?;
    let mut writer =
        written_by(program).profile("ros2").create(BufWriter::new(file)).map_err(failed)?;
    let mut topics: BTreeMap<String, BagTopic> = BTreeMap::new();
    // Their numbers in the bag, by those in the recording. A component that was unloaded and loaded
    // again has two channels of the same topic, which are one in the bag.
    let mut numbers = BTreeMap::new();
    for (number, channel) in &chosen {
        let Some(schema) = &channel.schema else { continue };
        let name = format!("/{}", channel.topic.trim_start_matches('/'));
        let ty = schema.name.clone();
        let id = writer.add_schema(&ty, &schema.encoding, &schema.data).map_err(failed)?;
        // Empty: whoever plays it offers what ROS offers by default.
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
        let id = writer.add_channel(id, &name, "cdr", &metadata).map_err(failed)?;
        numbers.insert(*number, (id, name.clone()));
        topics.insert(name.clone(), BagTopic { name, ty, messages: 0 });
    }
    recording.read(chosen.values().map(|channel| channel.topic.clone()).collect())?;
    let mut span = Span::default();
    let mut sequence = 0;
    while let Some(sample) = recording.next_sample()? {
        let Some((channel_id, topic)) = numbers.get(&sample.channel) else { continue };
        let (channel_id, date) = (*channel_id, sample.date);
        let header = MessageHeader { channel_id, sequence, log_time: date, publish_time: date };
        writer.write_to_known_channel(&header, &sample.message).map_err(failed)?;
        sequence = sequence.wrapping_add(1);
        span.add(date);
        if let Some(topic) = topics.get_mut(topic) {
            topic.messages += 1;
        }
    }
    writer.finish().map_err(failed)?;
    writer.into_inner().flush().map_err(|why| failed(why.into()))?;
    let topics: Vec<BagTopic> = topics.into_values().collect();
    let path = into.join(ABOUT);
    let about = fs::write(&path, about(&topics, span));
    about.map_err(|why| unwritten(&path, &why.into()))?;
    Ok(topics)
}

/// What `metadata.yaml` says. Names need no quotes: they are checked.
fn about(topics: &[BagTopic], span: Span) -> String {
    let messages: u64 = topics.iter().map(|topic| topic.messages).sum();
    let (start, duration) = (span.start(), span.duration());
    let listed: String = topics
        .iter()
        .map(|BagTopic { name, ty, messages }| {
            format!(
                "    - topic_metadata:\n        name: {name}\n        type: {ty}\n        \
                 serialization_format: cdr\n        offered_qos_profiles: \"\"\n      \
                 message_count: {messages}\n"
            )
        })
        .collect();
    format!(
        "rosbag2_bagfile_information:\n  version: {VERSION}\n  storage_identifier: {MCAP}\n  \
         duration:\n    nanoseconds: {duration}\n  starting_time:\n    nanoseconds_since_epoch: \
         {start}\n  message_count: {messages}\n  topics_with_message_count:\n{listed}  \
         compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - \
         {SAMPLES}\n  files:\n    - path: {SAMPLES}\n      starting_time:\n        \
         nanoseconds_since_epoch: {start}\n      duration:\n        nanoseconds: {duration}\n      \
         message_count: {messages}\n"
    )
}

/// The file with the samples: of a bag the one in its directory, otherwise the path itself.
///
/// # Errors
/// The directory cannot be read, or has none, several, or a bag in another format.
pub fn samples_of(path: &Path) -> Result<PathBuf, BagError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let entries = fs::read_dir(path).map_err(ReadError::from)?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let ends = |file: &&PathBuf, with: &str| file.extension().is_some_and(|it| it == with);
    let mut found = files.iter().filter(|file| ends(file, MCAP));
    match (found.next(), found.next()) {
        (Some(one), None) => Ok(one.clone()),
        (Some(_), Some(_)) => Err(BagError::NoBag {
            why: "it has several files, which are played one by one: name one of them".to_owned(),
        }),
        _ if files.iter().any(|file| ends(&file, "db3")) => Err(BagError::NoBag {
            why: "its format is sqlite3: `ros2 bag convert` makes one in MCAP of it".to_owned(),
        }),
        _ => Err(BagError::NoBag { why: "it is a directory without a file in MCAP".to_owned() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_ros() {
        for name in ["/demo/position", "demo/poses/left", "/a_1"] {
            assert!(is_topic(name), "{name}");
        }
        for name in ["/", "", "/demo//x", "/1st", "/demo/a b", "/demo/x: y", "/é"] {
            assert!(!is_topic(name), "{name}");
        }
        assert!(is_message("demo/msg/State"));
        for name in ["demo/State", "demo/srv/State", "State", "demo/msg/State/x", "demo/msg/"] {
            assert!(!is_message(name), "{name}");
        }
    }

    #[test]
    fn a_span_is_from_the_first_date_to_the_last_whatever_their_order() {
        let mut span = Span::default();
        assert_eq!((span.start(), span.duration()), (0, 0));
        [7, 3, 9].into_iter().for_each(|date| span.add(date));
        assert_eq!((span.start(), span.duration()), (3, 6));
    }

    #[test]
    fn a_directory_that_is_no_bag_says_what_it_is() {
        let place = tempfile::tempdir().unwrap();
        let told = || samples_of(place.path()).unwrap_err().to_string();
        assert_eq!(told(), "it is a directory without a file in MCAP");
        fs::write(place.path().join("x_0.db3"), "").unwrap();
        assert!(told().contains("ros2 bag convert"));
        fs::write(place.path().join("x_0.mcap"), "").unwrap();
        assert_eq!(samples_of(place.path()).unwrap(), place.path().join("x_0.mcap"));
        fs::write(place.path().join("x_1.mcap"), "").unwrap();
        assert!(told().contains("name one of them"));
    }
}
