//! A run with dates, as what happens in it: to be recorded, or to be played with scripted codels.

use genom_description::model::{CodelIx, Ix as _, Owner};

use crate::action::{Action, Answer, End, Target, Told};
use crate::state::{Mode, Run, State};
use crate::system::System;
use crate::timed::{Timed, Times, dates};

/// Steps from the first state on.
#[derive(Clone, Debug, Default)]
pub struct Course {
    pub(crate) steps: Vec<(State, Action)>,
}

impl Course {
    /// There are no steps: no run of all tasks is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }
}

/// Something that happens at a date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Happening {
    /// Nanoseconds from the start of the component.
    pub date: u64,
    /// What happens.
    pub event: Event,
}

/// A call of a codel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// The codel.
    pub codel: String,
    /// The task or service that it belongs to.
    pub owner: String,
    /// The task that executes it; `None` if control does, for a request.
    pub task: Option<String>,
}

/// What happens in a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A tick of this task.
    Tick(String),
    /// A tick of this task, which is at work.
    Late(String),
    /// This task makes a pass.
    Pass(String),
    /// A codel begins.
    Begins(Call),
    /// A codel waits for these, which exclude it.
    Waits(Call, Vec<String>),
    /// A codel returns this: a state, `ok`, or `exception`.
    Returns(Call, String),
    /// A client requests this service.
    Request(String),
    /// An activity of this service was accepted, with this number.
    Accepted(String, u32),
    /// An activity of this service moved to a state, or pauses there.
    Moved {
        /// The service.
        service: String,
        /// Its number.
        activity: u32,
        /// The state.
        state: String,
        /// Whether it waits for the next tick or event.
        paused: bool,
    },
    /// An activity of this service ended.
    Ended(String, u32, End),
    /// A client aborts the activity with this number.
    Abort(u32),
    /// An external event is fired.
    Fire(String),
    /// Control collects what ended.
    Control,
}

impl System {
    /// What happens in a run, with the earliest dates that its times allow.
    #[must_use]
    pub fn happenings(&self, times: &Times, course: &Course) -> Vec<Happening> {
        let dates = dates(self, times, &course.steps);
        let (mut all, mut told) = (Vec::new(), Vec::new());
        let mut names = Vec::new();
        // The same steps with numbers of activities, as the runtime gives them.
        let mut state = self.initial(true);
        for ((_, action), date) in course.steps.iter().zip(dates) {
            let next = self.after(&state, *action, &mut told);
            let mut push = |event| all.push(Happening { date, event });
            self.step(&state, *action).into_iter().for_each(&mut push);
            self.note_numbers(&next, &mut names);
            for told in told.drain(..) {
                let service = |number: u32| {
                    let known = names.iter().find(|(known, _)| *known == number);
                    known.map_or_else(String::new, |(_, service)| self.service_name(*service))
                };
                match told {
                    Told::Accepted(number) => push(Event::Accepted(service(number), number)),
                    Told::Ended(number, end) => push(Event::Ended(service(number), number, end)),
                    Told::Answered(..) => {}
                }
            }
            self.moves(&state, &next, &mut push);
            self.contexts(&state, *action, &next, &mut push);
            state = next;
        }
        all
    }

    /// The step itself.
    fn step(&self, state: &State, action: Action) -> Option<Event> {
        match action {
            Action::Tick(task) if Timed::is_late(state, action).is_some() => {
                Some(Event::Late(self.task_name(task)))
            }
            Action::Tick(task) => Some(Event::Tick(self.task_name(task))),
            Action::Begin(task) => Some(Event::Pass(self.task_name(task))),
            Action::Return(context, answer) => {
                let node = state.lock.held_by(context)?;
                let call = self.call(context, node)?;
                Some(Event::Returns(call, self.yielded(answer)))
            }
            Action::Request(service) => {
                let own = self.services[usize::from(service)].builtin.is_none();
                own.then(|| Event::Request(self.service_name(service)))
            }
            Action::Abort(_, target) => self.target(state, target).map(Event::Abort),
            Action::Fire(_, sink) => {
                let sinks = &self.plan.component().sinks;
                sinks.get(usize::from(sink)).map(|sink| Event::Fire(sink.name.clone()))
            }
            Action::Collect(_) => Some(Event::Control),
            Action::Start
            | Action::Advance
            | Action::Hurry(_)
            | Action::Wake(_)
            | Action::Proceed(_)
            | Action::Kill => None,
        }
    }

