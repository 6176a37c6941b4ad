//! Readers that DDS has connected to a writer of ours, but that may not know the writer yet.
//!
//! A volatile reader need not get what was written before both ends know each other, and DDS
//! reports only when this end does. Readers of RustDDS get what is written from then on, because
//! they request what they missed. Other implementations discard samples of a writer that they do
//! not know, and begin after the first heartbeat that they receive (RTPS 2.5, 8.4.12.2), so that
//! what was written in between is lost. They acknowledge that heartbeat: from then on they are
//! ready.

use std::time::{Duration, Instant};

use crate::dds::rustdds::{GUID, WriteOptionsBuilder};

use crate::dds::quality::same_make;
use crate::dds::wire::{Payload, Writer};

/// Shortest and longest interval between checks of acknowledgements.
const LOOKS: (Duration, Duration) = (Duration::from_millis(2), Duration::from_millis(50));

/// A reader that acknowledges nothing counts as ready after this time.
const LONGEST: Duration = Duration::from_secs(5);

/// Writes a message to a reader that does not exist. The writer then has a message to acknowledge,
/// so that acknowledgements tell that a reader knows it even before the first sample.
///
/// Not for transient local writers, which would keep the message for every new reader.
pub(crate) fn prime(writer: &Writer) {
    let options = WriteOptionsBuilder::new().to_single_reader(GUID::GUID_UNKNOWN).build();
    if writer.write_with_options(Payload(Default::default()), options).is_err() {
        tracing::debug!("a writer cannot tell when its readers are ready");
    }
}

/// Whether all reliable readers of a primed writer know it and have received everything.
pub(crate) fn acknowledged(writer: &Writer) -> bool {
    acknowledged_in(writer, Duration::ZERO)
}

/// The same after a limited time. Readers that are gone without a word acknowledge nothing.
pub(crate) fn acknowledged_in(writer: &Writer, longest: Duration) -> bool {
    writer.wait_for_acknowledgments(longest).unwrap_or(true)
}

#[derive(Clone, Copy, Debug)]
struct Meeting {
    writer: GUID,
    reader: GUID,
    since: Instant,
}

/// The readers that are not ready yet.
#[derive(Debug, Default)]
pub(crate) struct Meetings(Vec<Meeting>);

impl Meetings {
    /// DDS has connected the two. Returns true if the reader is ready at once.
    pub(crate) fn begin(&mut self, writer: GUID, reader: GUID) -> bool {
        let ready = same_make(&writer, &reader);
        if !ready {
            self.0.push(Meeting { writer, reader, since: Instant::now() });
        }
        ready
    }

    /// Removes readers that are gone.
    pub(crate) fn lost(&mut self, gone: impl Fn(&GUID) -> bool) {
        self.0.retain(|meeting| !gone(&meeting.reader));
    }

    /// Time until the next check; `None` if no reader is waited for.
    pub(crate) fn pause(&self) -> Option<Duration> {
        let youngest = self.0.iter().map(|meeting| meeting.since.elapsed()).min()?;
        Some((youngest / 8).clamp(LOOKS.0, LOOKS.1))
    }

    /// Removes those that are ready now, and returns them as writer and reader.
    pub(crate) fn ready(&mut self, acknowledged: impl Fn(&GUID) -> bool) -> Vec<(GUID, GUID)> {
        self.0
            .extract_if(.., |meeting| {
                meeting.since.elapsed() >= LONGEST || acknowledged(&meeting.writer)
            })
            .map(|meeting| (meeting.writer, meeting.reader))
            .collect()
    }
}
