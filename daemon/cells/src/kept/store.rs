//! The directory of recordings: what is there, what is under way, and what may be removed.

use std::collections::BTreeMap;
use std::fs;
use std::fs::File;
use std::io::ErrorKind;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use genom_configuration::RecordingsSection;
use genom_protocol::{KeptRecording, KeptRecordings, KeptState};
use rustix::fs::OFlags;
use tokio::time::timeout;

use super::active::{Active, Ended};
use super::base::{AT_ONCE, ENDING, is_file, is_link, lock};
use super::error::KeptError;
use super::glances::Glances;
use super::name;
use super::play::Play;
use crate::shelf::{Shelf, create, date, free, size};

/// How long the end of a recording is waited for: its last samples, and its index.
const LAST: Duration = Duration::from_secs(10);

/// The recordings of a daemon.
pub struct Kept {
    pub(super) shelf: Shelf,
    pub(super) under_way: Mutex<BTreeMap<String, Arc<Active>>>,
    /// How those ended that this daemon made.
    pub(super) ended: Mutex<BTreeMap<String, Ended>>,
    pub(super) plays: Mutex<BTreeMap<String, Arc<Play>>>,
    glances: Glances,
}

impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Kept").field("shelf", &self.shelf).finish_non_exhaustive()
    }
}

impl Kept {
    /// Those in the directory of the configuration.
    #[must_use]
    pub fn new(section: &RecordingsSection) -> Self {
        Self {
            shelf: Shelf {
                section: "recordings",
                prefix: "",
                directory: section.place(),
                most: section.most,
                most_bytes: section.most_bytes,
                writing: Mutex::default(),
            },
            under_way: Mutex::default(),
            ended: Mutex::default(),
            plays: Mutex::default(),
            glances: Glances::default(),
        }
    }

