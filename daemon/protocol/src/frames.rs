//! What a recording is sent as: frames in a row, each `length: u32, kind: u8, content`, little
//! endian. The content is JSON, but for samples: `channel: u16, number: u32, date: u64, message`.
//!
//! The first frame is a [`Start`], the last one an [`End`]; each [`Channel`] comes before its
//! samples.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::ClockKind;

/// A longer frame is none.
const LONGEST: usize = 256 << 20;

const START: u8 = 0;
const CHANNEL: u8 = 1;
const SAMPLE: u8 = 2;
const LOST: u8 = 3;
const END: u8 = 4;

/// What to record.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecordingRequest {
    /// Components, ports, elements of multiple ports; everything when empty.
    #[serde(default)]
    pub ports: Vec<String>,
}

/// A recording that ends.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecordingEnds {
    /// It does, once all is sent that was taken until now.
    pub ends: bool,
}

/// The first frame.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingStart))]
pub struct Start {
    /// Number of the recording, to end it.
    pub recording: u64,
    /// Version of the daemon.
    pub genomd: String,
    /// The clock that dates the samples.
    pub clock: ClockKind,
    /// What ran when it began, as a deployment file.
    pub deployment: String,
}

/// A port, or a subject of notes: calls, activities, exceptions, changes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingChannel))]
pub struct Channel {
    /// Its number in the frames that follow.
    pub channel: u16,
    /// `/COMPONENT/PORT`, or `/genom/SUBJECT`.
    pub topic: String,
    /// `cdr` or `json`.
    pub encoding: String,
    /// Name of the schema.
    pub schema: String,
    /// The schema: a ROS 2 message definition, or a JSON Schema.
    pub definition: String,
    /// Of a port: `direction`, `type`, and `reads`, the out port that feeds it.
    pub metadata: BTreeMap<String, String>,
}

/// Samples of a channel that found no room, so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingLoss))]
pub struct Lost {
    /// The channel.
    pub channel: u16,
    /// How many.
    pub lost: u64,
}

/// The last frame: everything was sent.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = RecordingEnd))]
pub struct End {
    /// Why the recording ended.
    pub why: String,
}

/// A sample or a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample<'a> {
    /// Its channel.
    pub channel: u16,
    /// From 0 in each channel, without gaps but for lost samples.
    pub number: u32,
    /// When it was taken, in nanoseconds since 1970 or on the virtual clock.
    pub date: u64,
    /// CDR with its encapsulation header, or JSON.
    pub message: &'a [u8],
}

/// One frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Frame<'a> {
    /// The recording begins.
    Start(Start),
    /// A channel comes.
    Channel(Channel),
    /// A sample comes.
    Sample(Sample<'a>),
    /// Samples were lost.
    Lost(Lost),
    /// The recording is over.
    End(End),
}

/// Bytes that are no frames.
#[derive(Debug, thiserror::Error)]
pub enum NoFrame {
    /// A length that no frame has.
    #[error("a frame of {0} bytes")]
    Length(usize),
    /// A kind that is not known.
    #[error("a frame of kind {0}")]
    Kind(u8),
    /// A sample that is too short.
    #[error("a sample without a head")]
    Sample,
    /// A content that is not what its kind says.
    #[error(transparent)]
    Content(#[from] serde_json::Error),
}

impl Frame<'_> {
    /// Appends the frame.
    pub fn append(&self, out: &mut Vec<u8>) {
        match self {
            Self::Start(start) => append_json(out, START, start),
            Self::Channel(channel) => append_json(out, CHANNEL, channel),
            Self::Lost(lost) => append_json(out, LOST, lost),
            Self::End(end) => append_json(out, END, end),
            Self::Sample(Sample { channel, number, date, message }) => {
                let head = [&channel.to_le_bytes()[..], &number.to_le_bytes(), &date.to_le_bytes()];
                append_parts(out, SAMPLE, &[head[0], head[1], head[2], message]);
            }
        }
    }
}

impl<'a> Frame<'a> {
    /// The first frame of these bytes and its length; `None` when it is not complete.
    ///
    /// # Errors
    /// The bytes are no frames.
    pub fn first(bytes: &'a [u8]) -> Result<Option<(Self, usize)>, NoFrame> {
        let Some(length) = complete(bytes)? else { return Ok(None) };
        let (kind, content) = (bytes[4], &bytes[5..length]);
        let frame = match kind {
            START => Self::Start(read(content)?),
            CHANNEL => Self::Channel(read(content)?),
            SAMPLE => Self::Sample(sample(content).ok_or(NoFrame::Sample)?),
            LOST => Self::Lost(read(content)?),
            END => Self::End(read(content)?),
            other => return Err(NoFrame::Kind(other)),
        };
        Ok(Some((frame, length)))
    }
}

/// Length of the first frame of these bytes; `None` when it is not complete.
///
/// # Errors
/// No frame has the length that is said.
pub fn complete(bytes: &[u8]) -> Result<Option<usize>, NoFrame> {
    let Some((length, rest)) = bytes.split_first_chunk::<4>() else { return Ok(None) };
    let length = u32::from_le_bytes(*length) as usize;
    if length == 0 || length > LONGEST {
        return Err(NoFrame::Length(length));
    }
    Ok((rest.len() >= length).then_some(4 + length))
}

fn append_json(out: &mut Vec<u8>, kind: u8, content: &impl Serialize) {
    // None of the contents can fail to be JSON.
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
