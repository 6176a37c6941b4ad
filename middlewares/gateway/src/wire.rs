//! Frames on a stream: four bytes of length, a byte that says what it is, and the rest.
//!
//! A sample is the number of its end and a message in CDR. A message is the length of its JSON,
//! the JSON, and what belongs to it.

use std::io::{self, BufReader, Read, Write};
use std::os::unix::net::UnixStream;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Greatest length of a frame in bytes.
pub(crate) const MOST: usize = 256 << 20;

/// A buffer that grew beyond this is not kept for small frames.
const KEPT: usize = 16 << 20;

/// Room for the first bytes of a frame.
const STEP: usize = 64 << 10;

const SAMPLE: u8 = 0;
const MESSAGE: u8 = 1;

/// A frame that was read.
#[derive(Debug)]
pub(crate) enum Frame<'a, M> {
    Sample { end: u32, message: &'a [u8] },
    Message(M, &'a [u8]),
}

fn garbage(why: impl std::fmt::Display) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.to_string())
}

fn length(size: usize) -> io::Result<[u8; 4]> {
    let fits = u32::try_from(size).ok().filter(|_| size <= MOST);
    Ok(fits.ok_or_else(|| garbage(format!("a frame of {size} bytes")))?.to_le_bytes())
}

/// The frame of a message, with what belongs to it.
pub(crate) fn message(words: &impl Serialize, payload: &[u8]) -> io::Result<Vec<u8>> {
    let json = serde_json::to_vec(words)?;
    let mut frame = Vec::with_capacity(9 + json.len() + payload.len());
    frame.extend(length(5 + json.len() + payload.len())?);
    frame.push(MESSAGE);
    frame.extend(length(json.len())?);
    frame.extend(json);
    frame.extend(payload);
    Ok(frame)
}

/// Writes the frame of a sample. A small one is put together in `scratch`, so that it takes one
/// system call.
pub(crate) fn write_sample(
    stream: &mut impl Write,
    end: u32,
    sample: &[u8],
    scratch: &mut Vec<u8>,
) -> io::Result<()> {
    const SMALL: usize = 64 << 10;
    scratch.clear();
    scratch.extend(length(5 + sample.len())?);
    scratch.push(SAMPLE);
    scratch.extend(end.to_le_bytes());
    if sample.len() <= SMALL {
        scratch.extend(sample);
        return stream.write_all(scratch);
    }
    stream.write_all(scratch)?;
    stream.write_all(sample)
}

/// Reads frames.
#[derive(Debug)]
pub(crate) struct Frames<R = UnixStream> {
    stream: BufReader<R>,
    /// As long as the longest frame that was read, and not shortened: it need not be cleared.
    buffer: Vec<u8>,
}

impl<R: Read> Frames<R> {
    pub(crate) fn new(stream: R) -> Self {
        Self { stream: BufReader::with_capacity(64 << 10, stream), buffer: Vec::new() }
    }

    /// The next frame; `None` at the end of the stream.
    pub(crate) fn next<M: DeserializeOwned>(&mut self) -> io::Result<Option<Frame<'_, M>>> {
        let mut head = [0; 4];
        if self.stream.read(&mut head[..1])? == 0 {
            return Ok(None);
        }
        self.stream.read_exact(&mut head[1..])?;
        let size = u32::from_le_bytes(head) as usize;
        if size > MOST {
            return Err(garbage(format!("a frame of {size} bytes")));
        }
        if self.buffer.len() > KEPT && size < KEPT / 16 {
            self.buffer = Vec::new();
        }
        // Memory is taken as bytes arrive, whatever length is claimed; what a frame before took is
        // read into at once.
        let mut read = 0;
        while read < size {
            let room = self.buffer.len().max(2 * read).max(STEP).min(size);
            if room > self.buffer.len() {
                self.buffer.resize(room, 0);
            }
            self.stream.read_exact(self.buffer.get_mut(read..room).unwrap_or_default())?;
            read = room;
        }
        let frame = self.buffer.get(..size).unwrap_or_default();
        let (&kind, rest) = frame.split_first().ok_or_else(|| garbage("an empty frame"))?;
        let (word, rest) =
            rest.split_first_chunk::<4>().ok_or_else(|| garbage("a frame without a head"))?;
        let word = u32::from_le_bytes(*word);
        match kind {
            SAMPLE => Ok(Some(Frame::Sample { end: word, message: rest })),
            MESSAGE => {
                let cut = rest.split_at_checked(word as usize);
                let (json, payload) = cut.ok_or_else(|| garbage("a message that is cut off"))?;
                let words = serde_json::from_slice(json).map_err(garbage)?;
                Ok(Some(Frame::Message(words, payload)))
            }
            other => Err(garbage(format!("a frame of kind {other}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_as_they_were_written() {
        let (mut stream, mut scratch) = (Vec::new(), Vec::new());
        write_sample(&mut stream, 7, b"sample", &mut scratch).unwrap();
        stream.extend(message(&("words", 3), b"payload").unwrap());
        write_sample(&mut stream, 8, &vec![9; 100_000], &mut scratch).unwrap();
        let mut frames = Frames::new(&stream[..]);
        let read = frames.next::<()>().unwrap().unwrap();
        assert!(matches!(read, Frame::Sample { end: 7, message: b"sample" }));
        let read = frames.next::<(String, u8)>().unwrap().unwrap();
        assert!(matches!(&read, Frame::Message((word, 3), b"payload") if word == "words"));
        let read = frames.next::<()>().unwrap().unwrap();
        assert!(matches!(read, Frame::Sample { end: 8, message } if message == [9; 100_000]));
        assert!(frames.next::<()>().unwrap().is_none());
    }

    #[test]
    fn garbage_is_an_error_and_takes_no_memory() {
        let cases: [&[u8]; 7] = [
            &[0xff; 4],
            &[0, 0, 0, 0],
            &[4, 0, 0, 0, 0, 1, 2, 3],
            &[5, 0, 0, 0, 9, 1, 2, 3, 4],
            &[6, 0, 0, 0, 1, 2, 0, 0, 0, b'{'],
            &[7, 0, 0, 0, 1, 2, 0, 0, 0, b'{', b'}'],
            &[0, 0, 0, 0x0f, 0, 1, 2, 3],
        ];
        for bytes in cases {
            let mut frames = Frames::new(bytes);
            assert!(frames.next::<(u8, u8)>().is_err(), "{bytes:?}");
            assert!(frames.buffer.capacity() < 1 << 20, "{bytes:?}");
        }
    }
}
