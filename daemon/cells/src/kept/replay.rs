//! Replays a recording: publishes its samples with their timing.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_protocol::replay;
use genom_recording::{MOST_APART, ReadError, Recording};
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until};

use super::base::{AT_ONCE, is_file, lock};
use super::error::KeptError;
use super::play::{Play, PlayError, Voice};
use super::store::Kept;

/// Bytes published at once, about.
const BATCH: usize = 256 << 10;
/// Samples so close together are published at once, in nanoseconds.
const CLOSE: u64 = 1_000_000;
/// Batches that wait for their time.
const AHEAD: usize = 8;

/// Samples that are published at once.
struct Batch {
    /// When, from the first sample of the recording on.
    due: Duration,
    bytes: Vec<u8>,
}

impl Kept {
    /// Opens a recording to be replayed, with the topics of ports in it. Blocks.
    ///
    /// # Errors
    /// There is none of that name, it is just being made, or it cannot be read.
    pub fn voices(&self, file: &str) -> Result<(Recording, Vec<Voice>), KeptError> {
        drop(self.open(file)?);
        let recording = Recording::open(&self.path(file)?);
        let recording = recording.map_err(|error| KeptError::Read(file.to_owned(), error))?;
        let voices = recording.channels().filter(|(_, one)| one.message_encoding == "cdr");
        let voices = voices.map(|(channel, one)| Voice {
            channel,
            topic: one.topic.clone(),
            definition: one.schema.as_ref().map(|one| one.data.to_vec()).unwrap_or_default(),
        });
        let voices = voices.collect();
        Ok((recording, voices))
    }

    /// Publishes the samples of these channels to these in ports, `rate` times as fast as they were
    /// recorded, in the background. `publish` takes samples as `POST /replay` does, and says how many
    /// were published.
    ///
    /// # Errors
    /// There is nothing to publish, it is replayed already, or too many are.
    pub fn play<F, P>(
        &self,
        file: &str,
        mut recording: Recording,
        (voices, left_out): (BTreeMap<u16, String>, Vec<String>),
        rate: f64,
        publish: F,
    ) -> Result<Arc<Play>, KeptError>
    where
        F: Fn(Vec<u8>) -> P + Send + 'static,
        P: Future<Output = Result<u64, PlayError>> + Send + 'static,
    {
        if voices.is_empty() {
            return Err(KeptError::Nothing { file: file.to_owned(), why: left_out });
        }
        let topics = recording.channels().filter(|(channel, _)| voices.contains_key(channel));
        let topics = topics.map(|(_, one)| one.topic.clone()).collect();
        recording.read(topics).map_err(|error| KeptError::Read(file.to_owned(), error))?;
        let mut plays = lock(&self.plays);
        if plays.get(file).is_some_and(|play| play.goes_on()) {
            return Err(KeptError::UnderWay(file.to_owned(), "is replayed already"));
        }
        if plays.values().filter(|play| play.goes_on()).count() >= AT_ONCE {
            return Err(KeptError::TooMany(AT_ONCE));
        }
        let mut ports: Vec<_> = voices.values().cloned().collect();
        ports.sort();
        let play = Arc::new(Play {
            ports,
            left_out,
            published: AtomicU64::new(0),
            passed_ns: AtomicU64::new(0),
            goes_on: watch::Sender::new(true),
            stop: watch::Sender::new(false),
            problem: Mutex::default(),
        });
        plays.insert(file.to_owned(), Arc::clone(&play));
        let (sender, batches) = mpsc::channel(AHEAD);
        let reader = tokio::task::spawn_blocking(move || read(&mut recording, &voices, &sender));
        let (own, name) = (Arc::clone(&play), file.to_owned());
        tokio::spawn(async move {
            let mut problem = paced(&own, batches, rate, publish).await.err();
            // It ends when nobody takes its batches any more.
            match reader.await {
                Ok(Ok(())) => {}
                Ok(Err(error)) => problem = problem.or(Some(error.into())),
                Err(error) => problem = problem.or(Some(error.into())),
            }
            let published = own.published.load(Ordering::Relaxed);
            match &problem {
                None => tracing::info!("replay of {name} ended: {published} samples"),
                Some(why) => tracing::warn!("replay of {name} ended ({why}): {published} samples"),
            }
            *lock(&own.problem) = problem.map(|why| why.to_string());
            own.goes_on.send_replace(false);
        });
        Ok(play)
    }

    /// The replay of a recording.
    ///
    /// # Errors
    /// There is no recording of that name, or it was not replayed.
    pub fn replay(&self, file: &str) -> Result<Arc<Play>, KeptError> {
        let path = self.path(file)?;
        let play = lock(&self.plays).get(file).cloned();
        play.ok_or_else(|| match is_file(&path) {
            true => KeptError::UnderWay(file.to_owned(), "is not replayed"),
            false => self.unknown(&path),
        })
    }
}

/// Publishes each batch when it is due, until there are no more or somebody stops it.
async fn paced<F, P>(
    play: &Play,
    mut batches: mpsc::Receiver<Batch>,
    rate: f64,
    publish: F,
) -> Result<(), PlayError>
where
    F: Fn(Vec<u8>) -> P,
    P: Future<Output = Result<u64, PlayError>>,
{
    let (begin, mut stopped) = (Instant::now(), play.stop.subscribe());
    while let Some(Batch { due, bytes }) = batches.recv().await {
        // Only dates that are far apart are too much for a division by a small rate.
        let at = Duration::try_from_secs_f64(due.as_secs_f64() / rate).ok();
        let at = at.and_then(|at| begin.checked_add(at)).ok_or(PlayError::Date)?;
        tokio::select! {
            biased;
            _ = stopped.wait_for(|stopped| *stopped) => return Err(PlayError::Stopped),
            () = sleep_until(at) => {}
        }
        let published = publish(bytes).await?;
        play.published.fetch_add(published, Ordering::Relaxed);
        play.passed_ns.store(due.as_nanos().try_into().unwrap_or(u64::MAX), Ordering::Relaxed);
    }
    Ok(())
}

/// Reads the samples in the order of their dates, and sends those that are close together at once.
fn read(
    recording: &mut Recording,
    voices: &BTreeMap<u16, String>,
    sender: &mpsc::Sender<Batch>,
) -> Result<(), ReadError> {
    // Dates of the first sample, of the first of the present batch, and of the latest.
    let mut dates: Option<(u64, u64, u64)> = None;
    let mut bytes = Vec::new();
    while let Some(sample) = recording.next_sample()? {
        let Some(port) = voices.get(&sample.channel) else { continue };
        let date = sample.date;
        let (first, mut begun, last) = dates.unwrap_or((date, date, date));
        if date.saturating_sub(last) > MOST_APART {
            return Err(ReadError::Dates);
        }
        let last = date.max(last);
        if !bytes.is_empty() && (last - begun > CLOSE || bytes.len() >= BATCH) {
            let due = Duration::from_nanos(begun - first);
            let batch = Batch { due, bytes: std::mem::take(&mut bytes) };
            if sender.blocking_send(batch).is_err() {
                return Ok(());
            }
        }
        if bytes.is_empty() {
            begun = last;
        }
        dates = Some((first, begun, last));
        replay::append(&mut bytes, port, &sample.message);
    }
    if let Some((first, begun, _)) = dates {
        // Nobody takes it when the replay was ended.
        let _ = sender.blocking_send(Batch { due: Duration::from_nanos(begun - first), bytes });
    }
    Ok(())
}
