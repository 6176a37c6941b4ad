//! One recording of components in several processes: the frames of each, as one stream.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use genom_protocol::frames::{Channel, EVENTS, End, Frame, Lost, Sample};
use genom_protocol::{Address, RecordingRequest, Subject, routes};
use http_body_util::BodyExt as _;
use hyper::body::{Bytes, Incoming};
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};
use crate::client::AskError;

/// Changes of cells are told on by the daemon, which records them with its own.
const CHANGES: &str = "/genom/changes";

/// Channels of a recording: their numbers have 16 bits.
const MOST: usize = 1 << 16;

/// Pieces of streams that wait to be merged.
const WAITING: usize = 8;

/// How long a cell may take for the samples that it took before it was asked to end.
const LAST: Duration = Duration::from_secs(5);

/// The daemon's own frames; cells follow.
const OWN: usize = 0;

/// Recordings of cells that have begun.
pub struct Recorded {
    cells: Vec<Begun>,
}

/// A recording of a cell.
struct Begun {
    cell: Arc<Cell>,
    /// What it was asked for, and its next process will be.
    wanted: RecordingRequest,
    body: Incoming,
}

/// What comes of a cell.
enum Piece {
    /// Bytes of its stream.
    Bytes(Bytes),
    /// Its process ended: what follows is the stream of the next one.
    Again,
}

/// Makes one numbering of channels and samples out of several.
#[derive(Default)]
struct Merger {
    /// Number of a channel by source and number there.
    channels: HashMap<(usize, u16), u16>,
    by_topic: HashMap<String, u16>,
    /// Samples passed on, by channel.
    samples: HashMap<u16, u32>,
    /// Samples lost, by channel and source.
    lost: HashMap<u16, HashMap<usize, u64>>,
    /// Channels that were begun; a recording has [`MOST`] at most.
    begun: usize,
}

impl Merger {
    /// Takes a frame of a source, and appends what becomes of it.
    fn take(&mut self, source: usize, frame: Frame<'_>, out: &mut Vec<u8>) {
        match frame {
            Frame::Start(start) if source == OWN => Frame::Start(start).append(out),
            Frame::Start(_) | Frame::End(_) => {}
            Frame::Channel(channel) => self.channel(source, channel, out),
            Frame::Sample(sample) => {
                let Some(&channel) = self.channels.get(&(source, sample.channel)) else { return };
                let next = self.samples.entry(channel).or_default();
                Frame::Sample(Sample { channel, number: *next, ..sample }).append(out);
                *next = next.wrapping_add(1);
            }
            Frame::Lost(Lost { channel, lost }) => {
                let Some(&channel) = self.channels.get(&(source, channel)) else { return };
                let all = self.lost.entry(channel).or_default();
                all.insert(source, lost);
                Frame::Lost(Lost { channel, lost: all.values().sum() }).append(out);
            }
        }
    }

    fn channel(&mut self, source: usize, channel: Channel, out: &mut Vec<u8>) {
        if source != OWN && channel.topic == CHANGES {
            return;
        }
        let there = channel.channel;
        let here = match self.by_topic.get(&channel.topic) {
            Some(&known) => known,
            None => {
                let Ok(new) = u16::try_from(self.begun) else {
                    let topic = channel.topic;
                    tracing::warn!("{topic} is not recorded: a recording has {MOST} channels");
                    return;
                };
                self.begun += 1;
                self.by_topic.insert(channel.topic.clone(), new);
                Frame::Channel(Channel { channel: new, ..channel }).append(out);
                new
            }
        };
        self.channels.insert((source, there), here);
    }
}

impl Cells {
    /// Begins a recording in each cell that holds something of what is wanted; in all, when nothing
    /// is named.
    ///
    /// # Errors
    /// A cell is down, or knows no such port.
    pub async fn record(&self, wanted: &RecordingRequest) -> Result<Recorded, OpenError> {
        let mut cells = Vec::new();
        for cell in self.all() {
            let of_cell = |name: &&String| {
                let component = match name.parse::<Subject>() {
                    Ok(Subject::Component(name)) if name == EVENTS => return true,
                    Ok(Subject::Component(name)) => name,
                    Ok(Subject::Port(Address { component, .. })) => component,
                    Err(_) => return false,
                };
                cell.holds(&component)
            };
            let ports: Vec<String> = wanted.ports.iter().filter(of_cell).cloned().collect();
            if ports.is_empty() && !wanted.ports.is_empty() {
                continue;
            }
            cell.answers().await?;
            let wanted = RecordingRequest { ports, times: wanted.times };
            let body = cell.stream(&routes::record(), &wanted).await?;
            cells.push(Begun { cell, wanted, body });
        }
        Ok(Recorded { cells })
    }
}

