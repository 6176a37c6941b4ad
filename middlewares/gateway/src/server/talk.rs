//! What a proxy says, one frame after the other.

use std::collections::HashMap;
use std::io;
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use genom_kit::sender::Sender;
use genom_middleware::{Address, Middleware};

use super::gathered::Gathered;
use super::guest::{ENDS, Guest};
use super::held::End;
use super::mouth::Mouth;
use crate::channel::{Outgoing, PATIENCE, lock};
use crate::wire::{Frame, Frames};
use crate::words::{About, Down, PROTOCOL, Refusal, Up};

/// How often to look for losses.
const LOSSES: Duration = Duration::from_millis(200);

/// Serves a proxy until it goes.
pub(super) fn serve(middleware: Arc<dyn Middleware>, gathered: Arc<Gathered>, stream: &UnixStream) {
    if let Err(error) = talk(middleware, gathered, stream) {
        tracing::warn!("the connection of a process to the gateway ends: {error}");
    }
    let _ = stream.shutdown(Shutdown::Both);
}

fn talk(
    middleware: Arc<dyn Middleware>,
    gathered: Arc<Gathered>,
    stream: &UnixStream,
) -> io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut frames = Frames::new(stream.try_clone()?);
    match frames.next::<Up>()? {
        None => return Ok(()),
        Some(Frame::Message(Up::Hello { .. }, _)) => {}
        Some(_) => return Err(io::Error::other("it does not begin with a greeting")),
    }
    stream.set_read_timeout(None)?;
    let guest = Arc::new(Guest {
        middleware,
        gathered,
        mouth: Arc::new(Mouth::new(stream.try_clone()?)),
        orders: OnceLock::new(),
        ends: Mutex::new(Some(HashMap::new())),
        called: Mutex::default(),
        asked: Mutex::default(),
        numbers: AtomicU64::new(1),
        workers: AtomicUsize::new(0),
    });
    let duty = Outgoing::new(&guest.mouth.channel, losses(&guest));
    let sender = Sender::single("gateway", true, duty)?;
    let _ = guest.orders.set(sender.orders().clone());
    let orders = sender.orders().clone();
    guest.mouth.open(Box::new(move || orders.ring()))?;
    let about = about(guest.middleware.as_ref());
    guest.say(&Down::Welcome { protocol: PROTOCOL, about }, &[]);
    if let Err(error) = genom_kit::prompt::be_prompt() {
        tracing::debug!(%error, "samples may wait for their turn to be received");
    }
    let heard = guest.hear(&mut frames);
    guest.mouth.close();
    let ends = lock(&guest.ends).take();
    // Whoever waits for these sees that nobody answers.
    lock(&guest.asked).clear();
    drop(ends);
    // Drops the subscriptions.
    drop(sender);
    lock(&guest.called).clear();
    // They use the middleware.
    let end = Instant::now() + PATIENCE;
    while guest.workers.load(Ordering::SeqCst) > 0 && Instant::now() < end {
        thread::park_timeout(Duration::from_millis(1));
    }
    heard
}

impl Guest {
    fn hear(self: &Arc<Self>, frames: &mut Frames) -> io::Result<()> {
        while let Some(frame) = frames.next::<Up>()? {
            match frame {
                Frame::Sample { end, message } => {
                    let writer = self.with(end, |end| match end {
                        End::Publisher(writer) => Some(Arc::clone(writer)),
                        _ => None,
                    });
                    if let Some(writer) = writer.flatten() {
                        lock(&writer).write(message, &self.mouth);
                    }
                }
                Frame::Message(up, payload) => self.heed(up, payload)?,
            }
        }
        Ok(())
    }

    fn heed(self: &Arc<Self>, up: Up, payload: &[u8]) -> io::Result<()> {
        match up {
            Up::Hello { .. } => return Err(io::Error::other("it greets twice")),
            Up::Open { end, what } => {
                let room = {
                    let mut ends = lock(&self.ends);
                    let Some(ends) = ends.as_mut() else { return Ok(()) };
                    let room = ends.len() < ENDS && !ends.contains_key(&end);
                    if room {
                        ends.insert(end, End::Opening);
                    }
                    room
                };
                if !room {
                    let why = Refusal::Own(format!("{ENDS} ports and services are open already"));
                    self.say(&Down::Refused { end, why }, &[]);
                    return Ok(());
                }
                self.apart(move |guest| guest.open(end, what));
            }
            Up::Close { end } => {
                let closed = lock(&self.ends).as_mut().and_then(|ends| ends.remove(&end));
                self.apart(move |guest| {
                    guest.end(closed);
                    guest.say(&Down::Closed { end }, &[]);
                });
            }
            Up::Request { end, call } => self.request(end, call, payload),
            Up::Cancel { call } => self.cancel(call),
            Up::Progress { call, progress } => self.progress(call, progress, payload),
            Up::Reply { call, replied } => self.replied(call, replied.then(|| payload.to_vec())),
            // Before the ends that follow are opened.
            Up::Mask { ours, foreign } => match foreign {
                // It was valid when it was given.
                Some(foreign) => drop(self.middleware.masquerade(&ours, &foreign)),
                None => self.middleware.unmask(&ours),
            },
            Up::Log(entry) => self.middleware.log(&entry),
            Up::Diagnose(tasks) => self.gathered.put(tasks),
            Up::Question { number, question } => {
                let payload = payload.to_vec();
                self.apart(move |guest| {
                    let (answer, reply) = guest.answer(question, &payload);
                    guest.say(&Down::Answer { number, answer }, &reply);
                });
            }
        }
        Ok(())
    }
}

/// Looks for losses now and then, as long as there are ports.
fn losses(guest: &Arc<Guest>) -> impl FnMut() -> Option<Duration> + Send + 'static {
    let (guest, mut last) = (Arc::downgrade(guest), Instant::now());
    let mut has_ports = true;
    move || {
        // A port may have been opened since.
        if !has_ports || last.elapsed() >= LOSSES {
            last = Instant::now();
            has_ports = guest.upgrade().is_some_and(|guest| guest.look_for_losses());
        }
        has_ports.then_some(LOSSES)
    }
}

fn about(middleware: &dyn Middleware) -> About {
    About {
        capabilities: middleware.capabilities(),
        discovers: middleware.discovery().is_some(),
        relays: middleware.relay().is_some(),
        takes_reports: middleware.takes_reports(),
        meeting: middleware.meeting_point(),
        own: middleware.relay().map(|relay| relay.own()).unwrap_or_default(),
        spelled: middleware.spelled(&Address::new("a", "b")),
    }
}
