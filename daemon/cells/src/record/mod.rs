//! One recording of components in several processes: the frames of each, as one stream.

mod merger;
mod order;
mod source;
mod stream;

use std::sync::Arc;
use std::time::Duration;

use genom_protocol::frames::{EVENTS, End, Frame};
use genom_protocol::{Address, RecordingRequest, Subject};
use genom_supervisor::recording::Apart;
use hyper::body::Bytes;
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;

use self::merger::{Merger, Origin};
use self::source::Source;
use self::stream::Stream;
use crate::cell::Cell;
use crate::cells::{Cells, OpenError};
use crate::client::AskError;

/// Pieces of streams that wait to be merged.
const WAITING: usize = 8;

/// How long a cell may take for the samples that it took before it was asked to end.
const LAST: Duration = Duration::from_secs(5);

/// Recordings of cells that have begun.
pub struct Recorded {
    cells: Vec<Begun>,
    ordered: bool,
    apart: Arc<Apart>,
}

/// A recording of a cell.
struct Begun {
    cell: Arc<Cell>,
    /// What it was asked for, and its next process will be.
    wanted: RecordingRequest,
    stream: Stream,
}

/// What comes of a cell.
enum Piece {
    /// Bytes of its stream.
    Bytes(Bytes),
    /// Its process ended.
    Over,
    /// What follows is the stream of the next process.
    Again,
}

impl Cells {
    /// Begins a recording in each cell that holds something of what is wanted; in all, when nothing
    /// is named.
    ///
    /// # Errors
    /// A cell is down, or knows no such port.
    pub async fn record(&self, wanted: &RecordingRequest) -> Result<Recorded, OpenError> {
        let (mut cells, apart) = (Vec::new(), Arc::new(Apart::default()));
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
            let wanted = RecordingRequest { ports, ..*wanted };
            let stream = Stream::open(&cell, &wanted, &apart).await?;
            cells.push(Begun { cell, wanted, stream });
        }
        Ok(Recorded { cells, ordered: wanted.ordered, apart })
    }
}

impl Recorded {
    /// Whether no cell takes part.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The processes whose changes are in these recordings.
    #[must_use]
    pub fn apart(&self) -> Arc<Apart> {
        Arc::clone(&self.apart)
    }

    /// Sends the frames of all to `out`, `own` among them. When `own` is over, cells are asked to
    /// end, too, and what they took until then is sent. After a cell whose process ends comes its
    /// next process.
    pub async fn join_frames(self, mut own: mpsc::Receiver<Vec<u8>>, out: mpsc::Sender<Vec<u8>>) {
        let (sender, mut pieces) = mpsc::channel(WAITING);
        let (over, is_over) = watch::channel(false);
        let mut theirs = Theirs::default();
        let processes = if self.ordered { 1 + self.cells.len() } else { 0 };
        for (rank, begun) in self.cells.into_iter().enumerate() {
            theirs.add(&begun.cell);
            let apart = Arc::clone(&self.apart);
            tokio::spawn(pass(rank, begun, apart, sender.clone(), is_over.clone()));
        }
        drop(sender);
        let (mut merger, mut mine) =
            (Merger::ordered(processes), Source::new(None, Origin::DAEMON));
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
        merger.end(&mut end);
        let why = mine.end.unwrap_or_else(|| End { why: "the daemon stops".to_owned() });
        Frame::End(why).append(&mut end);
        let _ = out.send(end).await;
    }
}

/// Where frames come from besides the daemon: one for each cell, in its present process.
#[derive(Default)]
struct Theirs {
    sources: Vec<Source>,
    /// How many there were, but for the daemon.
    begun: usize,
}

impl Theirs {
    fn add(&mut self, cell: &Arc<Cell>) {
        self.begun += 1;
        let origin = Origin { key: self.begun, rank: self.begun };
        self.sources.push(Source::new(Some(Arc::clone(cell)), origin));
    }

    /// The frames that become of what came.
    fn take(&mut self, rank: usize, piece: Piece, merger: &mut Merger) -> Vec<u8> {
        let Some(source) = self.sources.get_mut(rank) else { return Vec::new() };
        let mut out = Vec::new();
        match piece {
            Piece::Bytes(bytes) => return source.take(&bytes, merger),
            Piece::Over => merger.has_come(source.origin.rank, u64::MAX, &mut out),
            Piece::Again => {
                self.begun += 1;
                let origin = Origin { key: self.begun, ..source.origin };
                *source = Source::new(source.cell.take(), origin);
                merger.has_come(origin.rank, 0, &mut out);
            }
        }
        out
    }
}

/// Passes the bytes of a cell's stream on, then those of its next process, until the recording is
/// over or nobody wants them.
async fn pass(
    rank: usize,
    begun: Begun,
    apart: Arc<Apart>,
    to: mpsc::Sender<(usize, Piece)>,
    mut is_over: watch::Receiver<bool>,
) {
    let Begun { cell, wanted, mut stream } = begun;
    loop {
        while let Some(bytes) = stream.next().await {
            if to.send((rank, Piece::Bytes(bytes))).await.is_err() {
                return;
            }
        }
        if to.send((rank, Piece::Over)).await.is_err() {
            return;
        }
        let next = tokio::select! {
            biased;
            _ = is_over.wait_for(|over| *over) => return,
            next = next(&cell, &wanted, &apart) => next,
        };
        let Some(next) = next else { return };
        stream = next;
        if to.send((rank, Piece::Again)).await.is_err() {
            return;
        }
        tracing::info!("a recording goes on with the next process of cell {}", cell.name());
    }
}

/// The stream of a cell's next process; `None` where there will be none.
async fn next(cell: &Cell, wanted: &RecordingRequest, apart: &Apart) -> Option<Stream> {
    while cell.runs_again().await {
        match Stream::open(cell, wanted, apart).await {
            Ok(stream) => return Some(stream),
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
