//! Readers that DDS has connected to a writer of ours, and that may not know the writer yet.
//!
//! DDS owes a volatile reader nothing that was written before both ends know each other, and
//! says when this end does. What RustDDS writes then arrives in any case: its readers ask for
//! what they missed. Others throw away what a writer sends that they do not know, and begin
//! after the first heartbeat they hear (RTPS 2.5, 8.4.12.2); so does what was written between.
//! They acknowledge that heartbeat: then they are ready.

use std::time::{Duration, Instant};

use rustdds::{GUID, WriteOptionsBuilder};

use crate::quality::same_make;
use crate::wire::{Payload, Writer};

/// Longest and shortest time between two looks at what is acknowledged.
const LOOKS: (Duration, Duration) = (Duration::from_millis(2), Duration::from_millis(50));

/// A reader that acknowledges nothing for so long counts as ready.
const LONGEST: Duration = Duration::from_secs(5);

/// Writes a message to a reader that does not exist. From then on a reader that acknowledges
/// everything has heard of this writer, also before the first sample.
///
/// Not for transient local writers, which would keep it for all who come.
pub(crate) fn prime(writer: &Writer) {
    let options = WriteOptionsBuilder::new().to_single_reader(GUID::GUID_UNKNOWN).build();
    if writer.write_with_options(Payload(Default::default()), options).is_err() {
        tracing::debug!("a writer cannot tell when its readers are ready");
    }
}

/// Whether all reliable readers of a primed writer know it, and have all there is.
pub(crate) fn acknowledged(writer: &Writer) -> bool {
    writer.wait_for_acknowledgments(Duration::ZERO).unwrap_or(true)
}

#[derive(Clone, Copy, Debug)]
struct Meeting {
    writer: GUID,
    reader: GUID,
    since: Instant,
}

/// Those who are not ready yet.
#[derive(Debug, Default)]
pub(crate) struct Meetings(Vec<Meeting>);

impl Meetings {
    /// DDS has connected the two; true if the reader is ready at once.
    pub(crate) fn begin(&mut self, writer: GUID, reader: GUID) -> bool {
        let ready = same_make(&writer, &reader);
        if !ready {
            self.0.push(Meeting { writer, reader, since: Instant::now() });
        }
        ready
    }

    /// Some readers are gone.
    pub(crate) fn lost(&mut self, gone: impl Fn(&GUID) -> bool) {
        self.0.retain(|meeting| !gone(&meeting.reader));
    }

    /// How long to wait until the next look; `None` if there is nobody to look at.
    pub(crate) fn pause(&self) -> Option<Duration> {
        let youngest = self.0.iter().map(|meeting| meeting.since.elapsed()).min()?;
        Some((youngest / 8).clamp(LOOKS.0, LOOKS.1))
    }

    /// Takes out those that are ready now, as writer and reader.
    pub(crate) fn ready(&mut self, acknowledged: impl Fn(&GUID) -> bool) -> Vec<(GUID, GUID)> {
        self.0
            .extract_if(.., |meeting| {
                meeting.since.elapsed() >= LONGEST || acknowledged(&meeting.writer)
            })
            .map(|meeting| (meeting.writer, meeting.reader))
            .collect()
    }
}
