//! The steps that a state enables.

use genom_runtime::plan::Builtin;

use crate::action::{Action, Target};
use crate::codels::small;
use crate::services::Work;
use crate::state::{At, Life, Pc, Phase, Run, State};
use crate::system::System;

impl System {
    /// All steps that are possible whatever time it is: a tick may come whenever a task sleeps.
    #[must_use]
    pub fn enabled(&self, state: &State) -> Vec<Action> {
        let mut actions = self.internal(state);
        actions.extend(self.hurries(state));
        actions.extend(self.returns(state));
        actions.extend(self.ticks(state));
        actions.extend(self.asked(state));
        actions
    }

    /// Steps that the runtime takes by itself, for which no time passes.
    #[must_use]
    pub fn internal(&self, state: &State) -> Vec<Action> {
        let mut actions = Vec::new();
        self.any_internal(state, &mut |action| {
            actions.push(action);
            false
        });
        actions
    }

    /// Whether `wanted` accepts one of them; no more are shown to it then.
    pub(crate) fn any_internal(
        &self,
        state: &State,
        wanted: &mut dyn FnMut(Action) -> bool,
    ) -> bool {
        if state.phase == Phase::Stopped {
            return false;
        }
        if let Phase::Starting(task) = state.phase
            && state.tasks[usize::from(task)].at == At::Absent
            && wanted(Action::Start)
        {
            return true;
        }
        if self.advances(state) && wanted(Action::Advance) {
            return true;
        }
        let starting = matches!(state.phase, Phase::Starting(_));
        for (task, at) in state.tasks.iter().zip(0..) {
            let action = match task.at {
                At::Begin { .. } => Action::Begin(at),
                At::Sleep if task.runnable && (starting || self.is_looked_at(at)) => {
                    Action::Begin(at)
                }
                At::Wake => Action::Wake(at),
                _ => continue,
            };
            if wanted(action) {
                return true;
            }
        }
        // Control attends from the end of the start-up on.
        if !starting {
            let full = |(task, _): &(&crate::state::Task, u16)| !task.outbox.is_empty();
            let full = state.tasks.iter().zip(0..).filter(full).map(|(_, at)| at);
            let all = (full.clone().count() > 1).then_some(None);
            let collects = all.into_iter().chain(full.map(Some)).map(Action::Collect);
            if collects.into_iter().any(&mut *wanted) {
                return true;
            }
        }
        let due = |pc: Pc| matches!(pc, Pc::Wake(_) | Pc::Conclude);
        let mut workers = state.workers.iter().filter(|worker| due(worker.pc));
        workers.any(|worker| wanted(Action::Proceed(worker.service)))
    }

    /// Periodic tasks that a shutdown may wake before their ticks.
    #[must_use]
    pub fn hurries(&self, state: &State) -> Vec<Action> {
        let stopping = matches!(state.phase, Phase::Stopping(_));
        let tasks = state.tasks.iter().zip(0..);
        let hurried = tasks.filter(|(task, at)| {
            let idle = task.runs.is_empty() && task.inbox.is_empty();
            stopping && task.at == At::Sleep && !idle && !self.is_aperiodic(*at)
        });
        hurried.map(|(_, at)| Action::Hurry(at)).collect()
    }

    /// The ends of what is executed, with every result that the description allows.
    #[must_use]
    pub fn returns(&self, state: &State) -> Vec<Action> {
        let mut actions = Vec::new();
        for (context, node) in state.lock.holders() {
            let answers = self.answers(node);
            actions.extend(answers.iter().map(|answer| Action::Return(context, *answer)));
        }
        actions
    }

    /// Ticks of the tasks that sleep.
    #[must_use]
    pub fn ticks(&self, state: &State) -> Vec<Action> {
        let over = state.phase == Phase::Stopped;
        let sleeps = |at: &u16| {
            state.tasks[usize::from(*at)].at == At::Sleep && !self.is_aperiodic(*at) && !over
        };
        (0..small(state.tasks.len())).filter(sleeps).map(Action::Tick).collect()
    }

    /// What clients and others may ask, within the bounds.
    #[must_use]
    pub fn asked(&self, state: &State) -> Vec<Action> {
        let mut actions = Vec::new();
        if state.phase != Phase::Running {
            return actions;
        }
        if state.workers.len() < self.bounds.requests {
            let services = 0..small(self.services.len());
            for service in services.filter(|service| self.may_request(state, *service)) {
                if self.services[usize::from(service)].work.first() == Some(&Work::Abort) {
                    let targets = self.targets(state).into_iter();
                    actions.extend(targets.map(|target| Action::Abort(service, target)));
                } else {
                    actions.push(Action::Request(service));
                }
            }
        }
        if self.bounds.fire {
            for (task, at) in state.tasks.iter().zip(0..) {
                for (sink, number) in self.sinks.iter().zip(0..) {
                    let hears = |run: &Run| {
                        run.end.is_none()
                            && self.machines[usize::from(run.machine)].codel(*sink).is_some()
                    };
                    if !task.fired.contains(&number) && task.runs.iter().any(hears) {
                        actions.push(Action::Fire(at, number));
                    }
                }
            }
        }
        actions.extend(self.bounds.kill.then_some(Action::Kill));
        actions
    }

    /// Whether clients request this service in this state.
    fn may_request(&self, state: &State, service: u16) -> bool {
        let facts = &self.services[usize::from(service)];
        let free = self.pc(state, service).is_none() && self.clients[usize::from(service)];
        match facts.builtin {
            Some(Builtin::AbortActivity) => free && self.bounds.abort && !state.tasks.is_empty(),
            Some(_) => false,
            None if facts.machine.is_some() => {
                free && self.instances(state, service) < self.bounds.instances
            }
            None => free,
        }
    }

    /// Activities for which a stop request changes something. A request about none changes
    /// something only if it wakes tasks.
    fn targets(&self, state: &State) -> Vec<Target> {
        let mut targets = Vec::new();
        targets.extend(self.wakes_others(None).then_some(Target::Nobody));
        targets.extend((0..small(state.pending.len())).map(Target::Pending));
        for (task, number) in state.tasks.iter().zip(0..) {
            let of_service = |run: &Run| self.service_of(run).is_some();
            for (run, at) in task.inbox.iter().zip(0..) {
                if of_service(run) && run.life == Life::Init {
                    targets.push(Target::Sent(number, at));
                }
            }
            for (run, at) in task.runs.iter().zip(0..) {
                let stops = match run.life {
                    Life::Init => true,
                    Life::Run => !run.asked && run.end.is_none(),
                    Life::Stop | Life::Cancelled => false,
                };
                if of_service(run) && stops {
                    targets.push(Target::Runs(number, at));
                }
            }
        }
        targets
    }
}
