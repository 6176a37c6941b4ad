//! Opens a service of iceoryx2 or creates it, whatever others do to it meanwhile.

use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::{Address, OpenError};

use crate::error::failed;
use crate::room;
use crate::watch::Watcher;

/// How long others may take to finish what they are doing to a service.
const PATIENCE: Duration = Duration::from_secs(2);

/// Living processes have finished making a service by then.
const SOON: Duration = Duration::from_millis(200);

/// How an attempt to open or to create a service ended, unless it failed for good.
pub(crate) enum Attempt<S> {
    /// It is open.
    Done(S),
    /// There is none.
    Absent,
    /// Others are at it, in iceoryx2's words.
    Busy(String),
    /// One that was killed may have left it so.
    Broken(String),
}

/// Opens, or creates, again and again until one of it works, where more than `keep_free` bytes are
/// left.
pub(crate) fn attain<S>(
    (watcher, keep_free): (&Watcher, u64),
    at: &Address,
    open: impl Fn() -> Result<Attempt<S>, OpenError>,
    create: impl Fn() -> Result<Attempt<S>, OpenError>,
) -> Result<S, OpenError> {
    room::check(at, keep_free)?;
    // Who died has it no more.
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
