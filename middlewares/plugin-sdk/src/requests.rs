//! Requests in both directions.

use std::sync::{Arc, Mutex, PoisonError};

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    ActivityId, Address, CallError, Client, Outcome, Replies, Running, ServiceHandler, ServiceType,
};
use genom_plugin_abi::answers::{Said, Waiting};
use genom_plugin_abi::{Code, Failure, Sides};
use genom_types::{DataType, Record};

use crate::given::{Functions, Given};

/// What errors say of a service at an address.
pub(crate) fn sides(backend: &str, at: &Address, service: &ServiceType) -> Sides {
    Sides {
        backend: backend.to_owned(),
        address: at.clone(),
        name: service.input.name().to_owned(),
        ours: types_of_service(service),
    }
}

/// Passes requests to a service on to the host.
pub(crate) struct Handler {
    pub(crate) to: Arc<Given>,
    pub(crate) output: DataType,
    pub(crate) sides: Sides,
}

impl ServiceHandler for Handler {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let mut message = Vec::new();
        if let Err(error) = input.encode_message(&mut message) {
            return replies.finish(Outcome::Lost(CallError::Serialization(error.to_string())));
        }
        let (output, sides) = (self.output.clone(), self.sides.clone());
        let call = Call { waiting: Waiting::new(replies), output, sides };
        let call = Box::into_raw(Box::new(call));
        if !self.to.request(call.cast(), &message) {
            // SAFETY: it came from a box, and the host did not get it.
            drop(unsafe { Box::from_raw(call) });
        }
    }

    fn cancel(&self, id: ActivityId) {
        self.to.cancel(id.0);
    }
}

/// A request that the host answers.
pub(crate) struct Call {
    pub(crate) waiting: Waiting,
    pub(crate) output: DataType,
    pub(crate) sides: Sides,
}

/// The calling end of a service.
pub(crate) struct Calling {
    pub(crate) client: Mutex<Box<dyn Client>>,
    pub(crate) input: DataType,
    pub(crate) host: Functions,
}

/// A request of the host.
pub(crate) struct Run(pub(crate) Box<dyn Running>);

impl Calling {
    pub(crate) fn request(&self, input: &[u8], to: Arc<Given>) -> Result<Run, Failure> {
        let mut record = Record::new(&self.input);
        let decoded = record.decode_message(input);
        decoded.map_err(|error| Failure::new(Code::BAD_DATA, error.to_string()))?;
        let mut client = self.client.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(Run(client.request(&record, Box::new(ToHost(to)))?))
    }
}

/// Passes answers on to the host. Dropped before the end, it says so by releasing what was given.
struct ToHost(Arc<Given>);

impl Replies for ToHost {
    fn accepted(&mut self, id: ActivityId) {
        Said::Accepted(id).lend(|answer| self.0.answer(answer));
    }

    fn feedback(&mut self, state: &str) {
        Said::State(state.to_owned()).lend(|answer| self.0.answer(answer));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        Said::End(outcome).lend(|answer| self.0.answer(answer));
    }
}
