//! Connections between processes of one daemon.

use std::sync::Arc;

use genom_protocol::{Connection, ConnectionRequest, routes};
use genom_supervisor::Supervisor;

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};

/// Puts out ports and services of this process on shared memory, for components in cells.
pub(crate) async fn share(
    supervisor: &Arc<Supervisor>,
    outlets: Vec<String>,
) -> Result<(), OpenError> {
    let worker = Arc::clone(supervisor);
    let sharing = tokio::task::spawn_blocking(move || {
        outlets.iter().try_for_each(|outlet| worker.connections.share(outlet))
    });
    match sharing.await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(OpenError::Share(error.to_string())),
        Err(error) => Err(OpenError::Share(error.to_string())),
    }
}

impl Cells {
    /// Connects an in port or a remote of a component in a cell. What it reads or calls in this
    /// process is put on shared memory first, or on the middleware that is named.
    ///
    /// # Errors
    /// It cannot be put there, the cell is down, or refuses.
    pub async fn connect(
        &self,
        supervisor: &Arc<Supervisor>,
        cell: &Cell,
        wanted: &ConnectionRequest,
    ) -> Result<Connection, OpenError> {
        if wanted.over.is_none() {
            share(supervisor, vec![wanted.outport.clone()]).await?;
        }
        let ends = (wanted.inport.as_str(), wanted.outport.as_str(), wanted.over.as_deref());
        self.connect_over(supervisor, ends, async {
            cell.answers().await?;
            Ok(cell.tell(&routes::connect(), wanted).await?)
        })
        .await?
    }
}
