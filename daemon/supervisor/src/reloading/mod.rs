//! Exchanges the library of a running component.
//!
//! All that can fail or take long is done beside the component: the new library is copied, opened
//! and compared with the description as at a load. Then the code is exchanged at a moment when no
//! codel runs and each activity is at a pause; the memory stays where it is. If the description is
//! another one, a second component starts beside it and takes its place between two ticks. The library
//! that ran before is closed by the rule of all libraries, when nothing can be in its code any more.

mod back;
mod beforehand;
mod beside;
mod error;
mod found;
mod native;
mod restart;
mod trial;
mod watch;

use std::sync::Arc;

use genom_configuration::ReloadSection;
use genom_host::Contents;
use genom_protocol::{ComponentReload, ReloadRequest};

use crate::components::{Build, Hosted, is_vacated};
use crate::loading::{LoadError, Source, built, open};
use crate::supervisor::Supervisor;
use back::{Before, Way};
use found::Found;
use genom_bus::Change;
use genom_finder::{LocateError, locate};
use trial::{REST, Trial};

pub use error::ReloadError;
pub use trial::roll_back;

impl Supervisor {
    /// Exchanges the library of a running component. Blocks for file access, and until no codel
    /// runs.
    ///
    /// # Errors
    /// The library does not fit, or a codel does not return. The component goes on as before, unless
    /// the error says otherwise.
    pub fn reload(
        self: &Arc<Self>,
        name: &str,
        asked: &ReloadRequest,
    ) -> Result<ComponentReload, ReloadError> {
        if self.stopping() {
            return Err(LoadError::Stopping.into());
        }
        let hosted = self.components.get(name);
        let hosted = hosted.ok_or_else(|| ReloadError::NotThere(name.to_owned()))?;
        let busy = hosted.is_reloading();
        let Some(_turn) = busy.begin() else {
            return Err(ReloadError::Busy(name.to_owned()));
        };
        let mut found = self.find(&hosted, asked)?;
        let located = &found.source.located;
        let library = std::path::absolute(&located.library).unwrap_or(located.library.clone());
        let (model, specification) =
            (found.source.reading.model(), found.source.reading.plan.specification());
        let same = specification.fingerprint == hosted.specification().fingerprint;
        let native = native::inside(model, &specification.types);
        let in_locals = native::in_locals(model, &specification.types);
        let mut reload = ComponentReload {
            component: name.to_owned(),
            library: library.clone(),
            restarted: !same || native.is_some(),
            notes: Vec::new(),
            old_stays: false,
        };
        if reload.restarted {
            if asked.stop_first {
                reload.notes = self.restart(hosted, found)?;
                let native = native.filter(|_| same);
                reload.notes.extend(native.map(|native| {
                    format!("native data ({native}) is what the start codels made of it")
                }));
            } else {
                (reload.notes, reload.old_stays) = self.begin_beside(hosted, found)?;
                reload.notes.extend(in_locals.map(|native| {
                    format!("native data ({native}) in local variables of activities starts anew")
                }));
            }
        } else if let Some((new, digest)) = found.source.opened.take() {
            let Found { request, source: Source { located, reading, .. } } = found;
            let (date, description) = (built::date(&library), located.description);
            let build = Build { request, library, digest, description, reading };
            let trial = Trial::begin(self, &hosted, false);
            let (ran, bus) = (hosted.build(), Arc::clone(&self.bus));
            let changes = bus.live();
            hosted.exchange(&new, build, date, REST)??;
            let ReloadSection { ticks, exceptions } = self.settings.reload;
            if exceptions {
                // What it holds now is the code that ran.
                let date = built::date(&ran.library);
                let way = Way::Exchange { component: new, date };
                let before = Before { way, build: ran, changes, bus };
                back::watch(&hosted, trial, before, ticks);
            } else {
                if let Some(trial) = trial {
                    trial.watch(&hosted, ticks);
                }
                reload.old_stays = !is_vacated(&new);
            }
        }
        let path = reload.library.display().to_string();
        tracing::info!(instance = name, "runs {path} now");
        reload.notes.iter().for_each(|note| tracing::warn!(instance = name, "{note}"));
        self.bus.tell(&Change::ComponentReloaded { component: name.to_owned(), library: path });
        Ok(reload)
    }

    /// Finds, opens and checks the new library beside the component.
    fn find(&self, hosted: &Hosted, asked: &ReloadRequest) -> Result<Found, ReloadError> {
        let Build { mut request, description, .. } = hosted.build();
        request.instead = None;
        if let Some(library) = &asked.library {
            request.library.clone_from(library);
        }
        if asked.gen_file.is_some() {
            request.gen_file.clone_from(&asked.gen_file);
        }
        let found = |request: &_| locate(request, &self.settings.path);
        let located = match (found(&request), description.file()) {
            // A library without a description of its own: it is to fit the present one.
            (Err(LocateError::NoDescription { .. }), Some(description)) => {
                request.gen_file = Some(description);
                found(&request)
            }
            (located, _) => located,
        };
        let mut source = Source::of(self, located.map_err(LoadError::from)?)?;
        let (old, new) = (hosted.model(), source.reading.model());
        if old.name != new.name {
            let (name, runs, found) = (hosted.name.clone(), old.name.clone(), new.name.clone());
            return Err(ReloadError::OtherComponent { name, runs, found });
        }
        self.load_beforehand(&mut source)?;
        let (component, digest) = open(&mut source.located, &source.reading, &self.settings)?;
        component.name_it(&hosted.name);
        source.opened = Some((component, digest));
        Ok(Found { request, source })
    }

    /// In a cell, loads a library that is new here in another process.
    fn load_beforehand(&self, source: &mut Source) -> Result<(), ReloadError> {
        let Some(program) = self.settings.trials.as_ref().and_then(|one| one.program.as_deref())
        else {
            return Ok(());
        };
        let located = &mut source.located;
        let contents = match located.contents.take() {
            Some(contents) => contents,
            None => Contents::read(&located.library).map_err(LoadError::from)?,
        };
        let known = source.reading.fits(&contents.digest());
        located.contents = Some(contents);
        if known {
            return Ok(());
        }
        let description = located.description.file();
        beforehand::load(program, &located.library, description, &self.settings.include)
    }
}
