//! Whether a system can do what was seen of the runtime.
//!
//! What is seen are calls of codels, replies and lists of activities; what tasks and control do in
//! between is not. So a set of states is kept: all those in which the component may be after what
//! was seen up to now. The run is accepted if the set is never empty.

use std::collections::HashSet;

use genom_description::model::Ix as _;
use genom_formal::{Action, Answer, At, Life, Pc, Phase, State, System, Target, Told};
use genom_runtime::ActivityPhase;
use genom_runtime::plan::Builtin;

use super::body::Seen;

/// States of a set, beyond which something is wrong with the acceptor.
const MOST: usize = 200_000;

/// A state in which the component may be.
#[derive(Clone, PartialEq, Eq, Hash)]
struct May {
    state: State,
    /// Dates of the next ticks of the tasks that have started.
    next: Vec<Option<u64>>,
    /// What clients are to be told.
    told: Vec<Told>,
    /// The activity that `abort_activity` is asked for, and whether by a client of the service.
    abort: Option<(u32, bool)>,
}

pub(crate) struct Acceptor<'a> {
    system: &'a System,
    now: u64,
    set: HashSet<May>,
    abort_service: u16,
}

/// The first thing that the system cannot do, by place in the log.
#[derive(Debug)]
pub(crate) struct Refused(pub(crate) usize);

/// Accepts a run, or says where the system cannot follow it.
pub(crate) fn accept(system: &System, log: &[Seen]) -> Result<(), Refused> {
    let mut acceptor = Acceptor::new(system);
    for (at, seen) in log.iter().enumerate() {
        acceptor.see(seen);
        if acceptor.set.is_empty() {
            return Err(Refused(at));
        }
    }
    Ok(())
}

impl<'a> Acceptor<'a> {
    fn new(system: &'a System) -> Self {
        let services = system.plan().services();
        let aborts = services.find(|service| service.builtin == Some(Builtin::AbortActivity));
        let abort_service =
            aborts.map_or(u16::MAX, |service| u16::try_from(service.index()).unwrap());
        let first = May {
            state: system.initial(true),
            next: vec![None; system.periods().len()],
            told: Vec::new(),
            abort: None,
        };
        Self { system, now: 0, set: HashSet::from([first]), abort_service }
    }

    fn see(&mut self, seen: &Seen) {
        match seen {
            Seen::Called { date, task, number, codel, answer } => {
                self.advance(*date);
                self.settle_unseen();
                let action = |may: &May| self.called(may, *task, *number, *codel, *answer);
                self.set = self.set.iter().filter_map(action).collect();
            }
            Seen::Told(date, told) => {
                self.advance(*date);
                self.settle_unseen();
                let set = std::mem::take(&mut self.set).into_iter();
                self.set = set.filter_map(|may| without(may, told)).collect();
            }
            Seen::Requested(service, abort) => {
                self.settle_unseen();
                self.request(*service, abort.map(|activity| (activity, true)));
            }
            Seen::Aborted { date, activity, found } => {
                self.advance(*date);
                self.settle_unseen();
                self.set.retain(|may| find(&may.state, *activity).is_some() == *found);
                if *found {
                    self.request(self.abort_service, Some((*activity, false)));
                }
            }
            Seen::Fired(sink) => {
                self.settle_unseen();
                for task in 0..u16::try_from(self.system.periods().len()).unwrap() {
                    self.all(Action::Fire(task, *sink));
                }
            }
            Seen::Advanced(date) => {
                self.advance(*date);
                self.settle();
            }
            Seen::Activities(list) => {
                self.settle_unseen();
                self.set.retain(|may| may.told.is_empty() && same(self.system, &may.state, list));
            }
            Seen::Started => {
                self.settle_unseen();
                self.set.retain(|may| may.state.phase == Phase::Running);
            }
            Seen::Killed => {
                self.settle_unseen();
                self.all(Action::Kill);
            }
            Seen::Stopped => {
                self.settle_unseen();
                let over = |may: &May| may.state.phase == Phase::Stopped && may.told.is_empty();
                self.set.retain(over);
            }
        }
    }

    /// The state after a codel was called, if it can be.
    fn called(
        &self,
        may: &May,
        task: Option<u16>,
        number: u32,
        codel: u16,
        answer: Answer,
    ) -> Option<May> {
        let (context, _) = may.state.lock.holders().find(|(context, node)| {
            let here = usize::from(*context) < self.system.periods().len();
            *node == codel && if here { task == Some(*context) } else { task.is_none() }
        })?;
        if let Some(task) = task {
            let me = &may.state.tasks[usize::from(task)];
            let At::Codel { run, .. } = me.at else { return None };
            if me.runs[usize::from(run)].number != number {
                return None;
            }
        }
        Some(self.after(may, Action::Return(context, answer)))
    }

    fn request(&mut self, service: u16, abort: Option<(u32, bool)>) {
        self.all(Action::Request(service));
        let set = std::mem::take(&mut self.set).into_iter();
        self.set = set.map(|may| May { abort: abort.or(may.abort), ..may }).collect();
    }

    fn all(&mut self, action: Action) {
        self.set = self.set.iter().map(|may| self.after(may, action)).collect();
    }

