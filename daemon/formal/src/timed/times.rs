//! How long codels take.

use genom_description::model::{Codel, CodelIx, Component, Ix as _, Owner};
use genom_runtime::nanos;

use crate::system::System;

/// Least and greatest durations of all codels, in nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Times {
    pub(crate) codels: Vec<Duration>,
}

/// The time that a codel takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duration {
    /// At least this.
    pub least: u64,
    /// At most this; `None` without bound.
    pub most: Option<u64>,
}

impl Times {
    /// From nothing to the `wcet` of the description; without bound for codels that have none.
    #[must_use]
    pub fn declared(component: &Component) -> Self {
        let codels = component.codels.iter();
        let codels = codels.map(|codel| Duration { least: 0, most: codel.wcet.map(nanos) });
        Self { codels: codels.collect() }
    }

    /// Sets the durations of all codels with this name; returns whether there is one.
    pub fn set(&mut self, component: &Component, codel: &str, duration: Duration) -> bool {
        let mut any = false;
        for (known, place) in component.codels.iter().zip(&mut self.codels) {
            if known.name == codel {
                (*place, any) = (duration, true);
            }
        }
        any
    }

    /// Sets the duration of one codel.
    pub fn set_one(&mut self, codel: CodelIx, duration: Duration) {
        if let Some(place) = self.codels.get_mut(codel.index()) {
            *place = duration;
        }
    }

    /// Gives this bound to the codels that have none.
    pub fn bound_others(&mut self, most: u64) {
        self.codels.iter_mut().for_each(|codel| codel.most = codel.most.or(Some(most)));
    }

    /// Names of the component's own codels that have no bound.
    #[must_use]
    pub fn unbounded(&self, component: &Component) -> Vec<String> {
        let standard = |codel: &Codel| match codel.owner {
            Owner::Service(service) => component.services[service].standard,
            Owner::Task(_) => false,
        };
        let codels = component.codels.iter().zip(&self.codels);
        let unbounded = codels.filter(|(codel, time)| time.most.is_none() && !standard(codel));
        unbounded.map(|(codel, _)| codel.name.clone()).collect()
    }

    /// The same, with another greatest duration of a codel.
    pub(crate) fn with_most(&self, codel: u16, most: u64) -> Self {
        let mut other = self.clone();
        if let Some(duration) = other.codels.get_mut(usize::from(codel)) {
            duration.most = Some(most);
        }
        other
    }

    /// The same, with all codels of a task for their longest times.
    pub(super) fn longest_of(&self, system: &System, task: u16) -> Self {
        let mut other = self.clone();
        let own = system.machines.iter().filter(|machine| machine.task == task);
        for codel in own.flat_map(|machine| machine.codels.iter().flatten()) {
            let duration = &mut other.codels[usize::from(*codel)];
            duration.least = duration.most.unwrap_or(duration.least);
        }
        other
    }

    /// Duration of a node; data transfers take no time.
    #[must_use]
    pub fn of(&self, node: u16) -> Duration {
        let codel = self.codels.get(usize::from(node));
        codel.copied().unwrap_or(Duration { least: 0, most: Some(0) })
    }
}

impl System {
    /// Durations as the description declares them.
    #[must_use]
    pub fn declared_times(&self) -> Times {
        Times::declared(self.plan.component())
    }
}
