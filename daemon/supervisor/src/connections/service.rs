//! Connects remotes to services: directly within this daemon, through a middleware otherwise.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use genom_description::model::RemoteIx;
use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, EndpointKind, Middleware, OpenError, ServiceType};
use genom_nearest::suggest;
use genom_runtime::HeldUp;
use genom_runtime::body::RemoteCall;
use genom_types::DataType;

use super::calls::{DirectCall, FarCall};
use super::core::{Connections, LOOK_AGAIN, Patience, Wanted};
use super::elsewhere::SHARED;
use super::error::{ConnectError, Kind};
use super::find::{Outlet, is_visible, visible};
use super::serve::kind_of;
use crate::components::Hosted;
use crate::ties::ServiceConnection;
use genom_bus::Change;

impl Connections {
    /// Connects a remote, in place of its previous service.
    pub(super) fn connect_service(
        &self,
        caller: &Hosted,
        remote: RemoteIx,
        wanted: &Wanted,
    ) -> Result<ServiceConnection, ConnectError> {
        let Outlet { address, asked, .. } = wanted.outlet(Kind::Service)?;
        let fixed = asked.is_some();
        let own = self.components.get(&address.instance);
        let (call, backend): (Box<dyn RemoteCall>, _) = match (asked, own) {
            (None, Some(provider)) => {
                (Box::new(self.near(caller, remote, &provider, wanted, &address)?), None)
            }
            (asked, _) => {
                let far = self.far(caller, remote, asked.as_deref(), wanted, &address)?;
                let backend = far.backend().to_owned();
                (Box::new(far), Some(backend))
            }
        };
        caller.bind_remote(remote, Some(call))?;
        let name = &caller.model().remotes[remote].name;
        let remote_name = caller.address(name, None);
        let connection =
            ServiceConnection { remote: remote_name, service: address, backend, fixed };
        caller.ties.remote_connected(remote, connection.clone());
        self.bus.tell(&Change::RemoteConnected {
            remote: connection.remote.to_string(),
            service: connection.service.to_string(),
        });
        Ok(connection)
    }

    /// A connection to a component of this daemon, about which everything is known.
    fn near(
        &self,
        caller: &Hosted,
        remote: RemoteIx,
        provider: &Hosted,
        wanted: &Wanted,
        at: &Address,
    ) -> Result<DirectCall, ConnectError> {
        let services = &provider.model().services;
        let Some(theirs) = services.iter().find(|service| service.name == at.name) else {
            let names = services.iter().map(|one| one.name.as_str());
            return Err(wanted.no_service(" in this daemon", suggest(&at.name, names)));
        };
        let ours = &caller.model().remotes[remote];
        // genom3.md 4.9: the digests of both sides are compared when they are connected.
        if ours.digest != theirs.call_digest {
            let calls = format!("{} of interface {} ({})", ours.name, ours.interface, ours.digest);
            let is = format!("{} ({})", theirs.name, theirs.call_digest);
            return Err(differs(wanted, &calls, &is));
        }
        Ok(DirectCall::new(&self.components, provider, theirs, &caller.model().version))
    }

    /// A connection through a middleware: the one requested, else the first one of the caller on
    /// which the service is visible.
    fn far(
        &self,
        caller: &Hosted,
        remote: RemoteIx,
        asked: Option<&str>,
        wanted: &Wanted,
        at: &Address,
    ) -> Result<FarCall, ConnectError> {
        let middlewares = self.reaching(caller, asked, wanted, at)?;
        let middleware = self.showing(&middlewares, wanted, at)?;
        let (model, types) = (&caller.model().remotes[remote], &caller.specification().types);
        let lay_out = |ty| {
            DataType::new(types, ty).map_err(|error| OpenError::Failed {
                backend: middleware.name().to_owned(),
                address: at.clone(),
                why: error.to_string(),
            })
        };
        // genom3.md 4.9: parameters and exceptions must agree here as well.
        let ty =
            ServiceType::new(kind_of(model.kind), lay_out(model.input)?, lay_out(model.output)?)
                .described(&model.digest);
        let ours = types_of_service(&ty);
        FarCall::open(&middleware, at, ty, &caller.model().version).map_err(|error| match error {
            OpenError::TypeMismatch { theirs, .. } => {
                let calls = format!("{} of interface {}: {ours}", model.name, model.interface);
                differs(wanted, &calls, &theirs)
            }
            error => error.into(),
        })
    }

