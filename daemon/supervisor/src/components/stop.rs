//! Stops one component, or cuts it off if it does not stop in time.

use std::sync::PoisonError;
use std::time::{Duration, Instant};

use genom_description::model::PortDirection;
use genom_runtime::body::Body;
use genom_runtime::{OnShutdown, ShutdownError};

use super::hosted::Hosted;

impl Hosted {
    /// Interrupts activities, runs stop codels, ends the threads and closes the ports. Blocks for
    /// at most about `timeout`.
    pub fn stop(&self, timeout: Duration) -> Result<(), ShutdownError> {
        let deadline = Instant::now() + timeout;
        self.begin_stop(Box::new(|| {}), timeout);
        self.finish_stop(deadline)
    }

    /// Begins to stop the component, and returns at once; `ended` is called when none of its codels
    /// runs any more.
    pub(super) fn begin_stop(&self, ended: OnShutdown, timeout: Duration) {
        self.instance.begin_shutdown(ended, timeout);
    }

    /// Waits for the component to end, until `deadline`, and closes its ports and services. If
    /// codels still run then, the component is cut off from its ports, and an error is returned.
    pub(super) fn finish_stop(&self, deadline: Instant) -> Result<(), ShutdownError> {
        let stopped = self.instance.finish_shutdown(deadline);
        // Only after its services have sent their last replies.
        self.served.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.gone.raise();
        match &stopped {
            Ok(()) => self.let_go(),
            Err(_) => self.ties.cut(),
        }
        stopped
    }

    /// Closes ports and remotes now; streams may hold the instance a moment longer.
    pub fn let_go(&self) {
        // No codel runs any more, so this does not wait.
        if let Err(error) = self.instance.exclusively(|body| self.release_ports(body)) {
            tracing::error!("{error}");
        }
        self.ties.close();
    }

    pub(super) fn release_ports(&self, body: &dyn Body) {
        for remote in self.model().remotes.places() {
            body.bind_remote(remote, None);
        }
        for (index, port) in self.model().ports.pairs() {
            let elements: Vec<Option<String>> = if port.multiple {
                self.ties.elements(index).into_iter().map(Some).collect()
            } else {
                vec![None]
            };
            for element in elements {
                match port.direction {
                    PortDirection::Out => body.bind_out(index, element.as_deref(), None),
                    PortDirection::In => body.bind_in(index, element.as_deref(), None),
                }
            }
        }
    }
}
