//! Reloads components whose files change: the edit loop is save, make, running.
//!
//! The files are looked at several times a second, rather than announced by the kernel: that works on
//! every file system, also on one that is mounted from another machine or container, and a build
//! writes or replaces a file in several steps, of which only the last one matters.

use std::collections::HashMap;
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::sync::{Arc, Weak};
use std::thread;
use std::time::Duration;

use genom_host::Contents;
use genom_protocol::ReloadRequest;

use crate::components::Hosted;
use crate::supervisor::Supervisor;
use genom_bus::Change;

/// Interval between two looks. A file counts as written when it is the same in two of them.
const LOOK: Duration = Duration::from_millis(200);

impl Supervisor {
    /// Reloads components when their files change, if the settings say so.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn watch_files(self: &Arc<Self>) -> io::Result<()> {
        if !self.settings.watch {
            return Ok(());
        }
        let (supervisor, closed) = (Arc::downgrade(self), self.closed.clone());
        let watch = move || {
            let mut watch = Watch::default();
            while !closed.is_up() && watch.look(&supervisor) {
                thread::park_timeout(LOOK);
            }
        };
        thread::Builder::new().name("genomd-watch".to_owned()).spawn(watch).map(drop)
    }
}

/// What a file is: another one at the same place, or one that was written again, differs.
type Stamp = Option<(u64, u64, i64, i64)>;

fn stamp(path: &Path) -> Stamp {
    let file = std::fs::metadata(path).ok()?;
    Some((file.ino(), file.len(), file.mtime(), file.mtime_nsec()))
}

/// Library and description of a component.
type Stamps = (Stamp, Stamp);

#[derive(Default)]
struct Watch(HashMap<String, Watched>);

/// The files of one component.
struct Watched {
    /// As of the last look.
    seen: Stamps,
    /// What the component runs, or refused.
    done: Option<Stamps>,
}

impl Watch {
    /// Looks at the files of all components; `false` when there is no supervisor any more.
    fn look(&mut self, supervisor: &Weak<Supervisor>) -> bool {
        let Some(supervisor) = supervisor.upgrade() else { return false };
        let all = supervisor.components.all();
        self.0.retain(|name, _| all.iter().any(|hosted| hosted.name == *name));
        for hosted in &all {
            if supervisor.stopping() {
                break;
            }
            self.look_at(&supervisor, hosted);
        }
        true
    }

    fn look_at(&mut self, supervisor: &Arc<Supervisor>, hosted: &Hosted) {
        let build = hosted.build();
        let now = (stamp(&build.library), build.description.file().as_deref().and_then(stamp));
        // What was rolled back is not tried again before it changes.
        let done = build.request.instead.is_some().then_some(now);
        let new = || Watched { seen: now, done };
        let watched = self.0.entry(hosted.name.clone()).or_insert_with(new);
        let settled = std::mem::replace(&mut watched.seen, now) == now;
        if watched.done == Some(now) || !settled {
            return;
        }
        let described = watched.done.is_some_and(|done| done.1 != now.1);
        watched.done = Some(now);
        // A file that is being written will change again.
        let why = match Contents::read(&build.library) {
            Ok(contents) if contents.digest() == build.digest && !described => return,
            Ok(_) => supervisor.reload(&hosted.name, &ReloadRequest::default()).err(),
            Err(error) => Some(crate::loading::LoadError::from(error).into()),
        };
        if let Some(error) = why {
            let (component, why) = (hosted.name.clone(), error.to_string());
            tracing::warn!(instance = component, "not reloaded: {why}");
            supervisor.bus.tell(&Change::ComponentNotReloaded { component, why });
        }
    }
}
