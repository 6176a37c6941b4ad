//! A service that is served until this is dropped.

use std::sync::Arc;

use genom_middleware::{Address, OpenError, Served, ServiceHandler, ServiceType};

use super::desk::Desk;
use super::hub::Hub;
use super::request::Entry;

struct ShmServed {
    at: Address,
    entry: Arc<Entry>,
    hub: Arc<Hub>,
    desk: Arc<Desk>,
}

/// Serves until the result is dropped.
pub(crate) fn open(
    desk: &Arc<Desk>,
    at: &Address,
    ty: &ServiceType,
    handler: Arc<dyn ServiceHandler>,
) -> Result<impl Served + 'static, OpenError> {
    let worker = desk.worker(at)?;
    let hub = worker.hub(&desk.inner.ground, at)?;
    let entry = Arc::new(Entry { handler, ty: ty.clone() });
    hub.add(at, &entry)?;
    Ok(ShmServed { at: at.clone(), entry, hub, desk: Arc::clone(desk) })
}

impl Served for ShmServed {}

impl Drop for ShmServed {
    fn drop(&mut self) {
        self.hub.withdraw(&self.at, &self.entry);
        if let Ok(worker) = self.desk.worker(&self.at) {
            worker.bell().ring();
        }
    }
}
