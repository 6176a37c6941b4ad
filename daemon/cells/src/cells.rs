//! The cells of a daemon, by name.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use genom_protocol::{Component, CrashReport, Crashes, LoadRequest, Unloaded, routes};
use genom_supervisor::connections::ConnectError;
use genom_supervisor::loading::names_script;
use rustix::process::Signal;
use tokio::task::JoinSet;

use crate::bell::Bell;
use crate::cell::{Cell, Down};
use crate::client::{AskError, Client};
use crate::crashes::StoreError;
use crate::place::{self, Place, PlaceError};
use crate::process::{Process, left};
use crate::remains;
use crate::round::Round;
use crate::setup::Setup;
use crate::wants::Wants;

/// A cell could not be begun, or a component not be loaded into it.
#[derive(Clone, Debug, thiserror::Error)]
pub enum OpenError {
    /// Its files.
    #[error(transparent)]
    Place(Arc<PlaceError>),
    /// It runs in another process of this daemon.
    #[error("{name} runs in {place}: unload it first")]
    Elsewhere {
        /// The component.
        name: String,
        /// Where it runs.
        place: String,
    },
    /// What it needs of components of other processes.
    #[error("{0}")]
    Share(String),
    /// An out port of this process is not to be had on the middleware that was asked for.
    #[error("{}", .0.sentence())]
    End(Arc<ConnectError>),
    /// Its process.
    #[error(transparent)]
    Down(#[from] Down),
    /// The same of one that is gone, since nothing else was in it.
    #[error("{0}; the cell held nothing else, and is gone")]
    Gone(Down),
    /// It refuses.
    #[error(transparent)]
    Ask(#[from] AskError),
}

impl OpenError {
    /// Nothing was done in a cell that was down, and may be gone by now.
    fn of(down: Down, cell: &Cell) -> Self {
        if cell.is_over() { Self::Gone(down) } else { Self::Down(down) }
    }
}

/// The cells of a daemon.
pub struct Cells {
    setup: Arc<Setup>,
    all: Mutex<BTreeMap<String, Arc<Cell>>>,
    /// Rung by processes that need a gateway.
    bell: Mutex<Option<Bell>>,
    /// Locked while a deployment is applied; then what it did.
    last_round: tokio::sync::Mutex<Option<Round>>,
    /// What connections need of other processes.
    wants: Arc<Wants>,
}

impl std::fmt::Debug for Cells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.all()).finish()
    }
}

