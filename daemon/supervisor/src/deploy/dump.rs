//! Writes the running system as a deployment.

use std::collections::BTreeMap;

use genom_description::model::ServiceKind;

use crate::components::{Components, Hosted};
use crate::connections::Connections;
use crate::ties::Connection;
use genom_configuration::{BackendNames, CallEntry, Deployment, LoadRequest};

/// Components, connections and requests that run now; applied to a new daemon the deployment gives
/// the same system.
pub(super) fn dump(components: &Components, connections: &Connections) -> Deployment {
    let mut all = Deployment::default();
    for hosted in components.all() {
        all.component.push(component(&hosted));
        all.connection.extend(hosted.ties.connections().iter().map(Connection::entry));
        let entry = |service: &str, inputs| CallEntry {
            component: hosted.name.clone(),
            service: service.to_owned(),
            inputs,
        };
        for (service, inputs) in hosted.standing.all_deployed() {
            // Running activities are handled below.
            let known = hosted.model().services.iter().find(|known| known.name == service);
            if known.is_some_and(|known| known.kind != ServiceKind::Activity) {
                all.call.push(entry(&service, inputs));
            }
        }
        for activity in hosted.activities.all() {
            if let Some(inputs) = hosted.standing.inputs(activity.number) {
                all.activity.push(entry(&activity.service, inputs));
            }
        }
    }
    // Declared connections of which one side is missing.
    for declared in connections.declared() {
        if !all.connection.iter().any(|made| made.inport == declared.inport) {
            all.connection.push(declared);
        }
    }
    all
}

/// The same with only those activities that a deployment started: what runs again after a fault.
/// Whoever started another activity was told of its end, and decides whether to start it again.
pub(super) fn declared(components: &Components, connections: &Connections) -> Deployment {
    let mut all = dump(components, connections);
    all.activity.retain(|entry| {
        let hosted = components.get(&entry.component);
        hosted.is_some_and(|hosted| {
            let deployed = hosted.standing.all_deployed();
            deployed.iter().any(|(service, _)| *service == entry.service)
        })
    });
    all
}

/// The request that loads a component as it is now.
pub(super) fn component(hosted: &Hosted) -> LoadRequest {
    let bindings = &hosted.ties.bindings;
    let ports: BTreeMap<String, BackendNames> = bindings.ports();
    let build = hosted.build();
    LoadRequest {
        library: build.library,
        gen_file: build
            .request
            .gen_file
            .as_ref()
            .map(|file| std::path::absolute(file).unwrap_or_else(|_| file.clone())),
        name: Some(hosted.name.clone()),
        backend: Some(bindings.component()),
        ports,
        attributes: hosted.standing.attributes(),
        after: Vec::new(),
        ..build.request
    }
}
