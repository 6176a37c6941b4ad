//! The thread that reaches the gateway, and the next one when it has ended.

use std::io::{self, Read as _, Write as _};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use super::book::Shared;
use crate::channel::{PATIENCE, lock};
use crate::door::knock;
use crate::wire::{self, Frame, Frames};
use crate::words::{About, Down, PROTOCOL, Up};

/// Between two attempts to reach a gateway: the first pause, and the longest.
const PAUSE: (Duration, Duration) = (Duration::from_millis(5), Duration::from_millis(500));

/// Why there is no connection.
struct NoWay {
    why: String,
    /// The daemon itself says that there will be none.
    refused: bool,
}

impl From<io::Error> for NoWay {
    fn from(error: io::Error) -> Self {
        Self { why: error.to_string(), refused: false }
    }
}

/// Reaches the gateway again and again, and hears what it says meanwhile, until the proxy ends.
pub(super) fn keep_up(shared: &Arc<Shared>) {
    let _ = shared.hearing.set(thread::current().id());
    if let Err(error) = genom_kit::prompt::be_prompt() {
        tracing::debug!(%error, "samples may wait for their turn to be received");
    }
    let (mut pause, mut lost) = (PAUSE.0, false);
    while !shared.stops() {
        match shared.connect() {
            Ok((stream, mut frames, about)) => {
                let Ok(own) = stream.try_clone() else { continue };
                if lost {
                    tracing::info!("the gateway of {} is back", shared.name);
                }
                pause = PAUSE.0;
                shared.comes(stream, about);
                let end = shared.hear(&mut frames);
                let _ = own.shutdown(Shutdown::Both);
                let why = match end {
                    Ok(()) => "it has ended".to_owned(),
                    Err(error) => format!("the connection to it broke: {error}"),
                };
                if !shared.stops() {
                    tracing::warn!("the gateway of {} is gone: {why}", shared.name);
                }
                lost = true;
                shared.goes(why);
            }
            Err(NoWay { why, refused }) => {
                let mut book = lock(&shared.book);
                (book.why, book.refused) = (Some(why), refused);
                drop(book);
                shared.changed.notify_all();
                thread::park_timeout(pause);
                pause = (pause * 2).min(PAUSE.1);
            }
        }
    }
    shared.goes("it is closed".to_owned());
}

impl Shared {
    pub(super) fn stops(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Whether the daemon is starting a gateway right now.
    pub(super) fn waits_for_daemon(&self) -> bool {
        self.rings.load(Ordering::SeqCst)
    }

    /// Ends whatever the hearing thread waits for.
    pub(super) fn hang_up(&self) {
        if let Some(stream) = &*lock(&self.waits_on) {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }

    fn waits_on(&self, stream: &UnixStream) -> io::Result<()> {
        *lock(&self.waits_on) = Some(stream.try_clone()?);
        // Whoever stops the proxy sets the flag first, and shuts down what it finds then.
        if self.stops() { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }

    fn connect(&self) -> Result<(UnixStream, Frames, About), NoWay> {
        let door = self.reach.door(self.name);
        let stream = match knock(&door) {
            Ok(stream) => stream,
            Err(_) => {
                self.rings.store(true, Ordering::SeqCst);
                let rung = self.ring_for_one();
                self.rings.store(false, Ordering::SeqCst);
                rung?;
                knock(&door)?
            }
        };
        self.waits_on(&stream)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        (&stream).write_all(&wire::message(&Up::Hello { protocol: PROTOCOL }, &[])?)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let mut frames = Frames::new(stream.try_clone()?);
        let about = match frames.next::<Down>()? {
            Some(Frame::Message(Down::Welcome { protocol: PROTOCOL, about }, _)) => about,
            Some(Frame::Message(Down::Welcome { protocol, .. }, _)) => {
                let why = format!(
                    "the gateway of {} is of another version of genomd (protocol {protocol}, not \
                     {PROTOCOL}): `genomctl cells --restart gateway-{}` starts it again",
                    self.name, self.name
                );
                return Err(NoWay { why, refused: true });
            }
            _ => return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into()),
        };
        stream.set_read_timeout(None)?;
        Ok((stream, frames, about))
    }

    /// Asks the daemon for a gateway, and waits until there is one.
    fn ring_for_one(&self) -> Result<(), NoWay> {
        let bell = self.reach.bell();
        let unreachable = |error: io::Error| NoWay {
            why: format!("no daemon starts a gateway: {}: {error}", bell.display()),
            refused: false,
        };
        let mut stream = knock(&bell).map_err(unreachable)?;
        self.waits_on(&stream)?;
        stream.write_all(format!("{}\n", self.name).as_bytes())?;
        let mut why = String::new();
        stream.take(64 << 10).read_to_string(&mut why)?;
        if why.is_empty() { Ok(()) } else { Err(NoWay { why, refused: true }) }
    }
}
