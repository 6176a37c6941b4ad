//! What rules hear of a step.

use genom_description::model::{
    CodelIx, Direction, Ix as _, PortDirection, PortIx, ServiceIx, Source,
};
use genom_runtime::Happening;

use crate::action::{Action, Answer, End, Told};
use crate::state::{At, Life, Pc, Run, State};
use crate::system::System;

impl System {
    /// What happens in a step, in order. A port that a codel may write is there with `true`: it may
    /// be written or not.
    pub(super) fn heard(
        &self,
        state: &State,
        action: Action,
        next: &State,
        told: &[Told],
    ) -> Vec<(Happening, bool)> {
        let mut all = Vec::new();
        let sure = |what: Happening| (what, false);
        if let Action::Return(context, _) = action
            && let Some(codel) = state.lock.held_by(context).and_then(|node| self.codel_of(node))
        {
            all.extend(self.writes(codel).map(|port| (Happening::Write(port), true)));
            all.push(sure(Happening::Return(codel)));
        }
        if let Action::Begin(task) = action {
            all.extend(self.started(state, task).map(sure));
        }
        for task in 0..state.tasks.len() {
            all.extend(self.ended(state, action, next, task).into_iter().map(sure));
        }
        if let Action::Proceed(service) = action
            && told.iter().any(|one| matches!(one, Told::Accepted(_)))
        {
            all.push(sure(Happening::Accept(ix(service))));
        }
        all.extend(self.stopped(state, next).map(sure));
        all.extend(self.executed_by(state, next, told).into_iter().map(sure));
        all.extend(self.begun_codels(state, action, next).map(sure));
        all
    }

    fn codel_of(&self, node: u16) -> Option<CodelIx> {
        let codel = CodelIx::new(node.into());
        self.plan.component().codels.get(codel).map(|_| codel)
    }

