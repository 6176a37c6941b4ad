//! The state of a daemon with all of its cells, written and brought back: all of it, or nothing.

use std::sync::Arc;
use std::time::Duration;

use genom_protocol::freeze::{FORMAT, NotFrozen, VERSION};
use genom_protocol::{
    Component, ConnectionEntry, ConnectionRequest, Frozen, LoadRequest, Resumption, Thawed,
    ThawedComponent, routes,
};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_supervisor::connections::{ConnectError, Wanted};
use genom_supervisor::loading::LoadError;
use tokio::task::{JoinError, spawn_blocking};

use crate::cells::{Cells, OpenError};
use crate::client::AskError;

/// How long to look for a moment without a codel, in each component.
const PATIENCE: Duration = Duration::from_secs(5);

/// A system could not be frozen.
#[derive(Debug, thiserror::Error)]
pub enum FreezeError {
    /// A component of the daemon's own.
    #[error(transparent)]
    Own(#[from] genom_supervisor::components::FreezeError),
    /// A cell.
    #[error("cell {cell}: {why}")]
    Cell {
        /// Its name.
        cell: String,
        /// Why.
        #[source]
        why: OpenError,
    },
    /// A thread ended badly.
    #[error(transparent)]
    Thread(#[from] tokio::task::JoinError),
}

/// A step of bringing a system back could not be taken.
#[derive(Debug, thiserror::Error)]
enum NotDone {
    #[error(transparent)]
    Open(#[from] OpenError),
    #[error(transparent)]
    Ask(#[from] AskError),
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error("{}", .0.sentence())]
    Connect(#[from] ConnectError),
    #[error("there is no component {0} any more")]
    Gone(String),
    #[error(transparent)]
    Thread(#[from] JoinError),
}

/// A system could not be brought back. What had been done was undone.
#[derive(Debug, thiserror::Error)]
pub enum ThawError {
    /// It is of another format, or of a later version.
    #[error(transparent)]
    Format(#[from] NotFrozen),
    /// Names are taken.
    #[error(
        "{} already: unload {} first, or replace {} (--replace)",
        runs(.0), if .0.len() == 1 { "it" } else { "them" }, if .0.len() == 1 { "it" } else { "them" }
    )]
    Runs(Vec<String>),
    /// A state of a component that the deployment does not have.
    #[error("components.{0}: the deployment of the file has no such component")]
    Unknown(String),
    /// What was to be replaced could not be frozen or unloaded.
    #[error("{component} cannot be replaced: {why}")]
    Replace {
        /// The component.
        component: String,
        /// Why.
        why: String,
    },
    /// Something of it could not be done.
    #[error("{what}: {why}{}", remains(.left))]
    Failed {
        /// What was tried.
        what: String,
        /// Why it failed.
        why: String,
        /// What could not be undone.
        left: Vec<String>,
    },
}

fn runs(names: &[String]) -> String {
    match names {
        [one] => format!("{one} runs"),
        many => format!("{} run", many.join(", ")),
    }
}

fn remains(left: &[String]) -> String {
    if left.is_empty() {
        return "; everything is as it was before".to_owned();
    }
    format!("; all is as it was, but for: {}", left.join(", "))
}

impl Cells {
    /// The state of all components, those of cells, too: of each it is that of one moment.
    ///
    /// # Errors
    /// A cell is down, or a component leaves no moment between its codels.
    pub async fn freeze(&self, supervisor: &Arc<Supervisor>) -> Result<Frozen, FreezeError> {
        let worker = Arc::clone(supervisor);
        let own = spawn_blocking(move || Ok((worker.dump(), worker.freeze(PATIENCE)?))).await?;
        let (deployment, components): (_, _) =
            own.map_err(|error: genom_supervisor::components::FreezeError| error)?;
        let mut all = Frozen {
            format: FORMAT.to_owned(),
            version: VERSION,
            genomd: env!("CARGO_PKG_VERSION").to_owned(),
            backend: supervisor.settings.backend.clone(),
            deployment,
            components,
        };
        for cell in self.all() {
            let ask = async {
                cell.answers().await?;
                Ok::<_, OpenError>(cell.ask(&routes::freeze()).await?)
            };
            let theirs = ask.await;
            let theirs =
                theirs.map_err(|why| FreezeError::Cell { cell: cell.name().to_owned(), why })?;
            all.deployment.component.extend(theirs.deployment.component);
            all.deployment.connection.extend(theirs.deployment.connection);
            all.deployment.call.extend(theirs.deployment.call);
            all.deployment.activity.extend(theirs.deployment.activity);
            all.components.extend(theirs.components);
        }
        Ok(all)
    }

    /// Brings a system back: loads its components, which wait after their start codels, connects
    /// them, and lets all go on. With `replace`, components of the same names make room before.
    ///
    /// # Errors
    /// Something of it cannot be done: nothing is changed.
    pub async fn thaw(
        self: &Arc<Self>,
        supervisor: &Arc<Supervisor>,
        frozen: Frozen,
        replace: bool,
    ) -> Result<Thawed, ThawError> {
        frozen.check()?;
        let (requests, connections) = parts(frozen)?;
        let taken: Vec<String> = requests
            .iter()
            .map(LoadRequest::instance)
            .filter(|name| supervisor.components.get(name).is_some() || self.of(name).is_some())
            .collect();
        if taken.is_empty() {
            return self.bring(supervisor, &requests, &connections).await;
        }
        if !replace {
            return Err(ThawError::Runs(taken));
        }
        let failed = |component: &str, why: String| ThawError::Replace {
            component: component.to_owned(),
            why,
        };
        let before = self.freeze(supervisor).await;
        let mut before = before.map_err(|error| failed(&taken.join(", "), error.to_string()))?;
        let stays = |name: &str| !taken.iter().any(|one| one == name);
        // Connections of others to what is replaced stay with them, and find it again.
        before.deployment.connection.retain(|entry| !stays(entry.reader()));
        before.deployment.component.retain(|component| !stays(&component.instance()));
        before.components.retain(|name, _| !stays(name));
        let (old, tied) = parts(before)?;
        // In the order in which they were loaded.
        let taken: Vec<String> = old.iter().map(LoadRequest::instance).collect();
        let stuck = self.take_away(supervisor, &taken).await;
        let thawed = match stuck.first() {
            None => self.bring(supervisor, &requests, &connections).await,
            Some((name, why)) => Err(failed(name, why.to_string())),
        };
        let Err(error) = thawed else { return thawed };
        let is_gone = |name: &str| !stuck.iter().any(|(one, _)| one == name);
        let back: Vec<_> = old.into_iter().filter(|one| is_gone(&one.instance())).collect();
        let tied: Vec<_> = tied.into_iter().filter(|entry| is_gone(entry.reader())).collect();
        if let Err(again) = self.bring(supervisor, &back, &tied).await {
            tracing::error!("what was to be replaced does not come back: {again}");
            let what = "what was to be replaced does not come back".to_owned();
            return Err(ThawError::Failed {
                what,
                why: again.to_string(),
                left: vec![error.to_string()],
            });
        }
        Err(error)
    }

    async fn bring(
        self: &Arc<Self>,
        supervisor: &Arc<Supervisor>,
        requests: &[LoadRequest],
        connections: &[ConnectionEntry],
    ) -> Result<Thawed, ThawError> {
        self.open_all(requests).await;
        let mut thawed: Vec<ThawedComponent> = Vec::new();
        let mut outcome: Result<(), (String, NotDone)> = Ok(());
        for request in requests {
            let what = || format!("load {}", request.instance());
            match self.bring_one(supervisor, request).await {
                Ok(one) => thawed.push(one),
                Err(why) => {
                    outcome = Err((what(), why));
                    break;
                }
            }
        }
        for entry in connections {
            if outcome.is_ok()
                && let Err(why) = self.tie(supervisor, entry).await
            {
                outcome = Err((format!("connect {entry}"), why));
            }
        }
        for one in &thawed {
            if outcome.is_ok()
                && let Err(why) = self.go_on(supervisor, &one.name).await
            {
                outcome = Err((format!("{} goes on", one.name), why));
            }
        }
        let Err((what, why)) = outcome else { return Ok(Thawed { components: thawed }) };
        let names: Vec<String> = thawed.into_iter().map(|one| one.name).collect();
        let stuck = self.take_away(supervisor, &names).await.into_iter();
        let left = stuck.map(|(name, why)| format!("{name}: {why}")).collect();
        self.end_empty().await;
        Err(ThawError::Failed { what, why: why.to_string(), left })
    }

    async fn bring_one(
        &self,
        supervisor: &Arc<Supervisor>,
        request: &LoadRequest,
    ) -> Result<ThawedComponent, NotDone> {
        if let Some(cell) = &request.cell {
            let Component { name, activities, notes, .. } = self.load(cell, request).await?;
            return Ok(ThawedComponent { name, activities, notes });
        }
        let (worker, request) = (Arc::clone(supervisor), request.clone());
        let hosted: Arc<Hosted> = spawn_blocking(move || worker.load(&request)).await??;
        Ok(ThawedComponent {
            name: hosted.name.clone(),
            activities: hosted.activities.running(),
            notes: hosted.notes.clone(),
        })
    }

    /// Makes a connection, and keeps it up, even if the other side is not there.
    async fn tie(
        &self,
        supervisor: &Arc<Supervisor>,
        entry: &ConnectionEntry,
    ) -> Result<(), NotDone> {
        if let Some(cell) = self.of(entry.reader()) {
            let wanted = ConnectionRequest {
                inport: entry.inport.clone(),
                outport: entry.outport.clone(),
                policy: entry.policy.clone(),
                over: entry.over.clone(),
                wait: true,
            };
            self.connect(supervisor, &cell, &wanted).await?;
            return Ok(());
        }
        let ends = (entry.inport.as_str(), entry.outport.as_str(), entry.over.as_deref());
        let (worker, entry) = (Arc::clone(supervisor), entry.clone());
        let making = async {
            let making = spawn_blocking(move || {
                let wanted = Wanted { wait: true, ..Wanted::from(&entry) };
                worker.connections.connect(&wanted)?;
                worker.connections.declare(std::slice::from_ref(&entry));
                Ok::<_, ConnectError>(())
            });
            Ok(making.await??)
        };
        self.connect_over(supervisor, ends, making).await?
    }

    /// Lets a component go on that is held.
    async fn go_on(&self, supervisor: &Supervisor, name: &str) -> Result<(), NotDone> {
        if let Some(cell) = self.of(name) {
            cell.ask(&routes::go_on(name)).await?;
            return Ok(());
        }
        let hosted = supervisor.components.get(name);
        hosted.ok_or_else(|| NotDone::Gone(name.to_owned()))?.go_on();
        Ok(())
    }
}

/// What is to be loaded, each with its state, and what is to be connected. Calls are in the state,
/// activities go on.
fn parts(frozen: Frozen) -> Result<(Vec<LoadRequest>, Vec<ConnectionEntry>), ThawError> {
    let Frozen { deployment, mut components, .. } = frozen;
    let mut requests = deployment.component;
    for request in &mut requests {
        request.resume = components
            .remove(&request.instance())
            .map(|state| Box::new(Resumption { state, activities: true, hold: true, copy: None }));
    }
    match components.into_keys().next() {
        Some(name) => Err(ThawError::Unknown(name)),
        None => Ok((requests, deployment.connection)),
    }
}
