//! The parts of the daemon: a supervisor of components, and the state of the control plane.

use std::sync::Arc;

use genom_configuration::RpcSettings;
use genom_doors::{Slots, Streams};
use genom_supervisor::Supervisor;
use tokio_util::sync::CancellationToken;

use crate::announcements::Announcements;
use crate::settings::Settings;
use crate::startup::Startup;

/// Maximum number of questions to other daemons under way; each may occupy a thread.
const QUESTIONS: usize = 64;

/// The daemon: a supervisor with a control plane.
pub(crate) struct Daemon {
    /// Everything that concerns components.
    pub(crate) supervisor: Arc<Supervisor>,
    /// Name of this daemon in files that describe several.
    pub(crate) name: Option<String>,
    /// Addresses and limits of the control plane.
    pub(crate) rpc: RpcSettings,
    /// Announcements that make this daemon visible to others.
    pub(crate) announcements: Announcements,
    /// Progress of loading what the daemon was started with.
    pub(crate) startup: Arc<Startup>,
    /// Open streams.
    pub(crate) streams: Streams,
    /// Slots for questions to other daemons.
    pub(crate) questions: Arc<Slots>,
    /// Cancelled when everything has stopped, to end the control plane.
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
