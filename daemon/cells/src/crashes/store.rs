//! The directory of reports: one directory each, for this user alone, and limits on all of them.

use std::fs::{self, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use genom_configuration::CrashesSection;
use genom_protocol::{Crash, CrashReport};

use crate::shelf::{Shelf, ShelfError, create, free, make, unfinished};

/// What names of reports begin with.
const PREFIX: &str = "crash-";
/// Most bytes of a report that are read.
const MOST: u64 = 16 << 20;

/// A report could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Its directory cannot be used.
    #[error(transparent)]
    Shelf(#[from] ShelfError),
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
pub(super) struct Store(pub(super) Shelf);

impl Store {
    pub(super) fn new(section: &CrashesSection) -> Self {
        Self(Shelf {
            section: "crashes",
            prefix: PREFIX,
            directory: section.place(),
            most: section.most,
            most_bytes: section.most_bytes,
            writing: Mutex::default(),
        })
    }

    /// Whether reports are kept at all.
    pub(super) fn is_kept(&self) -> bool {
        self.0.most > 0
    }

    /// Writes a report under its name, or one like it that is free, with the files that `more`
    /// puts beside it; then removes the oldest ones above the limits.
    pub(super) fn add(
        &self,
        report: &mut CrashReport,
        note: &[u8],
        more: impl FnOnce(&Path, &mut CrashReport),
    ) -> Result<(), StoreError> {
        let (directory, turn) = self.0.open()?;
        report.crash.name = free(directory, &report.crash.name, "");
        let name = &report.crash.name;
        let new = directory.join(unfinished(name));
        let place = directory.join(name);
        let failed = |source| ShelfError::Io { path: place.clone(), source };
        let write = |path: PathBuf, bytes: &[u8]| create(&path)?.write_all(bytes);
        let written = (|| {
            make(&new, false)?;
            more(&new, report);
            let json = serde_json::to_vec_pretty(&report).map_err(io::Error::other)?;
            write(new.join("report.json"), &json)?;
            write(new.join("report.txt"), report.to_string().as_bytes())?;
            if !note.is_empty() {
                write(new.join("note.txt"), note)?;
            }
            fs::rename(&new, &place)
        })();
        written.map_err(|error| {
            let _ = fs::remove_dir_all(&new);
            failed(error)
        })?;
        self.0.limit(directory);
        drop(turn);
        Ok(())
    }

    /// All of them, the newest first; those that cannot be read are left out.
    pub(super) fn list(&self) -> Vec<Crash> {
        let names = self.0.names().into_iter();
        names.filter_map(|name| self.read(&name).ok()).map(|report| report.crash).collect()
    }

    /// One of them.
    pub(super) fn read(&self, name: &str) -> Result<CrashReport, StoreError> {
        let unknown = || StoreError::Unknown(name.to_owned());
        let directory = self.0.directory.as_deref().ok_or_else(unknown)?;
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
        let text = read().map_err(|source| ShelfError::Io { path: path.clone(), source })?;
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

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, symlink};

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
        Store::new(&CrashesSection { directory, most, most_bytes, ..CrashesSection::default() })
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
            all.add(&mut report(&format!("crash-{number:02}-arm")), b"", |_, _| {}).unwrap();
        }
        assert_eq!(found(&all), ["crash-19-arm", "crash-18-arm", "crash-17-arm"]);
        let mode = |path: &Path| fs::metadata(path).unwrap().mode() & 0o777;
        assert_eq!(mode(&place), 0o700);
        assert_eq!(mode(&place.join("crash-19-arm")), 0o700);
        assert_eq!(mode(&place.join("crash-19-arm/report.json")), 0o600);
        let small = store(&place, 3, 1);
        small.add(&mut report("crash-20-arm"), &[b'x'; 1000], |_, _| {}).unwrap();
        assert_eq!(found(&small), ["crash-20-arm"]);
        // A second one of the same name gets another.
        small.add(&mut report("crash-20-arm"), b"", |_, _| {}).unwrap();
        assert_eq!(found(&small), ["crash-20-arm-2"]);
    }

    #[test]
    fn a_process_that_ends_again_and_again_does_not_push_out_reports_of_others() {
        let scratch = tempfile::tempdir().unwrap();
        let all = store(scratch.path(), 5, u64::MAX);
        let add = |name: &str| all.add(&mut report(name), b"", |_, _| {}).unwrap();
        add("crash-01-arm");
        add("crash-02-arm-2");
        for number in 10..60 {
            add(&format!("crash-{number}-gateway-ros2"));
        }
        let gateway = |number| format!("crash-{number}-gateway-ros2");
        let kept = [gateway(59), gateway(58), gateway(57)];
        let rest = ["crash-02-arm-2", "crash-01-arm"].map(str::to_owned);
        assert_eq!(found(&all), [&kept[..], &rest].concat());
        // One that begins to takes of what the other has.
        for number in 60..63 {
            add(&format!("crash-{number}-base"));
        }
        let newest = ["crash-62-base", "crash-61-base", "crash-59-gateway-ros2"].map(str::to_owned);
        assert_eq!(found(&all), [&newest[..], &rest].concat());
        // With as many processes as reports, the oldest goes.
        for cell in ["a", "b", "c", "d", "e"] {
            add(&format!("crash-70-{cell}"));
        }
        let last = ["e", "d", "c", "b", "a"].map(|cell| format!("crash-70-{cell}"));
        assert_eq!(found(&all), last);
    }

    #[test]
    fn a_process_whose_reports_are_large_does_not_push_out_those_of_others() {
        let scratch = tempfile::tempdir().unwrap();
        let all = store(scratch.path(), 50, 100_000);
        let add = |name: &str, bytes: usize| {
            all.add(&mut report(name), &vec![b'x'; bytes], |_, _| {}).unwrap();
        };
        add("crash-01-arm", 0);
        for number in 10..60 {
            add(&format!("crash-{number}-eye"), 30_000);
        }
        assert_eq!(found(&all), ["crash-59-eye", "crash-58-eye", "crash-57-eye", "crash-01-arm"]);
        // The newest stays whatever its size.
        add("crash-60-base", 200_000);
        assert_eq!(found(&all), ["crash-60-base"]);
    }

    #[test]
    fn no_name_leads_out_of_the_directory() {
        let scratch = tempfile::tempdir().unwrap();
        let place = scratch.path().join("crashes");
        let all = store(&place, 9, u64::MAX);
        all.add(&mut report("crash-1-arm"), b"", |_, _| {}).unwrap();
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
        let refused = all.add(&mut report("crash-1-arm"), b"", |_, _| {}).unwrap_err();
        assert!(matches!(refused, StoreError::Shelf(ShelfError::Foreign { .. })), "{refused}");
    }
}
