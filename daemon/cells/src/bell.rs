//! The bell of a daemon: who needs a gateway connects, sends a line with the name of the middleware,
//! and reads why there is none, or nothing when there is one.

use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::{UnixListener, UnixStream};
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
    path: PathBuf,
    hearing: JoinHandle<()>,
}

impl Drop for Bell {
    fn drop(&mut self) {
        self.hearing.abort();
        let _ = fs::remove_file(&self.path);
    }
}

impl Bell {
    /// Hangs it up at this path, for this user alone, and starts gateways for who rings.
    pub(crate) fn hang(path: &Path, answers: Arc<Answer>) -> io::Result<Self> {
        let aside = path.with_extension("gateways.new");
        for file in [path, aside.as_path()] {
            // That of a daemon that died.
            if let Err(error) = fs::remove_file(file)
                && error.kind() != io::ErrorKind::NotFound
            {
                return Err(error);
            }
        }
        let listener = UnixListener::bind(&aside)?;
        fs::set_permissions(&aside, Permissions::from_mode(0o600))?;
        fs::rename(&aside, path)?;
        let hearing = tokio::spawn(hear(listener, answers));
        Ok(Self { path: path.to_owned(), hearing })
    }
}

async fn hear(listener: UnixListener, answers: Arc<Answer>) {
    let own = rustix::process::geteuid().as_raw();
    let free = Arc::new(tokio::sync::Semaphore::new(MOST));
    loop {
        let Ok(turn) = Arc::clone(&free).acquire_owned().await else { return };
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(Duration::from_millis(10)).await;
            continue;
        };
        if stream.peer_cred().map(|peer| peer.uid()).ok() != Some(own) {
            tracing::warn!("refused: another user asks for a gateway");
            continue;
        }
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
