//! Who publishes, reads and serves what.

use std::collections::{BTreeMap, BTreeSet};

use foxglove::ws_protocol::server::ConnectionGraphUpdate;
use foxglove::ws_protocol::server::connection_graph_update::{
    AdvertisedService, PublishedTopic, SubscribedTopic,
};
use genom_protocol::{ConnectionKind, PortDirection, PortParameters, routes};
use tokio_tungstenite::tungstenite::Message;

use crate::inside::{Asker, Inside, Refused};
use crate::reply;

type Ends = BTreeMap<String, BTreeSet<String>>;

/// The ends of topics and services: components, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Graph {
    published: Ends,
    read: Ends,
    services: Ends,
}

impl Graph {
    /// The ports and their connections, as far as this one may read them.
    pub(crate) async fn read(inside: &Inside, by: &Asker) -> Result<Self, Refused> {
        let query = PortParameters { values: Some(false) };
        let ports = inside.ask(by, &routes::ports().with(&query), "").await?;
        let connections = inside.ask(by, &routes::connections(), "").await?;
        let mut graph = Self::default();
        for port in ports.ports.iter().filter(|port| port.direction == PortDirection::Out) {
            add(&mut graph.published, topic(&port.address), &port.address);
        }
        for one in connections.connections {
            if one.kind == ConnectionKind::Port {
                add(&mut graph.read, topic(&one.outport), &one.inport);
            }
        }
        Ok(graph)
    }

    /// With these services of components, too.
    pub(crate) fn with_services<'a>(
        mut self,
        all: impl Iterator<Item = (&'a String, &'a String)>,
    ) -> Self {
        for (component, service) in all {
            add(&mut self.services, format!("/{component}/{service}"), component);
        }
        self
    }

    /// What changed since another one; `None` if nothing did.
    pub(crate) fn since(&self, before: &Self) -> Option<Message> {
        let mut change = ConnectionGraphUpdate::default();
        for (name, ids) in changed(&self.published, &before.published) {
            change.published_topics.push(PublishedTopic::new(name, ids));
        }
        for (name, ids) in changed(&self.read, &before.read) {
            change.subscribed_topics.push(SubscribedTopic::new(name, ids));
        }
        for (name, ids) in changed(&self.services, &before.services) {
            if ids.is_empty() {
                change.removed_services.push(name.clone());
            } else {
                change.advertised_services.push(AdvertisedService::new(name, ids));
            }
        }
        // A topic is removed once it has no end of either kind.
        let had = before.published.keys().chain(before.read.keys());
        let gone = had
            .filter(|name| !self.published.contains_key(*name) && !self.read.contains_key(*name));
        change.removed_topics = gone.collect::<BTreeSet<_>>().into_iter().cloned().collect();
        let empty = ConnectionGraphUpdate::default();
        (change != empty).then(|| reply::json(&change))
    }
}

/// Entries that differ, with their ends now.
fn changed<'a>(
    now: &'a Ends,
    before: &'a Ends,
) -> impl Iterator<Item = (&'a String, Vec<&'a String>)> {
    let gone = before.keys().filter(|name| !now.contains_key(*name)).map(|name| (name, Vec::new()));
    let other = now.iter().filter(|(name, ends)| before.get(*name) != Some(ends));
    other.map(|(name, ends)| (name, ends.iter().collect())).chain(gone)
}

/// As recordings name the topic of a port. A foreign one keeps its middleware before its name.
fn topic(address: &str) -> String {
    if address.contains(':') { address.to_owned() } else { format!("/{address}") }
}

fn add(to: &mut Ends, name: String, address: &str) {
    let component = address.split('/').next().unwrap_or(address);
    to.entry(name).or_default().insert(component.to_owned());
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn a_change_names_what_is_new_and_what_is_gone() {
        let mut before = Graph::default();
        add(&mut before.published, topic("a/x"), "a/x");
        add(&mut before.published, topic("b/y"), "b/y");
        add(&mut before.read, topic("a/x"), "b/in");
        let mut now = before.clone();
        assert_eq!(now.since(&before), None);
        now.published.remove("/b/y");
        add(&mut now.read, topic("a/x"), "c/in/left");
        add(&mut now.read, topic("ros2:/scan"), "c/scan");
        let now = now.with_services([(&"a".to_owned(), &"go".to_owned())].into_iter());
        let told = now.since(&before).unwrap().into_text().unwrap();
        let told: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(
            told,
            json!({
                "op": "connectionGraphUpdate",
                "publishedTopics": [{"name": "/b/y", "publisherIds": []}],
                "subscribedTopics": [
                    {"name": "/a/x", "subscriberIds": ["b", "c"]},
                    {"name": "ros2:/scan", "subscriberIds": ["c"]},
                ],
                "advertisedServices": [{"name": "/a/go", "providerIds": ["a"]}],
                "removedTopics": ["/b/y"],
                "removedServices": [],
            })
        );
    }
}
