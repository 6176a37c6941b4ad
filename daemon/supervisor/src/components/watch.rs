//! Reports what happens inside a component on the daemon's bus, and to callers of its activities.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_description::model::{ServiceIx, StateIx};
use genom_runtime::plan::Plan;
use genom_runtime::{Change as Inner, Watcher};

use super::guard::Guard;
use genom_bus::{Bus, Change};

/// Called with each state that an activity enters.
pub(crate) type Follower = Box<dyn FnMut(&str) + Send>;

/// Watcher of one instance.
pub(crate) struct BusWatcher {
    bus: Arc<Bus>,
    component: String,
    plan: Arc<Plan>,
    /// What is done when it breaks a rule.
    guard: Arc<Guard>,
    /// What was reported about the running activities.
    known: Mutex<HashMap<u32, Known>>,
    /// Followers of activities, each with the state reported last.
    followers: Mutex<HashMap<u32, Arc<Mutex<Following>>>>,
}

struct Following {
    last: Option<StateIx>,
    follower: Follower,
}

#[derive(Default)]
struct Known {
    /// Kept because transitions do not contain it. `None` for a permanent activity.
    service: Option<ServiceIx>,
    /// The state reported last: a state that yields itself at each period is reported once.
    last: Option<(StateIx, bool)>,
}

impl BusWatcher {
    /// A watcher for an instance of this plan.
    pub(crate) fn new(
        bus: &Arc<Bus>,
        component: &str,
        plan: &Arc<Plan>,
        guard: &Arc<Guard>,
    ) -> Self {
        Self {
            bus: Arc::clone(bus),
            component: component.to_owned(),
            plan: Arc::clone(plan),
            guard: Arc::clone(guard),
            known: Mutex::default(),
            followers: Mutex::default(),
        }
    }

    /// Reports the states of an activity from now on. An activity enters no state before all
    /// handlers of its acceptance have returned: a follower added there misses nothing.
    pub(crate) fn follow(&self, activity: u32, follower: Follower) {
        let following = Arc::new(Mutex::new(Following { last: None, follower }));
        self.followers().insert(activity, following);
    }

    /// Goes on to report the activities that another one reported.
    pub(super) fn inherit(&self, before: &Self) {
        self.followers().extend(before.followers().drain());
        let all: Vec<_> = before.with_known(|known| known.drain().collect());
        let services = &before.plan.component().services;
        self.with_known(|known| {
            known.extend(all.into_iter().filter_map(|(activity, before)| {
                let name = &services[before.service?].name;
                let service = Some(self.plan.service(name)?);
                Some((activity, Known { service, last: None }))
            }));
        });
    }

    fn followers(&self) -> MutexGuard<'_, HashMap<u32, Arc<Mutex<Following>>>> {
        self.followers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Not called with the map locked, because the follower may call back.
    fn entered(&self, activity: u32, state: StateIx) {
        let Some(following) = self.followers().get(&activity).map(Arc::clone) else { return };
        let mut following = following.lock().unwrap_or_else(PoisonError::into_inner);
        if following.last.replace(state) != Some(state)
            && let Some(name) = self.plan.component().states.get(state)
        {
            (following.follower)(name);
        }
    }

    fn service(&self, index: ServiceIx) -> String {
        self.plan.component().services[index].name.clone()
    }

    fn with_known<T>(&self, work: impl FnOnce(&mut HashMap<u32, Known>) -> T) -> T {
        work(&mut self.known.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The service of an activity that changed its state; `None` if that was reported already.
    fn moved(&self, activity: u32, to: (StateIx, bool)) -> Option<Option<ServiceIx>> {
        self.with_known(|known| {
            let known = known.entry(activity).or_default();
            let new = known.last.replace(to) != Some(to);
            new.then_some(known.service)
        })
    }
}

impl Watcher for BusWatcher {
    fn changed(&self, change: &Inner) {
        let component = self.component.clone();
        let told = match change {
            Inner::Accepted { activity, service } => {
                self.with_known(|known| {
                    known.entry(*activity).or_default().service = Some(*service)
                });
                let (service, activity) = (self.service(*service), u64::from(*activity));
                Change::ActivityStarted { component, service, activity }
            }
            Inner::Moved { activity, state, paused } => {
                self.entered(*activity, *state);
                let Some(service) = self.moved(*activity, (*state, *paused)) else { return };
                let service = service.map_or_else(String::new, |index| self.service(index));
                let state = self.plan.component().states.get(*state).cloned().unwrap_or_default();
                let (activity, paused) = (u64::from(*activity), *paused);
                Change::Transition { component, service, activity, state, paused }
            }
            Inner::Ended { activity, service, exception } => {
                self.with_known(|known| known.remove(activity));
                self.followers().remove(activity);
                let (service, activity) = (self.service(*service), u64::from(*activity));
                let exception = exception.clone();
                Change::ActivityEnded { component, service, activity, exception }
            }
            Inner::Overrun { task, ticks } => {
                let task = self.plan.component().tasks[*task].name.clone();
                Change::Overrun { component, task, ticks: *ticks }
            }
            Inner::Violated(violation) => return self.guard.violated(violation),
            Inner::Failed { task, exception } => {
                let task = &self.plan.component().tasks[*task].name;
                let why = format!("the permanent activity of task {task} ended with {exception}");
                tracing::error!(instance = component, "{why}");
                Change::ComponentFailed { component, why }
            }
        };
        self.bus.tell(&told);
    }
}
