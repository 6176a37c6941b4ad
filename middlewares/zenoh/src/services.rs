//! Services: how they are served and called.

use std::sync::Arc;

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    Address, Client, EndpointKind, OpenError, Served, ServiceHandler, ServiceKind, ServiceType,
    Services,
};
use zenoh::Wait;
use zenoh::key_expr::OwnedKeyExpr;

use crate::backend::Zenoh;
use crate::client::ZenohClient;
use crate::service::{Server, ZenohServed};

impl Services for Zenoh {
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let core = &self.core;
        let key = core.key(at)?;
        let digest = service.digest();
        let types = types_of_service(service);
        let claim = core.claim(at, EndpointKind::Service, digest, types)?;
        let orders = core.orders().clone();
        let server = Arc::new(Server::new(service.clone(), handler, orders));
        // A query on all keys (`**`) is not a request to this service.
        let declare = |key: OwnedKeyExpr, act: fn(&Server, zenoh::query::Query)| {
            let server = Arc::clone(&server);
            let queryable = core.session().declare_queryable(key.clone()).complete(true);
            queryable
                .callback(move |query| {
                    if query.key_expr().as_str() == key.as_str() {
                        act(&server, query);
                    }
                })
                .wait()
                .map_err(|error| core.failed(at, error))
        };
        let cancel = (service.kind == ServiceKind::Activity)
            .then(|| declare(core.key(&cancel_of(at))?, Server::cancel))
            .transpose()?;
        let queryable = declare(key, Server::request)?;
        let claim = core.show(at, claim)?;
        let shown = Some((queryable, cancel, claim));
        Ok(Box::new(ZenohServed { server, shown, core: Arc::clone(core) }))
    }

    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let core = &self.core;
        let digest = service.digest();
        if let Some(theirs) = core.graph().other_service(&at.to_string(), &digest) {
            let ours = types_of_service(service);
            return Err(OpenError::TypeMismatch { address: at.clone(), ours, theirs });
        }
        Ok(Box::new(ZenohClient {
            key: core.key(at)?,
            cancel: core.key(&cancel_of(at))?,
            at: at.clone(),
            ty: service.clone(),
            core: Arc::clone(core),
        }))
    }
}

/// Address of the key on which an activity is cancelled.
fn cancel_of(at: &Address) -> Address {
    Address::new(at.instance.as_str(), format!("{}/cancel", at.name))
}
