//! Components that did not stop in time: threads in codels that do not return.
//!
//! Their names, ports and services are free again; library and memory stay until the threads end.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_runtime::RunningCodel;

use super::hosted::Hosted;

/// The components left behind, oldest first.
#[derive(Default)]
pub(super) struct Remnants(Mutex<Vec<Arc<Hosted>>>);

/// A component that was left behind.
pub struct Remnant {
    /// Its instance name.
    pub was: String,
    /// Its name in the description.
    pub component: String,
    /// The codels that its threads are in.
    pub codels: Vec<RunningCodel>,
}

impl Remnants {
    fn lock(&self) -> MutexGuard<'_, Vec<Arc<Hosted>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a component that could not be stopped.
    pub(super) fn add(&self, hosted: Arc<Hosted>) {
        self.lock().push(hosted);
    }

    /// All of them, oldest first.
    pub(super) fn all(&self) -> Vec<Remnant> {
        let all = self.lock();
        let told = all.iter().map(|hosted| Remnant {
            was: hosted.name.clone(),
            component: hosted.model().name.clone(),
            codels: hosted.instance.running_codels(),
        });
        told.collect()
    }

    /// Removes and returns those whose threads have ended.
    pub(super) fn take_those_over(&self) -> Vec<Arc<Hosted>> {
        self.lock().extract_if(.., |hosted| hosted.instance.is_over()).collect()
    }
}
