//! A supervisor of components, and what the control plane before it keeps.

use std::ops::Deref;
use std::sync::Arc;

use genom_configuration::RpcSettings;
use genom_supervisor::Supervisor;

use crate::announcements::Announcements;
use crate::settings::Settings;
use crate::slots::Slots;
use crate::startup::Startup;

/// Questions to other daemons under way at a time, each of which holds a thread.
const QUESTIONS: usize = 64;

/// The daemon: a supervisor with a control plane.
pub(crate) struct Daemon {
    supervisor: Arc<Supervisor>,
    /// Which daemon of a file that describes several this one is.
    pub(crate) name: Option<String>,
    /// Where the control plane listens, and its limits.
    pub(crate) rpc: RpcSettings,
    /// What others see of this daemon.
    pub(crate) announcements: Announcements,
    /// How far it is with what it was started with.
    pub(crate) startup: Startup,
    /// Slots for open streams.
    pub(crate) streams: Arc<Slots>,
    /// Slots for questions to other daemons under way.
    pub(crate) questions: Arc<Slots>,
}

impl Daemon {
    /// A daemon without components.
    pub(crate) fn new(settings: &Settings) -> Arc<Self> {
        let rpc = settings.rpc.clone();
        Arc::new(Self {
            supervisor: Supervisor::new(settings.supervisor.clone()),
            name: settings.name.clone(),
            announcements: Announcements::default(),
            startup: Startup::new(),
            streams: Slots::new(rpc.max_streams, rpc.max_streams_per_token),
            questions: Slots::new(QUESTIONS, QUESTIONS / 4),
            rpc,
        })
    }
}

/// Whatever has to do with components is the supervisor's.
impl Deref for Daemon {
    type Target = Arc<Supervisor>;

    fn deref(&self) -> &Arc<Supervisor> {
        &self.supervisor
    }
}
