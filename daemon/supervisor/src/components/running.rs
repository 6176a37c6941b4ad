//! The components that run, by name, and those on their way in and out.

use std::sync::{Arc, PoisonError, RwLock};

use genom_runtime::ShutdownError;
use indexmap::IndexMap;

use super::hosted::Hosted;
use super::remnants::{Remnant, Remnants};

/// A component could not be unloaded.
#[derive(Clone, Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum UnloadError {
    /// It does not run.
    #[error("{0} does not run: it is being loaded or unloaded")]
    NotThere(String),
    /// A codel did not return in time.
    #[error(
        "{why}; the name {name} is free again, and what is left of it stays in memory until its \
         threads end"
    )]
    Stuck { name: String, why: ShutdownError },
}

/// Where a component is in its life.
#[derive(Clone)]
pub(super) enum Slot {
    /// Its name is taken; requests do not see it yet.
    Loading,
    Running(Arc<Hosted>),
    /// Requests do not see it any more; its name is free when its codels have ended.
    Stopping,
}

/// The components by instance name, in the order they were loaded.
#[derive(Default)]
pub struct Components {
    slots: RwLock<IndexMap<String, Slot>>,
    /// Those that did not stop.
    remnants: Remnants,
}

impl Components {
    /// The component of that name, if it runs.
    pub fn get(&self, name: &str) -> Option<Arc<Hosted>> {
        match self.slots.read().unwrap_or_else(PoisonError::into_inner).get(name) {
            Some(Slot::Running(hosted)) => Some(Arc::clone(hosted)),
            _ => None,
        }
    }

    /// All that run, in the order they were loaded.
    pub fn all(&self) -> Vec<Arc<Hosted>> {
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        let running = slots.values().filter_map(|slot| match slot {
            Slot::Running(hosted) => Some(Arc::clone(hosted)),
            _ => None,
        });
        running.collect()
    }

    /// It is no component any more, and cannot go.
    pub(super) fn leave_behind(&self, hosted: Arc<Hosted>) {
        self.remnants.add(hosted);
    }

    /// What is left of components that could not be stopped, oldest first.
    pub fn left_behind(&self) -> Vec<Remnant> {
        self.remnants.all()
    }

    /// Takes out those whose threads have ended: to be let go of.
    pub(crate) fn over(&self) -> Vec<Arc<Hosted>> {
        self.remnants.take_those_over()
    }

    /// Names of those that are being stopped.
    pub fn stopping(&self) -> Vec<String> {
        self.names(|slot| matches!(slot, Slot::Stopping))
    }

    /// Names of those that are being loaded.
    pub fn loading(&self) -> Vec<String> {
        self.names(|slot| matches!(slot, Slot::Loading))
    }

    fn names(&self, of: impl Fn(&Slot) -> bool) -> Vec<String> {
        let slots = self.slots.read().unwrap_or_else(PoisonError::into_inner);
        slots.iter().filter(|(_, slot)| of(slot)).map(|(name, _)| name.clone()).collect()
    }

    /// Takes a name for a component that is about to be loaded.
    pub fn reserve(&self, name: &str) -> Option<Reservation<'_>> {
        let mut slots = self.slots.write().unwrap_or_else(PoisonError::into_inner);
        if slots.contains_key(name) {
            return None;
        }
        slots.insert(name.to_owned(), Slot::Loading);
        Some(Reservation { components: self, name: name.to_owned(), kept: false })
    }

    /// A name may be used again.
    pub(super) fn free(&self, name: &str) {
        self.slots.write().unwrap_or_else(PoisonError::into_inner).shift_remove(name);
    }

    pub(super) fn exchange_running(&self, name: &str, new: Slot) -> Option<Slot> {
        let mut slots = self.slots.write().unwrap_or_else(PoisonError::into_inner);
        let slot = slots.get_mut(name).filter(|slot| matches!(slot, Slot::Running(_)))?;
        Some(std::mem::replace(slot, new))
    }
}

/// A name taken; given back unless a component moves in.
pub struct Reservation<'a> {
    components: &'a Components,
    name: String,
    kept: bool,
}

impl Reservation<'_> {
    /// The component runs under this name from now on.
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
