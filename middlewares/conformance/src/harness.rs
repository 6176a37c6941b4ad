//! Runs one property in a world of its own under a watchdog, and waits for conditions.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::Middleware;

/// A property that takes longer counts as hanging.
const WATCHDOG: Duration = Duration::from_secs(120);

/// A condition that does not hold within this time counts as failed.
const PATIENCE: Duration = Duration::from_secs(40);

/// Where a property runs: isolated from all other tests, with as many participants as it needs.
pub trait World: Send + Sync + 'static {
    /// Adds a participant, which corresponds to one more daemon. All participants reach each other.
    fn join(&self) -> Arc<dyn Middleware>;

    /// Names of what this world's participants left on the machine, such as files and shared
    /// memory. Empty for middlewares that leave nothing by design.
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
/// When it still does not hold after 40 s.
#[track_caller]
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "never: {what}");
        thread::park_timeout(Duration::from_millis(1));
    }
}
