//! In a cell, keeps what a component ran before a reload until the new library has proved itself: if
//! the process ends meanwhile, the next one goes on with what was kept.

use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use genom_protocol::{LoadRequest, Resumption};
use serde::{Deserialize, Serialize};

use crate::components::Hosted;
use crate::supervisor::Supervisor;

/// How long to wait for a moment of rest.
pub(super) const REST: Duration = Duration::from_secs(5);
/// Ticks that each periodic task makes during a trial.
const TICKS: u64 = 100;
/// Bounds of a trial.
const TIME: std::ops::Range<Duration> = Duration::from_secs(1)..Duration::from_secs(10);
/// Interval of looking whether it is over.
const LOOK: Duration = Duration::from_millis(50);

/// What a component ran before.
#[derive(Debug, Deserialize, Serialize)]
struct Kept {
    component: String,
    /// The path that it was loaded from, and its description.
    library: PathBuf,
    gen_file: Option<PathBuf>,
    /// A copy of the library as it was.
    copy: PathBuf,
    /// Its state at the reload.
    resume: Box<Resumption>,
}

/// A reload that is on trial; what is kept is removed when this is dropped.
pub(super) struct Trial {
    record: PathBuf,
    copy: PathBuf,
}

impl Trial {
    /// Keeps what a component runs, in a cell. What cannot be kept is told in the log.
    pub(super) fn begin(supervisor: &Supervisor, hosted: &Hosted) -> Option<Self> {
        let place = supervisor.settings.trials.as_deref()?;
        match Self::keep(place, hosted) {
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

    fn keep(place: &Path, hosted: &Hosted) -> io::Result<Self> {
        let state = hosted.freeze(REST).map_err(io::Error::other)?;
        let gone = || io::Error::other("there is no copy of the library that runs");
        let contents = hosted.contents().ok_or_else(gone)?;
        let build = hosted.build();
        fs::DirBuilder::new().recursive(true).mode(0o700).create(place)?;
        let number: String =
            build.digest.iter().take(6).map(|byte| format!("{byte:02x}")).collect();
        let copy = place.join(format!("{}.{number}.so", hosted.name));
        let record = place.join(format!("{}.json", hosted.name));
        let trial = Self { record, copy: copy.clone() };
        fs::write(&copy, &contents.bytes)?;
        let kept = Kept {
            component: hosted.name.clone(),
            library: build.library,
            gen_file: build.description.file(),
            copy,
            resume: Box::new(Resumption { state, activities: true, hold: false, copy: None }),
        };
        // Whole or not at all.
        let aside = trial.record.with_extension("new");
        fs::write(&aside, serde_json::to_vec(&kept)?)?;
        fs::rename(&aside, &trial.record)?;
        Ok(trial)
    }

    /// Ends the trial when the new library has run for long enough, or does not run any more.
    pub(super) fn watch(self, hosted: &Arc<Hosted>) {
        let (hosted, begun) = (Arc::downgrade(hosted), Instant::now());
        let first = hosted.upgrade().map(|hosted| cycles(&hosted)).unwrap_or_default();
        let watch = move || {
            while !is_over(&hosted, &first, begun.elapsed()) {
                thread::park_timeout(LOOK);
            }
            drop(self);
        };
        if let Err(error) = thread::Builder::new().name("genomd-trial".to_owned()).spawn(watch) {
            tracing::error!("a reload is not on trial: {error}");
        }
    }
}

impl Drop for Trial {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.record);
        let _ = fs::remove_file(&self.copy);
    }
}

/// Cycles of the periodic tasks so far.
fn cycles(hosted: &Hosted) -> Vec<u64> {
    let tasks = hosted.figures().tasks.into_iter();
    tasks.filter(|task| task.period_ns.is_some()).map(|task| task.cycles.count).collect()
}

fn is_over(hosted: &Weak<Hosted>, first: &[u64], spent: Duration) -> bool {
    let Some(hosted) = hosted.upgrade() else { return true };
    let made = || cycles(&hosted).iter().zip(first).all(|(now, first)| now - first >= TICKS);
    hosted.gone.is_up() || spent >= TIME.end || (spent >= TIME.start && made())
}

/// Changes what the process of a cell is to bring up, if the one before ended during trials: it goes
/// on with what ran before them.
pub fn roll_back(place: &Path, components: &mut [LoadRequest]) {
    for entry in fs::read_dir(place).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let kept = fs::read(&path).map(|text| serde_json::from_slice::<Kept>(&text));
        // Not a second time, if this is what ends the process.
        let _ = fs::remove_file(&path);
        let Ok(Ok(kept)) = kept else { continue };
        let mut all = components.iter_mut();
        if let Some(request) = all.find(|request| request.instance() == kept.component) {
            request.library = kept.library;
            request.gen_file = kept.gen_file;
            request.instead = Some(kept.copy);
            request.resume = Some(kept.resume);
        }
    }
}
