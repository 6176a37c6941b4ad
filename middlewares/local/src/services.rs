//! Services within one process: a request is a call of the handler that serves the address.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    ActivityId, Address, CallError, Client, OpenError, Outcome, Replies, Running, Served,
    ServiceHandler, ServiceType,
};
use genom_types::Record;

/// All services of a process.
#[derive(Default)]
pub(crate) struct Table(Mutex<HashMap<Address, Service>>);

struct Service {
    ty: ServiceType,
    handler: Arc<dyn ServiceHandler>,
    /// Requests that may still be in progress; their callers are notified when the service is
    /// withdrawn.
    pending: Vec<Weak<Request>>,
}

/// A request in progress.
struct Request {
    handler: Arc<dyn ServiceHandler>,
    /// Taken by whichever comes first: the service finishes, or it is withdrawn.
    replies: Mutex<Option<Box<dyn Replies>>>,
    id: OnceLock<ActivityId>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn same(ours: &ServiceType, theirs: &ServiceType) -> bool {
    let types = ours.input.same_as(&theirs.input) && ours.output.same_as(&theirs.output);
    types && ours.described == theirs.described
}

impl Table {
    pub(crate) fn for_each(&self, mut see: impl FnMut(&Address, &ServiceType)) {
        for (address, service) in &*lock(&self.0) {
            see(address, &service.ty);
        }
    }
}

/// Keeps a service in the list.
pub(crate) struct LocalServed {
    services: Arc<Table>,
    at: Address,
}

impl LocalServed {
    pub(crate) fn open(
        services: &Arc<Table>,
        at: &Address,
        ty: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Self, OpenError> {
        let mut list = lock(&services.0);
        if list.contains_key(at) {
            return Err(OpenError::Taken { address: at.clone() });
        }
        list.insert(at.clone(), Service { ty: ty.clone(), handler, pending: Vec::new() });
        drop(list);
        Ok(Self { services: Arc::clone(services), at: at.clone() })
    }
}

impl Served for LocalServed {}

impl Drop for LocalServed {
    fn drop(&mut self) {
        let Some(service) = lock(&self.services.0).remove(&self.at) else { return };
        for request in service.pending.iter().filter_map(Weak::upgrade) {
            request.finish(Outcome::Lost(CallError::Gone));
        }
    }
}

/// The calling end of a service.
pub(crate) struct LocalClient {
    services: Arc<Table>,
    at: Address,
    ty: ServiceType,
}

impl LocalClient {
    pub(crate) fn open(
        services: &Arc<Table>,
        at: &Address,
        ty: &ServiceType,
    ) -> Result<Self, OpenError> {
        if let Some(service) = lock(&services.0).get(at)
            && !same(ty, &service.ty)
        {
            return Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: types_of_service(ty),
                theirs: types_of_service(&service.ty),
            });
        }
        Ok(Self { services: Arc::clone(services), at: at.clone(), ty: ty.clone() })
    }
}

impl Client for LocalClient {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        let mut list = lock(&self.services.0);
        let service =
            list.get_mut(&self.at).ok_or_else(|| CallError::Nobody { address: self.at.clone() })?;
        if !same(&self.ty, &service.ty) || !input.ty().same_as(&service.ty.input) {
            return Err(CallError::TypeMismatch {
                address: self.at.clone(),
                ours: types_of_service(&self.ty),
                theirs: types_of_service(&service.ty),
            });
        }
        let request = Arc::new(Request {
            handler: Arc::clone(&service.handler),
            replies: Mutex::new(Some(replies)),
            id: OnceLock::new(),
        });
        service.pending.retain(|other| other.strong_count() > 0);
        service.pending.push(Arc::downgrade(&request));
        drop(list);
        // The handler may call back into this middleware, so no lock is held here.
        request.handler.request(input.clone(), Box::new(ToCaller(Arc::clone(&request))));
        Ok(Box::new(LocalRunning(request)))
    }
}

impl Request {
    fn finish(&self, outcome: Outcome) {
        let taken = lock(&self.replies).take();
        if let Some(replies) = taken {
            replies.finish(outcome);
        }
    }
}

/// Passes the service's replies on to the caller.
struct ToCaller(Arc<Request>);

impl Replies for ToCaller {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.0.id.set(id);
        if let Some(replies) = &mut *lock(&self.0.replies) {
            replies.accepted(id);
        }
    }

    fn feedback(&mut self, state: &str) {
        if let Some(replies) = &mut *lock(&self.0.replies) {
            replies.feedback(state);
        }
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        self.0.finish(outcome);
    }
}

impl Drop for ToCaller {
    // The service dropped the request without a reply.
    fn drop(&mut self) {
        self.0.finish(Outcome::Lost(CallError::Gone));
    }
}

struct LocalRunning(Arc<Request>);

impl Running for LocalRunning {
    fn cancel(&self) {
        let under_way = lock(&self.0.replies).is_some();
        if let Some(id) = self.0.id.get()
            && under_way
        {
            self.0.handler.cancel(*id);
        }
    }
}
