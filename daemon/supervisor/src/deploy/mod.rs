//! Deployments: compares what is wanted with what runs, and takes the steps in between.

mod apply;
mod dump;
mod error;
mod step;
mod steps;
mod undo;

pub use apply::ApplyError;
pub use error::{MoveError, StepError};
pub use step::Step;
pub use steps::{Contradiction, Steps};
pub(crate) use undo::Gone;
use undo::Undo;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use genom_configuration::{ConnectionEntry, Deployment};
use genom_protocol::FrozenComponent;

use self::steps::Present;
use crate::components::FreezeError;
use crate::settings::Settings;
use crate::supervisor::Supervisor;

impl Supervisor {
    /// Components, connections and requests that run now; applied to a new daemon the deployment
    /// gives the same system.
    #[must_use]
    pub fn dump(&self) -> Deployment {
        dump::dump(&self.components, &self.connections)
    }

    /// The same with only those activities that a deployment started: what runs again after a
    /// fault.
    #[must_use]
    pub fn declared(&self) -> Deployment {
        dump::declared(&self.components, &self.connections)
    }

    /// The states of all components, one after the other: of each it is that of one moment. Waits at
    /// most `patience` for each.
    ///
    /// # Errors
    /// The codels of one leave no moment between them.
    pub fn freeze(
        &self,
        patience: Duration,
    ) -> Result<BTreeMap<String, FrozenComponent>, FreezeError> {
        let all = self.components.all();
        all.iter().map(|hosted| Ok((hosted.name.clone(), hosted.freeze(patience)?))).collect()
    }

    /// Computes the steps from what runs to a deployment. With `prune`, what the deployment does not
    /// contain is removed.
    ///
    /// # Errors
    /// The deployment contradicts itself or what runs.
    pub fn steps_to(&self, wanted: &Deployment, prune: bool) -> Result<Steps, Contradiction> {
        let (components, connections) = (&self.components, &self.connections);
        let Settings { backend, path, .. } = &self.settings;
        let present = Present { components, connections, backend, path };
        steps::steps(present, wanted, prune)
    }

    /// Takes steps in order; each connection waits at most `patience` for its other side. Blocks.
    ///
    /// # Errors
    /// A step failed; those before it were undone as far as possible.
    pub fn apply(
        self: &Arc<Self>,
        steps: &[Step],
        patience: Option<Duration>,
    ) -> Result<Done, ApplyError> {
        let declared = self.connections.declared();
        Ok(Done { undo: apply::apply(self, steps, patience)?, declared })
    }

    /// Undoes a deployment. Returns what could not be undone. Blocks.
    pub fn take_back(self: &Arc<Self>, Done { undo, declared }: Done) -> Vec<String> {
        let left = undo::take_back(self, undo);
        self.connections.declare_only(declared);
        left
    }
}

/// What a deployment did, to be undone.
pub struct Done {
    undo: Vec<Undo>,
    /// The connections that were declared before.
    declared: Vec<ConnectionEntry>,
}
