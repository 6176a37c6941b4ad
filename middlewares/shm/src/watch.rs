//! Limits how long calls of iceoryx2 may block.
//!
//! A process that opens an empty segment waits for it to get a size, without a timeout: for ever if
//! its creator was killed or somebody truncated it. Such a wait ends when the segment is removed.
//! So a thread monitors all calls of iceoryx2, and removes empty segments when one takes long. Once
//! a second it also looks for nodes whose process was killed, so that peers need not wait until the
//! next daemon starts for their remains to be removed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use iceoryx2::prelude::Config;

use crate::heal::{self, Places, Turn};

/// Longer than any call that does not wait for another process.
const PATIENCE: Duration = Duration::from_millis(100);

/// How long a living process may leave a segment empty.
const HOPELESS: Duration = Duration::from_secs(1);

/// Interval between checks of a call that takes long.
const TICK: Duration = Duration::from_millis(20);

/// Interval between checks for nodes whose process is gone.
const PERIOD: Duration = Duration::from_secs(1);

/// The thread, and what it monitors.
#[derive(Debug)]
pub(crate) struct Watch {
    watcher: Watcher,
    thread: Option<JoinHandle<()>>,
}

/// Handle by which others report calls and request passes.
#[derive(Clone, Debug)]
pub(crate) struct Watcher {
    shared: Arc<Shared>,
}

/// A call in progress.
#[derive(Debug)]
pub(crate) struct Busy<'a> {
    shared: &'a Shared,
    number: u64,
}

#[derive(Debug)]
struct Shared {
    config: Config,
    places: Places,
    state: Mutex<State>,
    changed: Condvar,
    /// Whether a pass is running on a separate thread.
    healing: AtomicBool,
}

#[derive(Debug, Default)]
struct State {
    begun: BTreeMap<u64, Instant>,
    next: u64,
    stop: bool,
}

impl Watch {
    pub(crate) fn start(config: &Config) -> Self {
        let shared = Arc::new(Shared {
            config: config.clone(),
            places: Places::of(config),
            state: Mutex::default(),
            changed: Condvar::new(),
            healing: AtomicBool::new(false),
        });
        let watcher = Watcher { shared };
        let own = watcher.clone();
        let thread = thread::Builder::new().name("shm-watch".to_owned()).spawn(move || own.run());
        if let Err(error) = &thread {
            tracing::error!(%error, "no thread for shm: what killed processes left may hang this daemon");
        }
        Self { watcher, thread: thread.ok() }
    }

    pub(crate) fn watcher(&self) -> &Watcher {
        &self.watcher
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.watcher.shared.lock().stop = true;
        self.watcher.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Watcher {
    /// Monitors a call until the result is dropped.
    pub(crate) fn busy(&self) -> Busy<'_> {
        let mut state = self.shared.lock();
        let number = state.next;
        state.next += 1;
        // The watching thread is not woken: that would cost more than most of the calls.
        state.begun.insert(number, Instant::now());
        drop(state);
        Busy { shared: &self.shared, number }
    }

    /// Removes what killed processes left. Returns whether there was a killed one.
    pub(crate) fn heal(&self) -> bool {
        let _busy = self.busy();
        let places = &self.shared.places;
        match Turn::take(&places.root) {
            Ok(turn) => heal::heal(&self.shared.config, places, &turn).found_nodes(),
            Err(error) => {
                tracing::debug!(%error, "the folder of iceoryx2 cannot be opened");
                false
            }
        }
    }

    /// Does the same if the process of some node is gone, which takes a few system calls per node
    /// to find out.
    pub(crate) fn heal_dead(&self) -> bool {
        heal::somebody_died(&self.shared.places) && self.heal()
    }

    fn run(&self) {
        let mut looked = Instant::now();
        let mut empty = BTreeMap::new();
        let mut state = self.shared.lock();
        while !state.stop {
            let longest = state.begun.values().min().map(Instant::elapsed);
            let wait = match longest {
                Some(longest) if longest >= PATIENCE => {
                    drop(state);
                    unblock(&self.shared.places, &mut empty);
                    state = self.shared.lock();
                    TICK
                }
                Some(longest) => PATIENCE - longest,
                None => PATIENCE,
            };
            if wait > TICK {
                empty.clear();
            }
            if looked.elapsed() >= PERIOD {
                drop(state);
                if heal::somebody_died(&self.shared.places) {
                    self.heal_apart();
                }
                looked = Instant::now();
                state = self.shared.lock();
            }
            if state.stop {
                break;
            }
            let waited = self.shared.changed.wait_timeout(state, wait);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Runs a pass on a separate thread, since this one must not wait for what the pass may
    /// unblock.
    fn heal_apart(&self) {
        if self.shared.healing.swap(true, Ordering::AcqRel) {
            return;
        }
        let own = self.clone();
        let spawned = thread::Builder::new().name("shm-heal".to_owned()).spawn(move || {
            let _ = own.heal();
            own.shared.healing.store(false, Ordering::Release);
        });
        if spawned.is_err() {
            self.shared.healing.store(false, Ordering::Release);
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        self.shared.lock().begun.remove(&self.number);
    }
}

/// Removes empty segments: at once if a dead process is involved, else if they have been `empty`
/// for long, since a living process sets the size right after creating one.
fn unblock(places: &Places, empty: &mut BTreeMap<PathBuf, Instant>) {
    let now = heal::empty_segments(places);
    empty.retain(|file, _| now.iter().any(|(found, _)| found == file));
    if now.is_empty() {
        return;
    }
    let living: BTreeSet<u32> = heal::living_processes(places);
    for (file, processes) in now {
        let dead = processes.iter().any(|process| !living.contains(process));
        let since = *empty.entry(file.clone()).or_insert_with(Instant::now);
        if (dead || since.elapsed() >= HOPELESS) && std::fs::remove_file(&file).is_ok() {
            tracing::warn!(
                file = %file.display(),
                "removed a segment without bytes, on which processes wait: who made it was killed, or somebody cut it"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::{self, File};

    use iceoryx2::prelude::{Config, FileName, Path as IceoryxPath, SemanticString as _};

    use super::*;

    #[test]
    fn segments_that_the_living_make_are_left_to_them_and_those_of_the_dead_are_removed_at_once() {
        let prefix = format!("genomwatch_{}_", std::process::id());
        let root = std::env::temp_dir().join(&prefix);
        let mut config = Config::default();
        config.global.prefix = FileName::new(prefix.as_bytes()).unwrap();
        let path = IceoryxPath::new(root.as_os_str().as_encoded_bytes()).unwrap();
        config.global.set_root_path(&path);
        let places = Places::of(&config);
        let living = heal::living_processes(&places);
        let segment = |process: u32| {
            let id = u128::from(process) << 64 | 1;
            places.segments.join(format!("{prefix}x_{id}.data"))
        };
        let (own, gone) = (segment(*living.first().unwrap()), segment(u32::MAX));
        for file in [&own, &gone] {
            File::create(file).unwrap();
        }
        let mut empty = BTreeMap::new();
        for _ in 0..2 {
            unblock(&places, &mut empty);
            assert!(own.exists() && !gone.exists());
        }
        let long = Instant::now().checked_sub(2 * HOPELESS).unwrap();
        empty.values_mut().for_each(|since| *since = long);
        unblock(&places, &mut empty);
        assert!(!own.exists() && fs::read_dir(&root).is_err());
    }
}
