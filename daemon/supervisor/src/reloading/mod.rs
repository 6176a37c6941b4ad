//! Exchanges the library of a running component.
//!
//! All that can fail or take long is done beside the component: the new library is copied, opened
//! and compared with the description as at a load. Then the code is exchanged at a moment when no
//! codel runs and each activity is at a pause; the memory stays where it is. The library that ran
//! before is closed by the rule of all libraries, when nothing can be in its code any more.

mod error;
mod native;
mod watch;

use std::thread;
use std::time::Duration;

use genom_host::Component;
use genom_protocol::{ComponentReload, ReloadRequest};

use crate::bus::Change;
use crate::components::{Build, Hosted};
use crate::loading::locate::LocateError;
use crate::loading::{LoadError, built, locate, open, tell_warnings};
use crate::supervisor::Supervisor;
pub use error::ReloadError;

/// How long to wait for a moment of rest.
const REST: Duration = Duration::from_secs(5);
/// How often to look whether a thread is in the old library: addresses that it left on the stacks
/// of tasks disappear when these go on.
const LOOKS: u32 = 20;
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(20);

impl Supervisor {
    /// Exchanges the library of a running component. Blocks for file access, and until no codel
    /// runs.
    ///
    /// # Errors
    /// The library does not fit, or a codel does not return. The component goes on as before.
    pub fn reload(
        &self,
        name: &str,
        asked: &ReloadRequest,
    ) -> Result<ComponentReload, ReloadError> {
        if self.stopping() {
            return Err(LoadError::Stopping.into());
        }
        let hosted = self.components.get(name);
        let hosted = hosted.ok_or_else(|| ReloadError::NotThere(name.to_owned()))?;
        let turn = hosted.reloading();
        if turn.is_none() {
            return Err(ReloadError::Busy(name.to_owned()));
        }
        let (new, build) = self.prepare(&hosted, asked)?;
        let (library, date) = (build.library.clone(), built::date(&build.library));
        hosted.exchange(&new, build, date, REST)??;
        drop(turn);
        tracing::info!(instance = name, "runs {} now", library.display());
        let path = library.display().to_string();
        self.bus.tell(&Change::ComponentReloaded { component: name.to_owned(), library: path });
        let old_stays = !close(new);
        Ok(ComponentReload { component: name.to_owned(), library, old_stays })
    }

    /// Opens and checks the new library beside the component.
    fn prepare(
        &self,
        hosted: &Hosted,
        asked: &ReloadRequest,
    ) -> Result<(Component, Build), ReloadError> {
        let name = || hosted.name.clone();
        let Build { mut request, description, .. } = hosted.build();
        if let Some(library) = &asked.library {
            request.library.clone_from(library);
        }
        if asked.gen_file.is_some() {
            request.gen_file.clone_from(&asked.gen_file);
        }
        let find = |request: &_| locate::locate(request, &self.settings.path);
        let mut located = match find(&request) {
            // A library without a description of its own: it is to fit the present one.
            Err(LocateError::NoDescription { .. }) if description.is_some() => {
                request.gen_file = description;
                find(&request)
            }
            located => located,
        }
        .map_err(LoadError::from)?;
        let reading = self.known.read(&located.description, &self.settings.include)?;
        tell_warnings(&located, &reading);
        let (old, new) = (hosted.model(), reading.model());
        if old.name != new.name {
            let (runs, found) = (old.name.clone(), new.name.clone());
            return Err(ReloadError::OtherComponent { name: name(), runs, found });
        }
        let (component, digest) = open(&mut located, &reading)?;
        component.name_it(&hosted.name);
        let specification = reading.plan.specification();
        if specification.fingerprint != hosted.specification().fingerprint {
            return Err(ReloadError::Description { name: name() });
        }
        if let Some(native) = native::inside(new, &specification.types) {
            return Err(ReloadError::Native { name: name(), native });
        }
        let library = std::path::absolute(&located.library).unwrap_or(located.library);
        let description = located.description.file();
        Ok((component, Build { request, library, digest, description }))
    }
}

/// Closes the library that ran before; returns whether nothing is in it any more.
fn close(old: Component) -> bool {
    let free = (0..LOOKS).any(|_| {
        let free = !old.is_in_code();
        if !free {
            thread::park_timeout(LOOK);
        }
        free
    });
    // It is unmapped here, unless something uses it.
    drop(old);
    free
}
