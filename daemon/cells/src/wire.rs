//! What crosses processes of one daemon: connections between them, and deployments that concern
//! several.

use std::sync::Arc;

use genom_protocol::{
    Applied, Connection, ConnectionRequest, Deployment, DeploymentRequest, LoadRequest, routes,
};
use genom_supervisor::Supervisor;

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};

/// Puts out ports and services of this process on shared memory, for components in cells.
async fn share(supervisor: &Arc<Supervisor>, outlets: Vec<String>) -> Result<(), OpenError> {
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
    /// process is put on shared memory first, unless a middleware is named.
    ///
    /// # Errors
    /// It cannot be put there, the cell is down, or refuses.
    pub async fn connect(
        &self,
        supervisor: &Arc<Supervisor>,
        cell: &Cell,
        wanted: &ConnectionRequest,
    ) -> Result<Connection, OpenError> {
        if wanted.backend.is_none() {
            share(supervisor, vec![wanted.outport.clone()]).await?;
        }
        cell.answers().await?;
        Ok(cell.tell(&routes::connect(), wanted).await?)
    }

    /// Loads what a deployment puts into cells and what is in none, in its order.
    ///
    /// # Errors
    /// The first that could not be loaded, or that runs elsewhere in this daemon.
    pub async fn load_missing<'a>(
        self: &Arc<Self>,
        supervisor: &Supervisor,
        whole: &'a Deployment,
    ) -> Result<(), (&'a LoadRequest, OpenError)> {
        self.open_all(&whole.component).await;
        for request in &whole.component {
            let Some(cell) = request.cell.as_deref() else { continue };
            let name = request.instance();
            let runs_in = match self.of(&name) {
                Some(held) if held.name() == cell => continue,
                Some(held) => Some(format!("cell {}", held.name())),
                None if supervisor.components.get(&name).is_some() => {
                    Some("the daemon itself".to_owned())
                }
                None => None,
            };
            let loaded = match runs_in {
                Some(place) => Err(OpenError::Elsewhere { name, place }),
                None => self.load(cell, request).await.map(drop),
            };
            if let Err(error) = loaded {
                self.end_empty().await;
                return Err((request, error));
            }
        }
        Ok(())
    }

    /// Has each cell apply its part of a deployment, `whole`, which `wanted` is the request for.
    /// Cells that are left with nothing end.
    ///
    /// # Errors
    /// A cell is down, or refuses: what others did stays.
    pub async fn apply(
        &self,
        supervisor: &Arc<Supervisor>,
        whole: &Deployment,
        wanted: &DeploymentRequest,
    ) -> Result<Vec<Applied>, OpenError> {
        let theirs = whole.connection.iter().filter(|entry| self.of(entry.reader()).is_some());
        let theirs = theirs.filter(|entry| entry.backend.is_none());
        share(supervisor, theirs.map(|entry| entry.outport.clone()).collect()).await?;
        let mut all = Vec::new();
        for cell in self.all() {
            cell.answers().await?;
            let part = DeploymentRequest { cell: Some(cell.name().to_owned()), ..wanted.clone() };
            all.push(cell.tell(&routes::apply(), &part).await?);
        }
        if wanted.prune && !wanted.dry_run {
            self.end_empty().await;
        }
        Ok(all)
    }
}
