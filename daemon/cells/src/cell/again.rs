//! A restart that somebody asked for.

use genom_protocol::CellState;

use super::{Cell, Down};
use crate::journal;
use crate::process::kill;

impl Cell {
    /// Ends its process, if it has one, as a fault would, and waits until the next one answers. All
    /// that it held comes back, also what would not by itself (`restart = "never"`).
    ///
    /// # Errors
    /// It does not start again.
    pub async fn restart(&self) -> Result<(), Down> {
        match self.pid() {
            Some(pid) => {
                let mut phase = self.phase.subscribe();
                self.with(|state| state.asked = true);
                let _ = kill(pid);
                let _ = phase.wait_for(|phase| *phase != CellState::Running).await;
            }
            None => self.take_back(),
        }
        self.start_again();
        self.begun().await
    }

    /// Waits until the process that comes after the present one runs; `false` where none will.
    pub(crate) async fn runs_again(&self) -> bool {
        let _ = self.lost().await;
        let mut phase = self.phase.subscribe();
        tokio::select! {
            runs = phase.wait_for(|phase| *phase == CellState::Running) => runs.is_ok(),
            () = self.ended() => false,
        }
    }

    /// What its last process held, and the next one would not.
    fn take_back(&self) {
        let path = self.place.journal();
        let kept = journal::read(&path).unwrap_or_default();
        let all = kept.over(&self.with(|state| std::mem::take(&mut state.held)));
        if let Err(error) = journal::write(&path, &all) {
            tracing::error!("cell {}: its journal cannot be written: {error}", self.name);
            return;
        }
        let names = all.component.iter().map(|one| one.instance()).collect();
        self.with(|state| state.components = names);
    }
}
