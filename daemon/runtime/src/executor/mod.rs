//! One thread that executes the tasks and the control work of many instances, in the order of their
//! deadlines.
//!
//! The thread is shared by all that an instance has a thread for otherwise. A codel that does not
//! return holds up all of them.

mod agenda;
mod link;
mod member;

use std::fmt;
use std::num::NonZeroU64;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use agenda::Agenda;
use link::{Link, Mail};

use crate::clock::monotonic;
use crate::lock::lock;
use crate::running::RunningCodel;
use crate::shared::Shared;
use crate::task::call::Call;
use crate::task::runner::Runner;

pub(crate) use member::{Member, Turn};

/// Stack of the thread, in bytes: that of a task that declares none.
const STACK: usize = 8 << 20;

/// Executes the tasks of many instances in one thread, for
/// [`Execution::Single`](crate::Execution::Single).
///
/// The thread is created for the first instance, and ends after the last one and this were dropped.
pub struct Executor {
    name: String,
    link: Arc<Link>,
    /// Whether the thread was created.
    open: Mutex<bool>,
}

impl Executor {
    /// An executor whose thread has this name.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        let link = Arc::new(Link::new(monotonic()));
        Self { name: name.into(), link, open: Mutex::new(false) }
    }

    /// Creates the thread, if there is none.
    pub(crate) fn open(&self) -> std::io::Result<()> {
        let mut open = lock(&self.open);
        if *open {
            return Ok(());
        }
        let link = Arc::clone(&self.link);
        let thread = std::thread::Builder::new().name(self.name.clone()).stack_size(STACK);
        thread.spawn(move || {
            let _ = link.thread.set(std::thread::current().id());
            // Wake-ups must not be delayed to be combined with others.
            let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
            Agenda::new(link).run();
        })?;
        *open = true;
        Ok(())
    }

    /// Date that all ticks are counted from, so that tasks of one period tick together.
    pub(crate) fn epoch(&self) -> u64 {
        self.link.epoch
    }

    /// For an instance that will be added.
    pub(crate) fn call(&self) -> Call {
        Call::new(Arc::clone(&self.link.bell))
    }

    /// Adds an instance; returns its seat.
    pub(crate) fn enter(
        &self,
        member: Arc<dyn Member>,
        shared: &Arc<Shared>,
        call: &Arc<Call>,
    ) -> u64 {
        self.link.enter(member, Arc::clone(shared), Arc::clone(call))
    }

    /// Adds a task of the instance in this seat.
    pub(crate) fn add_task(&self, seat: u64, runner: Runner) {
        self.link.send(Mail::Task { seat, runner });
    }

    /// The codel that the thread has been in for longest.
    pub(crate) fn running(&self) -> Option<RunningCodel> {
        self.link.running()
    }

    /// Rounds of the thread so far: between two of them it runs one codel, or several that follow
    /// each other without pause. `None` while there is no thread.
    #[must_use]
    pub fn rounds(&self) -> Option<u64> {
        lock(&self.open).then(|| self.link.rounds.load(Ordering::Relaxed))
    }

    /// Asks the thread for another round.
    pub fn wake(&self) {
        self.link.bell.get_up();
    }

    /// Whether this is the thread.
    pub(crate) fn is_here(&self) -> bool {
        self.link.is_here()
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        self.link.close();
    }
}

impl fmt::Debug for Executor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Executor({})", self.name)
    }
}
