//! Writes a recording: takes the frames that a client would get.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use genom_protocol::frames::Frame;
use genom_recording::{Recorder, WriteError};
use tokio::runtime::Handle;
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::active::{Active, Ended, Stage};
use super::base::lock;
use super::store::Kept;

/// How often the file is saved, and its limit looked at.
const SAVE: Duration = Duration::from_secs(1);

impl Kept {
    /// Writes the frames of a recording to its file, until they end or there is no more room. Blocks
    /// as long as that takes.
    pub fn write(&self, active: &Active, frames: mpsc::Receiver<Vec<u8>>) {
        let why = match self.taken(active, frames) {
            Ok(why) => why,
            Err(error) => {
                tracing::error!("recordings: {error}");
                error.to_string()
            }
        };
        let messages = active.messages.load(Ordering::Relaxed);
        let lost = active.lost.load(Ordering::Relaxed);
        let file = &active.file;
        if active.number.get().is_none() {
            // Nothing began: there is nothing to read in it.
            let _ = std::fs::remove_file(&active.path);
        }
        tracing::info!("recording {file} ended ({why}): {messages} messages, {lost} lost");
        lock(&self.ended).insert(file.clone(), Ended { why, lost });
        lock(&self.under_way).remove(file);
        active.stage.send_replace(Stage::Over);
    }

    /// Why it ended.
    fn taken(
        &self,
        active: &Active,
        mut frames: mpsc::Receiver<Vec<u8>>,
    ) -> Result<String, WriteError> {
        let room = self.room_for(0);
        let mut writer = Writer { active, room, recorder: None, rest: Vec::new() };
        let mut saved = Instant::now();
        let ended = loop {
            // Frames may be far apart, and the file is saved meanwhile.
            let next = Handle::current().block_on(timeout(SAVE, frames.recv()));
            let taken = match next {
                Ok(Some(bytes)) => writer.take(&bytes),
                Ok(None) => break Ok(None),
                Err(_) => Ok(None),
            };
            match taken {
                Ok(None) => {}
                ended => break ended,
            }
            if saved.elapsed() >= SAVE {
                saved = Instant::now();
                if let Some(recorder) = &mut writer.recorder {
                    recorder.save()?;
                    recorder.limit(self.room_for(recorder.bytes()));
                }
            }
        };
        // Whoever sends frames stops with this.
        drop(frames);
        let Some(recorder) = writer.recorder else { return Ok("it did not begin".to_owned()) };
        let channels = recorder.finish(matches!(ended, Ok(Some(_))))?;
        let messages = channels.iter().map(|one| one.messages).sum();
        let lost = channels.iter().map(|one| one.lost).sum();
        active.messages.store(messages, Ordering::Relaxed);
        active.lost.store(lost, Ordering::Relaxed);
        match ended {
            Ok(Some(why)) => Ok(why),
            Ok(None) => Ok("what was recorded is gone".to_owned()),
            Err(error @ WriteError::Full { .. }) => {
                tracing::warn!("recordings: {error}");
                Ok(error.to_string())
            }
            Err(error) => Err(error),
        }
    }

    /// How large a file may become that has so many bytes, of as many as there are under way.
    fn room_for(&self, has: u64) -> u64 {
        let taken = self.bytes(&self.names());
        let left = self.shelf.most_bytes.saturating_sub(taken);
        let sharing = lock(&self.under_way).len().max(1) as u64;
        has.saturating_add(left / sharing)
    }
}

struct Writer<'a> {
    active: &'a Active,
    /// Bytes that the file may have at first.
    room: u64,
    recorder: Option<Recorder>,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
}

impl Writer<'_> {
    /// Takes bytes of the stream; why it ended, when it has.
    fn take(&mut self, bytes: &[u8]) -> Result<Option<String>, WriteError> {
        self.rest.extend_from_slice(bytes);
        let rest = std::mem::take(&mut self.rest);
        let mut at = 0;
        let mut ended = None;
        while ended.is_none() {
            match Frame::first(&rest[at..]) {
                Ok(Some((frame, length))) => {
                    ended = self.frame(frame)?;
                    at += length;
                }
                Ok(None) => break,
                Err(error) => return Err(self.broken(error.to_string())),
            }
        }
        self.rest.extend_from_slice(&rest[at..]);
        if let Some(recorder) = &self.recorder {
            let (messages, lost) = recorder.counts();
            self.active.messages.store(messages, Ordering::Relaxed);
            self.active.lost.store(lost, Ordering::Relaxed);
        }
        Ok(ended)
    }

    fn frame(&mut self, frame: Frame<'_>) -> Result<Option<String>, WriteError> {
        match (frame, &mut self.recorder) {
            (Frame::Start(start), recorder @ None) => {
                let made = lock(&self.active.made).take();
                let made = made.ok_or_else(|| {
                    let (path, why) =
                        (self.active.path.clone(), "it is written already".to_owned());
                    WriteError::Broken { path, written: 0, why }
                })?;
                let mut begun = Recorder::new("genomd", &self.active.path, made, &start)?;
                begun.limit(self.room);
                *recorder = Some(begun);
                let _ = self.active.number.set(start.recording);
                self.active.stage.send_replace(Stage::Recording);
            }
            (Frame::Channel(channel), Some(recorder)) => recorder.channel(channel)?,
            (Frame::Sample(sample), Some(recorder)) => recorder.sample(&sample)?,
            (Frame::Lost(lost), Some(recorder)) => recorder.lost(lost),
            (Frame::Until(_), Some(_)) => {}
            (Frame::End(end), _) => return Ok(Some(end.why)),
            (Frame::Start(_), Some(_)) | (_, None) => {
                return Err(self.broken("a recording that does not begin".to_owned()));
            }
        }
        Ok(None)
    }

    fn broken(&self, why: String) -> WriteError {
        let written = self.recorder.as_ref().map_or(0, Recorder::bytes);
        WriteError::Broken { path: self.active.path.clone(), written, why }
    }
}
