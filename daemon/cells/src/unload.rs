//! Takes components away: those of one process together, and a cell with all that is in it.

use std::sync::Arc;

use genom_supervisor::Supervisor;
use genom_supervisor::components::UnloadError;
use tokio::task::{JoinError, spawn_blocking};

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};

/// Why a component stays.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NotTaken {
    #[error(transparent)]
    Cell(#[from] OpenError),
    #[error(transparent)]
    Own(#[from] UnloadError),
    #[error("a thread ended badly: {0}")]
    Thread(#[from] Arc<JoinError>),
}

/// Components of one process, in the order in which they were loaded.
struct Together {
    /// `None` for the daemon's own.
    cell: Option<Arc<Cell>>,
    names: Vec<String>,
}

impl Cells {
    /// Unloads components, given in the order in which they were loaded; the last process first, and in
    /// each users before those they use. Returns those that stay, with the reason.
    pub(crate) async fn take_away(
        &self,
        supervisor: &Arc<Supervisor>,
        names: &[String],
    ) -> Vec<(String, NotTaken)> {
        let mut stay = Vec::new();
        for Together { cell, names } in self.by_process(names).into_iter().rev() {
            match cell {
                Some(cell) => stay.extend(self.take_out_of(&cell, names).await),
                None => stay.extend(unload(supervisor, names).await),
            }
        }
        stay
    }

    /// Neighbours of one process together.
    fn by_process(&self, names: &[String]) -> Vec<Together> {
        let mut all: Vec<Together> = Vec::new();
        for name in names {
            let cell = self.of(name);
            let of = |one: &Option<Arc<Cell>>| one.as_ref().map(|cell| cell.name().to_owned());
            match all.last_mut() {
                Some(last) if of(&last.cell) == of(&cell) => last.names.push(name.clone()),
                _ => all.push(Together { cell, names: vec![name.clone()] }),
            }
        }
        all
    }

    /// Takes components out of a cell; one that holds nothing else is ended, and they stop side by side.
    async fn take_out_of(&self, cell: &Cell, names: Vec<String>) -> Vec<(String, NotTaken)> {
        let turn = cell.changing().await;
        if cell.told().components.iter().all(|held| names.contains(held)) {
            self.stop(cell.name()).await;
            return Vec::new();
        }
        drop(turn);
        let mut stay = Vec::new();
        for name in names.into_iter().rev() {
            if let Err(why) = self.unload(cell, &name).await {
                stay.push((name, why.into()));
            }
        }
        stay
    }
}

/// Unloads components of the daemon's own process.
async fn unload(supervisor: &Arc<Supervisor>, names: Vec<String>) -> Vec<(String, NotTaken)> {
    let (worker, all) = (Arc::clone(supervisor), names.clone());
    match spawn_blocking(move || worker.unload_these(&all)).await {
        Ok(stuck) => stuck.into_iter().map(|(name, why)| (name, why.into())).collect(),
        Err(error) => {
            let error = Arc::new(error);
            names.into_iter().map(|name| (name, Arc::clone(&error).into())).collect()
        }
    }
}
