//! What the threads share that send for one middleware, and what each of them does in turn.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

use crate::bell::Bell;
use crate::busy::{Alarm, Busy};
use crate::lines::{Line, Lines};

/// Time between two looks while another thread has what is wanted.
const AGAIN: Duration = Duration::from_millis(1);

/// What the thread does beside sending, and what its jobs work with.
pub trait Duty: Send + Sized + 'static {
    /// Its out ports.
    type Line: Line;

    /// Does what is due, after each ring; how long until something is again, if nobody rings.
    fn due(&mut self, lines: &Lines<Self::Line>) -> Option<Duration> {
        let _ = lines;
        None
    }
}

/// Something to do on the thread.
pub(crate) type Job<D> = Box<dyn FnOnce(&mut D, &Lines<<D as Duty>::Line>) + Send>;

/// What the threads share that send for one middleware.
pub(crate) struct Shared<D: Duty> {
    /// Taken away at the end, with the jobs that were not done.
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
    /// What this thread sends for, as a number.
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

    /// Has the threads end.
    pub(crate) fn end(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.bell.ring();
        self.alarm.wake();
    }

    /// Whether the threads are to end.
    pub(crate) fn stops(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Says that this thread sends.
    pub(crate) fn sends_here(&self) {
        SENDS_FOR.set(self.number());
    }

    /// Whether this thread sends.
    pub(crate) fn is_here(&self) -> bool {
        SENDS_FOR.get() == self.number()
    }

    /// Goes on until the [end](Shared::end), and then lets go of everything.
    pub(crate) fn go_on(&self, busy: &Busy) {
        self.sends_here();
        let mut pause = None;
        loop {
            self.bell.wait(pause);
            // What was ordered before the end is done before it.
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

    /// Does what was ordered and what is due, and sends; how long until something is due again.
    pub(crate) fn pass(&self, busy: &Busy) -> Option<Duration> {
        let desk = match self.desk.try_lock() {
            Ok(desk) => Some(desk),
            Err(TryLockError::Poisoned(desk)) => Some(desk.into_inner()),
            // Another thread is at a job.
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
            // Comes back at once, after a look at orders.
            self.bell.ring();
        }
        pause
    }
}
