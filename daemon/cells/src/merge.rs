//! Lists of the control plane, joined: what the daemon itself has, and what its cells have.

use std::collections::BTreeMap;

use genom_protocol::frames::{Channel, Channels};
use genom_protocol::routes::Route;
use genom_protocol::{
    AllAborted, BackendNames, CellState, Clock, Component, Components, Connections, PortParameters,
    Ports, RunningDeployment, StepRequest, routes,
};
use genom_supervisor::connections::between_processes;
use serde::de::DeserializeOwned;

use crate::cell::Cell;
use crate::cells::Cells;
use crate::client::AskError;
use crate::journal;

impl Cells {
    /// What each cell that answers says, by cell; they are asked side by side.
    async fn each<R, Q>(&self, route: &Route<R, Q>) -> BTreeMap<String, R>
    where
        R: DeserializeOwned + Send + 'static,
        Q: 'static,
    {
        let asked: Vec<_> = self
            .all()
            .into_iter()
            .map(|cell| {
                let route = route.clone();
                tokio::spawn(async move {
                    cell.answers().await.ok()?;
                    let said = cell.ask(&route).await;
                    match said {
                        Ok(said) => Some((cell.name().to_owned(), said)),
                        Err(error) => {
                            tracing::debug!("cell {}: {route:?}: {error}", cell.name());
                            None
                        }
                    }
                })
            })
            .collect();
        let mut all = BTreeMap::new();
        for one in asked {
            all.extend(one.await.ok().flatten());
        }
        all
    }

    /// Adds the components of all cells; those of a cell that is down as `down`.
    pub async fn join_components(&self, own: &mut Components) {
        let mut said = self.each(&routes::components()).await;
        for cell in self.all() {
            match said.remove(cell.name()) {
                Some(theirs) => {
                    own.components.extend(theirs.components.into_iter().map(|mut component| {
                        component.cell = Some(cell.name().to_owned());
                        component
                    }));
                    own.loading.extend(theirs.loading);
                    own.left_behind.extend(theirs.left_behind);
                }
                None => own.components.extend(down(&cell)),
            }
        }
    }

    /// Adds the ports of all cells.
    pub async fn join_ports(&self, own: &mut Ports, asked: &PortParameters) {
        let route = routes::ports().with(asked);
        own.ports.extend(self.each(&route).await.into_values().flat_map(|theirs| theirs.ports));
    }

    /// Adds the connections of all cells.
    pub async fn join_connections(&self, own: &mut Connections) {
        let said = self.each(&routes::connections()).await;
        own.connections.extend(said.into_values().flat_map(|theirs| theirs.connections));
    }

    /// Adds the channels that recordings of all cells would have. Those of the daemon's own subjects
    /// are there already.
    pub async fn join_channels(&self, own: &mut Channels) {
        let said = self.each(&routes::channels()).await;
        for theirs in said.into_values().flat_map(|theirs| theirs.channels) {
            if own.channels.iter().all(|known| known.topic != theirs.topic) {
                let channel = u16::try_from(own.channels.len()).unwrap_or(u16::MAX);
                own.channels.push(Channel { channel, ..theirs });
            }
        }
    }

    /// Asks all activities of all cells to stop.
    pub async fn join_stopped(&self, own: &mut AllAborted) {
        let said = self.each(&routes::stop()).await;
        own.aborted.extend(said.into_values().flat_map(|theirs| theirs.aborted));
    }

    /// Adds what runs in all cells, and in those that are down is to run again.
    pub async fn join_deployment(&self, own: &mut RunningDeployment) {
        let mut said = self.each(&routes::dump()).await;
        for cell in self.all() {
            let runs = said.remove(cell.name()).map(|theirs| theirs.deployment.runs);
            let runs = runs.unwrap_or_else(|| cell.held());
            own.runs.component.extend(runs.component);
            own.runs.connection.extend(runs.connection);
            own.runs.call.extend(runs.call);
            own.runs.activity.extend(runs.activity);
        }
    }

    /// Steps the clocks of all cells. One that has failed has none until it is started again.
    ///
    /// # Errors
    /// One does not answer: it stays behind.
    pub async fn step(&self, step: &StepRequest) -> Result<(), AskError> {
        let all = self.all().into_iter();
        for cell in all.filter(|cell| cell.told().state != CellState::Failed) {
            let _: Clock = cell.tell(&routes::step(), step).await?;
        }
        Ok(())
    }
}

impl Cell {
    /// The middleware of components that name none.
    fn backend(&self) -> BackendNames {
        between_processes(&self.setup().config.backend.as_str().into())
    }

    /// What its journal says it is to hold.
    fn held(&self) -> genom_configuration::Deployment {
        journal::read(&self.place().journal()).unwrap_or_default()
    }
}

/// The components of a cell that is down, as far as its journal tells.
fn down(cell: &Cell) -> Vec<Component> {
    let told = cell.told();
    let held = cell.held();
    let one = |name: &String| {
        let known = held.component.iter().find(|one| one.instance() == *name);
        Component {
            name: name.clone(),
            component: name.clone(),
            state: "down".to_owned(),
            stuck: Vec::new(),
            spins: Vec::new(),
            backend: known
                .and_then(|known| known.backend.clone())
                .unwrap_or_else(|| cell.backend()),
            port_backends: Default::default(),
            cell: Some(told.name.clone()),
            library: known.map(|known| known.library.clone()).unwrap_or_default(),
            activities: 0,
            supervision: Vec::new(),
            notes: Vec::new(),
            remotes: Vec::new(),
        }
    };
    told.components.iter().map(one).collect()
}
