//! One service that is served, until it is dropped.

use std::sync::Arc;

use genom_middleware::{Address, OpenError, Served, ServiceHandler, ServiceType};

use super::hub::Hub;
use super::request::Entry;
use crate::inner::Inner;

struct ShmServed {
    at: Address,
    entry: Arc<Entry>,
    hub: Arc<Hub>,
    inner: Arc<Inner>,
}

/// Serves until the result is dropped.
pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &ServiceType,
    handler: Arc<dyn ServiceHandler>,
) -> Result<impl Served + 'static, OpenError> {
    let worker = inner.worker(at)?;
    let hub = worker.hub(&inner.ground, at)?;
    let entry = Arc::new(Entry { handler, ty: ty.clone() });
    hub.add(at, &entry)?;
    Ok(ShmServed { at: at.clone(), entry, hub, inner: Arc::clone(inner) })
}

impl Served for ShmServed {}

impl Drop for ShmServed {
    fn drop(&mut self) {
        self.hub.withdraw(&self.at, &self.entry);
        if let Ok(worker) = self.inner.worker(&self.at) {
            worker.bell().ring();
        }
    }
}