impl Recorded {
    /// Whether no cell takes part.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Sends the frames of all to `out`, `own` among them. When `own` is over, cells are asked to
    /// end, too, and what they took until then is sent. After a cell whose process ends comes its
    /// next process.
    pub async fn join_frames(self, mut own: mpsc::Receiver<Vec<u8>>, out: mpsc::Sender<Vec<u8>>) {
        let (sender, mut pieces) = mpsc::channel(WAITING);
        let (over, is_over) = watch::channel(false);
        let mut theirs = Theirs::default();
        for (rank, begun) in self.cells.into_iter().enumerate() {
            theirs.add(&begun.cell);
            tokio::spawn(pass(rank, begun, sender.clone(), is_over.clone()));
        }
        drop(sender);
        let (mut merger, mut mine) = (Merger::default(), Source::new(None, OWN));
        // The daemon's first frames come first: they begin the stream.
        let mut goes_on = true;
        while goes_on {
            let merged = tokio::select! {
                biased;
                bytes = own.recv() => match bytes {
                    Some(bytes) => mine.take(&bytes, &mut merger),
                    None => {
                        goes_on = false;
                        Vec::new()
                    }
                },
                Some((rank, piece)) = pieces.recv(), if mine.begun => {
                    theirs.take(rank, piece, &mut merger)
                }
            };
            if !merged.is_empty() && out.send(merged).await.is_err() {
                return;
            }
        }
        over.send_replace(true);
        for source in &theirs.sources {
            source.ask_to_end().await;
        }
        let rest = async {
            while let Some((rank, piece)) = pieces.recv().await {
                let merged = theirs.take(rank, piece, &mut merger);
                if !merged.is_empty() && out.send(merged).await.is_err() {
                    return;
                }
            }
        };
        if timeout(LAST, rest).await.is_err() {
            tracing::warn!("a recording ends without the last samples of a cell: it is silent");
        }
        let mut end = Vec::new();
        let why = mine.end.unwrap_or_else(|| End { why: "the daemon stops".to_owned() });
        Frame::End(why).append(&mut end);
        let _ = out.send(end).await;
    }
}

/// Where frames come from besides the daemon: one for each cell, in its present process.
#[derive(Default)]
struct Theirs {
    sources: Vec<Source>,
    /// How many there were; [`OWN`] is none of them.
    begun: usize,
}

impl Theirs {
    fn add(&mut self, cell: &Arc<Cell>) {
        self.begun += 1;
        self.sources.push(Source::new(Some(Arc::clone(cell)), self.begun));
    }

    /// The frames that become of what came.
    fn take(&mut self, rank: usize, piece: Piece, merger: &mut Merger) -> Vec<u8> {
        let Some(source) = self.sources.get_mut(rank) else { return Vec::new() };
        match piece {
            Piece::Bytes(bytes) => source.take(&bytes, merger),
            Piece::Again => {
                self.begun += 1;
                *source = Source::new(source.cell.take(), self.begun);
                Vec::new()
            }
        }
    }
}

/// Where frames come from.
struct Source {
    cell: Option<Arc<Cell>>,
    /// By which the channels there are known.
    key: usize,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
    /// Whether its first frame came, and the number of the recording there.
    begun: bool,
    number: u64,
    end: Option<End>,
}

impl Source {
    fn new(cell: Option<Arc<Cell>>, key: usize) -> Self {
        Self { cell, key, rest: Vec::new(), begun: false, number: 0, end: None }
    }

    /// Takes bytes of its stream; the frames that become of them.
    fn take(&mut self, bytes: &[u8], merger: &mut Merger) -> Vec<u8> {
        self.rest.extend_from_slice(bytes);
        let (mut merged, mut at) = (Vec::new(), 0);
        loop {
            match Frame::first(&self.rest[at..]) {
                Ok(Some((frame, length))) => {
                    match &frame {
                        Frame::Start(start) => (self.begun, self.number) = (true, start.recording),
                        Frame::End(end) => self.end = Some(end.clone()),
                        _ => {}
                    }
                    merger.take(self.key, frame, &mut merged);
                    at += length;
                }
                Ok(None) => break,
                Err(error) => {
                    tracing::error!("a recording of a cell cannot be read: {error}");
                    at = self.rest.len();
                    break;
                }
            }
        }
        self.rest.drain(..at);
        merged
    }

    async fn ask_to_end(&self) {
        let Some(cell) = self.cell.as_ref().filter(|_| self.begun) else { return };
        let number = self.number.to_string();
        if let Err(error) = cell.ask(&routes::end_recording(&number)).await {
            tracing::debug!("cell {}: the recording there is over: {error}", cell.name());
        }
    }
}

