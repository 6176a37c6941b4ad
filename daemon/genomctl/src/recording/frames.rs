//! Cuts a recording as the daemon sends it into frames: each `length: u32, kind: u8, content`,
//! little endian. The daemon has the same rule.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::body::Body;
use crate::failure::Failure;

/// A frame longer than this is none.
const LONGEST: usize = 256 << 20;

/// What the daemon tells.
#[derive(Debug)]
pub(crate) enum Frame {
    Start(Start),
    Channel(Channel),
    Sample(Sample),
    Lost(Lost),
    /// Everything was sent.
    End,
}

/// The first frame.
#[derive(Debug, Deserialize)]
pub(crate) struct Start {
    /// Number of the recording, to end it.
    pub(crate) recording: u64,
    /// Version of the daemon.
    pub(crate) genomd: String,
    /// `monotonic` or `virtual`.
    pub(crate) clock: String,
    /// What ran when it began, as a deployment file.
    pub(crate) deployment: String,
}

/// A port, or a subject of notes.
#[derive(Debug, Deserialize)]
pub(crate) struct Channel {
    /// Its number in the frames that follow.
    pub(crate) channel: u16,
    pub(crate) topic: String,
    /// `cdr` or `json`.
    pub(crate) encoding: String,
    /// Name of the schema.
    pub(crate) schema: String,
    pub(crate) definition: String,
    pub(crate) metadata: BTreeMap<String, String>,
}

/// A sample or a note.
#[derive(Debug)]
pub(crate) struct Sample {
    pub(crate) channel: u16,
    pub(crate) number: u32,
    pub(crate) date: u64,
    pub(crate) message: Vec<u8>,
}

/// Samples of a channel that found no room, so far.
#[derive(Debug, Deserialize)]
pub(crate) struct Lost {
    pub(crate) channel: u16,
    pub(crate) lost: u64,
}

/// The frames of one recording, in order.
pub(crate) struct Frames {
    body: Body,
    /// Bytes that are not handed over yet.
    bytes: Vec<u8>,
    /// How many of them are.
    done: usize,
}

impl Frames {
    pub(crate) fn new(body: Body) -> Self {
        Self { body, bytes: Vec::new(), done: 0 }
    }

    /// The next frame; `None` when the daemon went away or sent nonsense, a failure when it answers
    /// nobody any more. May be dropped and called again.
    pub(crate) async fn next(&mut self) -> Result<Option<Frame>, Failure> {
        loop {
            match cut(&self.bytes[self.done..]) {
                Err(_) => return Ok(None),
                Ok(Some((frame, length))) => {
                    self.done += length;
                    return Ok(Some(frame));
                }
                Ok(None) => {}
            }
            self.bytes.drain(..self.done);
            self.done = 0;
            let Some(bytes) = self.body.next().await? else { return Ok(None) };
            self.bytes.extend_from_slice(&bytes);
        }
    }
}

/// The first frame and its length; `None` when it is not complete.
fn cut(bytes: &[u8]) -> Result<Option<(Frame, usize)>, String> {
    let Some((length, rest)) = bytes.split_first_chunk::<4>() else { return Ok(None) };
    let length = u32::from_le_bytes(*length) as usize;
    if length == 0 || length > LONGEST {
        return Err(format!("a frame of {length} bytes"));
    }
    let Some(frame) = rest.get(..length) else { return Ok(None) };
    let (kind, content) = (frame[0], &frame[1..]);
    let frame = match kind {
        0 => Frame::Start(told(content)?),
        1 => Frame::Channel(told(content)?),
        2 => Frame::Sample(sample(content).ok_or("a sample without a head")?),
        3 => Frame::Lost(told(content)?),
        4 => Frame::End,
        other => return Err(format!("a frame of kind {other}")),
    };
    Ok(Some((frame, 4 + length)))
}

fn told<T: serde::de::DeserializeOwned>(content: &[u8]) -> Result<T, String> {
    serde_json::from_slice(content).map_err(|error| error.to_string())
}

fn sample(content: &[u8]) -> Option<Sample> {
    let (channel, rest) = content.split_first_chunk::<2>()?;
    let (number, rest) = rest.split_first_chunk::<4>()?;
    let (date, message) = rest.split_first_chunk::<8>()?;
    Some(Sample {
        channel: u16::from_le_bytes(*channel),
        number: u32::from_le_bytes(*number),
        date: u64::from_le_bytes(*date),
        message: message.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_cut_when_it_is_complete_and_nonsense_is_refused() {
        let content = [3, 0, 7, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0xAA, 0xBB];
        let mut bytes = 17_u32.to_le_bytes().to_vec();
        bytes.push(2);
        bytes.extend(content);
        for cut_at in 0..bytes.len() {
            assert!(matches!(cut(&bytes[..cut_at]), Ok(None)), "{cut_at}");
        }
        bytes.push(0xFF);
        let Ok(Some((Frame::Sample(sample), 21))) = cut(&bytes) else { panic!("no sample") };
        assert_eq!((sample.channel, sample.number, sample.date), (3, 7, 9));
        assert_eq!(sample.message, [0xAA, 0xBB]);
        assert!(cut(&[0, 0, 0, 0]).is_err());
        assert!(cut(&[1, 0, 0, 0, 99]).is_err());
        assert!(cut(&[255, 255, 255, 255]).is_err());
        assert!(cut(&[2, 0, 0, 0, 3, b'x']).is_err());
    }
}
