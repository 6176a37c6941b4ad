//! The bell of a daemon: who needs a gateway knocks there, sends a line with the name of the
//! middleware, and reads why there is none, or nothing when there is one.

use std::io;
use std::path::Path;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use genom_gateway::Door;
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader, Interest};
use tokio::net::{UnixDatagram, UnixStream};
use tokio::task::JoinHandle;
use tokio::time::timeout;

/// Why there is no gateway of this middleware; nothing when there is one.
pub(crate) type Answer =
    dyn Fn(String) -> Pin<Box<dyn Future<Output = Option<String>> + Send>> + Send + Sync;

/// How long whoever connects may take to say what it needs.
const PATIENCE: Duration = Duration::from_secs(2);

/// Longest line that is read, in bytes.
const LONGEST: u64 = 64;

/// Those that may wait for an answer at once; others wait to be heard.
const MOST: usize = 64;

/// The bell; nobody hears it any more when it is dropped.
#[derive(Debug)]
pub(crate) struct Bell {
    hearing: JoinHandle<()>,
}

impl Drop for Bell {
    fn drop(&mut self) {
        self.hearing.abort();
    }
}

impl Bell {
    /// Hangs it up at this path, for this user alone, and starts gateways for who rings.
    pub(crate) fn hang(path: &Path, answers: Arc<Answer>) -> io::Result<Self> {
        let door = Door::open(path)?;
        let knocks = UnixDatagram::from_std(door.knocks()?)?;
        let hearing = tokio::spawn(hear(door, knocks, answers));
        Ok(Self { hearing })
    }

    /// Takes it down: its door is gone when this returns.
    pub(crate) async fn take_down(mut self) {
        self.hearing.abort();
        // It was aborted.
        let _ = (&mut self.hearing).await;
    }
}

async fn hear(door: Door, knocks: UnixDatagram, answers: Arc<Answer>) {
    let free = Arc::new(tokio::sync::Semaphore::new(MOST));
    loop {
        let Ok(turn) = Arc::clone(&free).acquire_owned().await else { return };
        let stream = match knocks.async_io(Interest::READABLE, || door.next()).await {
            Ok(stream) => stream,
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                tracing::warn!("refused: for a gateway, {error}");
                continue;
            }
            Err(_) => {
                tokio::time::sleep(Duration::from_millis(10)).await;
                continue;
            }
        };
        let opened = stream.set_nonblocking(true).and_then(|()| UnixStream::from_std(stream));
        let Ok(stream) = opened else { continue };
        let answers = Arc::clone(&answers);
        tokio::spawn(async move {
            let _turn = turn;
            answer(stream, &*answers).await;
        });
    }
}

async fn answer(mut stream: UnixStream, answers: &Answer) {
    let (reading, mut writing) = stream.split();
    let mut line = String::new();
    let mut reading = BufReader::new(reading.take(LONGEST));
    let said = timeout(PATIENCE, reading.read_line(&mut line)).await;
    if !matches!(said, Ok(Ok(_))) || !line.ends_with('\n') {
        tracing::warn!("refused: somebody asks for a gateway and does not say for which");
        return;
    }
    if let Some(why) = answers(line.trim_end().to_owned()).await {
        let _ = writing.write_all(why.as_bytes()).await;
    }
}