    /// The number of the activity that an abort is about.
    fn target(&self, state: &State, target: Target) -> Option<u32> {
        let task = |task: u16| state.tasks.get(usize::from(task));
        match target {
            Target::Nobody => None,
            Target::Pending(at) => state.pending.get(usize::from(at)).map(|one| one.number),
            Target::Sent(of, at) => task(of)?.inbox.get(usize::from(at)).map(|run| run.number),
            Target::Runs(of, at) => task(of)?.runs.get(usize::from(at)).map(|run| run.number),
        }
    }

    /// What a codel returns, by the name that it uses.
    fn yielded(&self, answer: Answer) -> String {
        match answer {
            Answer::Go(to) => self.state_name(to).to_owned(),
            Answer::Pause(to) => format!("pause::{}", self.state_name(to)),
            Answer::Sleep(_) => "sleep".into(),
            Answer::End => "ether".into(),
            Answer::Ok => "ok".into(),
            Answer::Fail => "exception".into(),
        }
    }

    /// The call of a codel in a context; `None` for transfers of data.
    fn call(&self, context: u16, node: u16) -> Option<Call> {
        let model = self.plan.component();
        let codel = model.codels.get(CodelIx::new(node.into()))?;
        let owner = match codel.owner {
            Owner::Task(task) => model.tasks.get(task).map(|task| task.name.clone()),
            Owner::Service(service) => model.services.get(service).map(|one| one.name.clone()),
        };
        let task = self.is_task(context).then(|| self.task_name(context));
        Some(Call { codel: codel.name.clone(), owner: owner.unwrap_or_default(), task })
    }

    /// The services of activities, by their numbers.
    fn note_numbers(&self, state: &State, names: &mut Vec<(u32, u16)>) {
        let runs = state.tasks.iter().flat_map(|task| task.runs.iter().chain(&task.inbox));
        let runs = runs.filter_map(|run| Some((run.number, self.service_of(run)?)));
        let pending = state.pending.iter().map(|one| (one.number, one.service));
        for one in runs.chain(pending) {
            if !names.contains(&one) {
                names.push(one);
            }
        }
    }

    /// Activities that moved.
    fn moves(&self, state: &State, next: &State, push: &mut impl FnMut(Event)) {
        let runs = |state: &State| -> Vec<Run> {
            state.tasks.iter().flat_map(|task| task.runs.clone()).collect()
        };
        let before = runs(state);
        for run in runs(next) {
            let Some(service) = self.service_of(&run) else { continue };
            let place = |run: &Run| run.places.first().copied();
            let old = before.iter().find(|old| old.number == run.number).and_then(place);
            let Some(place) = place(&run).filter(|place| Some(*place) != old) else { continue };
            if place.mode == Mode::Done {
                continue;
            }
            push(Event::Moved {
                service: self.service_name(service),
                activity: run.number,
                state: self.state_name(place.state).to_owned(),
                paused: place.mode != Mode::Ready,
            });
        }
    }

    /// What contexts begin to execute, or to wait for.
    fn contexts(&self, state: &State, action: Action, next: &State, push: &mut impl FnMut(Event)) {
        let returned = match action {
            Action::Return(context, _) => Some(context),
            _ => None,
        };
        for (context, node) in next.lock.holders() {
            if (state.lock.held_by(context).is_none() || returned == Some(context))
                && let Some(call) = self.call(context, node)
            {
                push(Event::Begins(call));
            }
        }
        for &(context, node) in &next.lock.queue {
            if state.lock.awaited_by(context).is_none()
                && let Some(call) = self.call(context, node)
            {
                let others = next.lock.holders().chain(next.lock.queue.iter().copied());
                let others = others.take_while(|other| *other != (context, node));
                let others = others.filter(|(_, other)| self.conflicts.between(node, *other));
                let others = others.map(|(_, other)| self.node_name(other)).collect();
                push(Event::Waits(call, others));
            }
        }
    }
}
