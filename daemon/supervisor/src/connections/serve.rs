//! Offers the services of a component on middlewares.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use genom_description::model::ServiceIx;
use genom_description::model::ServiceKind as ModelKind;
use genom_middleware::{
    ActivityId, Middleware, OpenError, Outcome as Reply, Replies, ServiceHandler, ServiceKind,
    ServiceType,
};
use genom_runtime::Outcome;
use genom_types::Record;

use super::core::Connections;
use super::opening::BindError;
use crate::components::{Heard, Hosted, ServedOn, ServedServices};

impl Connections {
    /// Offers every service on each of these middlewares, if they support services.
    pub(crate) fn serve_on(
        &self,
        hosted: &Arc<Hosted>,
        names: &[String],
    ) -> Result<ServedOn, BindError> {
        let mut all = Vec::with_capacity(names.len());
        for name in names {
            let middleware = self.backends.get(name)?;
            let offers = |service: &str| self.offers.offers(name, &hosted.name, service);
            let served = serve(hosted, &middleware, offers)?;
            all.push((name.clone(), served));
        }
        Ok(all)
    }
}

fn serve(
    hosted: &Arc<Hosted>,
    middleware: &Arc<dyn Middleware>,
    offers: impl Fn(&str) -> bool,
) -> Result<ServedServices, BindError> {
    let mut served = Vec::new();
    for (index, service) in hosted.model().services.pairs() {
        // Not declared at all, so that callers see no such service.
        if !offers(&service.name) {
            continue;
        }
        let compiled = &hosted.plan().services()[index];
        let (input, output) = (compiled.input.clone(), compiled.output.clone());
        let ty =
            ServiceType::new(kind_of(service.kind), input, output).described(&service.call_digest);
        let handler = Arc::new(Handler { hosted: Arc::downgrade(hosted), service: index });
        match middleware.serve(&hosted.address(&service.name, None), &ty, handler) {
            Ok(one) => served.push((index, one)),
            // Calls through the control plane still work.
            Err(OpenError::Unsupported { why, .. }) => {
                tracing::debug!("{}/{}: {why}", hosted.name, service.name);
            }
            Err(error) => return Err(Box::new(error).into()),
        }
    }
    Ok(served)
}

/// Converts the kind of a service to that of the middleware API.
pub(super) fn kind_of(kind: ModelKind) -> ServiceKind {
    match kind {
        ModelKind::Attribute => ServiceKind::Attribute,
        ModelKind::Function => ServiceKind::Function,
        ModelKind::Activity => ServiceKind::Activity,
    }
}

/// Handles the requests to one service of one component.
struct Handler {
    /// Weak, because the component holds the handler.
    hosted: Weak<Hosted>,
    service: ServiceIx,
}

/// Where the reply goes; `None` once it was sent.
type Caller = Option<Box<dyn Replies>>;

fn lock(caller: &Mutex<Caller>) -> MutexGuard<'_, Caller> {
    caller.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ServiceHandler for Handler {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        // Dropping `replies` tells the caller that the service is gone.
        let Some(hosted) = self.hosted.upgrade() else { return };
        let replies = Arc::new(Mutex::new(Some(replies)));
        let weak = Weak::clone(&self.hosted);
        hosted.submit(self.service, input, move |heard| match heard {
            Heard::Accepted(activity) => {
                if let Some(replies) = lock(&replies).as_mut() {
                    replies.accepted(ActivityId(activity.number));
                }
                // Weak, so that `replies` is dropped, which tells that the service is gone, if the
                // component goes.
                let replies = Arc::downgrade(&replies);
                let follower = move |state: &str| {
                    if let Some(replies) = replies.upgrade()
                        && let Some(replies) = lock(&replies).as_mut()
                    {
                        replies.feedback(state);
                    }
                };
                if let Some(hosted) = weak.upgrade() {
                    hosted.follow(&activity, Box::new(follower));
                }
            }
            // Only partial inputs can be refused this way, and these are complete.
            Heard::Refused(_) => {}
            Heard::Ended(outcome) => {
                let replies = lock(&replies).take();
                if let Some(replies) = replies {
                    replies.finish(match outcome {
                        Outcome::Success(record) => Reply::Success(record),
                        Outcome::Exception(exception) => {
                            Reply::Exception { name: exception.name, detail: exception.detail }
                        }
                    });
                }
            }
        });
    }

    fn cancel(&self, id: ActivityId) {
        if let Some(hosted) = self.hosted.upgrade() {
            hosted.abort(id.0);
        }
    }
}
