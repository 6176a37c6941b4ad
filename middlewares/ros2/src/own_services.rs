//! Services of ROS itself on the node of a component, such as those of its parameters.

use std::sync::Arc;

use serde::Serialize;

use crate::names::TypeName;
use crate::rmw::{self, EndError, Entities, ServerEnd};
use crate::ros::Ros;
use crate::typed;

/// Where the reply to a request goes.
pub(crate) type Reply = Box<dyn rmw::Reply>;

/// One of these services, which needs a `T` to answer.
pub(crate) struct OwnService<T> {
    /// Its name below that of the node.
    pub(crate) name: &'static str,
    /// Package and name of its type.
    pub(crate) ty: (&'static str, &'static str),
    /// Decodes a request and arranges for the reply; `None` if it cannot be decoded.
    pub(crate) serve: fn(&T, Reply, &[u8]) -> Option<()>,
}

impl<T> OwnService<T> {
    /// The name of its type.
    pub(crate) fn type_name(&self) -> TypeName {
        TypeName::new(self.ty.0, "srv", self.ty.1)
    }
}

/// Services of one node, until this is dropped. Fields are dropped in order.
pub(crate) struct OwnServices {
    ends: Vec<Box<dyn ServerEnd>>,
    _belonging: Box<dyn Send + Sync>,
}

impl OwnServices {
    /// `node` has the namespace in front. `entities` are others that belong to it for as long.
    pub(crate) fn open<T: Send + Sync + 'static>(
        ros: &Ros,
        node: &str,
        services: &'static [OwnService<T>],
        state: &Arc<T>,
        mut entities: Entities,
    ) -> Result<Self, EndError> {
        let mut ends = Vec::with_capacity(services.len());
        for service in services {
            let of = ros.of_ros(format!("{node}/{}", service.name), service.type_name());
            let (serve, (_, ty)) = (service.serve, service.ty);
            let state = Arc::clone(state);
            let on_request = move |reply, message: &[u8]| {
                if serve(&state, reply, message).is_none() {
                    tracing::warn!("a request of {ty} cannot be read; it is left out");
                }
            };
            ends.push(ros.rmw.server(node, &of, Box::new(on_request))?);
        }
        for one in ends.iter().map(|end| end.entities()) {
            entities.writers.extend(one.writers);
            entities.readers.extend(one.readers);
        }
        Ok(Self { ends, _belonging: ros.rmw.belong(node, entities) })
    }
}

impl Drop for OwnServices {
    fn drop(&mut self) {
        self.ends.iter().for_each(|end| end.flush());
    }
}

/// Sends a reply.
pub(crate) fn answer(reply: Reply, response: &impl Serialize) {
    // None of them can fail to be encoded: they consist of texts and numbers.
    if let Some(body) = typed::encode(response) {
        reply.send(body);
    }
}
