//! In a cell, keeps what a component ran before a reload until the new library has proved itself: if
//! the process ends meanwhile, the next one goes on with what was kept.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use genom_configuration::{ConnectionEntry, Deployment, LoadRequest};
use genom_protocol::Resumption;
use serde::{Deserialize, Serialize};

use crate::components::Hosted;
use crate::deploy::Gone;
use crate::loading::texts_beside;
use crate::supervisor::Supervisor;

/// How long to wait for a moment of rest.
pub(super) const REST: Duration = Duration::from_secs(5);
/// Bounds of a trial.
const TIME: std::ops::Range<Duration> = Duration::from_secs(1)..Duration::from_secs(10);
/// Interval of looking whether it is over.
pub(super) const LOOK: Duration = Duration::from_millis(50);

/// What a component ran before.
#[derive(Debug, Deserialize, Serialize)]
struct Kept {
    /// The request that loads it as it was, with a copy of its library and its state at the reload.
    request: LoadRequest,
    connections: Vec<ConnectionEntry>,
    /// Whether the new library has another description: what was asked of it since may not fit.
    described: bool,
    /// Number of the trial.
    number: u64,
}

/// Number of the trial that a record is of.
#[derive(Deserialize)]
struct Numbered {
    number: u64,
}

/// Number of the next trial of this process.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A reload that is on trial; what is kept is removed when this is dropped.
pub(super) struct Trial {
    number: u64,
    /// One of a later reload of the component takes its place.
    record: PathBuf,
    copy: PathBuf,
    described: bool,
    /// Whether the component runs from the copy already, after a reload that was rolled back.
    in_use: bool,
}

impl Trial {
    /// Keeps what a component runs, in a cell. What cannot be kept is told in the log.
    pub(super) fn begin(supervisor: &Supervisor, hosted: &Hosted, described: bool) -> Option<Self> {
        let place = &supervisor.settings.trials.as_ref()?.place;
        match Self::keep(place, hosted, described) {
            Ok(trial) => Some(trial),
            Err(why) => {
                tracing::warn!(
                    instance = hosted.name,
                    "a fault of the new library cannot be undone: {why}"
                );
                None
            }
        }
    }

    fn keep(place: &Path, hosted: &Hosted, described: bool) -> io::Result<Self> {
        let gone = || io::Error::other("there is no copy of the library that runs");
        let contents = hosted.contents().ok_or_else(gone)?;
        let build = hosted.build();
        fs::DirBuilder::new().recursive(true).mode(0o700).create(place)?;
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let in_use = build.request.instead.is_some();
        let copy = build.request.instead.unwrap_or_else(|| {
            let digest: String =
                build.digest.iter().take(6).map(|byte| format!("{byte:02x}")).collect();
            let script = contents.is_script().then(|| contents.path.extension()).flatten();
            let kind = script.map_or("so".into(), OsStr::to_string_lossy);
            // No other process wrote one of this library here before.
            place.join(format!("{}.{digest}.{}-{number}.{kind}", hosted.name, std::process::id()))
        });
        let record = place.join(format!("{}.json", hosted.name));
        let trial = Self { number, record, copy, described, in_use };
        if !in_use {
            fs::write(&trial.copy, &contents.bytes)?;
            build.reading.texts().write(&texts_beside(&trial.copy))?;
        }
        trial.write(hosted)?;
        Ok(trial)
    }

    /// Keeps the present state of the component.
    pub(super) fn renew(&self, hosted: &Hosted) {
        if let Err(why) = self.write(hosted) {
            tracing::warn!(
                instance = hosted.name,
                "a fault of the new library would bring an earlier state back: {why}"
            );
        }
    }