/// Passes the bytes of a cell's stream on, then those of its next process, until the recording is
/// over or nobody wants them.
async fn pass(
    rank: usize,
    begun: Begun,
    to: mpsc::Sender<(usize, Piece)>,
    mut is_over: watch::Receiver<bool>,
) {
    let Begun { cell, wanted, mut body } = begun;
    loop {
        while let Some(Ok(frame)) = body.frame().await {
            let Ok(bytes) = frame.into_data() else { continue };
            if to.send((rank, Piece::Bytes(bytes))).await.is_err() {
                return;
            }
        }
        let next = tokio::select! {
            biased;
            _ = is_over.wait_for(|over| *over) => return,
            next = next(&cell, &wanted) => next,
        };
        let Some(next) = next else { return };
        body = next;
        if to.send((rank, Piece::Again)).await.is_err() {
            return;
        }
        tracing::info!("a recording goes on with the next process of cell {}", cell.name());
    }
}

/// The stream of a cell's next process; `None` where there will be none.
async fn next(cell: &Cell, wanted: &RecordingRequest) -> Option<Incoming> {
    while cell.runs_again().await {
        match cell.stream(&routes::record(), wanted).await {
            Ok(body) => return Some(body),
            // That process has ended, too.
            Err(AskError::Gone(_)) => {}
            Err(error) => {
                let name = cell.name();
                tracing::warn!("a recording has nothing of cell {name} any more: {error}");
                return None;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn channel(number: u16, topic: &str) -> Frame<'static> {
        Frame::Channel(Channel {
            channel: number,
            topic: topic.to_owned(),
            encoding: String::new(),
            schema: String::new(),
            definition: String::new(),
            metadata: BTreeMap::new(),
        })
    }

    fn sample(channel: u16, number: u32, message: &[u8]) -> Frame<'_> {
        Frame::Sample(Sample { channel, number, date: 0, message })
    }

    fn all(mut bytes: &[u8]) -> Vec<String> {
        let mut told = Vec::new();
        while let Some((frame, length)) = Frame::first(bytes).unwrap() {
            told.push(match frame {
                Frame::Channel(one) => format!("{} {}", one.channel, one.topic),
                Frame::Sample(one) => format!("{}:{} {:?}", one.channel, one.number, one.message),
                Frame::Lost(one) => format!("{} lost {}", one.channel, one.lost),
                other => format!("{other:?}"),
            });
            bytes = &bytes[length..];
        }
        told
    }

    #[test]
    fn channels_of_one_topic_are_one_and_samples_are_numbered_without_gaps() {
        let (mut merger, mut out) = (Merger::default(), Vec::new());
        for (source, frame) in [
            (0, channel(0, "/genom/calls")),
            (0, channel(1, CHANGES)),
            (1, channel(0, "/genom/calls")),
            (1, channel(1, CHANGES)),
            (1, channel(4, "/far/pose")),
            (1, sample(0, 0, &[1])),
            (0, sample(0, 0, &[2])),
            (1, sample(1, 0, &[3])),
            (1, sample(4, 0, &[4])),
            (0, Frame::Lost(Lost { channel: 0, lost: 2 })),
            (1, Frame::Lost(Lost { channel: 0, lost: 3 })),
        ] {
            merger.take(source, frame, &mut out);
        }
        let told = all(&out);
        assert_eq!(
            told,
            [
                "0 /genom/calls",
                "1 /genom/changes",
                "2 /far/pose",
                "0:0 [1]",
                "0:1 [2]",
                "2:0 [4]",
                "0 lost 2",
                "0 lost 5"
            ]
        );
    }

    #[test]
    fn no_two_channels_have_one_number_however_many_there_are() {
        let (mut merger, mut out) = (Merger::default(), Vec::new());
        for number in 0..MOST + 2 {
            let of = (number % MOST) as u16;
            merger.take(number / MOST, channel(of, &format!("/a/{number}")), &mut out);
        }
        let told = all(&out);
        assert_eq!((told.len(), told.last().unwrap().as_str()), (MOST, "65535 /a/65535"));
        out.clear();
        merger.take(1, sample(1, 0, &[1]), &mut out);
        assert!(out.is_empty(), "it has no channel");
    }

    #[test]
    fn frames_survive_any_cut() {
        let mut bytes = Vec::new();
        channel(7, "/far/pose").append(&mut bytes);
        sample(7, 0, &[9; 40]).append(&mut bytes);
        for cut in 0..=bytes.len() {
            let (mut source, mut merger) = (Source::new(None, 1), Merger::default());
            let mut out = source.take(&bytes[..cut], &mut merger);
            out.extend(source.take(&bytes[cut..], &mut merger));
            assert_eq!(all(&out).len(), 2, "{cut}");
        }
    }
}
