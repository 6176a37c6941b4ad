//! A directory of files that a daemon leaves for people: for its user alone, with limits on how
//! many there are and how large they are together. Daemons may share it.

use std::collections::BTreeMap;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use genom_supervisor::loading::date_in_utc;

/// What names begin with of what is being written.
const UNFINISHED: &str = ".new-";
/// After so long, nobody writes it any more.
const STALE: Duration = Duration::from_secs(600);

/// A directory and its limits.
#[derive(Debug)]
pub(crate) struct Shelf {
    /// Section of the configuration that says so, for messages.
    pub(crate) section: &'static str,
    /// What names begin with.
    pub(crate) prefix: &'static str,
    pub(crate) directory: Option<PathBuf>,
    pub(crate) most: usize,
    pub(crate) most_bytes: u64,
    /// Held while something is written and old things are removed.
    pub(crate) writing: Mutex<()>,
}

/// The directory cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ShelfError {
    /// There is none.
    #[error(
        "there is no directory for files: set {0}.directory, or XDG_STATE_HOME or HOME in the \
         daemon's environment"
    )]
    Nowhere(&'static str),
    /// Others could put files there.
    #[error(
        "{}: others may write there, or it belongs to another user: `chmod go-w` it, or set \
         {section}.directory", path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// Section of the configuration that names it.
        section: &'static str,
    },
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// What was to be made or read.
        path: PathBuf,
        /// Its own words.
        source: io::Error,
    },
}

impl Shelf {
    /// The directory, made if need be, and a turn to write there.
    pub(crate) fn open(&self) -> Result<(&Path, MutexGuard<'_, ()>), ShelfError> {
        let directory = self.directory.as_deref().ok_or(ShelfError::Nowhere(self.section))?;
        let turn = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let failed = |source| ShelfError::Io { path: directory.to_owned(), source };
        make(directory, true).map_err(failed)?;
        let found = fs::metadata(directory).map_err(failed)?;
        if found.uid() != rustix::process::geteuid().as_raw() || found.mode() & 0o022 != 0 {
            let (path, section) = (directory.to_owned(), self.section);
            return Err(ShelfError::Foreign { path, section });
        }
        Ok((directory, turn))
    }

    /// Removes what is above the limits, and what a daemon that died left unfinished. Of what has the
    /// most here the oldest goes first: a process that ends again and again does not push out what
    /// others left.
    pub(crate) fn limit(&self, directory: &Path) {
        let kept = |name: String| {
            let of = name.strip_prefix(self.prefix).and_then(|rest| rest.split_once('-'));
            let of = of.map_or_else(String::new, |(_date, of)| of.to_owned());
            Kept { bytes: size(&directory.join(&name)), name, of }
        };
        let mut all: Vec<_> = names(directory, self.prefix).into_iter().map(kept).collect();
        loop {
            let bytes = all.iter().fold(0_u64, |sum, one| sum.saturating_add(one.bytes));
            let first = if all.len() > self.most {
                first_to_go(&all, self.most > 0, |_| 1)
            } else if bytes > self.most_bytes {
                first_to_go(&all, true, |one| one.bytes)
            } else {
                None
            };
            let Some(first) = first else { break };
            remove(&directory.join(all.remove(first).name));
        }
        for name in names(directory, &format!("{UNFINISHED}{}", self.prefix)) {
            let path = directory.join(name);
            let changed = fs::symlink_metadata(&path).and_then(|found| found.modified());
            let age = changed.map(|changed| SystemTime::now().duration_since(changed));
            if matches!(age, Ok(Ok(age)) if age > STALE) {
                remove(&path);
            }
        }
    }

    /// The names that are there, the newest first.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut all = self.directory.as_deref().map_or_else(Vec::new, |at| names(at, self.prefix));
        all.reverse();
        all
    }
}

/// Something in the directory.
struct Kept {
    name: String,
    /// What it is of, as it stands behind the date: the cell that ended, the reason for a file.
    of: String,
    bytes: u64,
}

/// The oldest of what weighs most together; of what weighs the same, the oldest. `all` begins with the
/// oldest; the newest does not go if it `stays`.
fn first_to_go(all: &[Kept], stays: bool, weigh: fn(&Kept) -> u64) -> Option<usize> {
    let mut weights: BTreeMap<&str, u64> = BTreeMap::new();
    for one in all {
        let weight = weights.entry(&one.of).or_default();
        *weight = weight.saturating_add(weigh(one));
    }
    let may_go = all.len().saturating_sub(usize::from(stays));
    // Of equal ones, the last that is looked at is taken.
    (0..may_go).rev().max_by_key(|at| weights.get(all[*at].of.as_str()))
}

/// This name, or one like it that is free.
pub(crate) fn free(directory: &Path, wanted: &str, ending: &str) -> String {
    let others = (2..=99).map(|number| format!("{wanted}-{number}{ending}"));
    let mut names = std::iter::once(format!("{wanted}{ending}")).chain(others);
    let free = names.find(|name| fs::symlink_metadata(directory.join(name)).is_err());
    free.unwrap_or_else(|| format!("{wanted}{ending}"))
}

/// The name under which something is written until it is complete.
pub(crate) fn unfinished(name: &str) -> String {
    format!("{UNFINISHED}{name}")
}

/// A moment as it stands in names: they sort by it.
pub(crate) fn date(now: SystemTime) -> String {
    let date = date_in_utc(now).replace(['-', ':', 'Z'], "");
    let since = now.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    format!("{date}{:03}Z", since.subsec_millis())
}

/// Names that begin with this, oldest first; of links none.
fn names(directory: &Path, prefix: &str) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let own =
        entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir() || kind.is_file()));
    let names = own.filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<_> = names.filter(|name| name.starts_with(prefix)).collect();
    names.sort();
    names
}

/// Bytes of a file, or of the files in a directory.
pub(crate) fn size(path: &Path) -> u64 {
    match fs::symlink_metadata(path) {
        Ok(found) if !found.is_dir() => found.len(),
        _ => {
            let entries = fs::read_dir(path).into_iter().flatten().flatten();
            entries.filter_map(|entry| entry.metadata().ok()).map(|found| found.len()).sum()
        }
    }
}

fn remove(path: &Path) {
    let is_directory = fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    let removed = if is_directory { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    if let Err(error) = removed
        && error.kind() != io::ErrorKind::NotFound
    {
        tracing::warn!("{}: an old one stays: {error}", path.display());
    }
}

/// Makes a directory for this user alone.
pub(crate) fn make(path: &Path, recursive: bool) -> io::Result<()> {
    DirBuilder::new().recursive(recursive).mode(0o700).create(path)
}

/// Makes a file for this user alone, which is not there yet; a link is followed nowhere.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)
}
