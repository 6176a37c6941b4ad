//! Opens a service of iceoryx2 or creates it, whatever others do to it meanwhile.

use std::thread;
use std::time::{Duration, Instant};

use genom_middleware::{Address, OpenError};
use iceoryx2::prelude::Node;

use crate::error::failed;
use crate::raw::Ipc;
use crate::room;

/// How long others may take to finish what they are doing to a service.
const PATIENCE: Duration = Duration::from_secs(2);

/// How an attempt to open or to create a service ended, if not in vain.
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

/// Opens, or creates, again and again until one of it works.
pub(crate) fn attain<S>(
    node: &Node<Ipc>,
    keep_free: u64,
    at: &Address,
    open: impl Fn() -> Result<Attempt<S>, OpenError>,
    create: impl Fn() -> Result<Attempt<S>, OpenError>,
) -> Result<S, OpenError> {
    room::check(at, keep_free)?;
    let end = Instant::now() + PATIENCE;
    loop {
        let attempt = match open()? {
            Attempt::Absent => create()?,
            other => other,
        };
        let trouble = match attempt {
            Attempt::Done(service) => return Ok(service),
            Attempt::Absent => "it comes and goes".to_owned(),
            Attempt::Busy(trouble) => trouble,
            Attempt::Broken(trouble) => {
                node.try_cleanup_dead_nodes();
                trouble
            }
        };
        if Instant::now() > end {
            return Err(failed(at, &trouble));
        }
        thread::yield_now();
    }
}
