//! The directory of reports: one directory each, for this user alone, and limits on all of them.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use genom_configuration::CrashesSection;
use genom_protocol::{Crash, CrashReport};

/// What names of reports begin with.
const PREFIX: &str = "crash-";
/// What names of those begin with that are being written.
const UNFINISHED: &str = ".new-crash-";
/// After so long, nobody writes them any more.
const STALE: Duration = Duration::from_secs(600);
/// Most bytes of a report that are read.
const MOST: u64 = 16 << 20;

/// A report could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// There is no directory for them.
    #[error(
        "there is no directory for reports: set crashes.directory, or XDG_STATE_HOME or HOME in the \
         daemon's environment"
    )]
    Nowhere,
    /// Others could put files there.
    #[error(
        "{}: others may write there, or it belongs to another user: `chmod go-w` it, or set \
         crashes.directory", .0.display()
    )]
    Foreign(PathBuf),
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// What was to be made or read.
        path: PathBuf,
        /// Its own words.
        source: io::Error,
    },
    /// No report has this name.
    #[error("no report `{0}`")]
    Unknown(String),
    /// It is no report.
    #[error("{}: {why}", path.display())]
    Misread {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
}

/// The reports.
#[derive(Debug)]
pub(super) struct Store {
    pub(super) directory: Option<PathBuf>,
    most: usize,
    most_bytes: u64,
    /// Held while one is written and old ones are removed.
    writing: Mutex<()>,
}

impl Store {
    pub(super) fn new(section: &CrashesSection) -> Self {
        Self {
            directory: section.place(),
            most: section.most,
            most_bytes: section.most_bytes,
            writing: Mutex::default(),
        }
    }

    /// Whether reports are kept at all.
    pub(super) fn is_kept(&self) -> bool {
        self.most > 0
    }

    /// Writes a report under its name, or one like it that is free; then removes the oldest ones
    /// above the limits.
    pub(super) fn add(&self, report: &mut CrashReport, note: &[u8]) -> Result<(), StoreError> {
        let directory = self.directory.as_deref().ok_or(StoreError::Nowhere)?;
        let _turn = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let failed = |path: &Path, source| StoreError::Io { path: path.to_owned(), source };
        make(directory, true).map_err(|error| failed(directory, error))?;
        let found = fs::metadata(directory).map_err(|error| failed(directory, error))?;
        if found.uid() != rustix::process::geteuid().as_raw() || found.mode() & 0o022 != 0 {
            return Err(StoreError::Foreign(directory.to_owned()));
        }
        let wanted = report.crash.name.clone();
        let others = (2..=99).map(|number| format!("{wanted}-{number}"));
        let mut names = std::iter::once(wanted.clone()).chain(others);
        let free = names.find(|name| !directory.join(name).exists());
        report.crash.name = free.unwrap_or(wanted);
        let name = &report.crash.name;
        let new = directory.join(format!(".new-{name}"));
        let place = directory.join(name);
        let write = || {
            make(&new, false)?;
            let json = serde_json::to_vec_pretty(&report).map_err(io::Error::other)?;
            write(&new.join("report.json"), &json)?;
            write(&new.join("report.txt"), report.to_string().as_bytes())?;
            if !note.is_empty() {
                write(&new.join("note.txt"), note)?;
            }
            fs::rename(&new, &place)
        };
        write().map_err(|error| {
            let _ = fs::remove_dir_all(&new);
            failed(&place, error)
        })?;
        self.limit(directory);
        Ok(())
    }

    /// Removes the oldest above the limits, and what a daemon that died left unfinished.
    fn limit(&self, directory: &Path) {
        let (mut count, mut bytes) = (0, 0);
        for name in names(directory, PREFIX).into_iter().rev() {
            let path = directory.join(name);
            (count, bytes) = (count + 1, bytes + size(&path));
            // The newest stays whatever its size.
            if count > self.most || count > 1 && bytes > self.most_bytes {
                remove(&path);
            }
        }
        for name in names(directory, UNFINISHED) {
            let path = directory.join(name);
            let changed = fs::symlink_metadata(&path).and_then(|found| found.modified());
            let age = changed.map(|changed| SystemTime::now().duration_since(changed));
            if matches!(age, Ok(Ok(age)) if age > STALE) {
                remove(&path);
            }
        }
    }

    /// All of them, the newest first; those that cannot be read are left out.
    pub(super) fn list(&self) -> Vec<Crash> {
        let Some(directory) = &self.directory else { return Vec::new() };
        let names = names(directory, PREFIX).into_iter().rev();
        names.filter_map(|name| self.read(&name).ok()).map(|report| report.crash).collect()
    }

