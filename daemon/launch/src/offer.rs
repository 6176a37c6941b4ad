//! Offers the services of managed nodes on ROS 2.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use genom_doors::Own;
use genom_middleware::{
    ActivityId, Address, Middleware, OpenError, Outcome, PortSpec, Replies, Served, ServiceHandler,
};
use genom_registry::{BackendError, Backends, Masquerade};
use genom_types::{DataType, LayoutError, Record};
use tokio::runtime::Handle;
use tokio::sync::Semaphore;

use crate::managed::Managed;
use crate::messages::{self, Service};
use crate::node::{Events, Node};

/// The middleware that has such nodes.
const ON: &str = "ros2";

/// Requests that one node serves at once. Anybody on the network can make them.
const AT_ONCE: usize = 16;

/// Services that one thread takes back, one after the other.
const TOGETHER: usize = 50;

/// Why components cannot be managed by ROS.
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

/// What is offered of nodes, until this is dropped.
pub struct Offered {
    served: Vec<Box<dyn Served>>,
    /// Names of the types, which go after the services.
    _masquerades: Vec<Masquerade>,
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

/// The nodes of a daemon.
#[derive(Default)]
pub struct Nodes(Mutex<Option<Offered>>);

impl Nodes {
    /// Keeps them until they end.
    pub fn keep(&self, offered: Offered) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(offered);
    }

    /// Takes them back.
    pub fn end(&self) {
        let offered = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(offered);
    }
}

/// Offers the lifecycle services of these components. They act through `plane`, and wait at most
/// `patience` for an activity to stop. This may take a while, as it opens the middleware.
///
/// # Errors
/// The middleware cannot be opened, or refuses a service.
pub fn serve(
    managed: Vec<Managed>,
    backends: &Arc<Backends>,
    plane: &Own,
    patience: Duration,
    runtime: &Handle,
) -> Result<Offered, NotServed> {
    let mut masquerades = Vec::new();
    for service in Service::ALL {
        let (ours, ros) = service.masquerade();
        masquerades.extend(backends.masquerade(ON, &ours, &ros)?);
    }
    let middleware = backends.get(ON)?;
    let mut served = Vec::new();
    for what in managed {
        tracing::info!("{}: is managed by ROS 2: it is loaded when that configures it", what.name);
        let events = events(&*middleware, &what.name)?;
        let at = |name: &str| Address::new(what.name.clone(), name);
        let addresses = Service::ALL.map(|service| at(service.name()));
        let node = Arc::new(Node::new(what, plane.clone(), patience, events));
        let room = Arc::new(Semaphore::new(AT_ONCE));
        for (service, address) in Service::ALL.into_iter().zip(addresses) {
            let ty = service.types()?;
            let handler = Arc::new(Handler {
                node: Arc::clone(&node),
                service,
                output: ty.output.clone(),
                room: Arc::clone(&room),
                crowded: AtomicBool::new(false),
                runtime: runtime.clone(),
            });
            served.push(middleware.serve(&address, &ty, handler)?);
        }
    }
    Ok(Offered { served, _masquerades: masquerades })
}

fn events(middleware: &dyn Middleware, node: &str) -> Result<Events, NotServed> {
    let ty = messages::event()?;
    let address = Address::new(node, "transition_event");
    let publisher = middleware.publisher(&PortSpec::new(&address, &ty))?;
    Ok(Events { publisher, message: Record::new(&ty) })
}

/// Serves one service of one node.
struct Handler {
    node: Arc<Node>,
    service: Service,
    output: DataType,
    room: Arc<Semaphore>,
    /// Whether the log was told that requests were left out.
    crowded: AtomicBool,
    runtime: Handle,
}

impl ServiceHandler for Handler {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let Ok(place) = Arc::clone(&self.room).try_acquire_owned() else {
            // Who asked gets no reply, as when the node is gone.
            if !self.crowded.swap(true, Ordering::Relaxed) {
                tracing::warn!(
                    "{}: more than {AT_ONCE} requests to its lifecycle at once: some get no reply",
                    self.node.name()
                );
            }
            return;
        };
        let (node, service) = (Arc::clone(&self.node), self.service);
        let mut output = Record::new(&self.output);
        let input = input.to_json();
        self.runtime.spawn(async move {
            let said = node.serve(service, &input).await;
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
