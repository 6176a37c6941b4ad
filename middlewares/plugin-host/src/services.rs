//! Services, served and called.

use std::sync::Arc;

use genom_middleware::{
    Address, CallError, Client, OpenError, Replies, Running, Served, ServiceHandler, ServiceType,
    Services,
};
use genom_plugin_abi::Sides;
use genom_plugin_abi::answers::Waiting;
use genom_types::Record;

use crate::callbacks::give;
use crate::calls::Handle;
use crate::describe::{address, sides_of_service, with_service};
use crate::given::{Calling, Given, Serving};
use crate::middleware::{Core, Open};

impl Services for Open {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let core = Arc::clone(&self.0);
        let library = core.library;
        let to = give(Given::Served(Serving { library, service: service.clone(), handler }));
        let served = with_service(service, |ty| core.backend.serve(address(at), ty, to));
        let sides = || sides_of_service(library.name(), at, service);
        let served = served.map_err(|failure| failure.opening(&sides()))?;
        Ok(Box::new(Serves { _served: served, _core: core }))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let core = Arc::clone(&self.0);
        let sides = sides_of_service(core.library.name(), at, service);
        let client = with_service(service, |ty| core.backend.client(address(at), ty));
        let client = client.map_err(|failure| failure.opening(&sides))?;
        Ok(Box::new(Calls { client, service: service.clone(), sides, core }))
    }
}

/// Fields are dropped in order.
struct Serves {
    _served: Handle,
    _core: Arc<Core>,
}

impl Served for Serves {}

/// The calling end. Fields are dropped in order.
struct Calls {
    client: Handle,
    service: ServiceType,
    sides: Sides,
    core: Arc<Core>,
}

impl Client for Calls {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        let sides = &self.sides;
        if !input.ty().same_as(&self.service.input) {
            let (address, ours) = (sides.address.clone(), sides.ours.clone());
            return Err(CallError::TypeMismatch { address, theirs: ours.clone(), ours });
        }
        let mut message = Vec::new();
        let encoded = input.encode_message(&mut message);
        encoded.map_err(|error| CallError::Serialization(error.to_string()))?;
        let (output, waiting) = (self.service.output.clone(), Waiting::new(replies));
        let to = give(Given::Call(Calling { waiting, output, sides: sides.clone() }));
        let run = self.client.request(&message, to).map_err(|failure| failure.calling(sides))?;
        Ok(Box::new(Runs { run, _core: Arc::clone(&self.core) }))
    }
}

/// A request under way. Fields are dropped in order.
struct Runs {
    run: Option<Handle>,
    _core: Arc<Core>,
}

impl Running for Runs {
    fn cancel(&self) {
        if let Some(run) = &self.run {
            run.cancel();
        }
    }
}
