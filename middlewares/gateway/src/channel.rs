//! The way out of a process: one stream, a queue of messages, and the thread that writes both them
//! and samples.

use std::collections::VecDeque;
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use genom_kit::sender::{Duty, Line};
use serde::Serialize;

use crate::wire;

/// Bytes of messages that may wait to be written. A peer that reads so little is stuck.
const WAITING: usize = 64 << 20;

/// How long one write may take before the peer counts as stuck.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

/// A lock that a panic elsewhere does not take away.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The way out, shared by all that has something to send.
#[derive(Debug, Default)]
pub(crate) struct Channel {
    way: Mutex<Way>,
    queue: Mutex<Queue>,
}

#[derive(Debug, Default)]
struct Way {
    stream: Option<UnixStream>,
    scratch: Vec<u8>,
}

#[derive(Debug, Default)]
struct Queue {
    /// Which stream the messages are for; 0 while there is none.
    generation: u64,
    frames: VecDeque<Vec<u8>>,
    bytes: usize,
}

/// Why a message was not queued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NotQueued {
    /// The stream that it was for is closed.
    Closed,
    /// Too much waits already, or the message is too long.
    Full,
}

impl Channel {
    /// From now on, what is sent goes to this stream.
    pub(crate) fn open(&self, stream: UnixStream, generation: u64) {
        *lock(&self.queue) = Queue { generation, ..Queue::default() };
        lock(&self.way).stream = Some(stream);
    }

    /// From now on, nothing is sent. Whoever calls this has shut the stream down, so that no write
    /// is under way for long.
    pub(crate) fn close(&self) {
        *lock(&self.queue) = Queue::default();
        lock(&self.way).stream = None;
    }

    /// Queues a message for the stream of this generation. Ring the sending thread's bell then.
    pub(crate) fn put(
        &self,
        generation: u64,
        words: &impl Serialize,
        payload: &[u8],
    ) -> Result<(), NotQueued> {
        let frame = wire::message(words, payload).map_err(|_| NotQueued::Full)?;
        self.put_frame(generation, frame)
    }

    /// The same with a message that is a frame already.
    pub(crate) fn put_frame(&self, generation: u64, frame: Vec<u8>) -> Result<(), NotQueued> {
        let mut queue = lock(&self.queue);
        if queue.generation != generation || generation == 0 {
            return Err(NotQueued::Closed);
        }
        if queue.bytes + frame.len() > WAITING.max(frame.len()) {
            return Err(NotQueued::Full);
        }
        queue.bytes += frame.len();
        queue.frames.push_back(frame);
        Ok(())
    }

    fn take(&self) -> Option<Vec<u8>> {
        let mut queue = lock(&self.queue);
        let frame = queue.frames.pop_front()?;
        queue.bytes -= frame.len();
        Some(frame)
    }

    /// Writes all messages that wait.
    fn flush(&self) {
        while let Some(frame) = self.take() {
            self.write(|stream, _| stream.write_all(&frame));
        }
    }

    /// Writes a sample. Returns false when there is nobody to read it.
    pub(crate) fn sample(&self, end: u32, sample: &[u8]) -> bool {
        self.write(|stream, scratch| wire::write_sample(stream, end, sample, scratch))
    }

    fn write(
        &self,
        write: impl FnOnce(&mut UnixStream, &mut Vec<u8>) -> std::io::Result<()>,
    ) -> bool {
        let mut way = lock(&self.way);
        let Way { stream, scratch } = &mut *way;
        let Some(open) = stream else { return false };
        let written = write(open, scratch);
        if let Err(error) = &written {
            // A frame may have been written in part: the reading thread sees the end.
            tracing::debug!(%error, "what a gateway and its users say does not get through");
            let _ = open.shutdown(std::net::Shutdown::Both);
            *stream = None;
        }
        written.is_ok()
    }
}

/// What the sending thread does beside sending samples: it writes messages.
pub(crate) struct Outgoing<L> {
    pub(crate) channel: Arc<Channel>,
    /// Called after each ring; returns when to be called again.
    pub(crate) due: Box<dyn FnMut() -> Option<Duration> + Send>,
    _line: std::marker::PhantomData<fn(L)>,
}

impl<L> Outgoing<L> {
    pub(crate) fn new(
        channel: &Arc<Channel>,
        due: impl FnMut() -> Option<Duration> + Send + 'static,
    ) -> Self {
        let channel = Arc::clone(channel);
        Self { channel, due: Box::new(due), _line: std::marker::PhantomData }
    }
}

impl<L: Line> Duty for Outgoing<L> {
    type Line = L;

    fn due(&mut self, _: &genom_kit::lines::Lines<L>) -> Option<Duration> {
        let next = (self.due)();
        self.channel.flush();
        next
    }
}
