//! Services: `/<component>/rpc` is open while a service of the component is served.

use std::sync::Arc;

use genom_middleware::{Address, Client, OpenError, Served, ServiceHandler, ServiceType, Services};

use crate::backend::Yarp;
use crate::client::YarpClient;
use crate::core::Core;
use crate::desk::Desk;
use crate::desks::{Desks, RPC};
use crate::error::NameError;
use crate::mark;
use crate::names::is_name;
use crate::port::Role;

impl Core {
    /// The port that serves an address, and the name of the service there: `demo/goto` is `goto` of
    /// `/demo/rpc`, `hand/left/close` is `close` of `/hand/left`.
    pub(crate) fn server_of(&self, at: &Address) -> (String, String) {
        match at.name.rsplit_once('/') {
            Some((port, word)) => {
                (self.name_of(&Address::new(&at.instance, port)), word.to_owned())
            }
            None => (self.name_of(&Address::new(&at.instance, RPC)), at.name.clone()),
        }
    }
}

impl Services for Yarp {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let core = &self.core;
        let mut all = self.desks.lock();
        let (port, desk) = match all.get(&at.instance) {
            Some((port, desk)) => (Arc::clone(port), Arc::clone(desk)),
            None => {
                let rpc = Address::new(&at.instance, RPC);
                let name = core.checked_name(&rpc)?;
                if core.own(&name).is_some() {
                    let why = format!("its name on YARP would be {name}, which is a port's here");
                    return Err(core.failed(at, why));
                }
                core.check_free(at, &name)?;
                let desk = Desk::new(&at.instance, core.io.clone());
                let property = mark::of_services(&[]);
                let port = core.open(at, &name, property, Role::Rpc(Arc::clone(&desk)))?;
                all.insert(at.instance.clone(), (Arc::clone(&port), Arc::clone(&desk)));
                (port, desk)
            }
        };
        if !desk.add(&at.name, service, handler) {
            return Err(OpenError::Taken { address: at.clone() });
        }
        core.describe(&port, mark::of_services(&desk.names()));
        drop(all);
        core.names.announce(&port.name);
        let (core, desks) = (Arc::clone(core), Arc::clone(&self.desks));
        Ok(Box::new(YarpServed { at: at.clone(), core, desks }))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let core = &self.core;
        let (port, word) = core.server_of(at);
        if word.is_empty() || !is_name(&port) {
            return Err(core.failed(at, NameError::Name(format!("{port}/{word}"))));
        }
        let (at, service) = (at.clone(), service.clone());
        let core = Arc::clone(core);
        Ok(Box::new(YarpClient { at, port, word, service, core, genomd: None }))
    }
}

/// A served service.
struct YarpServed {
    at: Address,
    core: Arc<Core>,
    desks: Arc<Desks>,
}

impl Served for YarpServed {}

impl Drop for YarpServed {
    fn drop(&mut self) {
        let mut all = self.desks.lock();
        let Some((port, desk)) = all.get(&self.at.instance).cloned() else { return };
        let others = desk.names().into_iter().filter(|name| *name != self.at.name);
        let others: Vec<String> = others.collect();
        if others.is_empty() {
            all.remove(&self.at.instance);
        } else {
            self.core.describe(&port, mark::of_services(&others));
        }
        // Without the lock: what the handler holds may be a service, too.
        drop(all);
        desk.remove(&self.at.name);
        if others.is_empty() {
            self.core.close(&port);
        }
    }
}