    fn after(&self, may: &May, action: Action) -> May {
        let mut next = may.clone();
        next.state = self.system.after(&may.state, action, &mut next.told);
        if let Some((_, false)) = may.abort {
            // A client of the instance is not told like one of the service.
            next.told
                .retain(|told| !matches!(told, Told::Answered(s, _) if *s == self.abort_service));
        }
        next.told.sort_unstable();
        for (task, period) in self.system.periods().iter().enumerate() {
            let Some(period) = period else { continue };
            let (was, is) = (may.state.tasks[task].at, next.state.tasks[task].at);
            if was == At::Absent && is != At::Absent {
                let since = self.now.checked_sub(period.delay);
                let ticks = since.map_or(0, |since| since / period.period + 1);
                next.next[task] = Some(period.delay + ticks * period.period);
            }
            if action == Action::Tick(u16::try_from(task).unwrap()) {
                next.next[task] = next.next[task].map(|date| date + period.period);
            }
        }
        next
    }

    /// Steps that happen without being seen, at this date.
    fn unseen(&self, may: &May) -> Vec<Action> {
        let mut actions = self.system.internal(&may.state);
        actions.extend(self.system.hurries(&may.state));
        let due =
            may.next.iter().zip(0u16..).filter(|(date, _)| date.is_some_and(|d| d <= self.now));
        actions.extend(due.map(|(_, task)| Action::Tick(task)));
        for (context, node) in may.state.lock.holders() {
            if usize::from(node) >= self.system.plan().component().codels.len() {
                actions.push(Action::Return(context, Answer::Ok));
            }
        }
        let aborts =
            may.state.workers.iter().any(|worker| {
                worker.service == self.abort_service && matches!(worker.pc, Pc::Work(_))
            });
        if let (Some((activity, _)), true) = (may.abort, aborts) {
            let target = find(&may.state, activity).unwrap_or(Target::Nobody);
            actions.push(Action::Abort(self.abort_service, target));
        }
        actions
    }

    /// Adds all states that follow by steps that are not seen.
    fn settle_unseen(&mut self) {
        let mut left: Vec<May> = self.set.iter().cloned().collect();
        while let Some(may) = left.pop() {
            for action in self.unseen(&may) {
                let next = self.after(&may, action);
                if self.set.insert(next.clone()) {
                    left.push(next);
                }
            }
            assert!(self.set.len() < MOST, "too many states");
        }
    }

    /// Keeps the states in which nothing is left to do at this date.
    fn settle(&mut self) {
        self.settle_unseen();
        let set = std::mem::take(&mut self.set).into_iter();
        let idle =
            |may: &May| self.unseen(may).is_empty() && may.state.lock.holders().next().is_none();
        self.set = set.filter(idle).collect();
    }

    /// Time passes until this date. It does only where nothing is left to do, and not beyond a tick.
    fn advance(&mut self, date: u64) {
        while self.now < date {
            self.settle();
            let ticks = self.set.iter().flat_map(|may| may.next.iter().flatten());
            self.now = ticks.copied().min().unwrap_or(date).min(date);
        }
    }
}

/// Removes what a client was told; `None` if there was nothing to tell.
fn without(mut may: May, told: &Told) -> Option<May> {
    let at = may.told.iter().position(|other| other == told)?;
    may.told.remove(at);
    Some(may)
}

/// The activity of a service with this number.
fn find(state: &State, number: u32) -> Option<Target> {
    let small = |at: usize| u16::try_from(at).unwrap();
    if let Some(at) = state.pending.iter().position(|pending| pending.number == number) {
        return Some(Target::Pending(small(at)));
    }
    for (task, of) in state.tasks.iter().enumerate() {
        // Machines of permanent activities come first.
        let is = |run: &genom_formal::Run| {
            run.number == number && usize::from(run.machine) >= state.tasks.len()
        };
        if let Some(at) = of.inbox.iter().position(is) {
            return Some(Target::Sent(small(task), small(at)));
        }
        if let Some(at) = of.runs.iter().position(is) {
            return Some(Target::Runs(small(task), small(at)));
        }
        if of.outbox.iter().any(is) {
            return Some(Target::Nobody);
        }
    }
    None
}

/// Whether these are the activities of a state.
fn same(system: &System, state: &State, list: &[(u32, ActivityPhase, bool)]) -> bool {
    let mut mine = Vec::new();
    mine.extend(state.pending.iter().map(|p| (p.number, ActivityPhase::Init, false)));
    for task in &state.tasks {
        for run in task.runs.iter().chain(&task.inbox).chain(&task.outbox) {
            let phase = match run.life {
                Life::Init => ActivityPhase::Init,
                Life::Run => ActivityPhase::Run,
                Life::Stop => ActivityPhase::Stop,
                Life::Cancelled => continue,
            };
            let asked = run.asked && usize::from(run.machine) >= system.periods().len();
            mine.push((run.number, phase, asked));
        }
    }
    let mut list = list.to_vec();
    mine.sort_unstable_by_key(|(number, ..)| *number);
    list.sort_unstable_by_key(|(number, ..)| *number);
    mine == list
}
