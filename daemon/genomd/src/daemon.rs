//! The parts of the daemon: a supervisor of components, and what the control plane before it keeps.

use std::sync::Arc;

use genom_configuration::RpcSettings;
use genom_doors::{Slots, Streams};
use genom_supervisor::Supervisor;
use tokio_util::sync::CancellationToken;

use crate::announcements::Announcements;
use crate::settings::Settings;
use crate::startup::Startup;

/// Questions to other daemons under way at a time, each of which holds a thread.
const QUESTIONS: usize = 64;

/// The daemon: a supervisor with a control plane.
pub(crate) struct Daemon {
    /// Whatever has to do with components.
    pub(crate) supervisor: Arc<Supervisor>,
    /// Which daemon of a file that describes several this one is.
    pub(crate) name: Option<String>,
    /// Where the control plane listens, and its limits.
    pub(crate) rpc: RpcSettings,
    /// What others see of this daemon.
    pub(crate) announcements: Announcements,
    /// How far it is with what it was started with.
    pub(crate) startup: Arc<Startup>,
    /// Open streams.
    pub(crate) streams: Streams,
    /// Slots for questions to other daemons under way.
    pub(crate) questions: Arc<Slots>,
    /// Cancelled when everything stopped: the control plane ends.
    pub(crate) closed: CancellationToken,
}

impl Daemon {
    /// A daemon without components.
    pub(crate) fn new(settings: &Settings) -> Arc<Self> {
        let (rpc, closed) = (settings.rpc.clone(), CancellationToken::new());
        Arc::new(Self {
            supervisor: Supervisor::new(settings.supervisor.clone()),
            name: settings.name.clone(),
            announcements: Announcements::default(),
            startup: Arc::new(Startup::new()),
            streams: Streams::new(rpc.max_streams, rpc.max_streams_per_token, closed.clone()),
            questions: Slots::new(QUESTIONS, QUESTIONS / 4),
            closed,
            rpc,
        })
    }
}
