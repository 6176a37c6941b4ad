//! Deployments that concern several processes of one daemon: all of what they ask for, or nothing.

use std::sync::Arc;

use genom_protocol::{Applied, Deployment, DeploymentRequest, LoadRequest, routes};
use genom_supervisor::Supervisor;
use genom_supervisor::deploy::Done;
use tokio::task::{JoinError, spawn_blocking};

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};
use crate::round::Round;
use crate::wire::share;

/// A deployment could not be applied; `E` is why the daemon's own part was refused.
#[derive(Debug, thiserror::Error)]
pub enum DeployError<E> {
    /// A component could not be loaded into its cell.
    #[error("{1}")]
    Load(Box<LoadRequest>, OpenError),
    /// The daemon's own part.
    #[error("{0}")]
    Own(E),
    /// A cell's part.
    #[error("{why}")]
    Cell {
        /// Why.
        why: OpenError,
        /// What could not be undone elsewhere.
        left: Vec<String>,
    },
    /// A thread ended badly.
    #[error(transparent)]
    Thread(#[from] JoinError),
}

impl Cells {
    /// Applies a deployment, `whole`, which `wanted` is the request for: loads what is missing in
    /// cells, has `own` take the steps of this process, and the cells theirs. In a dry run `own` has
    /// done nothing.
    ///
    /// # Errors
    /// A part is refused; the parts that were done before it are undone as far as possible.
    pub async fn deploy<E: Send + 'static>(
        self: &Arc<Self>,
        supervisor: &Arc<Supervisor>,
        whole: &Deployment,
        wanted: &DeploymentRequest,
        own: impl FnOnce() -> Result<(Applied, Option<Done>), E> + Send + 'static,
    ) -> Result<Applied, DeployError<E>> {
        let mut last = self.last_round().lock().await;
        let mut round = Round::default();
        if wanted.dry_run {
            let parts = self.deploy_parts(supervisor, whole, wanted, own, round).await;
            return parts.map(|(applied, _)| applied);
        }
        *last = None;
        let loading = self.load_missing(supervisor, whole).await;
        round.loaded =
            loading.map_err(|(request, why)| DeployError::Load(Box::new(request.clone()), why))?;
        round.needed = self.wants().all_made();
        let asked = match self.open_for(supervisor, whole).await {
            Ok(asked) => asked,
            Err(why) => {
                self.take_out(&round.loaded).await;
                return Err(DeployError::Cell { why, left: Vec::new() });
            }
        };
        let applied = self.deploy_parts(supervisor, whole, wanted, own, round).await;
        self.opened_for(supervisor, asked).await;
        let (applied, round) = applied?;
        *last = Some(round);
        Ok(applied)
    }

    /// The parts of all processes, when what is missing in cells was loaded.
    async fn deploy_parts<E: Send + 'static>(
        self: &Arc<Self>,
        supervisor: &Arc<Supervisor>,
        whole: &Deployment,
        wanted: &DeploymentRequest,
        own: impl FnOnce() -> Result<(Applied, Option<Done>), E> + Send + 'static,
        mut round: Round,
    ) -> Result<(Applied, Round), DeployError<E>> {
        let own = spawn_blocking(own).await.map_err(DeployError::from);
        let mut all = match own.and_then(|done| done.map_err(DeployError::Own)) {
            Ok((applied, done)) => {
                round.own = done;
                applied
            }
            Err(error) => {
                self.take_out(&round.loaded).await;
                return Err(error);
            }
        };
        let theirs = self.apply_each(supervisor, whole, wanted, &mut round.applied).await;
        let theirs = match theirs {
            Ok(theirs) => theirs,
            Err(why) if wanted.dry_run => return Err(DeployError::Cell { why, left: Vec::new() }),
            Err(why) => {
                let left = self.undo(supervisor, round).await;
                return Err(DeployError::Cell { why, left });
            }
        };
        for theirs in theirs {
            all.steps.extend(theirs.steps);
            all.beside.extend(theirs.beside);
        }
        Ok((all, round))
    }

    /// Undoes what the last deployment did in all processes. Returns what could not be undone;
    /// `None` if there is no deployment to undo.
    pub async fn take_back(&self, supervisor: &Arc<Supervisor>) -> Option<Vec<String>> {
        let mut round = self.last_round().lock().await.take()?;
        let asked = self.open_again(supervisor, std::mem::take(&mut round.needed)).await;
        let left = self.undo(supervisor, round).await;
        self.opened_for(supervisor, asked).await;
        Some(left)
    }

    /// Undoes a round, the last part first. Returns what could not be undone.
    async fn undo(&self, supervisor: &Arc<Supervisor>, round: Round) -> Vec<String> {
        let mut left = Vec::new();
        for cell in round.applied.iter().rev() {
            let asked = async {
                cell.answers().await?;
                Ok::<_, OpenError>(cell.ask(&routes::take_back()).await?)
            };
            match asked.await {
                Ok(back) => left.extend(back.left),
                Err(error) => left.push(format!("cell {}: {error}", cell.name())),
            }
        }
        if let Some(own) = round.own {
            let worker = Arc::clone(supervisor);
            let undoing = move || {
                let _turn = worker.deploying();
                worker.take_back(own)
            };
            match spawn_blocking(undoing).await {
                Ok(own) => left.extend(own),
                Err(error) => left.push(error.to_string()),
            }
        }
        self.take_out(&round.loaded).await;
        left
    }

    /// Loads what a deployment puts into cells and what is in none, in its order: all of it, or
    /// nothing. Returns the names of what was loaded.
    async fn load_missing<'a>(
        self: &Arc<Self>,
        supervisor: &Supervisor,
        whole: &'a Deployment,
    ) -> Result<Vec<String>, (&'a LoadRequest, OpenError)> {
        self.open_all(&whole.component).await;
        let mut new = Vec::new();
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
                None => self.load(cell, request).await.map(|component| new.push(component.name)),
            };
            if let Err(error) = loaded {
                self.take_out(&new).await;
                return Err((request, error));
            }
        }
        Ok(new)
    }

    /// Unloads components of cells, the last first; cells that are left with nothing end.
    async fn take_out(&self, names: &[String]) {
        for name in names.iter().rev() {
            let Some(cell) = self.of(name) else { continue };
            if let Err(error) = self.unload(&cell, name).await {
                tracing::error!("{name} is not unloaded again: {error}");
            }
        }
        self.end_empty().await;
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
        self.apply_each(supervisor, whole, wanted, &mut Vec::new()).await
    }

    /// The same; `done` receives the cells that have applied their part.
    async fn apply_each(
        &self,
        supervisor: &Arc<Supervisor>,
        whole: &Deployment,
        wanted: &DeploymentRequest,
        done: &mut Vec<Arc<Cell>>,
    ) -> Result<Vec<Applied>, OpenError> {
        let theirs = whole.connection.iter().filter(|entry| self.of(entry.reader()).is_some());
        let theirs = theirs.filter(|entry| entry.over.is_none());
        share(supervisor, theirs.map(|entry| entry.outport.clone()).collect()).await?;
        let mut all = Vec::new();
        for cell in self.all() {
            cell.answers().await?;
            let part = DeploymentRequest { cell: Some(cell.name().to_owned()), ..wanted.clone() };
            all.push(cell.tell(&routes::apply(), &part).await?);
            done.push(cell);
        }
        if wanted.prune && !wanted.dry_run {
            self.end_empty().await;
        }
        Ok(all)
    }
}
