//! Connections between processes of one daemon over a middleware that somebody asked for: the out
//! port is opened there, in whatever process its component is, as long as such a connection lasts.
//!
//! The daemon counts these connections, and tells each process which of its out ports are needed
//! where. It does so again when a component is loaded into a cell, also after a crash.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Weak};
use std::time::Duration;

use genom_protocol::{BackendNames, ConnectionEntry, NeededEnds, routes};
use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Heard, Numbered};
use tokio::time::{MissedTickBehavior, interval};

use crate::cells::{Cells, OpenError};
use crate::journal;
use crate::wants::{Want, Wants, asked};

/// How often connections are looked for that went with their component.
const SWEEP: Duration = Duration::from_secs(1);

/// A process of the daemon: a cell, or with `None` the daemon's own.
type Process = Option<String>;

impl Cells {
    /// Makes a connection with `make`, after what it needs in another process is open. What the
    /// connection before needed, and no other does, is closed.
    ///
    /// # Errors
    /// It cannot be opened. The connection before is kept.
    pub async fn connect_over<T, E>(
        &self,
        supervisor: &Arc<Supervisor>,
        (inport, outport, over): (&str, &str, Option<&str>),
        make: impl Future<Output = Result<T, E>>,
    ) -> Result<Result<T, E>, OpenError> {
        let Some(mut want) = self.across(supervisor, inport, outport, over)? else {
            let made = make.await;
            if made.is_ok() {
                self.disconnected(supervisor, inport).await;
            }
            return Ok(made);
        };
        want.made = true;
        let mut wants = self.wants().lock().await;
        let had = wants.insert(inport.to_owned(), want.clone());
        let opened = self.tell_needs(supervisor, &wants, &want.writer, had.as_ref()).await;
        let made = match opened {
            Ok(()) => Ok(make.await),
            Err(error) => Err(error),
        };
        let unused = match (&made, had) {
            (Ok(Ok(_)), had) => had,
            (_, Some(had)) => wants.insert(inport.to_owned(), had),
            (_, None) => wants.remove(inport),
        };
        if let Some(unused) = unused.filter(|unused| wants.get(inport) != Some(unused)) {
            self.release(supervisor, &wants, &unused.writer).await;
        }
        made
    }

    /// The connection of an in port is gone, or needs nothing of another process any more.
    pub async fn disconnected(&self, supervisor: &Arc<Supervisor>, inport: &str) {
        let mut wants = self.wants().lock().await;
        if let Some(unused) = wants.remove(inport) {
            self.release(supervisor, &wants, &unused.writer).await;
        }
    }

    /// Opens what connections of a deployment need in other processes. Returns the in ports of these.
    ///
    /// # Errors
    /// Something cannot be opened; nothing is kept open for this deployment then.
    pub(crate) async fn open_for(
        &self,
        supervisor: &Arc<Supervisor>,
        entries: &[ConnectionEntry],
        deployed: &(dyn Fn(&str) -> bool + Sync),
    ) -> Result<Vec<String>, OpenError> {
        let (mut wants, mut new) = (self.wants().lock().await, Vec::new());
        let before = wants.clone();
        let mut writers = BTreeSet::new();
        for entry in entries {
            let (inport, over) = (entry.inport.as_str(), entry.over.as_deref());
            let known = |name: &str| self.process(supervisor, name, deployed);
            let want = self.between(supervisor, known, inport, &entry.outport, over)?;
            // One that is there already stays as it is.
            let there = wants.get(inport);
            let want = want.filter(|want| there.is_none_or(|there| !want.is(there)));
            if let Some(want) = want {
                writers.insert(want.writer.clone());
                new.push(inport.to_owned());
                wants.insert(inport.to_owned(), want);
            }
        }
        for writer in &writers {
            if let Err(error) = self.tell_needs(supervisor, &wants, writer, None).await {
                *wants = before;
                for writer in &writers {
                    self.release(supervisor, &wants, writer).await;
                }
                return Err(error);
            }
        }
        Ok(new)
    }

    /// The connections of a deployment to these in ports are made, or its parts were undone: what was
    /// opened for those that are not there is closed.
    pub(crate) async fn opened_for(&self, supervisor: &Arc<Supervisor>, inports: &[String]) {
        if inports.is_empty() {
            return;
        }
        let mut wants = self.wants().lock().await;
        for inport in inports {
            if let Some(want) = wants.get_mut(inport) {
                want.made = true;
            }
        }
        self.sweep(supervisor, &mut wants).await;
    }

