//! Copies of what the components of a cell are, for its next process: a file for each component that
//! asks for it, written between two of its codels by a thread that no task waits for.

use std::collections::HashMap;
use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use genom_configuration::Deployment;
use genom_protocol::freeze::{MOST, text_of};
use genom_protocol::{FrozenComponent, LoadRequest, Restore, Resumption};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;

/// How often to look whether a copy is due.
const LOOK: Duration = Duration::from_millis(20);
/// How long to wait for the end of a pass; the task does not wait meanwhile. A copy for which there
/// is no moment is made later.
const PATIENCE: Duration = Duration::from_millis(50);

/// The copies of one cell.
#[derive(Debug)]
pub(crate) struct Snapshots {
    directory: PathBuf,
    /// When the last one was made, by component; locked while one is made.
    made: Mutex<HashMap<String, Instant>>,
}

/// A copy could not be written.
#[derive(Debug, thiserror::Error)]
enum NotCopied {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("its {0} bytes are more than the {MOST} that are kept")]
    Large(usize),
}

impl Snapshots {
    pub(crate) fn new(directory: &Path) -> Self {
        Self { directory: directory.to_owned(), made: Mutex::default() }
    }

    fn file(&self, component: &str) -> PathBuf {
        self.directory.join(format!("{component}.snapshot"))
    }

    /// Gives components the copies that the process before this one made. A copy is used once: a
    /// process that it brings down before it makes another one starts the next without.
    pub(crate) fn put_back(&self, deployment: &mut Deployment) {
        let mut going_on = Vec::new();
        for request in &mut deployment.component {
            let name = request.instance();
            let taken = self.take(request, &name);
            // A reload that is taken back has the state from before it.
            let Some(resumption) = taken.filter(|_| request.resume.is_none()) else { continue };
            if resumption.activities {
                going_on.push(name);
            }
            request.resume = Some(Box::new(resumption));
        }
        // These go on where they were, and so does what was called of them.
        let anew = |name: &str| !going_on.iter().any(|one| one == name);
        deployment.call.retain(|entry| anew(&entry.component));
        deployment.activity.retain(|entry| anew(&entry.component));
    }

    fn take(&self, request: &LoadRequest, name: &str) -> Option<Resumption> {
        request.snapshot?;
        let file = self.file(name);
        let about = fs::metadata(&file).ok()?;
        let text = if about.len() > MOST as u64 {
            Err(io::Error::other(NotCopied::Large(usize::try_from(about.len()).unwrap_or(MOST))))
        } else {
            fs::read_to_string(&file)
        };
        let _ = fs::remove_file(&file);
        let read = text.and_then(|text| Ok(serde_json::from_str::<FrozenComponent>(&text)?));
        let state = read
            .inspect_err(|error| {
                tracing::error!(instance = name, "it starts anew: {}: {error}", file.display());
            })
            .ok()?;
        let age = about.modified().ok().and_then(|made| made.elapsed().ok()).unwrap_or_default();
        let activities = request.restore == Restore::Activities;
        let what = if activities { "IDS, ports and activities" } else { "IDS and ports" };
        let copy =
            format!("the {what} of {:.2} s before: its process had ended", age.as_secs_f64());
        Some(Resumption { state, activities, hold: false, copy: Some(copy) })
    }

    /// Makes those that are due, until the end.
    pub(crate) async fn keep(self: Arc<Self>, supervisor: Arc<Supervisor>) {
        while !supervisor.stopping() {
            let (own, worker) = (Arc::clone(&self), Arc::clone(&supervisor));
            let making = tokio::task::spawn_blocking(move || own.make(&worker, false));
            let _ = making.await;
            tokio::time::sleep(LOOK).await;
        }
    }

    /// Makes those that are due, or all.
    pub(crate) fn make(&self, supervisor: &Supervisor, all: bool) {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let components = supervisor.components.all();
        for name in made.keys() {
            if !components.iter().any(|hosted| hosted.name == *name) {
                let _ = fs::remove_file(self.file(name));
            }
        }
        made.retain(|name, _| components.iter().any(|hosted| hosted.name == *name));
        for hosted in components {
            let Some(seconds) = hosted.build().request.snapshot else { continue };
            let last = made.get(&hosted.name);
            let due = |last: &Instant| last.elapsed().as_secs_f64() >= seconds;
            if all || last.is_none_or(due) {
                // Also if it is not made: one that fails is not tried at each look.
                made.insert(hosted.name.clone(), Instant::now());
                self.copy(&hosted);
            }
        }
    }

    fn copy(&self, hosted: &Hosted) {
        let state = match hosted.freeze(PATIENCE) {
            Ok(state) => state,
            Err(error) => return tracing::debug!(instance = hosted.name, "no copy: {error}"),
        };
        if let Err(error) = self.write(&hosted.name, &text_of(&state)) {
            let file = self.file(&hosted.name);
            tracing::warn!(instance = hosted.name, "no copy in {}: {error}", file.display());
        }
    }

    /// Replaces the file as a whole, readable by this user only.
    fn write(&self, component: &str, text: &str) -> Result<(), NotCopied> {
        if text.len() > MOST {
            return Err(NotCopied::Large(text.len()));
        }
        let file = self.file(component);
        let aside = file.with_extension("snapshot.new");
        let mut options = OpenOptions::new();
        let mut opened =
            options.create(true).truncate(true).write(true).mode(0o600).open(&aside)?;
        opened.write_all(text.as_bytes())?;
        Ok(fs::rename(&aside, &file)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deployment() -> Deployment {
        let component = LoadRequest {
            name: Some("demo".to_owned()),
            snapshot: Some(1.0),
            ..LoadRequest::default()
        };
        Deployment { component: vec![component], ..Deployment::default() }
    }

    #[test]
    fn a_copy_is_put_back_once_and_a_damaged_one_is_left_out() {
        let scratch = tempfile::tempdir().unwrap();
        let snapshots = Snapshots::new(scratch.path());
        let state = FrozenComponent { component: "demo".to_owned(), ..FrozenComponent::default() };
        let written = || snapshots.write("demo", &text_of(&state)).unwrap();
        let put_back = || {
            let mut all = deployment();
            snapshots.put_back(&mut all);
            all.component.remove(0).resume
        };
        assert!(put_back().is_none(), "there is none");
        written();
        let resumption = put_back().unwrap();
        assert_eq!((resumption.state, resumption.activities), (state.clone(), false));
        assert!(resumption.copy.unwrap().starts_with("the IDS and ports of 0."));
        assert!(put_back().is_none(), "it was used");
        fs::write(snapshots.file("demo"), "{\"component\": ").unwrap();
        assert!(put_back().is_none());
        assert!(!snapshots.file("demo").exists());
        assert!(snapshots.write("demo", &" ".repeat(MOST + 1)).is_err());
    }
}
