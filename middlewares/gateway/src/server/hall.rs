//! The socket of a gateway, and those that are connected.

use std::io;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use genom_middleware::Middleware;
use rustix::event::{PollFd, PollFlags, poll};

use super::gathered::Gathered;
use super::talk;
use crate::channel::lock;
use crate::door::Door;

/// Connections at once: one of each process that uses the gateway.
const GUESTS: usize = 1024;

/// How long a gateway that nobody uses waits for the next who does.
const IDLE: Duration = Duration::from_secs(1);

/// How long one that nobody has used yet waits.
const FIRST: Duration = Duration::from_secs(15);

/// Serves a middleware to proxies.
pub struct Server;

/// Serves until it is dropped.
pub struct Listening {
    hall: Arc<Hall>,
    path: PathBuf,
    /// The accepting thread sees its other end close.
    leave: Option<UnixStream>,
    accepting: Option<JoinHandle<()>>,
}

/// Those that are connected.
struct Hall {
    guests: Mutex<Guests>,
    /// Signalled when one comes or goes.
    changed: Condvar,
}

#[derive(Default)]
struct Guests {
    streams: Vec<(u64, UnixStream)>,
    next: u64,
    /// Since when there is none.
    empty: Option<Instant>,
}

impl Server {
    /// Opens a door at which only this user can knock.
    ///
    /// # Errors
    /// An error of the system.
    pub fn listen(path: &Path, middleware: Arc<dyn Middleware>) -> io::Result<Listening> {
        // Whoever was behind it before has ended: the daemon starts one gateway at a time.
        let door = Door::open(path)?;
        let hall = Arc::new(Hall { guests: Mutex::default(), changed: Condvar::new() });
        let own = Arc::clone(&hall);
        let gathered = Gathered::new(&middleware);
        let (leave, left) = UnixStream::pair()?;
        let accepting = thread::Builder::new()
            .name("gateway".to_owned())
            .spawn(move || own.receive(&door, &left, &middleware, &gathered))?;
        Ok(Listening {
            hall,
            path: path.to_owned(),
            leave: Some(leave),
            accepting: Some(accepting),
        })
    }
}

impl std::fmt::Debug for Listening {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Listening").field("path", &self.path).finish_non_exhaustive()
    }
}

impl Listening {
    /// Whether somebody uses it now.
    #[must_use]
    pub fn is_used(&self) -> bool {
        !lock(&self.hall.guests).streams.is_empty()
    }

    /// Waits until nobody uses the gateway any more; this can outlive it.
    pub fn unused(&self) -> impl FnOnce() + Send + use<> {
        let hall = Arc::clone(&self.hall);
        move || hall.wait()
    }
}

impl Hall {
    fn wait(&self) {
        let begin = Instant::now();
        let mut guests = lock(&self.guests);
        loop {
            let end = match guests.empty {
                Some(since) => since + IDLE,
                None => begin + FIRST,
            };
            let left = end.saturating_duration_since(Instant::now());
            let used = !guests.streams.is_empty();
            if left.is_zero() && !used {
                return;
            }
            let left = if used { Duration::from_secs(3600) } else { left };
            let waited = self.changed.wait_timeout(guests, left);
            guests = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.leave = None;
        if let Some(accepting) = self.accepting.take() {
            // A panic of the thread has been reported already.
            let _ = accepting.join();
        }
        let mut guests = lock(&self.hall.guests);
        for (_, stream) in &guests.streams {
            let _ = stream.shutdown(std::net::Shutdown::Both);
        }
        let end = Instant::now() + crate::channel::PATIENCE;
        while !guests.streams.is_empty() && Instant::now() < end {
            let left = end.saturating_duration_since(Instant::now());
            let waited = self.hall.changed.wait_timeout(guests, left);
            guests = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Hall {
    fn receive(
        self: &Arc<Self>,
        door: &Door,
        left: &UnixStream,
        middleware: &Arc<dyn Middleware>,
        gathered: &Arc<Gathered>,
    ) {
        loop {
            let (wanted, over) =
                (PollFd::new(door, PollFlags::IN), PollFd::new(left, PollFlags::IN));
            let mut both = [wanted, over];
            if poll(&mut both, None).is_err() {
                continue;
            }
            if !both[1].revents().is_empty() {
                return;
            }
            match door.next().and_then(|stream| self.enter(stream, middleware, gathered)) {
                Ok(()) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                    tracing::warn!("refused: {error}");
                }
                Err(error) => {
                    tracing::warn!("a process does not get into the gateway: {error}");
                    // Without descriptors, accepting fails until one is closed.
                    thread::park_timeout(Duration::from_millis(10));
                }
            }
        }
    }

    fn enter(
        self: &Arc<Self>,
        stream: UnixStream,
        middleware: &Arc<dyn Middleware>,
        gathered: &Arc<Gathered>,
    ) -> io::Result<()> {
        let mut guests = lock(&self.guests);
        if guests.streams.len() >= GUESTS {
            return Err(io::Error::other(format!("{GUESTS} are connected already")));
        }
        let number = guests.next;
        guests.next += 1;
        guests.streams.push((number, stream.try_clone()?));
        guests.empty = None;
        drop(guests);
        let (hall, middleware, gathered) =
            (Arc::clone(self), Arc::clone(middleware), Arc::clone(gathered));
        let spawned = thread::Builder::new().name("gateway-guest".to_owned()).spawn(move || {
            talk::serve(middleware, gathered, &stream);
            // The middleware may be closed now, if this was the last that used it.
            hall.leave(number);
        });
        if spawned.is_err() {
            self.leave(number);
        }
        spawned.map(drop)
    }

    fn leave(&self, number: u64) {
        let mut guests = lock(&self.guests);
        guests.streams.retain(|(one, _)| *one != number);
        if guests.streams.is_empty() {
            guests.empty = Some(Instant::now());
        }
        drop(guests);
        self.changed.notify_all();
    }
}
