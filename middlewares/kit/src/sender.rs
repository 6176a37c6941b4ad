//! A thread that sends for all out ports of a middleware and does other slow work for it.
//!
//! Real-time threads fill the [outlet](crate::outlet) of a port, mark its line and ring the bell;
//! the library is called on this thread only. If a write blocks because a reader stopped, other
//! lines are not held up: after [`PATIENCE`] another thread continues with them (`relief`).

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Sender as Submit, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::busy::Busy;
pub use crate::lines::Line;
use crate::lines::Lines;
use crate::prompt::be_prompt;
use crate::relief;
pub use crate::shared::Duty;
use crate::shared::{Job, Shared};

/// How long a thread may be in one call before another takes over the other lines.
pub const PATIENCE: Duration = relief::LOOK;

/// Gives jobs to the sending thread. Clones refer to the same thread.
pub struct Orders<D: Duty> {
    submit: Submit<Job<D>>,
    shared: Arc<Shared<D>>,
}

impl<D: Duty> Clone for Orders<D> {
    fn clone(&self) -> Self {
        Self { submit: self.submit.clone(), shared: Arc::clone(&self.shared) }
    }
}

/// Owns the sending thread. Dropping it ends the thread once the jobs submitted before are done.
pub struct Sender<D: Duty> {
    orders: Orders<D>,
    threads: Vec<JoinHandle<()>>,
}

impl<D: Duty> Sender<D> {
    /// Starts the thread. With `prompt`, Linux runs it soon after it is woken
    /// ([`prompt`](crate::prompt)).
    ///
    /// # Errors
    /// The system cannot start another thread.
    pub fn start(name: &str, prompt: bool, duty: D) -> io::Result<Self> {
        let (mut sender, busy) = Self::alone(name, prompt, duty)?;
        let shared = Arc::clone(&sender.orders.shared);
        let name = format!("{name}-relief");
        let watching = thread::Builder::new()
            .name(name.clone())
            .spawn(move || relief::watch(&shared, &name, busy))?;
        sender.threads.push(watching);
        Ok(sender)
    }

    /// Starts the thread without others that relieve it: for lines that all go the same way, where
    /// one that blocks leaves no way to the others.
    ///
    /// # Errors
    /// The system cannot start another thread.
    pub fn single(name: &str, prompt: bool, duty: D) -> io::Result<Self> {
        Ok(Self::alone(name, prompt, duty)?.0)
    }

    fn alone(name: &str, prompt: bool, duty: D) -> io::Result<(Self, Arc<Busy>)> {
        let (submit, jobs) = channel();
        let shared = Arc::new(Shared::new(duty, jobs));
        let busy = Arc::new(Busy::new(&shared.alarm));
        let orders = Orders { submit, shared: Arc::clone(&shared) };
        let mut sender = Self { orders, threads: Vec::new() };
        let own = Arc::clone(&busy);
        let sending = thread::Builder::new().name(format!("{name}-sender")).spawn(move || {
            if prompt && let Err(error) = be_prompt() {
                tracing::debug!(%error, "samples may wait for their turn to be sent");
            }
            shared.go_on(&own);
        })?;
        sender.threads.push(sending);
        Ok((sender, busy))
    }

    /// The handle for giving jobs to the thread.
    pub fn orders(&self) -> &Orders<D> {
        &self.orders
    }
}

impl<D: Duty> Drop for Sender<D> {
    fn drop(&mut self) {
        self.orders.shared.end();
        if self.orders.shared.is_here() {
            return;
        }
        for thread in self.threads.drain(..) {
            thread.thread().unpark();
            // A panic of the thread has been reported already.
            let _ = thread.join();
        }
    }
}

impl<D: Duty> Orders<D> {
    /// Makes the thread check what is [due](Duty::due). Wait-free.
    pub fn ring(&self) {
        self.shared.bell.ring();
    }

    /// Queues a job for the thread, after all earlier ones.
    pub fn submit(&self, job: impl FnOnce(&mut D, &Lines<D::Line>) + Send + 'static) {
        // Fails when the thread has ended; the job is dropped then.
        let _ = self.submit.send(Box::new(job));
        self.ring();
    }

    /// Queues a job and waits until it is done. On the thread itself it does not wait.
    pub fn finish(&self, job: impl FnOnce(&mut D, &Lines<D::Line>) + Send + 'static) {
        let (done, finished) = channel::<()>();
        self.submit(move |duty, lines| {
            job(duty, lines);
            drop(done);
        });
        if !self.shared.is_here() {
            // Returns when the job is done, or was dropped together with the thread.
            let _ = finished.recv();
        }
    }

    /// Adds an out port and returns its number.
    #[must_use]
    pub fn add(&self, line: D::Line) -> usize {
        self.shared.lines.add(line)
    }

    /// Marks an out port as having something to send. Wait-free.
    pub fn mark(&self, line: usize) {
        self.shared.lines.mark(line);
        self.ring();
    }

    /// Blocks the first out port from sending until the result is dropped, so that tests can see
    /// how a stalled network affects real-time callers. The block is in effect when this returns.
    #[must_use]
    pub fn stall(&self) -> impl Send + use<D> {
        let (release, held) = channel::<()>();
        let (begun, begins) = channel();
        self.submit(move |_, lines| {
            lines.find(|_| {
                let _ = begun.send(());
                let _ = held.recv();
                Some(())
            });
        });
        let _ = begins.recv();
        release
    }

    /// Sends what an out port still has queued, removes it, and passes it to `end`. Waits until
    /// that is done, except on the thread itself.
    pub fn remove(&self, number: usize, end: impl FnOnce(&mut D, D::Line) + Send + 'static) {
        self.finish(move |duty, lines| {
            if let Some(mut line) = lines.remove(number) {
                while line.send() {}
                end(duty, line);
            }
            lines.free(number);
        });
    }
}
