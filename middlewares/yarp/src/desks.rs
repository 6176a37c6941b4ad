//! The ports of services, one for each component that has some.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::desk::Desk;
use crate::port::Port;

/// Name of the port of services among those of a component.
pub(crate) const RPC: &str = "rpc";

/// The ports of services, by component.
#[derive(Default)]
pub(crate) struct Desks(Mutex<HashMap<String, Open>>);

/// A port of services.
type Open = (Arc<Port>, Arc<Desk>);

impl Desks {
    pub(crate) fn lock(&self) -> MutexGuard<'_, HashMap<String, Open>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
