//! Connections between processes of one daemon over a middleware that somebody asked for: the out
//! port is opened there, in whatever process its component is, as long as such a connection lasts.
//!
//! The daemon counts these connections ([`Wants`]), and tells each process which of its out ports
//! are needed where. It does so again when a component is loaded, or its process is another one.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use genom_configuration::Deployment;
use genom_protocol::{BackendNames, ConnectionEntry, NeededEnds, component_of, routes};
use genom_supervisor::Supervisor;
use genom_supervisor::connections::ConnectError;
use tokio::task::spawn_blocking;

use crate::cell::Cell;
use crate::cells::{Cells, OpenError};
use crate::wants::{Asked, Ends, Found, Want};

/// A process of the daemon: a cell, or with `None` the daemon's own.
type Process = Option<String>;

impl Cells {
    /// Makes a connection with `make`, after what it needs in another process is open. What the
    /// connection before needed, and no other does, is closed then.
    ///
    /// # Errors
    /// It cannot be opened. The connection before is kept.
    pub async fn connect_over<T, E>(
        &self,
        supervisor: &Arc<Supervisor>,
        (inport, outport, over): (&str, &str, Option<&str>),
        make: impl Future<Output = Result<T, E>>,
    ) -> Result<Result<T, E>, OpenError> {
        let want = self.want(supervisor, &|_| false, inport, outport, over);
        if want.is_none() && self.wants().is_empty() {
            return Ok(make.await);
        }
        if let Some(want) = &want {
            genom_registry::check(&want.over)
                .map_err(|error| OpenError::End(Arc::new(ConnectError::Backend(error))))?;
        }
        let had = self.wants().made(inport);
        let writers: BTreeSet<String> =
            want.iter().chain(&had).map(|want| want.writer.clone()).collect();
        let asked = want.map(|want| {
            let writer = want.writer.clone();
            (writer, self.wants().ask(vec![(inport.to_owned(), want)]))
        });
        if let Some((writer, _)) = &asked {
            // Also if it was told already: who knows whether its process is still the same.
            self.tell(supervisor, writer, true).await?;
        }
        let made = make.await;
        self.count(supervisor).await;
        drop(asked);
        for writer in &writers {
            self.settle(supervisor, writer).await;
        }
        Ok(made)
    }

    /// The connection of an in port of this process is gone.
    pub async fn disconnected(&self, supervisor: &Arc<Supervisor>, inport: &str) {
        let Some(had) = self.wants().made(inport) else { return };
        self.count(supervisor).await;
        self.settle(supervisor, &had.writer).await;
    }

    /// Opens what connections of a deployment need in other processes, until the result is dropped:
    /// then that of connections that there are stays open. What the present ones need stays open,
    /// too, so that they can be put back.
    ///
    /// # Errors
    /// Something cannot be opened.
    pub async fn open_for(
        &self,
        supervisor: &Arc<Supervisor>,
        whole: &Deployment,
    ) -> Result<Asked, OpenError> {
        let deployed = |name: &str| whole.component.iter().any(|one| one.instance() == name);
        let mut wants = self.wants().all_made();
        let before = wants.len();
        for entry in &whole.connection {
            let (inport, over) = (&entry.inport, entry.over.as_deref());
            let want = self.want(supervisor, &deployed, inport, &entry.outport, over);
            wants.extend(want.map(|want| (inport.clone(), want)));
        }
        let writers: BTreeSet<String> =
            wants[before..].iter().map(|(_, want)| want.writer.clone()).collect();
        let asked = self.wants().ask(wants);
        for writer in &writers {
            self.tell(supervisor, writer, false).await?;
        }
        Ok(asked)
    }

    /// The same for connections that are to be put back, as far as possible.
    pub(crate) async fn open_again(
        &self,
        supervisor: &Arc<Supervisor>,
        wants: Vec<(String, Want)>,
    ) -> Asked {
        let asked = self.wants().ask(wants);
        self.settle_all(supervisor).await;
        asked
    }

    /// Connections were made or undone: what was opened for those that are not there is closed.
    pub async fn opened_for(&self, supervisor: &Arc<Supervisor>, asked: Asked) {
        self.count(supervisor).await;
        drop(asked);
        self.settle_all(supervisor).await;
    }

    /// Goes on with the connections of cells that a daemon before this one left. Of all at once: who
    /// is told what some of them need closes what the others do.
    pub(crate) fn adopt_ends(&self, cells: &[Arc<Cell>]) {
        let held: Vec<_> = cells.iter().map(|cell| cell.written()).collect();
        let connections = || held.iter().flat_map(|held| &held.connection);
        let wants = connections().filter_map(|entry| {
            let want = Want::of(&entry.outport, entry.over.as_deref())?;
            Some((entry.inport.clone(), want))
        });
        let asked = self.wants().ask(wants.collect());
        let there = connections().map(|entry| (entry.inport.clone(), Found::There(entry.clone())));
        self.wants().counted(there.collect());
        drop(asked);
        let components = held.iter().flat_map(|held| &held.component);
        components.for_each(|one| self.wants().forget(&one.instance()));
    }

