//! What the shared thread and all others have in common: newcomers, the members, and the bell.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, TryLockError, Weak};
use std::thread::ThreadId;

use super::member::Member;
use crate::lock::lock;
use crate::running::RunningCodel;
use crate::shared::Shared;
use crate::task::call::Call;
use crate::task::hurry::Hurry;
use crate::task::runner::Runner;

/// What is sent to the thread.
pub(crate) enum Mail {
    /// An instance, which has no task yet.
    Member { seat: u64, member: Arc<dyn Member>, shared: Arc<Shared>, call: Arc<Call> },
    /// The next task of an instance.
    Task { seat: u64, runner: Runner },
}

/// Shared by the thread and its users.
pub(crate) struct Link {
    /// The thread sleeps on this.
    pub(crate) bell: Arc<Hurry>,
    /// All ticks are counted from this date.
    pub(crate) epoch: u64,
    pub(crate) thread: OnceLock<ThreadId>,
    closed: AtomicBool,
    /// Rounds of the thread so far; only the thread counts.
    pub(crate) rounds: AtomicU64,
    seats: AtomicU64,
    mail: Mutex<Vec<Mail>>,
    has_mail: AtomicBool,
    /// The instances, by seat. The thread locks them only when one leaves.
    members: Mutex<Vec<(u64, Weak<dyn Member>)>>,
}

impl Link {
    pub(crate) fn new(epoch: u64) -> Self {
        Self {
            bell: Arc::default(),
            epoch,
            thread: OnceLock::new(),
            closed: AtomicBool::new(false),
            rounds: AtomicU64::new(0),
            seats: AtomicU64::new(0),
            mail: Mutex::default(),
            has_mail: AtomicBool::new(false),
            members: Mutex::default(),
        }
    }

    /// Adds an instance; returns its seat, a number that is never used again.
    pub(crate) fn enter(
        &self,
        member: Arc<dyn Member>,
        shared: Arc<Shared>,
        call: Arc<Call>,
    ) -> u64 {
        let seat = self.seats.fetch_add(1, Ordering::Relaxed);
        lock(&self.members).push((seat, Arc::downgrade(&member)));
        self.send(Mail::Member { seat, member, shared, call });
        seat
    }

    pub(crate) fn send(&self, mail: Mail) {
        lock(&self.mail).push(mail);
        self.has_mail.store(true, Ordering::Release);
        self.bell.get_up();
    }

    /// Takes what was sent; does not wait for somebody who is just sending, since they ring after
    /// that.
    pub(crate) fn take_mail(&self) -> Vec<Mail> {
        if !self.has_mail.load(Ordering::Acquire) {
            return Vec::new();
        }
        let mut mail = match self.mail.try_lock() {
            Ok(mail) => mail,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Vec::new(),
        };
        self.has_mail.store(false, Ordering::Relaxed);
        std::mem::take(&mut *mail)
    }

    pub(crate) fn leave(&self, seat: u64) {
        let mut members = self.members.lock().unwrap_or_else(PoisonError::into_inner);
        members.retain(|(its, _)| *its != seat);
    }

    /// The codel that the thread has been in for longest; in a nested call, the outermost one.
    pub(crate) fn running(&self) -> Option<RunningCodel> {
        let members: Vec<Arc<dyn Member>> =
            lock(&self.members).iter().filter_map(|(_, member)| member.upgrade()).collect();
        let all = members.iter().flat_map(|member| member.running());
        all.max_by_key(|codel| codel.for_ns)
    }

    /// Whether this is the shared thread.
    pub(crate) fn is_here(&self) -> bool {
        self.thread.get() == Some(&std::thread::current().id())
    }

    /// Ends the thread once it has no members.
    pub(crate) fn close(&self) {
        self.closed.store(true, Ordering::Release);
        self.bell.get_up();
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }
}
