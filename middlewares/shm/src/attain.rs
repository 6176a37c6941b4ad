//! Opens or creates a service of iceoryx2 while other processes may be creating, removing or
//! healing it.

use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::{Address, OpenError};

use crate::error::failed;
use crate::room;
use crate::watch::Watcher;

/// How long to wait for others that are creating or removing a service.
const PATIENCE: Duration = Duration::from_secs(2);

/// A living process has finished creating a service within this time.
const SOON: Duration = Duration::from_millis(200);

/// Result of an attempt to open or create a service, other than a final error.
pub(crate) enum Attempt<S> {
    /// Opened.
    Done(S),
    /// The service does not exist.
    Absent,
    /// Others are creating or removing it; the text is iceoryx2's.
    Busy(String),
    /// It may be incomplete because its creator was killed; the text is iceoryx2's.
    Broken(String),
}

/// Opens or creates the service, retrying until one of the two works. Refuses if `keep_free` bytes
/// or less of shared memory are left.
pub(crate) fn attain<S>(
    (watcher, keep_free): (&Watcher, u64),
    at: &Address,
    open: impl Fn() -> Result<Attempt<S>, OpenError>,
    create: impl Fn() -> Result<Attempt<S>, OpenError>,
) -> Result<S, OpenError> {
    room::check(at, keep_free)?;
    // A dead process must not keep its end of the service.
    let _ = watcher.heal_dead();
    let begin = Instant::now();
    loop {
        let attempt = match open()? {
            Attempt::Absent => create()?,
            other => other,
        };
        let (trouble, broken) = match attempt {
            Attempt::Done(service) => return Ok(service),
            Attempt::Absent => ("it comes and goes".to_owned(), false),
            Attempt::Busy(trouble) => (trouble, begin.elapsed() > SOON),
            Attempt::Broken(trouble) => (trouble, true),
        };
        if broken {
            let _ = watcher.heal();
        }
        if begin.elapsed() > PATIENCE {
            return Err(failed(at, &trouble));
        }
        thread::yield_now();
    }
}
