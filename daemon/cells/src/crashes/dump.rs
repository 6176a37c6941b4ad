//! A minidump of a process that has crashed and waits to end: registers and stacks of all threads,
//! as Breakpad's tools read them.

use std::io::{self, Cursor, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use minidump_writer::minidump_writer::MinidumpWriterConfig;

/// Most bytes of one.
const MOST: u64 = 16 << 20;

/// Why there is none.
#[derive(Clone, Debug, thiserror::Error)]
pub(crate) enum DumpError {
    /// The process could not be looked at.
    #[error("no minidump: {0}")]
    Looked(String),
    /// It is larger than it may be.
    #[error("no minidump: it would have {0} bytes, {MOST} at most")]
    Large(usize),
}

/// What becomes of the one request that a process makes when it crashes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dump(Arc<Mutex<Option<Taken>>>);

/// The bytes of a minidump, or why there are none.
pub(crate) type Taken = Result<Vec<u8>, DumpError>;

impl Dump {
    /// What was taken, if the process asked.
    pub(crate) fn taken(&self) -> Option<Taken> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Waits for the request of a process, on a thread of its own that sleeps: who looks at a
    /// process has to be one thread, and is stopped with it for a moment.
    pub(crate) fn await_request(&self, pid: i32, mut socket: UnixStream) -> io::Result<()> {
        let taken = self.clone();
        let wait = move || {
            let mut number = [0; 4];
            // The other end is closed when the process ends.
            if socket.read_exact(&mut number).is_err() {
                return;
            }
            let dump = take(pid, i32::from_le_bytes(number));
            *taken.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(dump);
            let _ = socket.write_all(&[0]);
        };
        thread::Builder::new().name("cell-dump".to_owned()).spawn(wait).map(drop)
    }
}

fn take(pid: i32, thread: i32) -> Taken {
    let mut config = MinidumpWriterConfig::new(pid, thread);
    config.set_minidump_size_limit(MOST);
    let bytes = config.write(&mut Cursor::new(Vec::new()));
    let bytes = bytes.map_err(|error| DumpError::Looked(error.to_string()))?;
    match bytes.len() {
        length if length as u64 > MOST => Err(DumpError::Large(length)),
        _ => Ok(bytes),
    }
}
