//! How a cell is, and waiting until it can be asked.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use genom_protocol::CellState;
use tokio::time::timeout;

use super::{Cell, Down, NOTICE};

/// How long a request waits for a cell whose process is starting.
const PATIENCE: Duration = Duration::from_secs(2);

impl Cell {
    /// Waits until its process answers; not for one that ended and is to be started later.
    ///
    /// # Errors
    /// It is down.
    pub async fn answers(&self) -> Result<(), Down> {
        let mut phase = self.phase.subscribe();
        let over = phase.wait_for(|phase| *phase != CellState::Starting);
        let _ = timeout(PATIENCE, over).await;
        match *self.phase.borrow() {
            CellState::Running => Ok(()),
            _ => Err(self.down()),
        }
    }

    /// How it is.
    #[must_use]
    pub fn state(&self) -> CellState {
        *self.phase.borrow()
    }

    /// Where its process is stepped by a daemon that is part of a program: another socket for each
    /// process. None of a process that a daemon before this one started.
    #[must_use]
    pub fn steps(&self) -> Option<Arc<OwnedFd>> {
        self.with(|state| state.steps.clone())
    }

    /// Waits until it runs, also after it ended, or failed.
    ///
    /// # Errors
    /// It does not run, and will not without being asked.
    pub async fn begun(&self) -> Result<(), Down> {
        let mut phase = self.phase.subscribe();
        let settled =
            |phase: &CellState| !matches!(phase, CellState::Starting | CellState::Waiting);
        let _ = phase.wait_for(settled).await;
        match *self.phase.borrow() {
            CellState::Running => Ok(()),
            _ => Err(self.down()),
        }
    }

    fn down(&self) -> Down {
        let state = *self.phase.borrow();
        let last_end = self.with(|one| one.last_end.clone());
        Down { cell: self.name.clone(), state, last_end }
    }

    /// A connection broke: its process ended, which may be noticed a moment later.
    pub async fn lost(&self) -> Down {
        let mut phase = self.phase.subscribe();
        let _ = timeout(NOTICE, phase.wait_for(|phase| *phase != CellState::Running)).await;
        self.down()
    }
}
