//! What a cell is to hold, as a deployment file: its own process writes it after each change, its
//! next process reads it.

use std::fs::Metadata;
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use genom_configuration::{Config, ConfigError, Deployment};
use genom_protocol::RestartPolicy;

use crate::theirs;

/// Most bytes of one. Components come with what they go on with, as in the file of a freeze.
const MOST: u64 = 2 * genom_protocol::freeze::MOST as u64;

/// A journal that its daemon reads now and then, and at a failure, which waits for no reading: one
/// with much in it takes milliseconds. What it holds is kept as long as the file looks the same.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    last: Mutex<Option<(Version, Arc<Deployment>)>>,
}

/// Each writing makes another file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Version {
    file: (u64, u64),
    size: u64,
    changed: (i64, i64),
}

impl Version {
    fn of(found: &Metadata) -> Self {
        let file = (found.dev(), found.ino());
        Self { file, size: found.size(), changed: (found.ctime(), found.ctime_nsec()) }
    }
}

impl Journal {
    pub(crate) fn new(path: PathBuf) -> Self {
        Self { path, last: Mutex::default() }
    }

    /// What it says now.
    ///
    /// # Errors
    /// It is no such file.
    pub(crate) fn read(&self) -> Result<Arc<Deployment>, ConfigError> {
        // Before it is read: one that changes meanwhile is read again next time.
        let now = std::fs::symlink_metadata(&self.path).ok().as_ref().map(Version::of);
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let (Some((version, held)), Some(now)) = (&*last, now)
            && *version == now
        {
            return Ok(Arc::clone(held));
        }
        let held = Arc::new(read(&self.path)?);
        *last = now.map(|now| (now, Arc::clone(&held)));
        Ok(held)
    }
}

/// Writes what is to be held. A process that dies while it writes leaves the file that was there.
///
/// # Errors
/// The system refuses.
pub fn write(path: &Path, held: &Deployment) -> io::Result<()> {
    let text = toml::to_string(held).map_err(io::Error::other)?;
    theirs::write(path, text.as_bytes())
}

/// Reads it; nothing is held where there is none yet.
///
/// # Errors
/// It is no such file.
pub fn read(path: &Path) -> Result<Deployment, ConfigError> {
    let text = match theirs::read(path, MOST) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Deployment::default()),
        read => read.map_err(|source| ConfigError::Read { path: path.to_owned(), source })?,
    };
    let Config { component, connection, call, activity, .. } = Config::of_text(path, &text)?;
    Ok(Deployment { component, connection, call, activity })
}

/// What is to come back after an end: components by their policies, and what is connected into
/// them and called of them.
#[must_use]
pub fn kept(mut held: Deployment, failure: bool) -> Deployment {
    held.component.retain(|component| match component.restart {
        RestartPolicy::Never => false,
        RestartPolicy::OnFailure => failure,
        RestartPolicy::Always => true,
    });
    let names: Vec<String> = held.component.iter().map(|one| one.instance()).collect();
    let stays = |name: &str| names.iter().any(|one| one == name);
    held.connection.retain(|entry| stays(entry.reader()));
    held.call.retain(|entry| stays(&entry.component));
    held.activity.retain(|entry| stays(&entry.component));
    held
}

#[cfg(test)]
mod tests {
    use std::fs;

    use genom_configuration::{CallEntry, ConnectionEntry, LoadRequest};
    use serde_json::json;

    use super::*;

    fn component(name: &str, restart: RestartPolicy) -> LoadRequest {
        let name = Some(name.to_owned());
        LoadRequest { library: "/lib/demo.so".into(), name, restart, ..LoadRequest::default() }
    }

    fn held() -> Deployment {
        let call = |component: &str| CallEntry {
            component: component.to_owned(),
            service: "set_speed".to_owned(),
            inputs: json!({"velocity": 2.5}),
        };
        Deployment {
            component: vec![
                component("a", RestartPolicy::Never),
                component("b", RestartPolicy::OnFailure),
                component("c", RestartPolicy::Always),
            ],
            connection: vec![ConnectionEntry {
                inport: "a/in".to_owned(),
                outport: "b/out".to_owned(),
                policy: None,
                over: None,
            }],
            call: vec![call("a"), call("b")],
            activity: Vec::new(),
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("journal.toml");
        assert_eq!(read(&path).unwrap(), Deployment::default());
        write(&path, &held()).unwrap();
        assert_eq!(read(&path).unwrap(), held());
        fs::write(&path, "component = 3").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("journal.toml:1"));
    }

    #[test]
    fn a_journal_is_read_again_when_it_has_changed_and_only_then() {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("journal.toml");
        let journal = Journal::new(path.clone());
        assert_eq!(*journal.read().unwrap(), Deployment::default());
        write(&path, &held()).unwrap();
        let first = journal.read().unwrap();
        assert_eq!(*first, held());
        assert!(Arc::ptr_eq(&first, &journal.read().unwrap()), "kept");
        let mut less = held();
        less.call.clear();
        write(&path, &less).unwrap();
        assert_eq!(*journal.read().unwrap(), less);
        fs::write(&path, "component = 3").unwrap();
        assert!(journal.read().is_err(), "also one that is written in place");
        fs::remove_file(&path).unwrap();
        assert_eq!(*journal.read().unwrap(), Deployment::default());
    }

    #[test]
    fn a_component_comes_back_as_its_policy_says_and_what_is_of_it_with_it() {
        let names = |kept: &Deployment| {
            let names = kept.component.iter().map(|one| one.instance());
            names.collect::<Vec<_>>().concat()
        };
        let failed = kept(held(), true);
        assert_eq!(
            (names(&failed).as_str(), failed.connection.len(), failed.call.len()),
            ("bc", 0, 1)
        );
        assert_eq!(names(&kept(held(), false)), "c");
    }
}