impl Cells {
    /// None yet.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let setup = Arc::new(setup);
        Self {
            setup,
            all: Mutex::default(),
            bell: Mutex::default(),
            last_round: Default::default(),
            wants: Default::default(),
        }
    }

    /// Reports of those that crashed.
    pub async fn crashes(&self) -> Crashes {
        let setup = Arc::clone(&self.setup);
        // Files are read on a thread that may wait for them.
        let list = tokio::task::spawn_blocking(move || setup.reports.list());
        list.await.unwrap_or(Crashes { directory: None, crashes: Vec::new() })
    }

    /// One of these reports.
    ///
    /// # Errors
    /// There is none of this name, with the names that there are; or it cannot be read.
    pub async fn crash(&self, name: &str) -> Result<CrashReport, (StoreError, Vec<String>)> {
        let (setup, wanted) = (Arc::clone(&self.setup), name.to_owned());
        let read = tokio::task::spawn_blocking(move || setup.reports.read(&wanted)).await;
        match read.unwrap_or_else(|_| Err(StoreError::Unknown(name.to_owned()))) {
            Ok(report) => Ok(report),
            Err(error) => {
                let all = self.crashes().await.crashes;
                Err((error, all.into_iter().map(|crash| crash.name).collect()))
            }
        }
    }

    fn with<T>(&self, work: impl FnOnce(&mut BTreeMap<String, Arc<Cell>>) -> T) -> T {
        let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|_, cell| !cell.is_over());
        work(&mut all)
    }

    /// Those for components.
    #[must_use]
    pub fn all(&self) -> Vec<Arc<Cell>> {
        let mut all = self.with_gateways();
        all.retain(|cell| !cell.is_gateway());
        all
    }

    /// Those for components, and gateways.
    #[must_use]
    pub fn with_gateways(&self) -> Vec<Arc<Cell>> {
        self.with(|all| all.values().map(Arc::clone).collect())
    }

    pub(crate) fn setup(&self) -> &Setup {
        &self.setup
    }

    pub(crate) fn last_round(&self) -> &tokio::sync::Mutex<Option<Round>> {
        &self.last_round
    }

    pub(crate) fn wants(&self) -> &Arc<Wants> {
        &self.wants
    }

    pub(crate) fn bell(&self) -> &Mutex<Option<Bell>> {
        &self.bell
    }

    /// The cell of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Arc<Cell>> {
        self.with(|all| all.get(name).map(Arc::clone))
    }

    /// The cell that holds a component.
    #[must_use]
    pub fn of(&self, component: &str) -> Option<Arc<Cell>> {
        self.all().into_iter().find(|cell| cell.holds(component))
    }

    /// The cell of this name, running; it is begun when it is not there. One that is begun for
    /// libraries may read the directories of them, whatever its sandbox.
    ///
    /// # Errors
    /// It has no place for its files, or its process does not run.
    pub async fn open(&self, name: &str, libraries: &[PathBuf]) -> Result<Arc<Cell>, OpenError> {
        let found = self.get(name);
        let cell = match found {
            // It is ending: one that begins takes its place.
            Some(cell) if cell.is_stopping() => {
                cell.ended().await;
                return Box::pin(self.open(name, libraries)).await;
            }
            Some(cell) if cell.is_gateway() => {
                let error = PlaceError::Gateway(name.to_owned());
                return Err(OpenError::Place(Arc::new(error)));
            }
            Some(cell) => {
                self.grant(name, cell.place(), libraries);
                cell.start_again();
                cell
            }
            None => {
                let place = match genom_gateway::middleware_of(name) {
                    Some(_) => Err(PlaceError::Gateway(name.to_owned())),
                    None => Place::new(&place::of_all(&self.setup.socket), name),
                };
                let place = place.and_then(|place| place.make().map(|()| place));
                let place = place.map_err(|error| OpenError::Place(Arc::new(error)))?;
                self.grant(name, &place, libraries);
                self.choose_runner(name, &place, libraries);
                self.begin(name, place, None)
            }
        };
        if let Err(down) = cell.begun().await {
            self.end_if_empty(&cell).await;
            return Err(OpenError::of(down, &cell));
        }
        Ok(cell)
    }

    /// A cell that begins with codels in a script is a process of their runner.
    fn choose_runner(&self, name: &str, place: &Place, libraries: &[PathBuf]) {
        let config = &self.setup.config;
        let of = |library: &PathBuf| LoadRequest { library: library.clone(), ..Default::default() };
        let language = libraries.iter().map(of).find_map(|one| names_script(&one, &config.path));
        let Some((command, key)) = language.and_then(|language| config.runner(language)) else {
            return;
        };
        tracing::debug!("cell {name} runs `{}` ({key})", command.join(" "));
        if let Err(error) = place.set_runner(&command) {
            tracing::error!("cell {name}: its runner cannot be written down: {error}");
        }
    }

    /// Lets a cell in a sandbox read where its libraries are.
    fn grant(&self, name: &str, place: &Place, libraries: &[PathBuf]) {
        if !self.setup.config.limits_of(name).is_sandbox() {
            return;
        }
        for file in libraries.iter().filter(|file| file.components().count() > 1) {
            let Ok(file) = std::path::absolute(file) else { continue };
            if let Some(directory) = file.parent()
                && let Err(error) = place.grant(directory)
            {
                tracing::warn!("cell {name}: {}: {error}", place.libraries().display());
            }
        }
    }

    /// Starts the cells of these components that are not there, side by side: most of the time of a start
    /// goes by in the new process.
    pub async fn open_all(self: &Arc<Self>, requests: impl IntoIterator<Item = &LoadRequest>) {
        let mut libraries: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
        for request in requests {
            let Some(name) = request.cell.clone() else { continue };
            libraries.entry(name).or_default().push(request.library.clone());
        }
        let mut opening = JoinSet::new();
        for (name, libraries) in libraries {
            let cells = Arc::clone(self);
            // Whoever loads into one that does not start is told why.
            opening.spawn(async move { cells.open(&name, &libraries).await.map(drop) });
        }
        opening.join_all().await;
    }

    pub(crate) fn begin(&self, name: &str, place: Place, found: Option<Process>) -> Arc<Cell> {
        self.with(|all| {
            let begin = || Cell::begin(name, place, &self.setup, found);
            Arc::clone(all.entry(name.to_owned()).or_insert_with(begin))
        })
    }

    /// Loads a component into a cell, which is begun for it if need be, and ended if it refuses
    /// and holds nothing else.
    ///
    /// # Errors
    /// The cell is down, or refuses the component.
    pub async fn load(&self, name: &str, request: &LoadRequest) -> Result<Component, OpenError> {
        let cell = self.open(name, std::slice::from_ref(&request.library)).await?;
        let turn = cell.changing().await;
        let loaded = match cell.tell(&routes::load(), request).await {
            // A library, or the runner of a script, ended it: whoever loads is told how.
            Err(AskError::Gone(_)) => Err(OpenError::Down(cell.lost().await)),
            loaded => loaded.map_err(OpenError::Ask),
        };
        if let Ok(component) = &loaded {
            cell.loaded(&component.name);
        }
        drop(turn);
        self.end_if_empty(&cell).await;
        loaded.map_err(|error| match error {
            OpenError::Down(down) => OpenError::of(down, &cell),
            error => error,
        })
    }

    /// Takes a component out of its cell, which ends with its last one.
    ///
    /// # Errors
    /// The cell is down, or refuses.
    pub async fn unload(&self, cell: &Cell, component: &str) -> Result<Unloaded, OpenError> {
        let turn = cell.changing().await;
        cell.answers().await?;
        let unloaded = cell.ask(&routes::unload(component)).await?;
        cell.unloaded(component);
        drop(turn);
        self.end_if_empty(cell).await;
        Ok(unloaded)
    }

    /// Ends the cells that hold nothing.
    pub(crate) async fn end_empty(&self) {
        for cell in self.all() {
            self.end_if_empty(&cell).await;
        }
    }

    async fn end_if_empty(&self, cell: &Cell) {
        let _turn = cell.changing().await;
        if cell.is_empty() {
            self.stop(cell.name()).await;
        }
    }

    /// Ends a cell and all that is in it; whether there was one.
    pub async fn stop(&self, name: &str) -> bool {
        let Some(cell) = self.get(name) else { return false };
        cell.ask_to_stop();
        cell.ended().await;
        true
    }

    /// Ends all, side by side.
    pub async fn stop_all(&self) {
        let all = self.all();
        all.iter().for_each(|cell| cell.ask_to_stop());
        for cell in all {
            self.stop(cell.name()).await;
        }
    }

    /// Goes on with the cells that a daemon before this one left: those that live are taken over
    /// as they are, those that ended meanwhile are started with what they held.
    pub async fn adopt(&self) {
        for (name, place) in Place::found(&place::of_all(&self.setup.socket)) {
            if self.get(&name).is_some() {
                // A gateway that was needed already.
                continue;
            }
            let process = match left(&place, &name) {
                Some(pid) => self.living(&name, &place, pid).await,
                None => None,
            };
            if process.is_none() {
                remains::end_descendants(&place);
            }
            if process.is_none() && !place.journal().exists() {
                place.remove();
                continue;
            }
            self.begin(&name, place, process);
        }
        let all = self.all();
        for cell in &all {
            let _ = cell.begun().await;
        }
        self.adopt_ends(&all);
    }

    /// A process that a daemon before this one started, if it answers; else it is killed.
    pub(crate) async fn living(&self, name: &str, place: &Place, pid: u32) -> Option<Process> {
        let process = Process::found(pid, Some(place)).ok()?;
        let client = Client::new(&place.socket());
        let about = routes::about();
        let answer = tokio::time::timeout(self.setup.settings.alive_timeout, client.ask(&about));
        match answer.await {
            Ok(Ok(_)) => Some(process),
            _ => {
                tracing::error!("cell {name}: process {pid} does not answer, and is killed");
                process.signal(Signal::KILL);
                process.ended().await;
                None
            }
        }
    }
}
