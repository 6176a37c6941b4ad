//! Serves what is answered in JSON as services of nodes on ROS 2.

use std::future::Future;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use genom_middleware::{
    ActivityId, Address, Middleware, OpenError, Outcome, Replies, Served, ServiceHandler,
    ServiceType,
};
use genom_protocol::{Code, Reason};
use genom_registry::{BackendError, Backends, Masquerade};
use genom_types::{DataType, LayoutError, Record};
use serde_json::Value;
use tokio::runtime::Handle;
use tokio::sync::Semaphore;

/// The middleware that has such nodes.
const ON: &str = "ros2";

/// Requests that one node serves at once. Anybody on the network can make them.
const AT_ONCE: usize = 16;

/// Services that one thread takes back, one after the other.
const TOGETHER: usize = 50;

/// Why nothing is offered to ROS.
#[derive(Debug, thiserror::Error)]
pub enum NotServed {
    /// The middleware cannot be opened.
    #[error("components are managed by ROS 2, and {0}")]
    Middleware(#[from] BackendError),
    /// A service or a topic cannot be opened.
    #[error("components are managed by ROS 2, and {0}")]
    End(#[from] OpenError),
    /// Does not happen: the messages have a layout.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

/// A request for something that is no more was not needed.
pub(crate) fn unless_gone<T>(asked: Result<T, Reason>) -> Result<(), Reason> {
    const GONE: [Code; 3] = [Code::NoSuchComponent, Code::NoSuchActivity, Code::Ended];
    match asked {
        Err(reason) if !GONE.iter().any(|code| reason.is(*code)) => Err(reason),
        _ => Ok(()),
    }
}

/// A service that is offered.
pub(crate) trait Kind: Copy + Send + Sync + 'static {
    /// Its name below the node's.
    fn name(self) -> &'static str;

    /// The full name of our type, and the ROS type that it is.
    fn masquerade(self) -> (String, String);

    /// Its input and output.
    fn types(self) -> Result<ServiceType, LayoutError>;
}

/// A node that answers.
pub(crate) trait Answers<K: Kind>: Send + Sync + 'static {
    /// Its name, in the log.
    fn name(&self) -> &str;

    /// The output of a service for this input.
    fn answer(&self, service: K, input: &Value) -> impl Future<Output = Value> + Send;
}

/// What is offered of nodes, until this is dropped.
pub struct Offered {
    middleware: Arc<dyn Middleware>,
    served: Vec<Box<dyn Served>>,
    /// Names of the types, which go after the services.
    masquerades: Vec<Masquerade>,
}

impl Offered {
    /// Nothing yet. Opens the middleware, which may take a while.
    pub(crate) fn nothing(backends: &Backends) -> Result<Self, NotServed> {
        let middleware = backends.get(ON)?;
        Ok(Self { middleware, served: Vec::new(), masquerades: Vec::new() })
    }

    pub(crate) fn middleware(&self) -> &dyn Middleware {
        &*self.middleware
    }

    /// Makes the types of these services those of ROS.
    pub(crate) fn speak<K: Kind>(
        &mut self,
        backends: &Arc<Backends>,
        services: &[K],
    ) -> Result<(), NotServed> {
        for service in services {
            let (ours, ros) = service.masquerade();
            self.masquerades.extend(backends.masquerade(ON, &ours, &ros)?);
        }
        Ok(())
    }

    /// Serves the services of the node of this instance.
    pub(crate) fn add<K: Kind>(
        &mut self,
        instance: &str,
        services: &[K],
        node: &Arc<impl Answers<K>>,
        runtime: &Handle,
    ) -> Result<(), NotServed> {
        let room = Arc::new(Semaphore::new(AT_ONCE));
        for &service in services {
            let ty = service.types()?;
            let handler = Arc::new(Handler {
                node: Arc::clone(node),
                service,
                output: ty.output.clone(),
                room: Arc::clone(&room),
                crowded: AtomicBool::new(false),
                runtime: runtime.clone(),
            });
            let at = Address::new(instance, service.name());
            self.served.push(self.middleware.serve(&at, &ty, handler)?);
        }
        Ok(())
    }
}

impl Drop for Offered {
    /// Each service waits until others know that it has gone: many do so at once.
    fn drop(&mut self) {
        let mut served = std::mem::take(&mut self.served);
        thread::scope(|scope| {
            while !served.is_empty() {
                let rest = served.split_off(served.len().min(TOGETHER));
                let some = std::mem::replace(&mut served, rest);
                // Without another thread, this one does it.
                let _ = thread::Builder::new().spawn_scoped(scope, move || drop(some));
            }
        });
    }
}

/// All that a daemon offers to ROS.
#[derive(Default)]
pub struct Offers(Mutex<Vec<Offered>>);

impl Offers {
    /// Keeps an offer until all end.
    pub fn keep(&self, offered: Offered) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(offered);
    }

    /// Takes them back.
    pub fn end(&self) {
        let offered = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        drop(offered);
    }
}

/// Serves one service of one node.
struct Handler<K, N> {
    node: Arc<N>,
    service: K,
    output: DataType,
    room: Arc<Semaphore>,
    /// Whether the log was told that requests were left out.
    crowded: AtomicBool,
    runtime: Handle,
}

impl<K: Kind, N: Answers<K>> ServiceHandler for Handler<K, N> {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let Ok(place) = Arc::clone(&self.room).try_acquire_owned() else {
            // Who asked gets no reply, as when the node is gone.
            if !self.crowded.swap(true, Ordering::Relaxed) {
                tracing::warn!(
                    "{}: more than {AT_ONCE} requests at once, as for {}: some get no reply",
                    self.node.name(),
                    self.service.name()
                );
            }
            return;
        };
        let (node, service) = (Arc::clone(&self.node), self.service);
        let mut output = Record::new(&self.output);
        let input = input.to_json();
        self.runtime.spawn(async move {
            let said = node.answer(service, &input).await;
            match output.merge_json(&said) {
                Ok(()) => replies.finish(Outcome::Success(output)),
                Err(error) => tracing::error!("{}: {error}", node.name()),
            }
            drop(place);
        });
    }

    /// There are no activities among these services.
    fn cancel(&self, _: ActivityId) {}
}
