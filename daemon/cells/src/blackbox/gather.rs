//! What several processes left, as frames of one recording: channels of the same topic and type are
//! one, samples of each process in order of their moments, and nothing from before the window.

use std::collections::BTreeMap;
use std::sync::Arc;

use genom_blackbox::{Kept, Memory, read};
use genom_ports::dates::Dates;
use genom_protocol::frames::{Channel, Frame, Lost, Sample};

use super::boxes::Of;

/// Channels of a recording: their numbers have 16 bits.
const MOST: usize = 1 << 16;

/// What subjects that are no ports begin with.
const SUBJECTS: &str = "/genom/";

/// What was gathered.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    pub(super) messages: u64,
    /// Seconds that topics reach back which do not reach back as far as they should.
    pub(super) short: BTreeMap<String, f64>,
    /// Topics for which there were no channels left.
    pub(super) left_out: u64,
}

/// One numbering of the channels of all processes.
#[derive(Default)]
struct Channels {
    /// Number by topic, schema and definition.
    known: BTreeMap<(String, String, String), u16>,
    /// The next number of a sample of a subject.
    numbers: BTreeMap<u16, u32>,
    lost: BTreeMap<u16, u64>,
}

/// Passes on what is kept of these processes, as far back as `window` nanoseconds.
///
/// # Errors
/// `each` fails.
pub(super) fn gather<E>(
    all: &[(Of, Arc<Memory>)],
    dates: &Dates,
    window: u64,
    mut each: impl FnMut(Frame<'_>) -> Result<(), E>,
) -> Result<Gathered, E> {
    let (calendar, since) = (dates.calendar(), dates.moment().saturating_sub(window));
    let (mut channels, mut told) = (Channels::default(), Gathered::default());
    for (of, memory) in all {
        let tracks = read(memory).unwrap_or_else(|error| {
            let of = of.as_deref().unwrap_or("the daemon");
            tracing::error!("the black box of {of} cannot be read: {error}");
            Vec::new()
        });
        // No record is of a later moment, unless the memory was written over.
        let until = dates.moment();
        let mut records = Vec::new();
        for track in &tracks {
            let Some(head) = head(track, of) else { continue };
            let first = track.records().map(|record| record.moment).find(|one| *one <= until);
            if let Some(first) = first.filter(|first| *first > since && track.dropped() > 0) {
                let reaches = until.saturating_sub(first) as f64 * 1e-9;
                let short = told.short.entry(head.topic.clone()).or_insert(reaches);
                *short = short.min(reaches);
            }
            let within = |moment: u64| (since..=until).contains(&moment);
            let mut wanted = track.records().filter(|one| within(one.moment)).peekable();
            if wanted.peek().is_none() && track.refused == 0 {
                continue;
            }
            let is_port = !head.topic.starts_with(SUBJECTS);
            let Some(channel) = channels.number(head, &mut each)? else {
                told.left_out += 1;
                continue;
            };
            *channels.lost.entry(channel).or_default() += track.refused;
            records.extend(wanted.map(|record| (channel, is_port, record)));
        }
        records.sort_by_key(|(.., record)| record.moment);
        for (channel, is_port, record) in records {
            let number = match is_port {
                // Numbers of samples show what was lost between them.
                true => (record.number & u64::from(u32::MAX)) as u32,
                false => {
                    let next = channels.numbers.entry(channel).or_default();
                    *next = next.wrapping_add(1);
                    next.wrapping_sub(1)
                }
            };
            let date = calendar.date(record.moment);
            each(Frame::Sample(Sample { channel, number, date, message: record.content }))?;
            told.messages += 1;
        }
    }
    for (channel, lost) in channels.lost.into_iter().filter(|(_, lost)| *lost > 0) {
        each(Frame::Lost(Lost { channel, lost }))?;
    }
    Ok(told)
}

/// What a track is of; `None` if the memory was written over.
fn head(track: &Kept, of: &Of) -> Option<Channel> {
    let mut head: Channel = serde_json::from_slice(&track.head).ok()?;
    if let Some(cell) = of.as_ref().filter(|_| !head.topic.starts_with(SUBJECTS)) {
        head.metadata.insert("cell".to_owned(), cell.clone());
    }
    Some(head)
}

impl Channels {
    /// The number of a channel, which is announced when it is new.
    fn number<E>(
        &mut self,
        head: Channel,
        each: &mut impl FnMut(Frame<'_>) -> Result<(), E>,
    ) -> Result<Option<u16>, E> {
        let key = (head.topic.clone(), head.schema.clone(), head.definition.clone());
        if let Some(known) = self.known.get(&key) {
            return Ok(Some(*known));
        }
        let next = self.known.len();
        let Some(channel) = u16::try_from(next).ok().filter(|_| next < MOST) else {
            return Ok(None);
        };
        self.known.insert(key, channel);
        each(Frame::Channel(Channel { channel, ..head }))?;
        Ok(Some(channel))
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use genom_blackbox::Writer;
    use serde_json::json;

    use super::*;

    fn head(topic: &str) -> Vec<u8> {
        let text = json!({
            "channel": 0, "topic": topic, "encoding": "json", "schema": "s", "definition": "d",
            "metadata": {},
        });
        text.to_string().into_bytes()
    }

    #[test]
    fn processes_share_channels_and_what_is_older_than_the_window_is_left_out() {
        let dates = Dates::default();
        let (one, other) = (Memory::new(0).unwrap(), Memory::new(0).unwrap());
        let writers = [Writer::new(&one).unwrap(), Writer::new(&other).unwrap()];
        let now = dates.moment();
        for (rank, writer) in writers.iter().enumerate() {
            let mut calls = writer.track(&head("/genom/calls"), 1 << 16).unwrap();
            let mut pose = writer.track(&head(&format!("/arm{rank}/pose")), 1 << 16).unwrap();
            calls.put(now - 5_000_000_000, b"old");
            calls.put(now - 2_000, format!("call {rank}").as_bytes());
            pose.put(now - 3_000, b"p");
            pose.put(u64::MAX, b"from the future");
            pose.put(now - 1_000, b"q");
            let mut broken = writer.track(b"no head", 1 << 16).unwrap();
            broken.put(now, b"x");
        }
        let all = [(None, Arc::new(one)), (Some("far".to_owned()), Arc::new(other))];
        let mut told = Vec::new();
        let gathered = gather(&all, &dates, 1_000_000_000, |frame| {
            told.push(match frame {
                Frame::Channel(Channel { channel, topic, metadata, .. }) => {
                    format!("{channel} {topic} {metadata:?}")
                }
                Frame::Sample(Sample { channel, number, message, .. }) => {
                    format!("{channel}:{number} {}", String::from_utf8_lossy(message))
                }
                other => format!("{other:?}"),
            });
            Ok::<_, Infallible>(())
        });
        assert_eq!(
            told,
            [
                "0 /genom/calls {}",
                "1 /arm0/pose {}",
                "1:0 p",
                "0:0 call 0",
                "1:2 q",
                "2 /arm1/pose {\"cell\": \"far\"}",
                "2:0 p",
                "0:1 call 1",
                "2:2 q",
            ]
        );
        let gathered = gathered.unwrap();
        assert_eq!((gathered.messages, gathered.short.len()), (6, 0));
    }

    #[test]
    fn a_topic_that_does_not_reach_back_as_far_as_it_should_is_told() {
        let dates = Dates::default();
        let memory = Memory::new(0).unwrap();
        let mut loud = Writer::new(&memory).unwrap().track(&head("/a/loud"), 8192).unwrap();
        (0..1000).for_each(|_| loud.put(dates.moment(), &[0; 100]));
        let all = [(None, Arc::new(memory))];
        let told = gather(&all, &dates, u64::MAX, |_| Ok::<_, Infallible>(())).unwrap();
        assert!(told.short["/a/loud"] < 60.0 && told.messages < 64, "{told:?}");
    }
}
