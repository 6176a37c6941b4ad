//! The format in which recordings are sent: a sequence of frames, each `length: u32, kind: u8,
//! content`, little endian. The content is JSON, except for samples: `channel: u16, number: u32,
//! date: u64, message`.
//!
//! The first frame is a [`Start`], the last one an [`End`]; each [`Channel`] precedes its samples.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::{ClockKind, is_false};

/// Maximum length of a frame, in bytes.
const LONGEST: usize = 256 << 20;

const START: u8 = 0;
const CHANNEL: u8 = 1;
const SAMPLE: u8 = 2;
const LOST: u8 = 3;
const END: u8 = 4;
const UNTIL: u8 = 5;

/// Name, among what is to be recorded, of the subjects that the daemon reports itself; their topics
/// begin with it.
pub const EVENTS: &str = "genom";

/// What to record.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecordingRequest {
    /// Components, ports, and elements of multiple ports; everything if empty. [`EVENTS`] stands for
    /// the calls, activities and exceptions of all components.
    #[serde(default)]
    pub ports: Vec<String>,
    /// Record when samples were written and read, and a digest of each, in place of contents:
    /// channels of ports are then of encoding `times`.
    #[serde(default, skip_serializing_if = "is_false")]
    pub times: bool,
    /// On a stepped clock, samples of several processes come in order of their dates: those of a date
    /// once all processes are further, which takes the next step.
    #[serde(default, skip_serializing_if = "is_false")]
    pub ordered: bool,
}

/// A recording was asked to end.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecordingEnds {
    /// Always true: the recording ends once all samples taken until now are sent.
    pub ends: bool,
}

/// The first frame.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingStart))]
pub struct Start {
    /// Number of the recording, needed to end it.
    pub recording: u64,
    /// Version of genomd.
    pub genomd: String,
    /// The clock of the dates of samples.
    pub clock: ClockKind,
    /// What ran when the recording began, as text of a deployment file.
    pub deployment: String,
}

/// A port, or one of the subjects that the daemon reports itself: calls, activities, exceptions,
/// changes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingChannel))]
pub struct Channel {
    /// Number of the channel in the frames that follow.
    pub channel: u16,
    /// `/COMPONENT/PORT`, or `/genom/SUBJECT`.
    pub topic: String,
    /// `cdr`, `json` or `times`.
    pub encoding: String,
    /// Name of the schema of its messages.
    pub schema: String,
    /// The schema: a ROS 2 message definition, or a JSON Schema.
    pub definition: String,
    /// For a port: `direction`, `type`, and `reads`, the out port that feeds it.
    pub metadata: BTreeMap<String, String>,
}

/// The channels that a recording of everything would have now.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Channels {
    /// Those of the daemon's own subjects, then ports by component, as they are open or connected.
    pub channels: Vec<Channel>,
}

/// Total of samples of a channel that were dropped because the buffer was full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingLoss))]
pub struct Lost {
    /// Number of the channel.
    pub channel: u16,
    /// Number of samples dropped so far.
    pub lost: u64,
}

/// The last frame: everything before it was sent.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingEnd))]
pub struct End {
    /// Why the recording ended.
    pub why: String,
}

/// A sample of a port, or a report of the daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample<'a> {
    /// Number of its channel.
    pub channel: u16,
    /// Number of the sample, from 0 in each channel; dropped samples leave gaps.
    pub number: u32,
    /// When it was taken, in nanoseconds since 1970, or of the virtual clock.
    pub date: u64,
    /// CDR with its encapsulation header, JSON, or [`Times`].
    pub message: &'a [u8],
}

/// When a sample was written or read: the message of channels of encoding `times`, as four `u64`,
/// little endian, in this order. Dates are those of the machine's monotonic clock, in nanoseconds,
/// which all processes of a machine share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Times {
    /// When the codel's `write` or `read` began.
    pub begun: u64,
    /// When it ended.
    pub ended: u64,
    /// Of a sample that was read: since when it could have been; 0 is sent for `None`, where the
    /// middleware does not know, or samples can be read as soon as `write` has ended.
    pub arrived: Option<u64>,
    /// A digest of the content: equal for equal contents, within one version of genomd.
    pub digest: u64,
}

impl Times {
    /// How many bytes are sent.
    pub const BYTES: usize = 32;

    /// As it is sent.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let all = [self.begun, self.ended, self.arrived.unwrap_or(0), self.digest];
        for (place, number) in bytes.chunks_exact_mut(8).zip(all) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        bytes
    }

    /// Read from a message; `None` if it has another length.
    #[must_use]
    pub fn from_bytes(message: &[u8]) -> Option<Self> {
        let message: [u8; Self::BYTES] = message.try_into().ok()?;
        let (numbers, _) = message.as_chunks::<8>();
        let [begun, ended, arrived, digest] = numbers else { return None };
        let [begun, ended, arrived, digest] =
            [begun, ended, arrived, digest].map(|bytes| u64::from_le_bytes(*bytes));
        Some(Self { begun, ended, arrived: Some(arrived).filter(|date| *date > 0), digest })
    }
}

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Frame<'a> {
    /// The recording begins.
    Start(Start),
    /// Announces a channel.
    Channel(Channel),
    /// A sample comes.
    Sample(Sample<'a>),
    /// Samples were dropped.
    Lost(Lost),
    /// The recording ends.
    End(End),
    /// No sample that follows has an earlier date, in nanoseconds of the stepped clock. In
    /// [`RecordingRequest::ordered`] recordings of one process: those of several need none.
    Until(u64),
}

