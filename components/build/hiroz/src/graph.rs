//! What the graph of hiroz has: nodes, topics, services, actions.

use std::time::Instant;

use hiroz::TypeInfo;
use hiroz::entity::{EndpointKind, Entity};
use hiroz::node::ZNode;
use serde_json::{Value, json};

use super::{Outcome, PATIENCE, Wrong, text};

/// Waits for what the graph tells by a signal. It signals without its lock, so that one may be
/// missed: hence the short waits.
fn until(node: &ZNode, what: &str, mut holds: impl FnMut() -> bool) -> Result<(), Wrong> {
    let end = Instant::now() + PATIENCE;
    let (mutex, changed) = &*node.graph().change_signal;
    loop {
        let guard = mutex.lock().map_err(|error| error.to_string())?;
        if holds() {
            return Ok(());
        }
        if Instant::now() >= end {
            return Err(format!("never: {what}").into());
        }
        let short = PATIENCE / 500;
        drop(changed.wait_timeout(guard, short).map_err(|error| error.to_string())?);
    }
}

/// Waits until somebody serves it.
pub(crate) fn served(node: &ZNode, service: &str) -> Result<(), Wrong> {
    let graph = node.graph();
    until(node, service, || graph.count_by_service(EndpointKind::Service, service) > 0)
}

/// Waits for an end of another program, and tells its type: hiroz cannot know those of components.
pub(crate) fn type_of(node: &ZNode, kind: EndpointKind, name: &str) -> Result<TypeInfo, Wrong> {
    let graph = node.graph();
    let mut found = None;
    until(node, name, || {
        let ends = match kind {
            EndpointKind::Service | EndpointKind::Client => {
                graph.get_entities_by_service(kind, name)
            }
            _ => graph.get_entities_by_topic(kind, name),
        };
        found = ends.iter().find_map(|end| match &**end {
            Entity::Endpoint(end) => end.type_info.clone(),
            Entity::Node(_) => None,
        });
        found.is_some()
    })?;
    found.ok_or_else(|| format!("{name} has no type").into())
}

pub(crate) fn command(node: &ZNode, verb: &str, given: &[Value]) -> Outcome {
    let graph = node.graph();
    match verb {
        "nodes" | "no node" => {
            let name = text(given, 0)?;
            let there = || {
                let all = graph.get_node_names();
                all.iter().any(|(node, before)| {
                    format!("{}/{node}", before.trim_end_matches('/')) == name
                })
            };
            until(node, name, || there() == (verb == "nodes"))?;
            Ok(json!(there()))
        }
        "topic" | "no topic" => {
            let name = text(given, 0)?;
            let there = || graph.get_topic_names_and_types().iter().any(|(topic, _)| topic == name);
            until(node, name, || there() == (verb == "topic"))?;
            Ok(json!(there()))
        }
        "no service" => {
            let name = text(given, 0)?;
            let there = || graph.count_by_service(EndpointKind::Service, name) > 0;
            until(node, name, || !there())?;
            Ok(json!(there()))
        }
        "topics" => Ok(json!(graph.get_topic_names_and_types())),
        "services" => Ok(json!(graph.get_service_names_and_types())),
        "actions" => Ok(json!(graph.get_action_names_and_types())),
        // The hash of a service of components, which no package has.
        "hash" => {
            let ty = type_of(node, EndpointKind::Service, text(given, 0)?)?;
            Ok(json!(ty.hash.to_rihs_string()))
        }
        other => Err(format!("no verb {other}").into()),
    }
}