    fn write(&self, hosted: &Hosted) -> io::Result<()> {
        let state = hosted.freeze(REST).map_err(io::Error::other)?;
        let Gone { mut request, connections, .. } = Gone::of(hosted);
        request.gen_file = hosted.build().description.file();
        request.instead = Some(self.copy.clone());
        request.resume =
            Some(Box::new(Resumption { state, activities: true, hold: false, copy: None }));
        let (described, number) = (self.described, self.number);
        let kept = Kept { request, connections, described, number };
        // Whole or not at all.
        let aside = self.record.with_extension("new");
        fs::write(&aside, serde_json::to_vec(&kept)?)?;
        fs::rename(&aside, &self.record)
    }

    /// Ends the trial when the new library has run for long enough, or does not run any more.
    pub(super) fn watch(self, hosted: &Arc<Hosted>, ticks: u64) {
        let watched = Watched::new(hosted, ticks);
        let watch = move || {
            while !watched.is_over() {
                thread::park_timeout(LOOK);
            }
            self.passed();
        };
        if let Err(error) = thread::Builder::new().name("genomd-trial".to_owned()).spawn(watch) {
            tracing::error!("a reload is not on trial: {error}");
        }
    }

    /// The new library goes on: nothing runs from the copy any more.
    pub(super) fn passed(mut self) {
        self.in_use = false;
    }
}

impl Drop for Trial {
    fn drop(&mut self) {
        let own = |text: Vec<u8>| {
            let of = serde_json::from_slice::<Numbered>(&text);
            of.is_ok_and(|of| of.number == self.number)
        };
        if fs::read(&self.record).is_ok_and(own) {
            let _ = fs::remove_file(&self.record);
        }
        if !self.in_use {
            let _ = fs::remove_file(&self.copy);
            let _ = fs::remove_file(texts_beside(&self.copy));
        }
    }
}

/// Cycles of the periodic tasks so far.
fn cycles(hosted: &Hosted) -> Vec<u64> {
    let tasks = hosted.figures().tasks.into_iter();
    tasks.filter(|task| task.period_ns.is_some()).map(|task| task.cycles.count).collect()
}

/// A component whose library is on trial.
pub(super) struct Watched {
    hosted: Weak<Hosted>,
    begun: Instant,
    /// Cycles at that moment.
    first: Vec<u64>,
    ticks: u64,
}

impl Watched {
    pub(super) fn new(hosted: &Arc<Hosted>, ticks: u64) -> Self {
        let (first, begun) = (cycles(hosted), Instant::now());
        Self { hosted: Arc::downgrade(hosted), begun, first, ticks }
    }

    /// Whether it ran for long enough, or does not run any more.
    pub(super) fn is_over(&self) -> bool {
        let Some(hosted) = self.hosted.upgrade() else { return true };
        let spent = self.begun.elapsed();
        let enough = |(now, first): (u64, &u64)| now.saturating_sub(*first) >= self.ticks;
        let made = || cycles(&hosted).into_iter().zip(&self.first).all(enough);
        hosted.gone.is_up() || spent >= TIME.end || (spent >= TIME.start && made())
    }
}

/// Changes what the process of a cell is to bring up, if the one before ended during trials: it goes
/// on with what ran before them.
pub fn roll_back(place: &Path, held: &mut Deployment) {
    for entry in fs::read_dir(place).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let kept = fs::read(&path).map(|text| serde_json::from_slice::<Kept>(&text));
        // Not a second time, if this is what ends the process.
        let _ = fs::remove_file(&path);
        let Ok(Ok(Kept { request, connections, described, .. })) = kept else { continue };
        let name = request.instance();
        let mut all = held.component.iter_mut();
        // One that is not to come back does not.
        let Some(there) = all.find(|one| one.instance() == name) else { continue };
        if !described {
            there.library = request.library;
            there.gen_file = request.gen_file;
            there.instead = request.instead;
            there.resume = request.resume;
            continue;
        }
        *there = request;
        held.connection.retain(|entry| entry.reader() != name);
        held.connection.extend(connections);
        // What was called and started goes on where it was.
        held.call.retain(|entry| entry.component != name);
        held.activity.retain(|entry| entry.component != name);
    }
}
