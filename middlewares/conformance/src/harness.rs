//! Runs one property: a world to run in, a watchdog, and waiting for a condition.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::Middleware;

/// A property that takes longer than this hangs.
const WATCHDOG: Duration = Duration::from_secs(120);

/// A condition that is not met within this time never will be.
const PATIENCE: Duration = Duration::from_secs(40);

/// Where a property runs: apart from all other tests, with as many participants as it asks for.
pub trait World: Send + Sync + 'static {
    /// One more participant, as one more daemon would be. All participants reach each other.
    fn join(&self) -> Arc<dyn Middleware>;

    /// What this world's participants left on the machine: files, shared memory. Nothing, for
    /// middlewares that leave nothing by nature.
    fn leftovers(&self) -> Vec<String> {
        Vec::new()
    }
}

impl<F: Fn() -> Arc<dyn Middleware> + Send + Sync + 'static> World for F {
    fn join(&self) -> Arc<dyn Middleware> {
        self()
    }
}

/// Runs a property under a watchdog.
///
/// # Panics
/// When the property does not hold, or hangs.
pub fn run<W: World>(name: &str, world: Arc<W>, property: fn(&dyn World)) {
    let (done, finished) = channel();
    let runner = thread::Builder::new()
        .name(name.to_owned())
        .spawn(move || {
            property(&*world);
            let _ = done.send(());
        })
        .expect("a thread");
    match finished.recv_timeout(WATCHDOG) {
        Err(RecvTimeoutError::Timeout) => panic!("{name} hangs"),
        Ok(()) | Err(RecvTimeoutError::Disconnected) => {
            if let Err(cause) = runner.join() {
                std::panic::resume_unwind(cause);
            }
        }
    }
}

/// Waits until a condition holds.
///
/// # Panics
/// When it does not hold for long.
#[track_caller]
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "never: {what}");
        thread::park_timeout(Duration::from_millis(1));
    }
}
