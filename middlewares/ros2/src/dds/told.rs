//! Announcements to and from other daemons and ROS nodes.

use std::sync::Arc;
use std::time::Duration;

use crate::dds::rustdds::GUID;
use crate::dds::rustdds::bytes::Bytes;

use crate::dds::feeds::Feeds;
use crate::dds::graph::Graph;
use crate::dds::info::{self, Ends};
use crate::dds::meetings::acknowledged_in;
use crate::dds::process::Process;
use crate::dds::receiver::{Sample, Sink};
use crate::dds::sender::Announce;
use crate::dds::wire::{Payload, Writer};
use crate::typed;

/// Announces this daemon's nodes and ends.
pub(crate) struct Told {
    pub(crate) ends: Writer,
    pub(crate) nodes: Writer,
    pub(crate) graph: Arc<Graph>,
    pub(crate) feeds: Arc<Feeds>,
    pub(crate) participant: info::Gid,
    pub(crate) process: Process,
}

impl Announce for Told {
    fn tell(&self) -> bool {
        let (ends, nodes) = self.graph.ours();
        let ends = typed::encode(&Ends { process: self.process.clone(), ends });
        let nodes = typed::encode(&Graph::nodes(self.participant, nodes));
        [(&self.ends, ends), (&self.nodes, nodes)].into_iter().all(|(writer, payload)| {
            // Repeating it would fail again.
            let Some(payload) = payload else { return true };
            writer.write(Payload(Bytes::from(payload)), None).is_ok()
        })
    }

    fn settle(&self, longest: Duration) -> bool {
        acknowledged_in(&self.ends, longest)
    }

    fn complain(&self) {
        self.feeds.complain();
    }
}

/// Receives the announcements of other daemons.
pub(crate) struct Hear {
    pub(crate) graph: Arc<Graph>,
    pub(crate) feeds: Arc<Feeds>,
    pub(crate) ourselves: GUID,
}

impl Sink for Hear {
    fn arrive(&mut self, sample: Sample<'_>) {
        if sample.writer.prefix == self.ourselves.prefix {
            return;
        }
        match typed::decode::<Ends>(sample.message) {
            Some(ends) => {
                self.graph.told(sample.writer, ends);
                self.feeds.settle();
            }
            None => tracing::warn!("a participant tells what cannot be read; it is left out"),
        }
    }
}