    /// Keeps open what is needed, and nothing else, as components come and go.
    pub async fn keep_ends(cells: Weak<Self>, supervisor: Arc<Supervisor>) {
        let mut changes = supervisor.bus.listen(None);
        let mut rounds = interval(SWEEP);
        rounds.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let news = tokio::select! {
                heard = changes.next() => match heard {
                    Some(heard) => News::of(&heard),
                    None => return,
                },
                _ = rounds.tick() => Some(News::Gone),
            };
            let (Some(news), Some(cells)) = (news, cells.upgrade()) else { continue };
            let mut wants = cells.wants().lock().await;
            match news {
                _ if wants.is_empty() => {}
                News::Loaded(component) => cells.release(&supervisor, &wants, &component).await,
                News::Gone => cells.sweep(&supervisor, &mut wants).await,
            }
        }
    }

    /// What a connection needs, if its two sides are in different processes.
    fn across(
        &self,
        supervisor: &Supervisor,
        inport: &str,
        outport: &str,
        over: Option<&str>,
    ) -> Result<Option<Want>, OpenError> {
        let known = |name: &str| self.process(supervisor, name, &|_| false);
        self.between(supervisor, known, inport, outport, over)
    }

    fn between(
        &self,
        supervisor: &Supervisor,
        process: impl Fn(&str) -> Option<Process>,
        inport: &str,
        outport: &str,
        over: Option<&str>,
    ) -> Result<Option<Want>, OpenError> {
        let Some(want) = asked(outport, over) else { return Ok(None) };
        let reader = inport.split('/').next().unwrap_or_default();
        let (Some(from), Some(to)) = (process(&want.writer), process(reader)) else {
            return Ok(None);
        };
        if from == to {
            return Ok(None);
        }
        let on = supervisor.backends.get(&want.over);
        let on = on.map_err(|error| OpenError::Over(error.to_string()))?;
        if !on.capabilities().cross_process {
            let (writer, over) = (&want.writer, &want.over);
            return Err(OpenError::Over(format!(
                "{reader} and {writer} run in different processes, and {over} does not leave one: \
                 name another middleware, or none for shared memory"
            )));
        }
        Ok(Some(want))
    }

    /// The process of a component, if this daemon has it, or is to have it.
    fn process(
        &self,
        supervisor: &Supervisor,
        component: &str,
        deployed: &dyn Fn(&str) -> bool,
    ) -> Option<Process> {
        match self.of(component) {
            Some(cell) => Some(Some(cell.name().to_owned())),
            None if supervisor.components.get(component).is_some() => Some(None),
            None => deployed(component).then_some(None),
        }
    }

    /// Tells the process of a component which of its out ports are needed where; `also` is needed for
    /// a connection that is about to go.
    async fn tell_needs(
        &self,
        supervisor: &Arc<Supervisor>,
        wants: &Wants,
        component: &str,
        also: Option<&Want>,
    ) -> Result<(), OpenError> {
        let mut ports: BTreeMap<String, BackendNames> = BTreeMap::new();
        for want in wants.values().chain(also).filter(|want| want.writer == component) {
            let names = ports.remove(&want.port);
            let over = std::slice::from_ref(&want.over);
            let names = names.unwrap_or_else(|| BackendNames::one(want.over.as_str()));
            ports.insert(want.port.clone(), names.with(over));
        }
        if let Some(cell) = self.of(component) {
            cell.answers().await?;
            cell.tell(&routes::need_ends(component), &NeededEnds { ports }).await?;
            return Ok(());
        }
        let (worker, component) = (Arc::clone(supervisor), component.to_owned());
        let opening = tokio::task::spawn_blocking(move || {
            worker.connections.need_elsewhere(&component, &ports)
        });
        match opening.await {
            Ok(opened) => opened.map_err(|error| OpenError::Share(error.sentence())),
            Err(error) => Err(OpenError::Share(error.to_string())),
        }
    }

    /// The same, where nobody waits for it.
    async fn release(&self, supervisor: &Arc<Supervisor>, wants: &Wants, component: &str) {
        if let Err(error) = self.tell_needs(supervisor, wants, component, None).await {
            // Told again when the component is loaded again.
            tracing::debug!("ends of {component}: {error}");
        }
    }

    /// Releases what connections needed that are not there any more, and are not to come back.
    async fn sweep(&self, supervisor: &Arc<Supervisor>, wants: &mut Wants) {
        let mut gone = BTreeSet::new();
        let mut held: BTreeMap<String, Vec<ConnectionEntry>> = BTreeMap::new();
        wants.retain(|inport, want| {
            let reader = inport.split('/').next().unwrap_or_default();
            let entry = match self.of(reader) {
                Some(cell) => {
                    let entries = held.entry(cell.name().to_owned()).or_insert_with(|| {
                        let read = journal::read(&cell.place().journal());
                        read.unwrap_or_default().connection
                    });
                    entries.iter().find(|entry| entry.inport == *inport).cloned()
                }
                None => supervisor.connections.entry(inport),
            };
            let needs = entry.and_then(|entry| asked(&entry.outport, entry.over.as_deref()));
            let there = needs.is_some_and(|needs| needs.is(want));
            let stays = there || !want.made;
            want.made |= there;
            if !stays {
                gone.insert(want.writer.clone());
            }
            stays
        });
        for writer in gone {
            self.release(supervisor, wants, &writer).await;
        }
    }
}

/// What changes about it.
enum News {
    /// A component was loaded.
    Loaded(String),
    /// A connection or a component may be gone.
    Gone,
}

impl News {
    fn of(heard: &Heard) -> Option<Self> {
        let Heard::Told(Numbered { data, .. }) = heard else { return Some(Self::Gone) };
        match data["event"].as_str()? {
            "component_loaded" => Some(Self::Loaded(data["component"].as_str()?.to_owned())),
            "disconnected" | "component_unloaded" => Some(Self::Gone),
            _ => None,
        }
    }
}
