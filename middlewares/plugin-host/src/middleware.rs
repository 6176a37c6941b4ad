//! The middleware as a whole.

use std::borrow::Cow;
use std::io;
use std::sync::Arc;

use genom_kit::sender::{Duty, Sender};
use genom_middleware::{
    Capabilities, Diagnosis, Discovery, LogEntry, Middleware, NoForeignName, Obstacle, Refused,
    Relay, Services,
};
use genom_plugin_abi::table::can;

use crate::calls::Handle;
use crate::error::LibraryError;
use crate::library::Library;
use crate::listing::{Lent, Listed};
use crate::outlet::Line;
use crate::reports::Reports;

/// An open middleware of a library.
pub(crate) struct Open(pub(crate) Arc<Core>);

/// Shared by all its ends. Fields are dropped in order: the threads end before the backend closes.
pub(crate) struct Core {
    pub(crate) sender: Sender<Nothing>,
    /// What a thread of its own tells the library; `None` if the library takes no reports.
    reports: Option<Reports>,
    pub(crate) backend: Arc<Handle>,
    pub(crate) can: u64,
    pub(crate) library: &'static Library,
}

/// Duty of the sending thread beside sending: none.
pub(crate) struct Nothing;

impl Duty for Nothing {
    type Line = Line;
}

impl Open {
    pub(crate) fn new(library: &'static Library, options: &str) -> Result<Self, LibraryError> {
        let backend = Arc::new(library.open_backend(options)?);
        let can = backend.capabilities() & library.able();
        let refused = |error: io::Error| LibraryError::Refused { why: error.to_string() };
        let sender = Sender::start(library.name(), true, Nothing).map_err(refused)?;
        let reports =
            (can & can::REPORTS != 0).then(|| Reports::start(library.name(), Arc::clone(&backend)));
        let reports = reports.transpose().map_err(refused)?;
        Ok(Self(Arc::new(Core { sender, reports, backend, can, library })))
    }
}

impl Core {
    pub(crate) fn can(&self, flag: u64) -> bool {
        self.can & flag != 0
    }

    /// What a function lists.
    pub(crate) fn listed(
        &self,
        by: impl FnOnce(&Handle, genom_plugin_abi::table::Opaque),
    ) -> Listed {
        let list = Lent::new();
        by(&self.backend, list.number());
        list.into_listed(self.library.name())
    }
}

/// Pairs of a cause and what to do.
pub(crate) fn obstacles(listed: Listed) -> Vec<Obstacle> {
    listed.texts.into_iter().map(|(what, fix)| Obstacle { what, fix }).collect()
}

impl Middleware for Open {
    fn name(&self) -> &'static str {
        self.0.library.name()
    }

    fn capabilities(&self) -> Capabilities {
        let can = |flag| self.0.can(flag);
        Capabilities {
            variable_size: can(can::VARIABLE),
            zero_copy: false,
            cross_process: can(can::CROSS_PROCESS),
            cross_host: can(can::CROSS_HOST),
            services: can(can::SERVICES),
            native_services: can(can::SERVICES) && can(can::NATIVE_SERVICES),
        }
    }

    fn services(&self) -> Option<&dyn Services> {
        self.0.can(can::SERVICES).then_some(self)
    }

    fn discovery(&self) -> Option<&dyn Discovery> {
        self.0.can(can::DISCOVERY).then_some(self)
    }

    fn relay(&self) -> Option<&dyn Relay> {
        self.0.can(can::RELAY).then_some(self)
    }

    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        let listed = self.0.listed(|backend, list| backend.meeting_point(list));
        listed.texts.into_iter().map(|(name, value)| (Cow::Owned(name), value)).collect()
    }

    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        match self.0.backend.masquerade(ours, foreign) {
            None => Ok(()),
            Some(failure) => Err(NoForeignName {
                ours: ours.to_owned(),
                foreign: foreign.to_owned(),
                form: Cow::Owned(failure.why()),
            }),
        }
    }

    fn unmask(&self, ours: &str) {
        self.0.backend.unmask(ours);
    }

    fn simulated_time(&self) {
        self.0.backend.simulated_time();
    }

    fn takes_reports(&self) -> bool {
        self.0.reports.is_some()
    }

    fn log(&self, entry: &LogEntry) {
        if let Some(reports) = &self.0.reports {
            reports.log(entry);
        }
    }

    fn diagnose(&self, parts: &[Diagnosis]) {
        if let Some(reports) = &self.0.reports {
            reports.diagnose(parts);
        }
    }

    fn trouble(&self) -> Vec<Obstacle> {
        obstacles(self.0.listed(|backend, list| backend.trouble(list)))
    }

    fn refused(&self) -> Vec<Refused> {
        self.0.listed(|backend, list| backend.refused(list)).refused
    }
}
