//! What goes to one proxy.

use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, OnceLock};

use crate::channel::{Channel, NotQueued};
use crate::words::Down;

/// The only generation: a connection that broke is not mended, the proxy makes another one.
const GENERATION: u64 = 1;

/// Wakes the thread that sends.
type Ring = Box<dyn Fn() + Send + Sync>;

/// The way to one proxy.
pub(super) struct Mouth {
    pub(super) channel: Arc<Channel>,
    stream: UnixStream,
    ring: OnceLock<Ring>,
}

impl Mouth {
    pub(super) fn new(stream: UnixStream) -> Self {
        Self { channel: Arc::default(), stream, ring: OnceLock::new() }
    }

    /// From now on, what is said is sent by the thread that this wakes.
    pub(super) fn open(&self, ring: Ring) -> std::io::Result<()> {
        self.channel.open(self.stream.try_clone()?, GENERATION);
        let _ = self.ring.set(ring);
        Ok(())
    }

    /// Nothing more is sent.
    pub(super) fn close(&self) {
        let _ = self.stream.shutdown(Shutdown::Both);
        self.channel.close();
    }

    /// Queues a message. A proxy that does not read what it is told is given up.
    pub(super) fn say(&self, down: &Down, payload: &[u8]) {
        if self.channel.put(GENERATION, down, payload) == Err(NotQueued::Full) {
            tracing::warn!("a process does not read what the gateway tells it");
            let _ = self.stream.shutdown(Shutdown::Both);
        }
        if let Some(ring) = self.ring.get() {
            ring();
        }
    }

    /// Sends a sample, on the thread that sends.
    pub(super) fn sample(&self, end: u32, message: &[u8]) -> bool {
        self.channel.sample(end, message)
    }
}