/// The bytes are not a valid frame.
#[derive(Debug, thiserror::Error)]
pub enum NoFrame {
    /// The length is above the limit.
    #[error("a frame of {0} bytes")]
    Length(usize),
    /// The kind is unknown.
    #[error("a frame of kind {0}")]
    Kind(u8),
    /// The content is shorter than the header of a sample.
    #[error("a sample without a head")]
    Sample,
    /// The content is not the JSON that its kind requires.
    #[error(transparent)]
    Content(#[from] serde_json::Error),
}

impl Frame<'_> {
    /// Appends the encoded frame to `out`.
    pub fn append(&self, out: &mut Vec<u8>) {
        match self {
            Self::Start(start) => append_json(out, START, start),
            Self::Channel(channel) => append_json(out, CHANNEL, channel),
            Self::Lost(lost) => append_json(out, LOST, lost),
            Self::End(end) => append_json(out, END, end),
            Self::Until(date) => append_json(out, UNTIL, date),
            Self::Sample(Sample { channel, number, date, message }) => {
                let head = [&channel.to_le_bytes()[..], &number.to_le_bytes(), &date.to_le_bytes()];
                append_parts(out, SAMPLE, &[head[0], head[1], head[2], message]);
            }
        }
    }
}

impl<'a> Frame<'a> {
    /// Decodes the first frame of `bytes`, and returns it with its length; `None` if it is not
    /// complete.
    ///
    /// # Errors
    /// The bytes are not a valid frame.
    pub fn first(bytes: &'a [u8]) -> Result<Option<(Self, usize)>, NoFrame> {
        let Some(length) = complete(bytes)? else { return Ok(None) };
        let (kind, content) = (bytes[4], &bytes[5..length]);
        let frame = match kind {
            START => Self::Start(read(content)?),
            CHANNEL => Self::Channel(read(content)?),
            SAMPLE => Self::Sample(sample(content).ok_or(NoFrame::Sample)?),
            LOST => Self::Lost(read(content)?),
            END => Self::End(read(content)?),
            UNTIL => Self::Until(read(content)?),
            other => return Err(NoFrame::Kind(other)),
        };
        Ok(Some((frame, length)))
    }
}

/// Length of the first frame of `bytes`; `None` if it is not complete.
///
/// # Errors
/// The length is above the limit.
pub fn complete(bytes: &[u8]) -> Result<Option<usize>, NoFrame> {
    let Some((length, rest)) = bytes.split_first_chunk::<4>() else { return Ok(None) };
    let length = u32::from_le_bytes(*length) as usize;
    if length == 0 || length > LONGEST {
        return Err(NoFrame::Length(length));
    }
    Ok((rest.len() >= length).then_some(4 + length))
}

fn append_json(out: &mut Vec<u8>, kind: u8, content: &impl Serialize) {
    // None of the contents can fail to serialise.
    let text = serde_json::to_vec(content).unwrap_or_default();
    append_parts(out, kind, &[&text]);
}

fn append_parts(out: &mut Vec<u8>, kind: u8, parts: &[&[u8]]) {
    let length: usize = 1 + parts.iter().map(|part| part.len()).sum::<usize>();
    out.extend_from_slice(&u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    out.push(kind);
    for part in parts {
        out.extend_from_slice(part);
    }
}

fn read<T: DeserializeOwned>(content: &[u8]) -> Result<T, NoFrame> {
    Ok(serde_json::from_slice(content)?)
}

fn sample(content: &[u8]) -> Option<Sample<'_>> {
    let (channel, rest) = content.split_first_chunk::<2>()?;
    let (number, rest) = rest.split_first_chunk::<4>()?;
    let (date, message) = rest.split_first_chunk::<8>()?;
    Some(Sample {
        channel: u16::from_le_bytes(*channel),
        number: u32::from_le_bytes(*number),
        date: u64::from_le_bytes(*date),
        message,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_read_back_as_written_when_they_are_complete() {
        let frames = [
            Frame::Start(Start {
                recording: 7,
                genomd: "1.0".to_owned(),
                clock: ClockKind::Virtual,
                deployment: String::new(),
            }),
            Frame::Sample(Sample { channel: 3, number: 7, date: 9, message: &[0xAA, 0xBB] }),
            Frame::Lost(Lost { channel: 3, lost: 2 }),
            Frame::Until(1 << 60),
            Frame::End(End { why: "asked".to_owned() }),
        ];
        for frame in &frames {
            let mut bytes = Vec::new();
            frame.append(&mut bytes);
            for end in 0..bytes.len() {
                assert!(matches!(Frame::first(&bytes[..end]), Ok(None)), "{end}");
            }
            let length = bytes.len();
            bytes.push(0xFF);
            assert_eq!(Frame::first(&bytes).unwrap(), Some((frame.clone(), length)));
        }
    }

    #[test]
    fn a_sample_has_its_head_before_its_message() {
        let mut bytes = Vec::new();
        Frame::Sample(Sample { channel: 3, number: 7, date: 9, message: &[0xAA] })
            .append(&mut bytes);
        let head = [16, 0, 0, 0, SAMPLE, 3, 0, 7, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0xAA];
        assert_eq!(bytes, head);
    }

    #[test]
    fn times_are_read_back_as_sent() {
        for arrived in [None, Some(5)] {
            let times = Times { begun: 3, ended: 1 << 40, arrived, digest: u64::MAX };
            assert_eq!(Times::from_bytes(&times.to_bytes()), Some(times));
        }
        assert_eq!(Times::from_bytes(&[0; 31]), None);
    }

    #[test]
    fn nonsense_is_refused() {
        for bytes in [
            &[0, 0, 0, 0][..],
            &[1, 0, 0, 0, 99],
            &[255; 4],
            &[2, 0, 0, 0, LOST, b'x'],
            &[2, 0, 0, 0, SAMPLE, 0],
        ] {
            assert!(Frame::first(bytes).is_err(), "{bytes:?}");
        }
    }
}