    /// The middlewares on which the service may be found.
    fn reaching(
        &self,
        caller: &Hosted,
        asked: Option<&str>,
        wanted: &Wanted,
        at: &Address,
    ) -> Result<Vec<Arc<dyn Middleware>>, ConnectError> {
        if let Some(asked) = asked {
            return Ok(vec![self.backends.get(asked)?]);
        }
        let bindings = caller.ties.bindings.component();
        let mut all = Vec::new();
        for name in bindings.names() {
            let middleware = self.backends.get(name)?;
            let can = middleware.capabilities();
            if can.services && can.cross_process {
                all.push(middleware);
            }
        }
        if all.is_empty() && self.elsewhere.holds(&at.instance) {
            all.push(self.backends.get(SHARED)?);
        }
        if all.is_empty() {
            let components = self.components.all();
            let names = components.iter().map(|hosted| hosted.name.as_str());
            let place =
                format!(": no such component in this daemon, and {bindings} calls no other");
            return Err(wanted.no_service(&place, suggest(&at.instance, names)));
        }
        Ok(all)
    }

    /// The first middleware on which the service is visible; on a network this may take a while.
    fn showing(
        &self,
        all: &[Arc<dyn Middleware>],
        wanted: &Wanted,
        at: &Address,
    ) -> Result<Arc<dyn Middleware>, ConnectError> {
        let patience = if wanted.wait { Patience::None } else { wanted.patience };
        let ends = all.iter().map(|middleware| patience.end(&self.backends, middleware.as_ref()));
        let end = ends.max().unwrap_or_else(Instant::now);
        loop {
            for middleware in all {
                if is_visible(middleware.as_ref(), EndpointKind::Service, at)? {
                    return Ok(Arc::clone(middleware));
                }
            }
            if Instant::now() < end {
                std::thread::park_timeout(LOOK_AGAIN);
                continue;
            }
            if let Some(first) = all.first().filter(|_| wanted.wait) {
                return Ok(Arc::clone(first));
            }
            let mut seen = BTreeSet::new();
            for middleware in all {
                seen.extend(visible(middleware.as_ref(), EndpointKind::Service, at)?);
            }
            let names: Vec<_> = all.iter().map(|middleware| middleware.name()).collect();
            let help = format!(
                "{}; one that comes later is waited for with --wait",
                suggest(&at.to_string(), seen.iter().map(String::as_str))
            );
            let message =
                format!("there is no service `{}` on {}", wanted.outport, names.join(", "));
            let kind = Kind::Service;
            return Err(ConnectError::NoSuchOutport { kind, message, help, absent: true });
        }
    }

    /// Disconnects a remote. Returns whether it was connected.
    pub(super) fn disconnect_service(
        &self,
        caller: &Hosted,
        remote: RemoteIx,
    ) -> Result<bool, HeldUp> {
        let Some(had) = caller.ties.remote_disconnected(remote) else { return Ok(false) };
        if let Err(held_up) = caller.bind_remote(remote, None) {
            caller.ties.remote_connected(remote, had);
            return Err(held_up);
        }
        Ok(true)
    }
}

/// The error for a service whose parameters or exceptions differ.
fn differs(wanted: &Wanted, ours: &str, theirs: &str) -> ConnectError {
    let Wanted { inport: remote, outport: service, .. } = wanted;
    let message =
        format!("{remote} calls {ours}, {service} is {theirs}: make the two .gen interfaces equal");
    ConnectError::Type { message, help: None }
}
