//! How others reach an instance whose tasks share a thread with those of other instances.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use super::hurry::Hurry;
use crate::lock::lock;

/// Asks the shared thread to look at one instance.
#[derive(Debug)]
pub(crate) struct Call {
    asked: AtomicBool,
    /// The shared thread sleeps on this.
    bell: Arc<Hurry>,
    /// Whether the thread has released everything of the instance.
    gone: Mutex<bool>,
    left: Condvar,
}

impl Call {
    pub(crate) fn new(bell: Arc<Hurry>) -> Self {
        Self { asked: AtomicBool::new(false), bell, gone: Mutex::default(), left: Condvar::new() }
    }

    /// Asks for a look at the instance. A system call is made only if the thread sleeps.
    pub(crate) fn ring(&self) {
        // A thread that has been asked and has not looked yet will also see what is new.
        if !self.asked.swap(true, Ordering::AcqRel) {
            self.bell.get_up();
        }
    }

    /// Whether somebody asked; resets it.
    pub(crate) fn take(&self) -> bool {
        self.asked.load(Ordering::Relaxed) && self.asked.swap(false, Ordering::AcqRel)
    }

    /// The shared thread has released the instance's memory and code.
    pub(crate) fn gone(&self) {
        *lock(&self.gone) = true;
        self.left.notify_all();
    }

    /// Waits for that. Called when the thread has ended its last work for the instance.
    pub(crate) fn wait_until_gone(&self) {
        let mut gone = lock(&self.gone);
        while !*gone {
            gone = self.left.wait(gone).unwrap_or_else(PoisonError::into_inner);
        }
    }
}
