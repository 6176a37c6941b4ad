//! How one component stops: asked, ended, taken down, or left behind.

use std::sync::PoisonError;
use std::time::{Duration, Instant};

use genom_description::model::PortDirection;
use genom_runtime::body::Body;
use genom_runtime::{OnShutdown, ShutdownError};

use super::hosted::Hosted;

impl Hosted {
    /// Interrupts activities, runs stop codels, ends the threads and lets go of the ports.
    pub fn stop(&self, timeout: Duration) -> Result<(), ShutdownError> {
        let deadline = Instant::now() + timeout;
        self.begin_stop(Box::new(|| {}), timeout);
        self.finish_stop(deadline)
    }

    /// Asks for its end and returns; `ended` is told when no codel of it runs any more.
    pub(super) fn begin_stop(&self, ended: OnShutdown, timeout: Duration) {
        self.instance.begin_shutdown(ended, timeout);
    }

    /// Waits for the end, until `deadline`, and lets go of ports and services. What hangs then is
    /// left behind, cut off from all others.
    pub(super) fn finish_stop(&self, deadline: Instant) -> Result<(), ShutdownError> {
        let stopped = self.instance.finish_shutdown(deadline);
        // After the last answers of its services.
        self.served.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.gone.raise();
        match &stopped {
            Ok(()) => self.let_go(),
            Err(_) => self.ties.cut(),
        }
        stopped
    }

    /// Streams may hold the instance a moment longer; the middleware is free already.
    pub fn let_go(&self) {
        // No codel runs any more that could be in the way.
        if let Err(error) = self.instance.exclusively(|body| self.release_ports(body)) {
            tracing::error!("{error}");
        }
        self.ties.close();
    }

    fn release_ports(&self, body: &dyn Body) {
        for remote in 0..self.model().remotes.len() {
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
