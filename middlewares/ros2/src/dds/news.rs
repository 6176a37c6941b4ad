//! Distributes the events of DDS's discovery to those parts that need them.

use std::sync::Arc;

use crate::dds::rustdds::{
    DomainParticipantStatusEvent as Event, EndpointDescription, GUID, LostReason,
};

use crate::dds::feeds::Feeds;
use crate::dds::graph::{Found, Graph};
use crate::dds::obstacles;
use crate::dds::receiver::News;
use crate::dds::reunions::Reunions;
use crate::dds::sender::Orders;

fn found(end: EndpointDescription, writer: bool) -> (GUID, Found) {
    (end.guid, Found::new(end, writer))
}

/// A handler for events about participants other than `ourselves`.
pub(crate) fn news(
    ourselves: GUID,
    known: Arc<Graph>,
    hearing: Arc<Feeds>,
    orders: Orders,
    mut reunions: Reunions,
) -> News {
    Box::new(move |event| match event {
        Event::WriterDetected { writer } if writer.guid.prefix != ourselves.prefix => {
            let (guid, found) = found(writer, true);
            let topic = found.topic.clone();
            let new = known.found(guid, found);
            hearing.follow(&topic);
            hearing.settle();
            if new {
                obstacles::tell(&known, &hearing, &topic);
            }
        }
        Event::ReaderDetected { reader } if reader.guid.prefix != ourselves.prefix => {
            let (guid, found) = found(reader, false);
            let topic = found.topic.clone();
            if known.found(guid, found) {
                obstacles::tell(&known, &hearing, &topic);
            }
        }
        Event::WriterLost { guid, .. } => known.lost(&guid),
        Event::ReaderLost { guid, .. } => {
            known.lost(&guid);
            orders.part(move |reader| *reader == guid);
        }
        Event::ParticipantLost { id, reason } => {
            let silent = matches!(reason, LostReason::Timeout { .. });
            let ends = known.lost_all(|guid| guid.prefix == id, silent);
            reunions.lost(id, ends, silent);
            orders.part(move |reader| reader.prefix == id);
        }
        Event::ParticipantDiscovered { dpd } => reunions.found(dpd.guid.prefix),
        Event::RemoteReaderMatched { local_writer, remote_reader }
            if !reunions.matched(local_writer) =>
        {
            orders.meet(local_writer, remote_reader);
        }
        Event::RemoteWriterMatched { local_reader, .. } => _ = reunions.matched(local_reader),
        _ => {}
    })
}
