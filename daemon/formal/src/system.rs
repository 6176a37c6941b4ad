//! A component as the rules read it: arrays by index, made from a plan.

use std::sync::Arc;

use genom_description::model::{CodelIx, Ix as _, Task};
use genom_runtime::body::EventId;
use genom_runtime::nanos;
use genom_runtime::plan::Plan;
use genom_timing::{Conflicts, Lock, Period};

use crate::action::Answer;
use crate::bounds::Bounds;
use crate::codels::{self, Codel, small};
use crate::machines::{self, Machine};
use crate::services::{self, Service};
use crate::state::{At, Phase, State, Task as TaskState};
use crate::variant::{Variant, conflicts};

/// A component whose steps can be explored.
#[derive(Clone, Debug)]
pub struct System {
    pub(crate) plan: Arc<Plan>,
    pub(crate) bounds: Bounds,
    pub(crate) variant: Option<Variant>,
    /// Ticks of each task; `None` for an aperiodic one.
    pub(crate) periods: Vec<Option<Period>>,
    pub(crate) machines: Vec<Machine>,
    pub(crate) codels: Vec<Codel>,
    pub(crate) services: Vec<Service>,
    pub(crate) conflicts: Conflicts,
    /// States of external events, in the model's order.
    pub(crate) sinks: Vec<u16>,
    /// Each place takes one transition per tick (dialects.md A).
    pub(crate) by_period: bool,
    /// Services that clients request.
    pub(crate) clients: Vec<bool>,
    /// Tasks that are looked at; others do nothing once requests are served.
    pub(crate) looked_at: Vec<bool>,
}

impl System {
    /// The system of a component.
    #[must_use]
    pub fn new(plan: &Arc<Plan>, bounds: Bounds) -> Self {
        Self::with(plan, bounds, None)
    }

    /// The system with one changed rule.
    #[must_use]
    pub fn with(plan: &Arc<Plan>, bounds: Bounds, variant: Option<Variant>) -> Self {
        let period = |task: &Task| {
            let period = nanos(task.period?).max(1);
            let shifted = variant != Some(Variant::Phase);
            let delay = if shifted { nanos(task.delay) % period } else { 0 };
            Some(Period { period, delay })
        };
        Self {
            bounds,
            variant,
            periods: plan.component().tasks.iter().map(period).collect(),
            machines: machines::machines(plan),
            codels: codels::codels(plan),
            services: services::services(plan),
            conflicts: conflicts(plan.nodes(), variant),
            sinks: plan.component().sinks.iter().map(|sink| small(sink.state.index())).collect(),
            by_period: plan.steps_by_period(),
            clients: vec![true; plan.component().services.len()],
            looked_at: vec![true; plan.component().tasks.len()],
            plan: Arc::clone(plan),
        }
    }

    /// The same component, of which clients request only these services. What it can do, it can
    /// do with all clients as well.
    pub(crate) fn slice(&self, services: &[u16]) -> Self {
        let mut slice = self.clone();
        for (client, service) in slice.clients.iter_mut().zip(0u16..) {
            let aborts = self.services[usize::from(service)].builtin.is_some();
            *client = aborts || services.contains(&service);
        }
        slice
    }

    /// The component.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// What clients may ask for.
    #[must_use]
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Ticks of each task; `None` for an aperiodic one.
    #[must_use]
    pub fn periods(&self) -> &[Option<Period>] {
        &self.periods
    }

    /// The state machines: the permanent activity of each task, in their order, then activities.
    #[must_use]
    pub fn machines(&self) -> &[Machine] {
        &self.machines
    }

    /// The services, in the model's order.
    #[must_use]
    pub fn services(&self) -> &[Service] {
        &self.services
    }

    /// Which nodes exclude each other.
    #[must_use]
    pub fn conflicts(&self) -> &Conflicts {
        &self.conflicts
    }

    /// What a node may return: a codel by its description; a data transfer only ends.
    #[must_use]
    pub fn answers(&self, node: u16) -> &[Answer] {
        let codel = self.codels.get(usize::from(node));
        codel.map_or(&[Answer::Ok], |codel| &codel.answers)
    }

    /// The first state: nothing has started. With `numbered`, activities get the numbers that the
    /// runtime gives them.
    #[must_use]
    pub fn initial(&self, numbered: bool) -> State {
        let task = TaskState {
            at: At::Absent,
            runs: Vec::new(),
            inbox: Vec::new(),
            outbox: Vec::new(),
            fired: Vec::new(),
            runnable: false,
            again: false,
            moved: false,
            late: false,
            young: 2,
        };
        State {
            phase: if self.periods.is_empty() { Phase::Running } else { Phase::Starting(0) },
            tasks: vec![task; self.periods.len()],
            pending: Vec::new(),
            workers: Vec::new(),
            lock: Lock::default(),
            ran: Vec::new(),
            failed: false,
            next: u32::from(numbered),
        }
    }

    /// The effect of an event that a codel of a state machine returned.
    #[must_use]
    pub fn answer(&self, codel: CodelIx, event: EventId) -> Answer {
        codels::answered(&self.plan, codel, event)
    }

    /// The context of the worker that serves this service.
    pub(crate) fn worker_context(&self, service: u16) -> u16 {
        small(self.periods.len()) + service
    }

    /// The context of the task with this index.
    pub(crate) fn is_task(&self, context: u16) -> bool {
        usize::from(context) < self.periods.len()
    }

    pub(crate) fn is_aperiodic(&self, task: u16) -> bool {
        self.periods[usize::from(task)].is_none()
    }

    /// Whether this task does anything once requests are served.
    pub(crate) fn is_looked_at(&self, task: u16) -> bool {
        self.looked_at[usize::from(task)]
    }

    /// Whether this task has ticks, and they are looked at.
    pub(crate) fn ticks_of(&self, task: u16) -> bool {
        !self.is_aperiodic(task) && self.is_looked_at(task)
    }

    /// Whether an aperiodic task other than this one exists, which others can wake.
    pub(crate) fn wakes_others(&self, but: Option<u16>) -> bool {
        let aperiodic = |(task, period): (usize, &Option<Period>)| {
            period.is_none() && but.map(usize::from) != Some(task)
        };
        self.periods.iter().enumerate().any(aperiodic)
    }

    /// The machine of a task's permanent activity.
    pub(crate) fn permanent(&self, task: u16) -> u16 {
        // Those come first, in the order of tasks.
        task
    }
}
