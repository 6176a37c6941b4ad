//! Gateways: cells that hold a middleware instead of components, for the daemon and its other cells.
//! They are begun when somebody needs them, and end when nobody does.

use std::io;
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::{Arc, PoisonError};

use genom_gateway::{Reach, cell_of};
use rustix::process::Signal;

use crate::bell::Bell;
use crate::cell::Cell;
use crate::cells::Cells;
use crate::place::{self, Place, PlaceError};
use crate::process::left;
use crate::remains;

/// Why there is no gateway.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoGateway {
    #[error("this daemon has no gateway of {0:?}: name it in [gateways] of its configuration")]
    NotOne(String),
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// In the words of the gateway, or how its process ended.
    #[error("{0}")]
    Ended(String),
}

impl Cells {
    /// Starts gateways for whoever asks, from now on.
    ///
    /// # Errors
    /// An error of the system.
    pub fn start_gateways(self: &Arc<Self>) -> io::Result<()> {
        if self.setup().config.gateways.of.is_empty() {
            return Ok(());
        }
        for path in self.doors() {
            place::make(&path).map_err(io::Error::other)?;
        }
        let cells = Arc::downgrade(self);
        let answers = move |middleware: String| -> Pin<Box<dyn Future<Output = _> + Send>> {
            let cells = cells.upgrade();
            Box::pin(async move { cells?.gateway(&middleware).await.err().map(|e| e.to_string()) })
        };
        let bell = Bell::hang(&Reach::new(&self.setup().socket).bell(), Arc::new(answers))?;
        *self.bell().lock().unwrap_or_else(PoisonError::into_inner) = Some(bell);
        Ok(())
    }

    /// Ends all gateways, and starts no more.
    pub async fn stop_gateways(&self) {
        let bell = self.bell().lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(bell) = bell {
            bell.take_down().await;
        }
        let all: Vec<_> =
            self.with_gateways().into_iter().filter(|cell| cell.is_gateway()).collect();
        all.iter().for_each(|cell| cell.ask_to_stop());
        for cell in all {
            cell.ended().await;
        }
        for path in self.doors().iter().rev() {
            // There is none if there were no gateways.
            let _ = std::fs::remove_dir(path);
        }
    }

    /// The directories of all doors, outer ones first. They stay as long as the daemon runs: that
    /// of a cell in a sandbox is a grant for a directory, not for a path.
    fn doors(&self) -> Vec<PathBuf> {
        let reach = Reach::new(&self.setup().socket);
        let each = self.setup().config.gateways.of.iter();
        let each = each.filter_map(|name| Some(reach.door(name).parent()?.to_owned()));
        std::iter::once(reach.directory()).chain(each).collect()
    }

    /// Waits until the gateway of a middleware runs, which is begun if there is none. Else says why
    /// it does not run.
    pub(crate) async fn gateway(&self, middleware: &str) -> Result<(), NoGateway> {
        if !self.setup().config.gateways.of.iter().any(|name| name == middleware) {
            return Err(NoGateway::NotOne(middleware.to_owned()));
        }
        let name = cell_of(middleware);
        let cell = loop {
            match self.get(&name) {
                Some(cell) if cell.is_stopping() => cell.ended().await,
                Some(cell) => {
                    cell.start_if_failed();
                    break cell;
                }
                None => break self.begin_gateway(&name).await?,
            }
        };
        let begun = cell.begun().await;
        begun.map_err(|down| match down.last_end.as_deref() {
            // Whoever asked says what it wanted to open.
            Some(why) => {
                let why = why.trim_start_matches("refused: ");
                let known = format!("backend {middleware} cannot be opened: ");
                NoGateway::Ended(why.trim_start_matches(&known).to_owned())
            }
            None => NoGateway::Ended(down.to_string()),
        })
    }

    async fn begin_gateway(&self, name: &str) -> Result<Arc<Cell>, NoGateway> {
        let place = Place::new(&place::of_all(&self.setup().socket), name);
        let place = place.and_then(|place| place.make().map(|()| place))?;
        // That of a daemon before this one, unless it was configured in another way.
        let mut process = match left(&place, name) {
            Some(pid) => self.living(name, &place, pid).await,
            None => None,
        };
        let fits = || {
            let has_door = place.door().is_some_and(|door| door.exists());
            has_door && self.setup().wrote_config(name, &place)
        };
        if let Some(found) = process.take_if(|_| !fits()) {
            tracing::warn!("{name} runs with another configuration, and is started again");
            found.signal(Signal::KILL);
            found.ended().await;
        }
        if process.is_none() {
            remains::end_descendants(&place);
        }
        Ok(self.begin(name, place, process))
    }
}
