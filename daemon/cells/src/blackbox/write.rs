//! Writes what is kept: to a file of the black box, beside the report of a crash, or to a client.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use genom_blackbox::Memory;
use genom_configuration::Deployment;
use genom_ports::dates::Dates;
use genom_protocol::frames::{End, Frame, Start};
use genom_protocol::{BlackBoxLeft, Change, ClockKind};
use genom_recording::{Recorder, WriteError};
use genom_runtime::{Clock, nanos};
use genom_supervisor::Supervisor;
use genom_supervisor::loading::date_in_utc;
use tokio::sync::mpsc;

use super::boxes::{BlackBoxes, Of, PREFIX};
use super::gather::gather;
use crate::shelf::{ShelfError, create, date, free, unfinished};

/// Name of the file in the report of a crash.
const BESIDE: &str = "blackbox.mcap";

/// About so many bytes are sent to a client at once.
const BATCH: usize = 64 << 10;

/// Nothing could be written.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// It is off.
    #[error("the black box is off: nothing is kept")]
    Off,
    /// Its directory cannot be used.
    #[error(transparent)]
    Shelf(#[from] ShelfError),
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Whoever wrote it was stopped.
    #[error("stopped while it was being written")]
    Stopped,
}

/// Why something is written: as it stands in the name of the file, and in its metadata.
#[derive(Clone, Debug)]
pub(super) struct Why {
    pub(super) reason: &'static str,
    pub(super) detail: String,
    pub(super) cell: Of,
}

impl BlackBoxes {
    /// Has a file written since somebody asked.
    ///
    /// # Errors
    /// Nothing could be written.
    pub async fn save(self: &Arc<Self>) -> Result<BlackBoxLeft, SaveError> {
        let why = Why { reason: "command", detail: "somebody asked for it".to_owned(), cell: None };
        self.save_for(why).await
    }

    /// One file at a time.
    pub(super) async fn save_for(self: &Arc<Self>, why: Why) -> Result<BlackBoxLeft, SaveError> {
        let _turn = self.turn.lock().await;
        let worker = Arc::clone(self);
        let saved = tokio::task::spawn_blocking(move || {
            let saved = worker.save_now(&why)?;
            worker.tell(&why, &saved);
            Ok(saved)
        });
        saved.await.unwrap_or(Err(SaveError::Stopped))
    }

    fn tell(&self, why: &Why, saved: &BlackBoxLeft) {
        let BlackBoxLeft { file, messages, short, error } = saved;
        let reason = format!("{}: {}", why.reason, why.detail);
        let name = file.display();
        match error {
            Some(error) => tracing::error!("black box ({reason}): {error}"),
            None => tracing::warn!("black box ({reason}): {messages} messages in {name}"),
        }
        if *short > 0 {
            tracing::warn!(
                "black box: {short} topics reach back less than blackbox.seconds = {}: raise \
                 blackbox.bytes or port_bytes, or name fewer ports",
                self.section.seconds
            );
        }
        if let Some(supervisor) = self.daemon.get().and_then(|one| one.supervisor.upgrade()) {
            let (file, messages) = (file.display().to_string(), *messages);
            supervisor.bus.tell(&Change::BlackboxSaved { file, why: reason, messages });
        }
    }

    /// Writes a file to the directory. Blocks.
    fn save_now(&self, why: &Why) -> Result<BlackBoxLeft, SaveError> {
        let all = self.all();
        if all.is_empty() {
            return Err(SaveError::Off);
        }
        let (directory, turn) = self.shelf.open()?;
        let wanted = format!("{PREFIX}{}-{}", date(SystemTime::now()), why.reason);
        let name = free(directory, &wanted, ".mcap");
        let (new, place) = (directory.join(unfinished(&name)), directory.join(&name));
        let mut left = self.write(&new, why, None, &all)?;
        left.file.clone_from(&place);
        let renamed = fs::rename(&new, &place);
        renamed.map_err(|source| ShelfError::Io { path: place.clone(), source })?;
        self.shelf.limit(directory);
        drop(turn);
        Ok(left)
    }

    /// Writes a file beside the report of a crash, with what the process left and what the others
    /// did meanwhile. Blocks.
    pub(crate) fn put_beside(
        &self,
        directory: &Path,
        cell: &str,
        report: &str,
        (end, left): (&str, Arc<Memory>),
    ) -> BlackBoxLeft {
        let mut all = vec![(Some(cell.to_owned()), left)];
        // Its next process has nothing to do with it.
        all.extend(self.all().into_iter().filter(|(of, _)| of.as_deref() != Some(cell)));
        let why = Why { reason: "crash", detail: end.to_owned(), cell: Some(cell.to_owned()) };
        let written = self.write(&directory.join(BESIDE), &why, Some(report), &all);
        let failed = |error: WriteError| {
            tracing::error!("cell {cell}: no black box of its end: {error}");
            let error = Some(error.to_string());
            BlackBoxLeft { file: PathBuf::new(), messages: 0, short: 0, error }
        };
        let written = written.unwrap_or_else(failed);
        // Where it is once the report is complete.
        BlackBoxLeft { file: directory.with_file_name(report).join(BESIDE), ..written }
    }