    /// One of them.
    pub(super) fn read(&self, name: &str) -> Result<CrashReport, StoreError> {
        let unknown = || StoreError::Unknown(name.to_owned());
        let directory = self.directory.as_deref().ok_or_else(unknown)?;
        if !is_name(name) {
            return Err(unknown());
        }
        let place = directory.join(name);
        let is_there = fs::symlink_metadata(&place).is_ok_and(|found| found.is_dir());
        if !is_there {
            return Err(unknown());
        }
        let path = place.join("report.json");
        let no_link = rustix::fs::OFlags::NOFOLLOW.bits().cast_signed();
        let read = || {
            let file = OpenOptions::new().read(true).custom_flags(no_link).open(&path)?;
            let mut text = String::new();
            file.take(MOST).read_to_string(&mut text)?;
            Ok(text)
        };
        let text = read().map_err(|source| StoreError::Io { path: path.clone(), source })?;
        let mut report: CrashReport = serde_json::from_str(&text)
            .map_err(|error| StoreError::Misread { path: path.clone(), why: error.to_string() })?;
        name.clone_into(&mut report.crash.name);
        Ok(report)
    }
}

/// Whether this is a name of a report, which names nothing outside the directory.
fn is_name(name: &str) -> bool {
    let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    name.len() <= 128 && name.starts_with(PREFIX) && name.chars().all(fine)
}

/// Names of directories that begin with this, oldest first.
fn names(directory: &Path, prefix: &str) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let names = own.filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<_> = names.filter(|name| name.starts_with(prefix)).collect();
    names.sort();
    names
}

/// Bytes of the files in a directory.
fn size(directory: &Path) -> u64 {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|found| found.len()).sum()
}

fn remove(path: &Path) {
    if let Err(error) = fs::remove_dir_all(path)
        && error.kind() != io::ErrorKind::NotFound
    {
        tracing::warn!("{}: an old report stays: {error}", path.display());
    }
}

fn make(path: &Path, recursive: bool) -> io::Result<()> {
    DirBuilder::new().recursive(recursive).mode(0o700).create(path)
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)?;
    file.write_all(bytes)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt as _, symlink};

    use super::*;

    fn report(name: &str) -> CrashReport {
        serde_json::from_value(serde_json::json!({
            "name": name, "time": 0.0, "cell": "arm", "end": "signal 9 (SIGKILL)",
            "genomd": "0", "socket": "/s", "components": [], "log": [],
        }))
        .unwrap()
    }

    fn store(directory: &Path, most: usize, most_bytes: u64) -> Store {
        let directory = Some(directory.to_owned());
        Store::new(&CrashesSection { directory, most, most_bytes, core: false })
    }

    fn found(store: &Store) -> Vec<String> {
        store.list().into_iter().map(|crash| crash.name).collect()
    }

    #[test]
    fn the_oldest_go_when_there_are_too_many_or_they_are_too_large() {
        let scratch = tempfile::tempdir().unwrap();
        let place = scratch.path().join("a/crashes");
        let all = store(&place, 3, u64::MAX);
        for number in 0..20 {
            all.add(&mut report(&format!("crash-{number:02}-arm")), b"").unwrap();
        }
        assert_eq!(found(&all), ["crash-19-arm", "crash-18-arm", "crash-17-arm"]);
        let mode = |path: &Path| fs::metadata(path).unwrap().mode() & 0o777;
        assert_eq!(mode(&place), 0o700);
        assert_eq!(mode(&place.join("crash-19-arm")), 0o700);
        assert_eq!(mode(&place.join("crash-19-arm/report.json")), 0o600);
        let small = store(&place, 3, 1);
        small.add(&mut report("crash-20-arm"), &[b'x'; 1000]).unwrap();
        assert_eq!(found(&small), ["crash-20-arm"]);
        // A second one of the same name gets another.
        small.add(&mut report("crash-20-arm"), b"").unwrap();
        assert_eq!(found(&small), ["crash-20-arm-2"]);
    }

    #[test]
    fn no_name_leads_out_of_the_directory() {
        let scratch = tempfile::tempdir().unwrap();
        let place = scratch.path().join("crashes");
        let all = store(&place, 9, u64::MAX);
        all.add(&mut report("crash-1-arm"), b"").unwrap();
        fs::create_dir(scratch.path().join("crash-0")).unwrap();
        fs::copy(place.join("crash-1-arm/report.json"), scratch.path().join("crash-0/report.json"))
            .unwrap();
        symlink(scratch.path().join("crash-0"), place.join("crash-link")).unwrap();
        fs::create_dir(place.join("crash-file")).unwrap();
        let json = scratch.path().join("crash-0/report.json");
        symlink(json, place.join("crash-file/report.json")).unwrap();
        for name in [
            "../crash-0",
            "crash-1-arm/../../crash-0",
            "crash-link",
            "crash-\0",
            "",
            "..",
            "crash-file",
            "crash-./..",
            "/crash-0",
        ] {
            assert!(all.read(name).is_err(), "{name}");
        }
        assert_eq!(found(&all), ["crash-1-arm"]);
    }

    #[test]
    fn a_directory_that_others_may_write_to_gets_no_report() {
        let scratch = tempfile::tempdir().unwrap();
        fs::set_permissions(scratch.path(), fs::Permissions::from_mode(0o777)).unwrap();
        let all = store(scratch.path(), 3, u64::MAX);
        let refused = all.add(&mut report("crash-1-arm"), b"").unwrap_err();
        assert!(matches!(refused, StoreError::Foreign(_)), "{refused}");
    }
}
