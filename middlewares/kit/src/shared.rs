//! What the threads that send for one middleware share, and the work each does in turn.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

use crate::bell::Bell;
use crate::busy::{Alarm, Busy};
use crate::lines::{Line, Lines};

/// Time between two attempts to get what another thread is using.
const AGAIN: Duration = Duration::from_millis(1);

/// The thread's duty beside sending, and the data that its jobs use.
pub trait Duty: Send + Sized + 'static {
    /// Type of its out ports.
    type Line: Line;

    /// Does what is due; called after each ring. Returns how long until the next call if nobody
    /// rings.
    fn due(&mut self, lines: &Lines<Self::Line>) -> Option<Duration> {
        let _ = lines;
        None
    }
}

/// A job for the thread.
pub(crate) type Job<D> = Box<dyn FnOnce(&mut D, &Lines<<D as Duty>::Line>) + Send>;

/// What the threads that send for one middleware share.
pub(crate) struct Shared<D: Duty> {
    /// Removed at the end, together with jobs that were not done.
    desk: Mutex<Option<Desk<D>>>,
    pub(crate) lines: Lines<D::Line>,
    pub(crate) bell: Bell,
    stop: AtomicBool,
    pub(crate) alarm: Arc<Alarm>,
}

struct Desk<D: Duty> {
    duty: D,
    jobs: Receiver<Job<D>>,
}

thread_local! {
    /// Identifies the `Shared` that this thread sends for; 0 if none.
    static SENDS_FOR: Cell<usize> = const { Cell::new(0) };
}

impl<D: Duty> Shared<D> {
    pub(crate) fn new(duty: D, jobs: Receiver<Job<D>>) -> Self {
        Self {
            desk: Mutex::new(Some(Desk { duty, jobs })),
            lines: Lines::new(),
            bell: Bell::default(),
            stop: AtomicBool::new(false),
            alarm: Arc::default(),
        }
    }

    fn number(&self) -> usize {
        std::ptr::from_ref(self).addr()
    }

    /// Tells the threads to end.
    pub(crate) fn end(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.bell.ring();
        self.alarm.wake();
    }

    /// Whether the threads must end.
    pub(crate) fn stops(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Registers the calling thread as one that sends.
    pub(crate) fn sends_here(&self) {
        SENDS_FOR.set(self.number());
    }

    /// Whether the calling thread is one that sends.
    pub(crate) fn is_here(&self) -> bool {
        SENDS_FOR.get() == self.number()
    }

    /// Works until the [end](Shared::end), then drops everything.
    pub(crate) fn go_on(&self, busy: &Busy) {
        self.sends_here();
        let mut pause = None;
        loop {
            self.bell.wait(pause);
            // Read first, so that jobs submitted before the end are done.
            let last = self.stops();
            pause = self.pass(busy);
            if last {
                break;
            }
        }
        let desk = self.desk.lock().unwrap_or_else(PoisonError::into_inner).take();
        self.lines.clear();
        drop(desk);
    }

    /// Runs jobs, does what is due and sends. Returns how long until something is due again.
    pub(crate) fn pass(&self, busy: &Busy) -> Option<Duration> {
        let desk = match self.desk.try_lock() {
            Ok(desk) => Some(desk),
            Err(TryLockError::Poisoned(desk)) => Some(desk.into_inner()),
            // Another thread is running a job.
            Err(TryLockError::WouldBlock) => None,
        };
        let mut pause = Some(AGAIN);
        if let Some(mut desk) = desk {
            pause = desk.as_mut().and_then(|Desk { duty, jobs }| {
                let _working = busy.begin();
                while let Ok(job) = jobs.try_recv() {
                    job(duty, &self.lines);
                }
                duty.due(&self.lines)
            });
        }
        if self.lines.send(busy) {
            // More to send: return here after checking for jobs.
            self.bell.ring();
        }
        pause
    }
}
