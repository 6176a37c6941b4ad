//! Finds out why existing ends are not connected, or exchange less than they could.

use genom_middleware::{Address, Obstacle};

use crate::dds::feeds::Feeds;
use crate::dds::graph::Graph;
use crate::dds::quality::{self, Ours};

/// What keeps ends of others at an address from connecting to ours, or to any.
pub(crate) fn obstacles(graph: &Graph, feeds: &Feeds, at: &Address, topic: &str) -> Vec<Obstacle> {
    let mut all = Vec::new();
    if let Some((ours, offers)) = graph.writer(topic) {
        for (_, reader) in graph.others(topic, false) {
            all.extend(quality::other_structure(at, Ours::Writer, ours.hash.as_deref(), &reader));
            all.extend(quality::obstacle(at, Ours::Writer, &offers, &reader.qos));
        }
    }
    for handle in feeds.of(topic) {
        let (asks, hash) = (handle.qos(), handle.feed.hash.as_deref());
        let writers = graph.others(topic, true);
        for (_, writer) in &writers {
            all.extend(quality::other_structure(at, Ours::Reader, hash, writer));
            all.extend(quality::obstacle(at, Ours::Reader, &writer.qos, &asks));
        }
        all.extend(quality::mixed(at, &asks, &writers));
    }
    all.dedup();
    all
}

/// Logs what keeps a newly discovered end from connecting to ours.
pub(crate) fn tell(graph: &Graph, feeds: &Feeds, topic: &str) {
    let Some(name) = topic.strip_prefix("rt/") else { return };
    for Obstacle { what, fix } in obstacles(graph, feeds, &Address::new("", name), topic) {
        tracing::warn!("{what}: {fix}");
    }
}
