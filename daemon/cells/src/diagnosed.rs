//! How the processes of components fare, for middlewares whose tools show that (ROS 2:
//! `/diagnostics`). What tasks in them do, each process tells itself; that it has ended, only
//! others can tell.

use std::collections::BTreeMap;
use std::sync::Arc;

use genom_middleware::{Diagnosis, Health, Part};
use genom_registry::Backends;
use genom_supervisor::Supervisor;
use tokio::time::{MissedTickBehavior, interval};

use crate::cells::Cells;

impl Cells {
    /// From now on, middlewares are told how the processes of the components fare that are on them.
    pub fn diagnose(self: &Arc<Self>, supervisor: &Arc<Supervisor>) {
        let (cells, of) = (Arc::downgrade(self), Arc::downgrade(supervisor));
        tokio::spawn(async move {
            let mut rounds = interval(Diagnosis::ROUND);
            rounds.set_missed_tick_behavior(MissedTickBehavior::Delay);
            loop {
                rounds.tick().await;
                let Some((cells, supervisor)) = cells.upgrade().zip(of.upgrade()) else { return };
                if supervisor.closed.is_up() {
                    return;
                }
                // Journals are read, and a gateway may have to be asked what it is.
                let round = move || cells.tell_round(&supervisor.backends);
                let _ = tokio::task::spawn_blocking(round).await;
            }
        });
    }

    fn tell_round(&self, backends: &Backends) {
        let (mut all, mut names) = (Vec::new(), BTreeMap::new());
        for cell in self.all() {
            let Some(standing) = cell.standing() else { continue };
            for held in standing.held {
                for name in &held.on {
                    let worst = names.entry(name.clone()).or_insert(standing.health);
                    *worst = standing.health.max(*worst);
                }
                let diagnosis = Diagnosis {
                    instance: held.name,
                    of: Part::Cell(cell.name().to_owned()),
                    health: standing.health,
                    message: standing.message.clone(),
                    values: standing.values.clone(),
                };
                all.push((held.on, diagnosis));
            }
        }
        for (name, worst) in names {
            let mut on = backends.opened(&name);
            // Where all that was on it has ended, it may be that nobody has it open.
            if on.is_none() && worst == Health::Ended && backends.is_gateway(&name) {
                on = backends.get(&name).ok();
            }
            let Some(on) = on.filter(|on| on.takes_reports()) else { continue };
            let told = all.iter().filter(|(names, _)| names.contains(&name));
            let told: Vec<_> = told.map(|(_, diagnosis)| diagnosis.clone()).collect();
            on.diagnose(&told);
        }
    }
}
