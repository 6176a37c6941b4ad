//! Steps in words, with places in the description.

use genom_description::model::{CodelIx, Ix as _, ServiceIx, Span, StateIx, TaskIx};

use crate::action::{Action, Answer, Target};
use crate::state::{At, Pc, State};
use crate::system::System;

/// What happens in a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Who does it: a task, the request of a service, `control`, `client`.
    pub who: String,
    /// What it does.
    pub what: String,
    /// Where that is declared.
    pub span: Option<Span>,
}

impl System {
    /// What happens in a step from this state; `None` for steps that a reader need not see.
    #[must_use]
    pub fn words(&self, state: &State, action: Action) -> Option<Line> {
        let line = |who: String, what: String| Some(Line { who, what, span: None });
        match action {
            Action::Start => match state.phase {
                crate::Phase::Starting(task) => line(self.task_name(task), "starts".into()),
                _ => None,
            },
            Action::Tick(task) => line(self.task_name(task), "tick".into()),
            Action::Hurry(task) => line(self.task_name(task), "is woken by the shutdown".into()),
            Action::Return(context, answer) => self.returned(state, context, answer),
            Action::Request(service) => {
                let name = self.service_name(service);
                line("client".into(), format!("requests {name}"))
            }
            Action::Abort(_, target) => {
                let what = match target {
                    Target::Nobody => return None,
                    Target::Pending(at) => state.pending.get(usize::from(at)).map(|p| p.service),
                    Target::Sent(task, at) => {
                        let inbox = &state.tasks.get(usize::from(task))?.inbox;
                        inbox.get(usize::from(at)).and_then(|run| self.service_of(run))
                    }
                    Target::Runs(task, at) => {
                        let runs = &state.tasks.get(usize::from(task))?.runs;
                        runs.get(usize::from(at)).and_then(|run| self.service_of(run))
                    }
                };
                line("client".into(), format!("aborts {}", self.service_name(what?)))
            }
            Action::Fire(task, sink) => {
                let sink = self.plan.component().sinks.get(usize::from(sink))?;
                line(self.task_name(task), format!("event {}", sink.name))
            }
            Action::Kill => line("client".into(), "asks the component to end".into()),
            Action::Proceed(service) if self.pc(state, service) == Some(Pc::Conclude) => {
                let activity = self.services.get(usize::from(service))?.machine.is_some();
                let what = if activity { "is accepted" } else { "is done" };
                line(self.service_name(service), what.into())
            }
            Action::Advance
            | Action::Begin(_)
            | Action::Wake(_)
            | Action::Proceed(_)
            | Action::Collect(_) => None,
        }
    }

    fn returned(&self, state: &State, context: u16, answer: Answer) -> Option<Line> {
        let node = state.lock.held_by(context)?;
        let who = self.context_name(state, context);
        let Some(codel) = self.plan.component().codels.get(CodelIx::new(node.into())) else {
            return Some(Line { who, what: "reads or stores parameters".into(), span: None });
        };
        let to = match answer {
            Answer::Go(to) => format!("yields {}", self.state_name(to)),
            Answer::Pause(to) => format!("yields pause::{}", self.state_name(to)),
            Answer::Sleep(_) => "yields sleep".into(),
            Answer::End => "yields ether".into(),
            Answer::Ok => "succeeds".into(),
            Answer::Fail => "ends with an exception".into(),
        };
        Some(Line { who, what: format!("{} {to}", codel.name), span: Some(codel.span) })
    }

    /// What a context does with a node.
    pub(crate) fn line_of(&self, state: &State, context: u16, node: u16, what: String) -> Line {
        let codel = self.plan.component().codels.get(CodelIx::new(node.into()));
        Line { who: self.context_name(state, context), what, span: codel.map(|codel| codel.span) }
    }

    /// A task, with the activity that it executes; or the service that a worker serves.
    fn context_name(&self, state: &State, context: u16) -> String {
        if !self.is_task(context) {
            return self.service_name(context - self.worker_context(0));
        }
        let task = &state.tasks[usize::from(context)];
        let run = match task.at {
            At::Codel { run, .. } | At::Fetch { run } => task.runs.get(usize::from(run)),
            _ => None,
        };
        let service = run.and_then(|run| self.service_of(run));
        match service {
            Some(service) => {
                format!("{}: {}", self.task_name(context), self.service_name(service))
            }
            None => self.task_name(context),
        }
    }

    /// The name of a task.
    #[must_use]
    pub fn task_name(&self, task: u16) -> String {
        let task = self.plan.component().tasks.get(TaskIx::new(task.into()));
        task.map(|task| task.name.clone()).unwrap_or_default()
    }

    /// The name of a service.
    #[must_use]
    pub fn service_name(&self, service: u16) -> String {
        let service = self.plan.component().services.get(ServiceIx::new(service.into()));
        service.map(|service| service.name.clone()).unwrap_or_default()
    }

    pub(crate) fn state_name(&self, state: u16) -> &str {
        let state = self.plan.component().states.get(StateIx::new(state.into()));
        state.map_or("", String::as_str)
    }
}
