//! The components by name: running ones, and those being loaded or stopped.

use std::sync::{Arc, PoisonError, RwLock, Weak};

use genom_runtime::ShutdownError;
use indexmap::IndexMap;

use super::hosted::Hosted;
use super::remnants::{Remnant, Remnants};

/// Why a component could not be unloaded.
#[derive(Clone, Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum UnloadError {
    /// There is no running component of that name.
    #[error("{0} does not run: it is being loaded or unloaded")]
    NotThere(String),
    /// A codel did not return in time.
    #[error(
        "{why}; the name {name} is free again, and what is left of it stays in memory until its \
         threads end"
    )]
    Stuck { name: String, why: ShutdownError },
}

/// State of an instance name.
#[derive(Clone)]
pub(super) enum Slot {
    /// Its component is being loaded; requests do not find it yet.
    Loading,
    Running(Arc<Hosted>),
    /// Its component is being stopped; only requests about its activities still find it. The name
    /// becomes free when the codels have ended.
    Stopping(Weak<Hosted>),
}

/// The components by instance name, in the order they were loaded.
#[derive(Default)]
pub struct Components {
    slots: RwLock<IndexMap<String, Slot>>,
    /// Components that did not stop in time.
    remnants: Remnants,
}

impl Components {
    /// The running component of that name.
    pub fn get(&self, name: &str) -> Option<Arc<Hosted>> {
        match self.slot(name)? {
            Slot::Running(hosted) => Some(hosted),
            Slot::Loading | Slot::Stopping(_) => None,
        }
    }

    /// The component of that name that runs or is being stopped, until it is closed: how its activities
    /// end is still of interest.
    pub fn get_until_closed(&self, name: &str) -> Option<Arc<Hosted>> {
        match self.slot(name)? {
            Slot::Running(hosted) => Some(hosted),
            Slot::Stopping(hosted) => hosted.upgrade(),
            Slot::Loading => None,
        }
    }

    fn slot(&self, name: &str) -> Option<Slot> {
        self.slots.read().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    /// All running components, in the order they were loaded.
    pub fn all(&self) -> Vec<Arc<Hosted>> {
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        let running = slots.values().filter_map(|slot| match slot {
            Slot::Running(hosted) => Some(Arc::clone(hosted)),
            _ => None,
        });
        running.collect()
    }

    /// Keeps what is left of a component that could not be stopped.
    pub(super) fn leave_behind(&self, hosted: Arc<Hosted>) {
        self.remnants.add(hosted);
    }

    /// Components that could not be stopped, oldest first.
    pub fn left_behind(&self) -> Vec<Remnant> {
        self.remnants.all()
    }

    /// Removes and returns those left behind whose threads have ended, to be dropped by the caller.
    pub(crate) fn over(&self) -> Vec<Arc<Hosted>> {
        self.remnants.take_those_over()
    }

    /// Names of components that are being stopped.
    pub fn stopping(&self) -> Vec<String> {
        self.names(|slot| matches!(slot, Slot::Stopping(_)))
    }

    /// Names of components that are being loaded.
    pub fn loading(&self) -> Vec<String> {
        self.names(|slot| matches!(slot, Slot::Loading))
    }

    fn names(&self, of: impl Fn(&Slot) -> bool) -> Vec<String> {
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        slots.iter().filter(|(_, slot)| of(slot)).map(|(name, _)| name.clone()).collect()
    }

    /// Reserves a name for a component to be loaded; `None` if it is in use.
    pub fn reserve(&self, name: &str) -> Option<Reservation<'_>> {
        let mut slots = self.slots.write().unwrap_or_else(PoisonError::into_inner);
        if slots.contains_key(name) {
            return None;
        }
        slots.insert(name.to_owned(), Slot::Loading);
        Some(Reservation { components: self, name: name.to_owned(), kept: false })
    }

    /// Frees a name.
    pub(super) fn free(&self, name: &str) {
        self.slots.write().unwrap_or_else(PoisonError::into_inner).shift_remove(name);
    }

    /// Puts a component in the place of a running one.
    pub(super) fn replace(&self, name: &str, new: Arc<Hosted>) {
        self.exchange_running(name, |_| Slot::Running(new));
    }

    /// A running component, which is to be stopped: requests do not find it any more.
    pub(super) fn withdraw(&self, name: &str) -> Option<Arc<Hosted>> {
        self.exchange_running(name, |old| Slot::Stopping(Arc::downgrade(old)))
    }

    fn exchange_running(
        &self,
        name: &str,
        new: impl FnOnce(&Arc<Hosted>) -> Slot,
    ) -> Option<Arc<Hosted>> {
        let mut slots = self.slots.write().unwrap_or_else(PoisonError::into_inner);
        let slot = slots.get_mut(name)?;
        let Slot::Running(old) = &*slot else { return None };
        let old = Arc::clone(old);
        *slot = new(&old);
        Some(old)
    }
}

/// A reserved name; freed when dropped, unless [`keep`](Self::keep) is called.
pub struct Reservation<'a> {
    components: &'a Components,
    name: String,
    kept: bool,
}

impl Reservation<'_> {
    /// Gives the name to the component, which is running from now on.
    pub fn keep(mut self, hosted: Arc<Hosted>) {
        self.kept = true;
        let mut slots = self.components.slots.write().unwrap_or_else(PoisonError::into_inner);
        slots.insert(self.name.clone(), Slot::Running(hosted));
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        if !self.kept {
            self.components.free(&self.name);
        }
    }
}