    /// What a connection needs, unless both its sides are in the same process. One whose writer is
    /// nowhere yet may find it anywhere.
    fn want(
        &self,
        supervisor: &Supervisor,
        deployed: &dyn Fn(&str) -> bool,
        inport: &str,
        outport: &str,
        over: Option<&str>,
    ) -> Option<Want> {
        let want = Want::of(outport, over)?;
        let reader = self.process(supervisor, deployed, component_of(inport))?;
        let writer = self.process(supervisor, deployed, &want.writer);
        (writer != Some(reader)).then_some(want)
    }

    /// The process of a component, if this daemon has it, or is to have it.
    fn process(
        &self,
        supervisor: &Supervisor,
        deployed: &dyn Fn(&str) -> bool,
        component: &str,
    ) -> Option<Process> {
        match self.of(component) {
            Some(cell) => Some(Some(cell.name().to_owned())),
            None if supervisor.components.get(component).is_some() => Some(None),
            None => deployed(component).then_some(None),
        }
    }

    /// Looks which of the connections there are that somebody asked for.
    pub(crate) async fn count(&self, supervisor: &Arc<Supervisor>) {
        let _turn = self.wants().counting.lock().await;
        let inports = self.wants().inports();
        if inports.is_empty() {
            return;
        }
        let readers = inports.into_iter().map(|inport| (self.of(component_of(&inport)), inport));
        let (readers, worker): (Vec<_>, _) = (readers.collect(), Arc::clone(supervisor));
        // Journals are files.
        let looking = spawn_blocking(move || look(&worker, readers));
        if let Ok(found) = looking.await {
            self.wants().counted(found);
        }
    }

    /// Tells the process of a component which of its out ports are needed where, if it does not know
    /// that, or `anyway`.
    pub(crate) async fn tell(
        &self,
        supervisor: &Arc<Supervisor>,
        writer: &str,
        anyway: bool,
    ) -> Result<(), OpenError> {
        let turn = self.wants().turn(writer);
        let _turn = turn.lock().await;
        let ends = self.wants().of(writer);
        if !anyway && self.wants().knows(writer, &ends) {
            return Ok(());
        }
        // It may hear this, and the answer be lost.
        self.wants().forget(writer);
        let told = self.send(supervisor, writer, &ends).await;
        if told.is_ok() {
            self.wants().told(writer, ends);
        }
        told
    }

    async fn send(
        &self,
        supervisor: &Arc<Supervisor>,
        writer: &str,
        ends: &Ends,
    ) -> Result<(), OpenError> {
        let names = |over: &BTreeSet<String>| {
            let all = over.iter().cloned().collect::<Vec<_>>();
            BackendNames::from(all.join("+").as_str())
        };
        let ports: BTreeMap<String, BackendNames> =
            ends.iter().map(|(port, over)| (port.clone(), names(over))).collect();
        if let Some(cell) = self.of(writer) {
            cell.answers().await?;
            cell.tell(&routes::need_ends(writer), &NeededEnds { ports }).await?;
            return Ok(());
        }
        let (worker, writer) = (Arc::clone(supervisor), writer.to_owned());
        let opening = spawn_blocking(move || worker.connections.need_elsewhere(&writer, &ports));
        match opening.await {
            Ok(opened) => opened.map_err(|error| OpenError::End(Arc::new(error))),
            Err(error) => Err(OpenError::Share(error.to_string())),
        }
    }

    /// The same, where nobody waits for it: it is tried again if it cannot be done.
    pub(crate) async fn settle(&self, supervisor: &Arc<Supervisor>, writer: &str) {
        match self.tell(supervisor, writer, false).await {
            Ok(()) => {}
            // Told when it runs again.
            Err(OpenError::Down(down)) => tracing::debug!("out ports of {writer}: {down}"),
            Err(error) => {
                let why = error.to_string();
                if self.wants().failed(writer, why.clone()) {
                    tracing::warn!("connections need out ports of {writer}: {why}; tried again");
                }
            }
        }
    }

    async fn settle_all(&self, supervisor: &Arc<Supervisor>) {
        for writer in self.wants().untold() {
            self.settle(supervisor, &writer).await;
        }
    }
}

/// What became of connections, given by in port, each with the cell of its reader.
fn look(
    supervisor: &Supervisor,
    readers: Vec<(Option<Arc<Cell>>, String)>,
) -> BTreeMap<String, Found> {
    let mut held: BTreeMap<String, Arc<Deployment>> = BTreeMap::new();
    let there = |entry: Option<ConnectionEntry>| entry.map_or(Found::Gone, Found::There);
    let each = readers.into_iter().map(|(cell, inport)| {
        let found = match cell {
            Some(cell) => {
                let held = held.entry(cell.name().to_owned()).or_insert_with(|| cell.written());
                let mut entries = held.connection.iter();
                there(entries.find(|entry| entry.inport == inport).cloned())
            }
            None if supervisor.components.get(component_of(&inport)).is_none() => Found::Away,
            None => there(supervisor.connections.entry(&inport)),
        };
        (inport, found)
    });
    each.collect()
}