    /// Out ports of a codel.
    fn writes(&self, codel: CodelIx) -> impl Iterator<Item = PortIx> + '_ {
        let model = self.plan.component();
        let ports = model.codels[codel].parameters.iter().filter_map(|one| match one.source {
            Source::Port(port) if one.direction != Direction::In => Some(port),
            _ => None,
        });
        ports.filter(|port| model.ports[*port].direction == PortDirection::Out)
    }

    /// Activities that begin to run in a pass.
    fn started(&self, state: &State, task: u16) -> impl Iterator<Item = Happening> + '_ {
        let me = &state.tasks[usize::from(task)];
        let tick = !matches!(me.at, At::Begin { tick: false });
        let runs: Vec<Run> = me.runs.iter().chain(&me.inbox).cloned().collect();
        let starts = move |run: &Run| tick && run.life == Life::Init;
        runs.into_iter()
            .filter(starts)
            .filter_map(|run| self.service_of(&run))
            .map(|service| Happening::Start(ix(service)))
    }

    /// Activities that end: before their outputs are read, or when they are handed back.
    fn ended(&self, state: &State, action: Action, next: &State, task: usize) -> Vec<Happening> {
        let mut all = Vec::new();
        if matches!(action, Action::Collect(_)) {
            return all;
        }
        let (was, is) = (&state.tasks[task], &next.tasks[task]);
        let fetched = matches!(was.at, At::Fetch { .. }) && is.outbox.len() > was.outbox.len();
        let new = is.outbox.iter().skip(was.outbox.len() + usize::from(fetched));
        let ran = |run: &&Run| run.life != Life::Cancelled;
        let reads = match (was.at, is.at) {
            (before, At::Fetch { run }) if before != is.at || fetched => {
                is.runs.get(usize::from(run)).filter(|run| run.end == Some(End::Success))
            }
            _ => None,
        };
        let ended = new.filter(ran).chain(reads).filter_map(|run| self.service_of(run));
        all.extend(ended.map(|service| Happening::End(ix(service))));
        all
    }

    /// Activities that run and are asked to stop.
    fn stopped<'a>(
        &'a self,
        state: &'a State,
        next: &'a State,
    ) -> impl Iterator<Item = Happening> + 'a {
        let tasks = state.tasks.iter().zip(&next.tasks);
        let asked =
            tasks.filter(|(was, is)| was.runs.len() == is.runs.len()).flat_map(|(was, is)| {
                was.runs.iter().zip(&is.runs).filter(|(was, is)| {
                    was.machine == is.machine && !was.asked && is.asked && was.life == Life::Run
                })
            });
        let services = asked.filter_map(|(_, is)| self.service_of(is));
        services.map(|service| Happening::Stop(ix(service)))
    }

    /// Functions and attributes: executed once their inputs are valid.
    fn executed_by(&self, state: &State, next: &State, told: &[Told]) -> Vec<Happening> {
        let mut all = Vec::new();
        for (service, facts) in (0u16..).zip(&self.services) {
            if facts.machine.is_some() || facts.builtin.is_some() {
                continue;
            }
            let checks = self.plan.component().services[ix(service)].validates.len();
            let past =
                |pc: Option<Pc>| matches!(pc, Some(Pc::Work(item)) if usize::from(item) >= checks);
            let (was, is) = (self.pc(state, service), self.pc(next, service));
            let before = past(was);
            let works = |pc| matches!(pc, Some(Pc::Work(_)));
            // No work at all: it is over in the step of its request.
            let asks = was.is_none() && (is.is_some() || answered(told, service).is_some());
            if !asks && !works(was) {
                continue;
            }
            let success = matches!(is, Some(Pc::Wake(true) | Pc::Conclude))
                || answered(told, service) == Some(End::Success);
            if !before && (past(is) || success) {
                all.push(Happening::Start(ix(service)));
            }
            if !works(is) && (before || success) {
                all.push(Happening::End(ix(service)));
            }
        }
        all
    }

    /// Codels that contexts begin to execute.
    fn begun_codels<'a>(
        &'a self,
        state: &'a State,
        action: Action,
        next: &'a State,
    ) -> impl Iterator<Item = Happening> + 'a {
        let returned = match action {
            Action::Return(context, _) => Some(context),
            _ => None,
        };
        let new = move |(context, _): &(u16, u16)| {
            state.lock.held_by(*context).is_none() || returned == Some(*context)
        };
        let nodes = next.lock.holders().filter(new);
        nodes.filter_map(|(_, node)| self.codel_of(node)).map(Happening::Call)
    }

    /// The state machine's step that a codel of a task takes: its machine, and the states.
    pub(super) fn machine_step(&self, state: &State, action: Action) -> Option<(u16, u16, u16)> {
        let Action::Return(context, answer) = action else { return None };
        let task = state.tasks.get(usize::from(context)).filter(|_| self.is_task(context))?;
        let At::Codel { run, place } = task.at else { return None };
        let run = task.runs.get(usize::from(run))?;
        let from = run.places.get(usize::from(place))?.state;
        let to = match answer {
            Answer::Go(to) | Answer::Pause(to) | Answer::Sleep(to) => to,
            Answer::End => self.ether()?,
            Answer::Ok | Answer::Fail => return None,
        };
        Some((run.machine, from, to))
    }

    fn ether(&self) -> Option<u16> {
        let state = self.plan.component().state("ether")?;
        Some(crate::codels::small(state.index()))
    }

    /// Whether all of this is read off the steps as it happens.
    pub(super) fn is_heard(&self, what: Happening) -> bool {
        match what {
            Happening::Fire(_) | Happening::Cycle(_) => false,
            Happening::Start(service) | Happening::End(service) => {
                self.services[service.index()].builtin.is_none()
            }
            _ => true,
        }
    }
}

fn answered(told: &[Told], service: u16) -> Option<End> {
    told.iter().find_map(|one| match one {
        Told::Answered(own, end) if *own == service => Some(*end),
        _ => None,
    })
}

fn ix(service: u16) -> ServiceIx {
    ServiceIx::new(service.into())
}