    /// Whether a file of a crash is to be written.
    pub(crate) fn is_for_crashes(&self) -> bool {
        self.section.is_on(genom_configuration::BlackBoxReason::Crash)
    }

    /// A file that ends early since the disk is full is whole as far as it goes.
    fn write(
        &self,
        path: &Path,
        why: &Why,
        report: Option<&str>,
        all: &[(Of, Arc<Memory>)],
    ) -> Result<BlackBoxLeft, WriteError> {
        let broken = |why: std::io::Error| WriteError::Broken {
            path: path.to_owned(),
            written: 0,
            why: why.to_string(),
        };
        let file = create(path).map_err(broken)?;
        let written = (|| {
            let mut recorder = Recorder::new("genomd", path, file, &self.start())?;
            recorder.tell("genom.blackbox", self.metadata(why, report))?;
            let gathered = gather(all, &self.dates(), self.window(), |frame| match frame {
                Frame::Channel(channel) => recorder.channel(channel),
                Frame::Sample(sample) => recorder.sample(&sample),
                Frame::Lost(lost) => {
                    recorder.lost(lost);
                    Ok(())
                }
                Frame::Start(_) | Frame::End(_) | Frame::Until(_) => Ok(()),
            });
            let (messages, _) = recorder.counts();
            let (short, error) = match gathered {
                Ok(gathered) => {
                    let short = gathered.short.len() as u64;
                    let reaches = gathered.short.into_iter();
                    let reaches = reaches.map(|(topic, seconds)| (topic, format!("{seconds:.3}")));
                    recorder.tell("genom.blackbox.short", reaches.collect())?;
                    (short, None)
                }
                Err(error @ WriteError::Full { .. }) => (0, Some(error.to_string())),
                Err(error) => return Err(error),
            };
            recorder.finish(error.is_none())?;
            Ok(BlackBoxLeft { file: path.to_owned(), messages, short, error })
        })();
        written.inspect_err(|_| {
            // Nobody could read it.
            let _ = fs::remove_file(path);
        })
    }

    fn dates(&self) -> Dates {
        self.daemon.get().map(|one| one.dates.clone()).unwrap_or_default()
    }

    fn window(&self) -> u64 {
        nanos(self.section.time())
    }

    /// How a recording of all begins: with what ran, as far as this process knows.
    fn start(&self) -> Start {
        let supervisor = self.daemon.get().and_then(|one| one.supervisor.upgrade());
        let clock = supervisor.as_ref().map_or(ClockKind::Monotonic, |one| match one.clock {
            Clock::Monotonic => ClockKind::Monotonic,
            Clock::Virtual(_) | Clock::Staged(_) => ClockKind::Virtual,
        });
        let ran = supervisor.map_or_else(Deployment::default, |one: Arc<Supervisor>| one.dump());
        let deployment = toml::to_string(&ran).unwrap_or_default();
        let genomd = env!("CARGO_PKG_VERSION").to_owned();
        Start { recording: 0, genomd, clock, deployment }
    }

    fn metadata(&self, why: &Why, report: Option<&str>) -> BTreeMap<String, String> {
        let dates = self.dates();
        let now = dates.calendar().date(dates.moment());
        let mut told = BTreeMap::from([
            ("reason".to_owned(), why.reason.to_owned()),
            ("detail".to_owned(), why.detail.clone()),
            ("written".to_owned(), date_in_utc(SystemTime::now())),
            ("date_ns".to_owned(), now.to_string()),
            ("seconds".to_owned(), self.section.seconds.to_string()),
        ]);
        told.extend(why.cell.clone().map(|cell| ("cell".to_owned(), cell)));
        told.extend(report.map(|report| ("report".to_owned(), report.to_owned())));
        told
    }

    /// Sends what is kept to a client, as a recording. Blocks as long as the client is slow.
    ///
    /// # Errors
    /// Nothing is kept.
    pub fn send(&self, sender: &mpsc::Sender<Vec<u8>>) -> Result<(), SaveError> {
        let all = self.all();
        if all.is_empty() {
            return Err(SaveError::Off);
        }
        let mut out = Vec::new();
        Frame::Start(self.start()).append(&mut out);
        // The client is gone when this fails: there is nobody to tell.
        let sent = gather(&all, &self.dates(), self.window(), |frame| {
            frame.append(&mut out);
            match out.len() {
                BATCH.. => sender.blocking_send(std::mem::take(&mut out)).map_err(drop),
                _ => Ok(()),
            }
        });
        if sent.is_ok() {
            Frame::End(End { why: "asked".to_owned() }).append(&mut out);
            let _ = sender.blocking_send(out);
        }
        Ok(())
    }

    /// Whether anything is kept.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        !self.with(|all| all.is_empty())
    }
}
