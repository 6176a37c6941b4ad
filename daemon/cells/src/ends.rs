//! Keeps out ports open where connections between processes need them, and nowhere else, as
//! components and processes come and go.

use std::sync::{Arc, Weak};
use std::time::Duration;

use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Heard, Numbered};
use tokio::time::{MissedTickBehavior, interval};

use crate::cells::Cells;

/// How often to look whether all is as it should be.
const LOOK: Duration = Duration::from_secs(1);

impl Cells {
    /// Does so until the daemon ends.
    pub async fn keep_ends(cells: Weak<Self>, supervisor: Arc<Supervisor>) {
        let mut changes = supervisor.bus.listen(None);
        let mut rounds = interval(LOOK);
        rounds.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let news = tokio::select! {
                heard = changes.next() => match heard {
                    Some(heard) => News::of(&heard),
                    None => return,
                },
                _ = rounds.tick() => Some(News::Any),
            };
            let Some(cells) = cells.upgrade() else { return };
            let Some(news) = news.filter(|_| !cells.wants().is_empty()) else { continue };
            match news {
                News::Loaded(component) => cells.wants().begins(&component),
                News::Runs(cell) => cells.begin_again(&cell),
                News::Missed => cells.wants().all_begin(),
                News::Any => {}
            }
            cells.count(&supervisor).await;
            for writer in cells.wants().untold() {
                cells.tell_soon(&supervisor, writer);
            }
        }
    }

    /// Somebody else told the process of a component what is needed of it: what this daemon needs of
    /// it is told again.
    pub fn tell_again(&self, component: &str) {
        self.wants().begins(component);
    }

    /// The process of a cell is another one, which knows nothing.
    fn begin_again(&self, cell: &str) {
        let held = self.get(cell).map(|cell| cell.told().components);
        held.into_iter().flatten().for_each(|component| self.wants().begins(&component));
    }

    /// Tells the process of a component what is needed of it, unless that is being done: one that
    /// does not answer keeps no other waiting.
    fn tell_soon(self: &Arc<Self>, supervisor: &Arc<Supervisor>, writer: String) {
        let turn = self.wants().turn(&writer);
        if turn.try_lock().is_err() {
            return;
        }
        let (cells, supervisor) = (Arc::clone(self), Arc::clone(supervisor));
        tokio::spawn(async move { cells.settle(&supervisor, &writer).await });
    }
}

/// What changes about it.
enum News {
    /// A component was loaded.
    Loaded(String),
    /// A process of a cell runs.
    Runs(String),
    /// Who knows what.
    Missed,
    /// A connection or a component may have come or gone.
    Any,
}

impl News {
    fn of(heard: &Heard) -> Option<Self> {
        let Heard::Told(Numbered { data, .. }) = heard else { return Some(Self::Missed) };
        match data["event"].as_str()? {
            "component_loaded" => Some(Self::Loaded(data["component"].as_str()?.to_owned())),
            "cell_runs" => Some(Self::Runs(data["cell"].as_str()?.to_owned())),
            "connected" | "disconnected" | "component_unloaded" | "cell_ended" => Some(Self::Any),
            _ => None,
        }
    }
}
