//! A thread that sends for the out ports of a middleware, and does what else takes its time.
//!
//! Real-time threads fill the [outlet](crate::outlet) of a port, mark its line and ring; what the
//! library's calls cost or wait for is paid here. A line whose write waits, for a reader that
//! stopped, holds up no other: after [`PATIENCE`] another thread goes on with the rest (`relief`).

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

/// How long a thread may be at one message before another one takes over the rest.
pub const PATIENCE: Duration = relief::LOOK;

/// Gives orders to the thread; clones give them to the same one.
pub struct Orders<D: Duty> {
    submit: Submit<Job<D>>,
    shared: Arc<Shared<D>>,
}

impl<D: Duty> Clone for Orders<D> {
    fn clone(&self) -> Self {
        Self { submit: self.submit.clone(), shared: Arc::clone(&self.shared) }
    }
}

/// Owns the thread. It ends when this is dropped, after what was ordered before.
pub struct Sender<D: Duty> {
    orders: Orders<D>,
    threads: Vec<JoinHandle<()>>,
}

impl<D: Duty> Sender<D> {
    /// Starts the thread. `prompt` has Linux run it at once when it is woken.
    ///
    /// # Errors
    /// There are no more threads to be had.
    pub fn start(name: &str, prompt: bool, duty: D) -> io::Result<Self> {
        let (submit, jobs) = channel();
        let shared = Arc::new(Shared::new(duty, jobs));
        let busy = Arc::new(Busy::new(&shared.alarm));
        let orders = Orders { submit, shared: Arc::clone(&shared) };
        let mut sender = Self { orders, threads: Vec::new() };
        let (sending, own) = (Arc::clone(&shared), Arc::clone(&busy));
        let sending = thread::Builder::new().name(format!("{name}-sender")).spawn(move || {
            if prompt && let Err(error) = be_prompt() {
                tracing::debug!(%error, "samples may wait for their turn to be sent");
            }
            sending.go_on(&own);
        })?;
        sender.threads.push(sending);
        let name = format!("{name}-relief");
        let watching = thread::Builder::new()
            .name(name.clone())
            .spawn(move || relief::watch(&shared, &name, busy))?;
        sender.threads.push(watching);
        Ok(sender)
    }

    /// For who gives orders.
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
            // A thread that panicked has been reported by its panic.
            let _ = thread.join();
        }
    }
}

impl<D: Duty> Orders<D> {
    /// Has the thread look at what is [due](Duty::due). Wait-free.
    pub fn ring(&self) {
        self.shared.bell.ring();
    }

    /// Has a job done soon, after all that was ordered before.
    pub fn submit(&self, job: impl FnOnce(&mut D, &Lines<D::Line>) + Send + 'static) {
        // After the end there is nothing left to do it with.
        let _ = self.submit.send(Box::new(job));
        self.ring();
    }

    /// Has a job done and waits for it, except on the thread itself.
    pub fn finish(&self, job: impl FnOnce(&mut D, &Lines<D::Line>) + Send + 'static) {
        let (done, finished) = channel::<()>();
        self.submit(move |duty, lines| {
            job(duty, lines);
            drop(done);
        });
        if !self.shared.is_here() {
            // Ends when the job did, or was dropped with the thread.
            let _ = finished.recv();
        }
    }

    /// Adds an out port; its number.
    #[must_use]
    pub fn add(&self, line: D::Line) -> usize {
        self.shared.lines.add(line)
    }

    /// Says that an out port has something to send. Wait-free.
    pub fn mark(&self, line: usize) {
        self.shared.lines.mark(line);
        self.ring();
    }

    /// Keeps the first out port from sending until the result is dropped: for tests of what
    /// real-time callers feel of a stalled network. It holds when this returns.
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

    /// Sends what an out port still has, takes it away, and has it ended by `end`. Waits for
    /// that, except on the thread itself.
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