    /// Makes a file for a recording of these ports, with this name or one of the present date. Blocks.
    ///
    /// # Errors
    /// The name is none, or taken; the directory is full or cannot be used; too many are under way.
    pub fn create(&self, name: Option<&str>, ports: &[String]) -> Result<Arc<Active>, KeptError> {
        let named = name.map(name::file).transpose()?;
        let (directory, _turn) = self.shelf.open()?;
        let file = named.unwrap_or_else(|| free(directory, &date(SystemTime::now()), ENDING));
        let mut under_way = lock(&self.under_way);
        if under_way.len() >= AT_ONCE {
            return Err(KeptError::TooMany(AT_ONCE));
        }
        let there = self.names();
        if there.len() >= self.shelf.most {
            return Err(KeptError::Full(format!("most = {}", self.shelf.most)));
        }
        if self.bytes(&there) >= self.shelf.most_bytes {
            return Err(KeptError::Full(format!("most_bytes = {}", self.shelf.most_bytes)));
        }
        let path = directory.join(&file);
        let made = create(&path).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => KeptError::Taken(file.clone()),
            _ => KeptError::Io { path: path.clone(), source },
        })?;
        lock(&self.ended).remove(&file);
        let active = Arc::new(Active::new(file.clone(), path, made, ports.to_vec()));
        under_way.insert(file, Arc::clone(&active));
        Ok(active)
    }

    /// The recordings, the newest first. Blocks.
    #[must_use]
    pub fn told(&self) -> KeptRecordings {
        let names = self.names();
        self.forget_but(&names);
        let mut recordings: Vec<_> = names.iter().filter_map(|file| self.look(file)).collect();
        recordings.sort_by(|one, other| {
            other.written.total_cmp(&one.written).then_with(|| other.file.cmp(&one.file))
        });
        KeptRecordings {
            directory: self.shelf.directory.clone(),
            most: self.shelf.most,
            most_bytes: self.shelf.most_bytes,
            bytes: recordings.iter().fold(0, |sum: u64, one| sum.saturating_add(one.bytes)),
            recordings,
        }
    }

    /// Forgets files that are gone, whoever removed them.
    fn forget_but(&self, names: &[String]) {
        self.glances.forget_but(names);
        lock(&self.ended).retain(|file, _| names.contains(file));
        lock(&self.plays).retain(|file, play| play.goes_on() || names.contains(file));
    }

    /// One of them. Blocks.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn one(&self, file: &str) -> Result<KeptRecording, KeptError> {
        let path = self.path(file)?;
        self.look(file).ok_or_else(|| self.unknown(&path))
    }

    fn look(&self, file: &str) -> Option<KeptRecording> {
        let path = self.shelf.directory.as_deref()?.join(file);
        let found = fs::symlink_metadata(&path).ok().filter(fs::Metadata::is_file)?;
        let written = found.modified().ok()?.duration_since(SystemTime::UNIX_EPOCH);
        let mut told = KeptRecording {
            file: file.to_owned(),
            state: KeptState::Recording,
            bytes: found.len(),
            written: written.unwrap_or_default().as_secs_f64(),
            seconds: None,
            messages: None,
            lost: None,
            ports: Vec::new(),
            why: None,
            replay: lock(&self.plays).get(file).map(|play| play.told()),
        };
        let active = lock(&self.under_way).get(file).cloned();
        match active {
            Some(active) => active.tell(&mut told),
            None => {
                self.glances.tell(&path, &found, &mut told);
                if let Some(ended) = lock(&self.ended).get(file) {
                    (told.why, told.lost) = (Some(ended.why.clone()), Some(ended.lost));
                }
            }
        }
        Some(told)
    }

    /// The file of one that is not under way, to be read.
    ///
    /// # Errors
    /// There is none of that name, or it is just being made.
    pub fn open(&self, file: &str) -> Result<File, KeptError> {
        let path = self.path(file)?;
        if lock(&self.under_way).contains_key(file) {
            return Err(KeptError::UnderWay(file.to_owned(), "is just being made: end it first"));
        }
        self.read(&path)
    }

    fn read(&self, path: &Path) -> Result<File, KeptError> {
        let mut options = File::options();
        // What is there now may be a link, or no file at all.
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
        options.read(true).custom_flags(flags.bits().cast_signed());
        let opened = options.open(path);
        let opened = opened.and_then(|file| Ok((file.metadata()?.is_file(), file)));
        match opened {
            Ok((true, file)) => Ok(file),
            Ok((false, _)) => Err(self.unknown(path)),
            Err(error) if error.kind() == ErrorKind::NotFound || is_link(path) => {
                Err(self.unknown(path))
            }
            Err(source) => Err(KeptError::Io { path: path.to_owned(), source }),
        }
    }

    /// Removes one. Blocks.
    ///
    /// # Errors
    /// There is none of that name, it is under way, or the system refuses.
    pub fn remove(&self, file: &str) -> Result<(), KeptError> {
        let path = self.path(file)?;
        let (_, _turn) = self.shelf.open()?;
        let under_way = lock(&self.under_way);
        if under_way.contains_key(file) {
            return Err(KeptError::UnderWay(file.to_owned(), "is just being made: end it first"));
        }
        let mut plays = lock(&self.plays);
        if plays.get(file).is_some_and(|play| play.goes_on()) {
            return Err(KeptError::UnderWay(file.to_owned(), "is just replayed: end that first"));
        }
        if !is_file(&path) {
            return Err(self.unknown(&path));
        }
        fs::remove_file(&path).map_err(|source| KeptError::Io { path, source })?;
        plays.remove(file);
        lock(&self.ended).remove(file);
        Ok(())
    }

    /// One that is under way.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn active(&self, file: &str) -> Result<Arc<Active>, KeptError> {
        let path = self.path(file)?;
        let active = lock(&self.under_way).get(file).cloned();
        active.ok_or_else(|| match is_file(&path) {
            true => KeptError::UnderWay(file.to_owned(), "has ended already"),
            false => self.unknown(&path),
        })
    }

    /// Whether a recording of this number is one of these.
    #[must_use]
    pub fn has(&self, number: u64) -> bool {
        lock(&self.under_way).values().any(|active| active.number() == Some(number))
    }

    /// Waits until all recordings have their ends, for some seconds at most: when the daemon ends.
    pub async fn all_over(&self) {
        let all: Vec<_> = lock(&self.under_way).values().cloned().collect();
        let over = async {
            for active in &all {
                active.over().await;
            }
        };
        if timeout(LAST, over).await.is_err() {
            tracing::error!("recordings have no end: they did not stop in time");
        }
    }

    /// The path of a recording; names that leave the directory are none.
    pub(super) fn path(&self, file: &str) -> Result<PathBuf, KeptError> {
        name::check(file)?;
        let directory = self.shelf.directory.as_deref();
        let directory = directory.ok_or_else(|| KeptError::Unknown(file.to_owned(), Vec::new()))?;
        Ok(directory.join(file))
    }

    pub(super) fn unknown(&self, path: &Path) -> KeptError {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        KeptError::Unknown(file, self.names())
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.shelf.names().into_iter().filter(|file| name::check(file).is_ok()).collect()
    }

    pub(super) fn bytes(&self, names: &[String]) -> u64 {
        let Some(directory) = self.shelf.directory.as_deref() else { return 0 };
        let sizes = names.iter().map(|name| size(&directory.join(name)));
        sizes.fold(0, u64::saturating_add)
    }
}
